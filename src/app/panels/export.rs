//! What leaves the program: pictures, raw numbers, figures, the session, and the command that makes the same picture.

use std::path::PathBuf;
use std::time::Duration;

use egui::{Align, Button, ComboBox, DragValue, FontId, Label, Layout, RichText, TextEdit, Ui, vec2};

use crate::app::commands::{Command, Commands, ExportRequest, SaveTarget};
use crate::app::view::{AppView, JobStatus};
use crate::export::picture::Extras;
use crate::inspect::sweep::rough_time;
use crate::scene::SceneRef;
use crate::session::Session;
use crate::session::flags::command_line;

use super::animation::AnimationForm;
use super::glossary::Term;
use super::widgets;

const SIDE: std::ops::RangeInclusive<u32> = 1..=16384;
const SAMPLES: std::ops::RangeInclusive<u32> = 1..=100_000;
const SIZES: [(&str, [u32; 2]); 6] = [
    ("HD, 1280 × 720", [1280, 720]),
    ("Full HD, 1920 × 1080", [1920, 1080]),
    ("4K, 3840 × 2160", [3840, 2160]),
    ("8K, 7680 × 4320", [7680, 4320]),
    ("Square, 1024 × 1024", [1024, 1024]),
    ("Print, 3508 × 2480", [3508, 2480]),
];

/// View state of the Export panel.
pub struct ExportPanel {
    /// What was typed or chosen, by target; `None`: the suggestion.
    paths: [Option<String>; SaveTarget::ALL.len()],
    size: [u32; 2],
    samples: u32,
    overlay: bool,
    legend: bool,
    /// With the nodes below those that are selected.
    below: bool,
    animation: AnimationForm,
}

impl Default for ExportPanel {
    fn default() -> Self {
        Self {
            paths: Default::default(),
            size: [1920, 1080],
            samples: 64,
            overlay: true,
            legend: false,
            below: false,
            animation: AnimationForm::default(),
        }
    }
}

impl ExportPanel {
    pub fn ui(&mut self, ui: &mut Ui, view: &AppView, commands: &mut Commands) {
        self.picture(ui, view, commands);
        self.film(ui, view, commands);
        for (target, term) in [
            (SaveTarget::Report, Term::ReportFile),
            (SaveTarget::Raw, Term::RawFile),
            (SaveTarget::Figures, Term::FiguresFile),
            (SaveTarget::Sweep, Term::SweepFile),
            (SaveTarget::Tree, Term::TreeFile),
            (SaveTarget::Boxes, Term::BoxesFile),
            (SaveTarget::Plot, Term::PlotFile),
            (SaveTarget::Window, Term::WindowFile),
        ] {
            widgets::term_section(ui, term);
            if target == SaveTarget::Plot {
                let none = "None chosen yet: use the button in a plot's corner, or its second mouse button.";
                widgets::caption(ui, view.palette, view.plot.map_or(none, |plot| plot.title.as_str()));
            }
            if target == SaveTarget::Boxes {
                let count = view.selections.current().map_or(0, |selection| selection.nodes.len());
                let text = match count {
                    0 => "Nothing is selected: click in the picture, or in the panel Tree.".to_owned(),
                    1 => "One node is selected.".to_owned(),
                    _ => format!("{count} nodes are selected."),
                };
                widgets::caption(ui, view.palette, text);
                if widgets::switch(ui, Term::BoxesBelow, self.below) {
                    self.below = !self.below;
                }
            }
            if let Some(path) = self.path_row(ui, view, target, commands) {
                commands.push(Command::Export(match target {
                    SaveTarget::Boxes => ExportRequest::Boxes { path, below: self.below },
                    SaveTarget::Raw => ExportRequest::Raw { path },
                    SaveTarget::Figures => ExportRequest::Figures { path },
                    SaveTarget::Sweep => ExportRequest::Sweep { path },
                    SaveTarget::Tree => ExportRequest::Tree { path },
                    SaveTarget::Plot => ExportRequest::Plot { path },
                    SaveTarget::Report => {
                        let samples =
                            if view.session.view.refines(view.session.count) { self.samples } else { 1 };
                        ExportRequest::Report { path, size: self.size, samples }
                    }
                    SaveTarget::Window
                    | SaveTarget::Picture
                    | SaveTarget::Animation
                    | SaveTarget::Session => ExportRequest::Window { path },
                }));
            }
        }
        self.session(ui, view, commands);
        copy_command(ui, view, commands);
    }

    /// Takes a path that the system's dialog answered.
    pub fn path_chosen(&mut self, target: SaveTarget, path: PathBuf) {
        self.paths[target as usize] = Some(path.display().to_string());
    }

    fn picture(&mut self, ui: &mut Ui, view: &AppView, commands: &mut Commands) {
        widgets::term_section(ui, Term::PictureFile);
        self.picture_size(ui, view);
        let refines = view.session.view.refines(view.session.count);
        ui.add_enabled_ui(refines, |ui| {
            let mut one = 1;
            let samples = if refines { &mut self.samples } else { &mut one };
            let field = DragValue::new(samples).range(SAMPLES).speed(0.5);
            widgets::number(ui, Term::Samples, field)
        })
        .response
        .on_disabled_hover_text("One sample is all there is to this view.");
        ui.horizontal_wrapped(|ui| {
            if widgets::switch(ui, Term::WithOverlay, self.overlay) {
                self.overlay = !self.overlay;
            }
            if widgets::switch(ui, Term::WithLegend, self.legend) {
                self.legend = !self.legend;
            }
        });
        if let Some(path) = self.path_row(ui, view, SaveTarget::Picture, commands) {
            let [width, height] = self.size;
            let samples = if refines { self.samples } else { 1 };
            let (overlay, legend) = (self.overlay, self.legend);
            commands.push(Command::Export(ExportRequest::Picture {
                path,
                width,
                height,
                samples,
                overlay,
                legend,
            }));
        }
        if let Some(job) = &view.exporting {
            if widgets::progress(ui, view.palette, job, "Cancel") {
                commands.push(Command::CancelExport);
            }
            if let Some(left) = time_left(job) {
                widgets::caption(ui, view.palette, format!("about {} left", rough_time(left)));
            }
        }
    }

    fn film(&mut self, ui: &mut Ui, view: &AppView, commands: &mut Commands) {
        widgets::term_section(ui, Term::AnimationFile);
        self.animation.ui(ui, view);
        if let Some(path) = self.path_row(ui, view, SaveTarget::Animation, commands) {
            let refines = view.session.view.refines(view.session.count);
            commands.push(Command::Export(ExportRequest::Animation {
                path,
                size: self.size,
                samples: if refines { self.samples } else { 1 },
                extras: Extras { overlay: self.overlay, legend: self.legend },
                frames: self.animation.frames(),
            }));
        }
    }

    fn picture_size(&mut self, ui: &mut Ui, view: &AppView) {
        widgets::row(ui, Term::PictureSize, |ui| {
            let preset = SIZES.iter().find(|(_, size)| *size == self.size).map_or("Other", |(name, _)| name);
            let combo = ComboBox::from_id_salt("size").width(ui.available_width()).selected_text(preset);
            let shown = combo.truncate().show_ui(ui, |ui| {
                let [width, height] = view.render.size;
                if width > 0
                    && ui.selectable_label(false, format!("As the viewport, {width} × {height}")).clicked()
                {
                    self.size = [width, height];
                }
                for (name, size) in SIZES {
                    if ui.selectable_label(size == self.size, name).clicked() {
                        self.size = size;
                    }
                }
            });
            shown.response.accessible_name(Term::PictureSize.label()).on_hover_text(Term::PictureSize.text());
        });
        ui.horizontal(|ui| {
            ui.add_space(widgets::LABEL_WIDTH + 6.0);
            let [width, height] = &mut self.size;
            widgets::named_number(ui, Term::PictureWidth, DragValue::new(width).range(SIDE));
            ui.label("×");
            widgets::named_number(ui, Term::PictureHeight, DragValue::new(height).range(SIDE));
        });
    }

    fn session(&mut self, ui: &mut Ui, view: &AppView, commands: &mut Commands) {
        widgets::term_section(ui, Term::SessionFile);
        if let Some(path) = self.path_row(ui, view, SaveTarget::Session, commands) {
            commands.push(Command::SaveSession(path));
        }
        let open = ui.button("Open a session…").on_hover_text("A session's file, or a PNG that carries one.");
        if open.clicked() {
            commands.push(Command::AskOpen);
        }
    }

    /// A path, the system's dialog for it, and the button that saves there. The path, if that was clicked.
    fn path_row(
        &mut self,
        ui: &mut Ui,
        view: &AppView,
        target: SaveTarget,
        commands: &mut Commands,
    ) -> Option<PathBuf> {
        let stored = &mut self.paths[target as usize];
        let mut text = stored.clone().unwrap_or_else(|| match target {
            SaveTarget::Animation => {
                let name = suggestion(view.session, target);
                name.replace("film", self.animation.word())
            }
            _ => suggestion(view.session, target),
        });
        let mut save = false;
        let row = vec2(ui.available_width(), widgets::ROW_HEIGHT);
        ui.allocate_ui_with_layout(row, Layout::right_to_left(Align::Center), |ui| {
            let name = target.name();
            let is_there = match target {
                SaveTarget::Sweep => !view.sweep.points.is_empty(),
                SaveTarget::Plot => view.plot.is_some(),
                SaveTarget::Boxes => view.selections.current().is_some(),
                _ => true,
            };
            let ready =
                is_there && !text.trim().is_empty() && view.exporting.is_none() && view.scene.is_some();
            let button = ui.add_enabled(ready, Button::new("Save"));
            save = button.accessible_name(format!("Save the {name}")).clicked();
            let browse = ui.button("…").on_hover_text("Chooses where to save.");
            if browse.accessible_name(format!("Choose where to save the {name}")).clicked() {
                commands.push(Command::AskSavePath { target, suggested: PathBuf::from(&text) });
            }
            let edit = TextEdit::singleline(&mut text)
                .desired_width(ui.available_width())
                .align(egui::Align2::LEFT_CENTER)
                .hint_text(format!("path of the {name}"));
            let field = ui.add(edit).accessible_name(format!("Path of the {name}"));
            if field.changed() {
                *stored = Some(text.clone()).filter(|t| !t.is_empty());
            }
            field.on_hover_text(text.clone());
        });
        save.then(|| PathBuf::from(text.trim()))
    }
}

/// A file name that says what it shows.
fn suggestion(session: &Session, target: SaveTarget) -> String {
    let scene = match &session.scene.reference {
        SceneRef::Builtin(name) => name.replace(':', "-"),
        SceneRef::File(path) => {
            path.file_stem().map_or_else(|| "scene".to_owned(), |s| s.to_string_lossy().into_owned())
        }
    };
    let extension = target.extensions()[0];
    match target {
        SaveTarget::Picture | SaveTarget::Raw => format!("{scene}-{}.{extension}", session.view.name()),
        SaveTarget::Window => format!("{scene}-window.{extension}"),
        SaveTarget::Figures => format!("{scene}-{}.{extension}", session.build().builder.name()),
        SaveTarget::Sweep => format!("{scene}-sweep.{extension}"),
        SaveTarget::Session => format!("{scene}.{extension}"),
        SaveTarget::Tree => format!("{scene}-{}.{extension}", session.build().builder.name()),
        SaveTarget::Boxes => format!("{scene}-boxes.{extension}"),
        SaveTarget::Plot => format!("{scene}-plot.{extension}"),
        SaveTarget::Report => format!("{scene}-report.{extension}"),
        SaveTarget::Animation => format!("{scene}-{}-film.{extension}", session.view.name()),
    }
}

/// What the share so far lets expect; nothing while too little is done to tell.
fn time_left(job: &JobStatus) -> Option<Duration> {
    let share = job.fraction.filter(|share| *share > 0.01 && *share < 1.0)?;
    let patient = job.elapsed > Duration::from_secs(2);
    patient.then(|| job.elapsed.mul_f32((1.0 - share) / share))
}

fn copy_command(ui: &mut Ui, view: &AppView, commands: &mut Commands) {
    widgets::term_section(ui, Term::CommandLine);
    let mut session = view.session.clone();
    if session.view.refines(session.count) {
        // Without end in the window; the command makes the picture as it is now.
        session.render.spp.get_or_insert(view.render.samples.max(1));
    }
    let line = command_line(&session, &suggestion(view.session, SaveTarget::Picture));
    let text = RichText::new(&line).font(FontId::monospace(11.0));
    ui.add(Label::new(text).wrap().selectable(true));
    if ui.button("Copy command").on_hover_text(Term::CommandLine.text()).clicked() {
        commands.push(Command::CopyText { text: line, what: "command" });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn suggested_names_say_what_they_show_and_fit_a_file_system() {
        let mut session = Session::default();
        session.scene.reference = SceneRef::Builtin("soup:500".to_owned());
        assert_eq!(suggestion(&session, SaveTarget::Picture), "soup-500-path.png");
        session.scene.reference = SceneRef::File("/models/a b.obj".into());
        assert_eq!(suggestion(&session, SaveTarget::Session), "a b.ron");
        assert_eq!(suggestion(&session, SaveTarget::Raw), "a b-path.exr");
    }

    #[test]
    fn each_target_keeps_its_own_path() {
        let mut panel = ExportPanel::default();
        panel.path_chosen(SaveTarget::Raw, "x.csv".into());
        let set: Vec<_> =
            SaveTarget::ALL.into_iter().filter(|t| panel.paths[*t as usize].is_some()).collect();
        assert_eq!(set, [SaveTarget::Raw]);
    }
}
