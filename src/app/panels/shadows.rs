//! The same shadow ray asked three ways: the pictures, where they differ, and what the early out saves.

use egui::{Sense, Ui, vec2};

use crate::app::commands::{Command, Commands};
use crate::app::view::{AppView, CompareStyle, CompareViews};
use crate::render::View;
use crate::render::shadow::ShadowClass;
use crate::scene::{SceneRef, ShadowRule};

use super::cost::share_bar;
use super::glossary::Term;
use super::heatmap::view_name;
use super::numbers;
use super::widgets::{self, Figure, Side};

const PICTURES: [View; 5] = [
    View::ShadowIntersect,
    View::ShadowOccluded,
    View::ShadowFiltered,
    View::ShadowDifference,
    View::ShadowSaving,
];

/// View state of the Shadows panel.
pub struct ShadowsPanel {
    left: View,
    right: View,
    drawn: bool,
}

impl Default for ShadowsPanel {
    fn default() -> Self {
        Self { left: View::ShadowIntersect, right: View::ShadowOccluded, drawn: false }
    }
}

impl ShadowsPanel {
    pub fn ui(&mut self, ui: &mut Ui, view: &AppView, commands: &mut Commands) {
        if !std::mem::replace(&mut self.drawn, true) && is_untouched(view) {
            commands.push(Command::ShadowPreset);
        }
        introduction(ui, view, commands);
        pictures(ui, view, commands);
        self.compare(ui, view, commands);
        classes(ui, view);
        nodes(ui, view);
    }

    fn compare(&mut self, ui: &mut Ui, view: &AppView, commands: &mut Commands) {
        // Two states are the business of the panel Compare.
        let current = view.compare.filter(|compare| !compare.is_of_states());
        if let Some(compare) = current {
            let shown = |side: crate::app::view::Side| side.view.unwrap_or(view.session.view);
            (self.left, self.right) = (shown(compare.left), shown(compare.right));
        }
        widgets::section(ui, "Two pictures at once");
        let mode = current.map(|c| c.style);
        let choices =
            [None, Some(CompareStyle::SideBySide), Some(CompareStyle::Wipe), Some(CompareStyle::Blink)];
        let describe = |style: Option<CompareStyle>| match style {
            None => ("off", "the one picture that is chosen above"),
            Some(style) => (style.name(), style.description()),
        };
        let mut wanted = current;
        if let Some(style) = widgets::segmented(ui, Term::CompareWith, Some(mode), &choices, &describe) {
            wanted = style.map(|style| CompareViews::of_views(self.left, self.right, style));
        }
        ui.add_enabled_ui(current.is_some(), |ui| {
            let describe = |v: View| (view_name(v), v.description());
            for (term, side) in [(Term::CompareLeft, &mut self.left), (Term::CompareRight, &mut self.right)] {
                if let Some(v) = widgets::combo(ui, term, Some(*side), &View::ALL, &describe, "none") {
                    *side = v;
                }
            }
            if let Some(compare) = &mut wanted {
                (compare.left.view, compare.right.view) = (Some(self.left), Some(self.right));
            }
        });
        if wanted != current {
            commands.push(Command::SetCompareViews(wanted));
        }
    }
}

/// Whether the panel was just brought to the front over the default scene as it came: then it opens on the preset,
/// and nothing is lost. A panel that is in front when the program starts is drawn before the scene is there.
fn is_untouched(view: &AppView) -> bool {
    let session = view.session;
    view.scene.is_some()
        && session.scene.reference == SceneRef::default()
        && session.camera.is_none()
        && session.time == 0.0
        && !view.animating
        && view.compare.is_none()
        && !PICTURES.contains(&session.view)
}

fn introduction(ui: &mut Ui, view: &AppView, commands: &mut Commands) {
    widgets::section(ui, "Intersect against occluded");
    let text = "A shadow ray may stop at the first thing it meets, which is cheaper, but then it cannot know \
                whether that was glass: the filtered query asks that on the way.";
    widgets::caption(ui, view.palette, text);
    if ui
        .button("Show the false shadow")
        .on_hover_text(
            "Sets scene, camera and picture so that the black shadow of the glass is seen on the glossy floor.",
        )
        .clicked()
    {
        commands.push(Command::ShadowPreset);
    }
}

fn pictures(ui: &mut Ui, view: &AppView, commands: &mut Commands) {
    widgets::section(ui, "Picture");
    let describe = |r: ShadowRule| match r {
        ShadowRule::Glass => ("glass", r.description()),
        ShadowRule::GlassMirror => ("glass + mirror", r.description()),
    };
    let rule = view.session.shadow_rule;
    if let Some(rule) = widgets::segmented(ui, Term::ShadowRule, Some(rule), &ShadowRule::ALL, &describe) {
        commands.edit(move |s| s.shadow_rule = rule);
    }
    for picture in PICTURES {
        let selected = view.session.view == picture && view.compare.is_none();
        let name = picture_name(picture);
        let response = ui
            .radio(selected, name)
            .on_hover_text(picture.description())
            .accessible_name(format!("Picture {name}"));
        if response.clicked() && !selected {
            commands.edit(move |s| s.view = picture);
            if view.compare.is_some() {
                commands.push(Command::SetCompareViews(None));
            }
        }
    }
}

/// The view's name without the word that all of them share.
fn picture_name(view: View) -> &'static str {
    let name = view_name(view);
    name.strip_prefix("shadow: ").unwrap_or(name)
}

fn classes(ui: &mut Ui, view: &AppView) {
    widgets::term_section(ui, Term::PixelClasses);
    let Some(counts) = view.shadow.counts else {
        let text = if view.shadow.running { "Counting…" } else { "Not counted yet." };
        widgets::caption(ui, view.palette, text);
        return;
    };
    let total: u64 = counts.0.iter().sum();
    let color = |class: ShadowClass| {
        let [r, g, b] = class.color();
        egui::Color32::from_rgb(r, g, b)
    };
    let parts: Vec<_> = ShadowClass::ALL.iter().map(|&c| (counts.get(c) as f64, color(c))).collect();
    share_bar(ui, &parts);
    for class in ShadowClass::ALL {
        class_row(ui, view, class, counts.get(class), total);
    }
    if counts.get(ShadowClass::DarkOnlyInIntersect) > 0 {
        let text = "Pixels are dark only in intersect: that must not happen, please report this scene.";
        widgets::notice(ui, view.palette.error, text);
    }
}

/// Swatch, name, number of pixels, share.
fn class_row(ui: &mut Ui, view: &AppView, class: ShadowClass, count: u64, total: u64) {
    let size = vec2(widgets::form_width(ui), widgets::FIGURE_HEIGHT);
    let (rect, response) = ui.allocate_exact_size(size, Sense::hover());
    let [r, g, b] = class.color();
    let swatch = egui::Rect::from_center_size(rect.left_center() + vec2(5.0, 0.0), vec2(10.0, 10.0));
    let outline = ui.visuals().widgets.noninteractive.bg_stroke;
    ui.painter().rect(swatch, 2.0, egui::Color32::from_rgb(r, g, b), outline, egui::StrokeKind::Inside);
    let (mono, body) = (widgets::number_font(ui), widgets::body_font(ui));
    let strong = ui.visuals().strong_text_color();
    let share = format!("{} %", numbers::percent(count as f64, total as f64));
    let cell = |right: f32, width: f32| {
        egui::Rect::from_x_y_ranges(rect.right() - right - width..=rect.right() - right, rect.y_range())
    };
    widgets::paint_text(ui, cell(0.0, 58.0), Side::Right, &share, mono.clone(), view.palette.muted);
    widgets::paint_text(ui, cell(62.0, 72.0), Side::Right, &numbers::count(count), mono, strong);
    let (name, aside) = class_name(class);
    let label = egui::Rect::from_x_y_ranges(rect.left() + 18.0..=rect.right() - 136.0, rect.y_range());
    widgets::paint_text(ui, label, Side::Left, name, body, ui.visuals().text_color());
    let text = format!("{}: {} pixels, {share}", class.name(), numbers::count(count));
    response.widget_info(|| egui::WidgetInfo::labeled(egui::accesskit::Role::Label, true, &text));
    response.on_hover_text(aside);
}

/// A name short enough for a narrow column, and a sentence on it.
fn class_name(class: ShadowClass) -> (&'static str, &'static str) {
    match class {
        ShadowClass::NotAsked => {
            ("not asked", "No ray was asked: a miss, a light, or a surface that faces away from the light.")
        }
        ShadowClass::LitInBoth => ("lit in both", "Both answers let the light through."),
        ShadowClass::DarkInBoth => ("dark in both", "Both answers find something that blocks the light."),
        ShadowClass::DarkOnlyInOccluded => {
            ("false shadow", "Dark only in occluded, which stopped at something that lets light pass.")
        }
        ShadowClass::DarkOnlyInIntersect => {
            ("impossible", "Dark only in intersect, which cannot be, and is counted to prove it.")
        }
    }
}

fn nodes(ui: &mut Ui, view: &AppView) {
    widgets::term_section(ui, Term::ShadowNodes);
    let means = view.shadow.nodes_mean;
    if means.is_none() && view.shadow.running {
        widgets::caption(ui, view.palette, "Counting…");
    }
    let mean = |i: usize| means.map(|m| m[i]);
    let p = view.palette;
    Figure::new(Term::AskIntersect, numbers::decimal(mean(0), 2)).unit("").show(ui, p);
    Figure::new(Term::AskOccluded, numbers::decimal(mean(1), 2)).unit("").show(ui, p);
    Figure::new(Term::AskFiltered, numbers::decimal(mean(2), 2)).unit("").show(ui, p);
    let saved = means.map_or(numbers::DASH.to_owned(), |m| numbers::percent(m[0] - m[2], m[0]));
    Figure::new(Term::Saved, saved).unit("%").color(p.accent).show(ui, p);
}
