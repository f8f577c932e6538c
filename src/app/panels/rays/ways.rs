//! The chosen ray by three queries, side by side.

use egui::{Grid, RichText, Ui};

use super::shape_name;
use crate::app::commands::{Command, Commands};
use crate::app::inspection::{AskedAs, RayView};
use crate::app::panels::glossary::Term;
use crate::app::panels::{numbers, widgets};
use crate::app::view::AppView;

pub fn ui(ui: &mut Ui, view: &AppView, commands: &mut Commands) {
    widgets::term_section(ui, Term::RayWays);
    let (Some(recorded), Some(world)) = (&view.inspection.recorded, view.world) else { return };
    let muted = view.palette.muted;
    Grid::new("ways").num_columns(4).striped(true).spacing([10.0, 2.0]).show(ui, |ui| {
        ui.label("");
        for way in [AskedAs::Intersect, AskedAs::Occluded, AskedAs::Filtered] {
            ui.label(RichText::new(way.name()).small().color(muted)).on_hover_text(way.description());
        }
        ui.end_row();
        let row = |ui: &mut Ui, term: Term, value: &dyn Fn(usize) -> String| {
            ui.label(RichText::new(term.label()).small()).on_hover_text(term.text());
            for way in 0..recorded.ways.len() {
                ui.label(RichText::new(value(way)).monospace().small());
            }
            ui.end_row();
        };
        let ways = &recorded.ways;
        row(ui, Term::RayVisits, &|way| numbers::count(ways[way].counters.nodes_visited()));
        row(ui, Term::RayBoxTests, &|way| numbers::count(ways[way].counters.box_tests));
        row(ui, Term::RayShapeTests, &|way| numbers::count(ways[way].counters.shape_tests));
        row(ui, Term::RayWaiting, &|way| numbers::count(ways[way].left_waiting()));
        row(ui, Term::RayFound, &|way| {
            ways[way].answer.map_or("nothing".to_owned(), |shape| shape_name(world, shape))
        });
    });
    let ray_view = view.inspection.view;
    let describe = |way: AskedAs| (way.name(), way.description());
    let asked = widgets::segmented(ui, Term::AskedAs, Some(ray_view.asked_as), &AskedAs::ALL, &describe);
    if let Some(asked_as) = asked {
        let step = usize::MAX;
        commands.push(Command::SetRayView(RayView { asked_as, step, playing: false, ..ray_view }));
    }
}
