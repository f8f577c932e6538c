//! What is loaded, what else there is to open, and the moment that is shown.

use std::path::Path;

use egui::{Button, DragValue, RichText, Slider, TextEdit, Ui, vec2};

use crate::accel::Update;
use crate::app::commands::{Command, Commands};
use crate::app::view::AppView;
use crate::export::session_file::is_session_path;
use crate::export::tree_file::is_tree_path;
use crate::geometry::ShapeKind;
use crate::scene::{Scene, SceneRef, UpAxis, builtin};
use crate::session::Session;
use crate::world::World;

use super::bookmarks::Bookmarks;
use super::glossary::Term;
use super::numbers;
use super::widgets::{self, Figure};

/// Where the time slider ends, in seconds.
const LONGEST: f32 = 20.0;
const SOUP_SIZES: std::ops::RangeInclusive<u32> = 1..=10_000_000;

/// View state of the Scene panel.
pub struct ScenePanel {
    open_text: String,
    soup_size: u32,
    bookmarks: Bookmarks,
}

impl Default for ScenePanel {
    fn default() -> Self {
        Self { open_text: String::new(), soup_size: 100_000, bookmarks: Bookmarks::default() }
    }
}

impl ScenePanel {
    pub fn ui(&mut self, ui: &mut Ui, view: &AppView, commands: &mut Commands) {
        loaded(ui, view, commands);
        self.open(ui, view, commands);
        self.builtin(ui, view, commands);
        recent(ui, view, commands);
        staging(ui, view, commands);
        time(ui, view, commands);
        self.bookmarks.ui(ui, view, commands);
    }

    fn open(&mut self, ui: &mut Ui, view: &AppView, commands: &mut Commands) {
        widgets::section(ui, "Open");
        ui.horizontal(|ui| {
            let edit = TextEdit::singleline(&mut self.open_text)
                .hint_text("path or name")
                .align(egui::Align2::LEFT_CENTER)
                .desired_width(ui.available_width() - 56.0);
            let field =
                ui.add(edit).accessible_name(Term::OpenPath.label()).on_hover_text(Term::OpenPath.text());
            let enter = field.lost_focus() && ui.input(|i| i.key_pressed(egui::Key::Enter));
            let text = self.open_text.trim();
            let button = ui.add_enabled(!text.is_empty(), Button::new("Open").min_size(vec2(50.0, 0.0)));
            if (button.clicked() || enter) && !text.is_empty() {
                commands.push(open_command(text));
            }
        });
        ui.horizontal(|ui| {
            if ui.button("Choose a file…").clicked() {
                commands.push(Command::AskOpen);
            }
            ui.label(RichText::new("or drop one on the window").color(view.palette.muted));
        });
    }

    fn builtin(&mut self, ui: &mut Ui, view: &AppView, commands: &mut Commands) {
        widgets::section(ui, "Built-in scenes");
        let current = view.session.scene.reference.text();
        let current = current.split(':').next().unwrap_or_default();
        for (name, description) in builtin::SCENES {
            let selected = matches!(view.session.scene.reference, SceneRef::Builtin(_)) && name == current;
            if scene_row(ui, view, selected, name, description) {
                commands.push(Command::OpenScene(self.reference(name)));
            }
        }
        ui.add_space(2.0);
        widgets::row(ui, Term::SoupSize, |ui| {
            let speed = 0.02 * f64::from(self.soup_size);
            let field = DragValue::new(&mut self.soup_size)
                .range(SOUP_SIZES)
                .speed(speed)
                .custom_formatter(|n, _| numbers::count(n as u64))
                .custom_parser(parse_count);
            ui.add(field).accessible_name(Term::SoupSize.label()).on_hover_text(Term::SoupSize.text());
            if ui.button("Open").accessible_name("Open a soup of this size").clicked() {
                commands.push(Command::OpenScene(self.reference("soup")));
            }
        });
    }

    fn reference(&self, name: &str) -> SceneRef {
        if name == "soup" {
            SceneRef::Builtin(format!("soup:{}", self.soup_size))
        } else {
            SceneRef::Builtin(name.to_owned())
        }
    }
}

/// A whole number as people write it: with separators, in any place.
fn parse_count(text: &str) -> Option<f64> {
    let digits: String = text.chars().filter(|c| !matches!(c, ',' | '_' | ' ' | '\'')).collect();
    digits.parse::<f64>().ok().filter(|n| n.is_finite())
}

/// A session, and a PNG that may carry one, open as sessions, all else as scenes.
fn open_command(text: &str) -> Command {
    if is_session_path(Path::new(text)) {
        Command::OpenSession(text.into())
    } else if is_tree_path(Path::new(text)) {
        Command::ImportTree(text.into())
    } else {
        Command::OpenScene(SceneRef::parse(text))
    }
}

/// A name with a line on it. True if it was clicked.
fn scene_row(ui: &mut Ui, view: &AppView, selected: bool, name: &str, description: &str) -> bool {
    let mut text = egui::text::LayoutJob::default();
    let body = egui::TextFormat::simple(widgets::body_font(ui), ui.visuals().strong_text_color());
    text.append(name, 0.0, body);
    let quiet = if selected { ui.visuals().text_color() } else { view.palette.muted };
    let quiet = egui::TextFormat::simple(widgets::small_font(ui), quiet);
    text.append(&format!("\n{description}"), 0.0, quiet);
    text.wrap.max_width = ui.available_width() - 14.0;
    let button = Button::selectable(selected, text).min_size(vec2(ui.available_width(), 0.0)).wrap();
    ui.add(button).accessible_name(format!("Open {name}")).clicked()
}

fn loaded(ui: &mut Ui, view: &AppView, commands: &mut Commands) {
    let palette = view.palette;
    let reference = &view.session.scene.reference;
    let title = match (view.scene, reference) {
        (Some(scene), _) if !scene.name.is_empty() => scene.name.clone(),
        (_, SceneRef::Builtin(name)) => name.clone(),
        (_, SceneRef::File(path)) => file_name(path),
    };
    widgets::section(ui, &title);
    if let SceneRef::File(path) = reference {
        widgets::caption(ui, palette, path.display().to_string());
    }
    if let Some(job) = &view.loading
        && widgets::progress(ui, palette, job, "Cancel")
    {
        commands.push(Command::CancelLoad);
    }
    let Some(scene) = view.scene else {
        if view.loading.is_none() {
            widgets::caption(ui, palette, "Nothing is loaded. Open a file or a built-in scene.");
        }
        return;
    };
    shape_figures(ui, view, scene);
    let bounds = view.world.and_then(|w| world_size(w));
    let size = bounds.map_or(numbers::DASH.to_owned(), |e| {
        format!(
            "{} × {} × {}",
            numbers::short(f64::from(e.x)),
            numbers::short(f64::from(e.y)),
            numbers::short(f64::from(e.z))
        )
    });
    Figure::new(Term::Bounds, size).show(ui, palette);
    Figure::new(Term::Materials, numbers::count(scene.materials.len())).show(ui, palette);
    Figure::new(Term::Lights, numbers::count(scene.lights.len())).show(ui, palette);
    if !view.scene_warnings.is_empty() {
        widgets::notice(ui, palette.warning, Term::Warnings.label()).on_hover_text(Term::Warnings.text());
        for warning in view.scene_warnings {
            widgets::notice(ui, palette.warning, format!("• {warning}"));
        }
    }
}

fn world_size(world: &World) -> Option<glam::Vec3> {
    let bounds = world.tree.bounds();
    (!bounds.is_empty()).then(|| bounds.extent())
}

fn shape_figures(ui: &mut Ui, view: &AppView, scene: &Scene) {
    let total = scene.shape_count();
    Figure::new(Term::Shapes, numbers::count(total)).show(ui, view.palette);
    let others = [
        (ShapeKind::Sphere, scene.spheres.len()),
        (ShapeKind::Cuboid, scene.cuboids.len()),
        (ShapeKind::Quad, scene.quads.len()),
        (ShapeKind::Torus, scene.tori.len()),
    ];
    let triangles = total.saturating_sub(others.iter().map(|(_, n)| n).sum());
    for (kind, n) in [(ShapeKind::Triangle, triangles)].into_iter().chain(others).filter(|(_, n)| *n > 0) {
        let term = match kind {
            ShapeKind::Triangle => Term::Triangles,
            ShapeKind::Sphere => Term::Spheres,
            ShapeKind::Cuboid => Term::Cuboids,
            ShapeKind::Quad => Term::Quads,
            ShapeKind::Torus => Term::Tori,
        };
        Figure::new(term, numbers::count(n)).part().show(ui, view.palette);
    }
    let planes = scene.planes.len() + usize::from(scene.ground.is_some());
    if planes > 0 {
        Figure::new(Term::Planes, numbers::count(planes)).show(ui, view.palette);
    }
}

fn recent(ui: &mut Ui, view: &AppView, commands: &mut Commands) {
    let files: Vec<_> = view
        .recent
        .iter()
        .filter_map(|r| match r {
            SceneRef::File(path) => Some(path),
            SceneRef::Builtin(_) => None,
        })
        .collect();
    if files.is_empty() {
        return;
    }
    widgets::term_section(ui, Term::Recent);
    for path in files {
        let selected = view.session.scene.reference == SceneRef::File(path.clone());
        let folder = path.parent().map_or(String::new(), |p| p.display().to_string());
        if scene_row(ui, view, selected, &file_name(path), &folder) {
            commands.push(Command::OpenScene(SceneRef::File(path.clone())));
        }
    }
}

fn file_name(path: &Path) -> String {
    path.file_name().map_or_else(|| path.display().to_string(), |n| n.to_string_lossy().into_owned())
}

fn staging(ui: &mut Ui, view: &AppView, commands: &mut Commands) {
    widgets::section(ui, "Staging");
    let describe = |up: UpAxis| match up {
        UpAxis::Y => ("Y", "the y axis points up, as in most OBJ and glTF files"),
        UpAxis::Z => ("Z", "the z axis points up, as in many STL files"),
    };
    if let Some(up) = widgets::segmented(ui, Term::UpAxis, Some(view.session.up), &UpAxis::ALL, &describe) {
        commands.edit(move |s| set_up(s, up));
    }
    if widgets::switch(ui, Term::Ground, view.session.ground) {
        commands.edit(|s| s.ground = !s.ground);
    }
}

fn set_up(session: &mut Session, up: UpAxis) {
    session.up = up;
    if let Some(camera) = &mut session.camera {
        camera.up = up;
    }
}

fn time(ui: &mut Ui, view: &AppView, commands: &mut Commands) {
    let Some(scene) = view.scene else { return };
    widgets::section(ui, "Motion");
    if !scene.is_animated() {
        widgets::caption(ui, view.palette, "Nothing moves in this scene.");
        return;
    }
    if widgets::switch(ui, Term::Animate, view.animating) {
        commands.push(Command::SetAnimating(!view.animating));
    }
    let mut time = view.session.time;
    let slider = Slider::new(&mut time, 0.0..=LONGEST)
        .clamping(egui::SliderClamping::Edits)
        .fixed_decimals(2)
        .suffix(" s")
        .trailing_fill(true);
    let changed = widgets::slider(ui, Term::Time, slider).changed();
    if changed {
        commands.edit(move |s| s.time = time);
    }
    let update = Some(view.session.build().update);
    let describe = |u: Update| (u.name(), u.description());
    if let Some(update) = widgets::segmented(ui, Term::Update, update, &Update::ALL, &describe) {
        commands.edit(move |s| s.build_mut().update = update);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_typed_opens_as_what_it_is() {
        assert!(matches!(open_command("a/b.RON"), Command::OpenSession(_)));
        assert!(matches!(open_command("shot.png"), Command::OpenSession(_)));
        assert!(
            matches!(open_command("soup:12"), Command::OpenScene(SceneRef::Builtin(n)) if n == "soup:12")
        );
        assert!(matches!(open_command("tree.NPZ"), Command::ImportTree(_)));
        assert!(matches!(open_command("a.obj"), Command::OpenScene(SceneRef::File(_))));
    }

    #[test]
    fn counts_are_read_as_they_are_written() {
        assert_eq!(parse_count("1,000,000"), Some(1e6));
        assert_eq!(parse_count("many"), None);
    }

    #[test]
    fn another_up_axis_turns_a_camera_that_was_moved() {
        let mut session = Session { camera: Some(crate::scene::Camera::default()), ..Session::default() };
        set_up(&mut session, UpAxis::Z);
        assert_eq!((session.up, session.camera.map(|c| c.up)), (UpAxis::Z, Some(UpAxis::Z)));
    }
}
