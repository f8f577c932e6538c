//! What is predicted of the tree, what its rays pay, and which prediction holds.

use egui::{Align, Layout, Response, RichText, Ui, vec2};

use crate::app::view::AppView;
use crate::inspect::prediction::{Forecast, Prediction, agreement};
use crate::render::bench::RaySetKind;
use crate::render::measure::RayFigures;
use crate::world::World;

use super::glossary::Term;
use super::numbers;
use super::widgets::{self, Figure};

fn term_of(prediction: Prediction) -> Term {
    match prediction {
        Prediction::SahCost => Term::Predicted,
        Prediction::Epo => Term::Epo,
        Prediction::SahEpo => Term::SahEpo,
    }
}

fn term_of_kind(kind: RaySetKind) -> Term {
    match kind {
        RaySetKind::Primary => Term::PrimaryCost,
        RaySetKind::Diffuse => Term::DiffuseCost,
        RaySetKind::Shadow => Term::ShadowCost,
    }
}

pub fn ui(ui: &mut Ui, view: &AppView, world: &World) {
    widgets::term_section(ui, Term::Predictions);
    let p = view.palette;
    let sah_cost = world.figures.sah_cost.map(|cost| cost.total());
    let forecast = view.forecast.copied().unwrap_or(Forecast { sah_cost, ..Forecast::default() });
    for prediction in Prediction::ALL {
        let value = numbers::decimal(forecast.predicted(prediction), 2);
        let figure = Figure::new(term_of(prediction), value).unit("");
        match prediction {
            Prediction::SahCost => figure,
            Prediction::Epo => figure.note(epo_note(world)),
            Prediction::SahEpo => figure,
        }
        .show(ui, p);
    }
    widgets::section(ui, "Mean ray cost");
    for kind in RaySetKind::ALL {
        let cost = forecast.ray_costs.of(kind);
        let note = match cost.zip(sah_cost) {
            Some((cost, sah)) => format!("{} % of what the SAH cost predicts.", numbers::percent(cost, sah)),
            None => String::new(),
        };
        Figure::new(term_of_kind(kind), numbers::decimal(cost, 2)).unit("").note(note).show(ui, p);
    }
    which_holds(ui, view);
    camera_rays(ui, view, world);
}

fn epo_note(world: &World) -> String {
    match world.known_epo() {
        Some(epo) if epo.sampled => "Spheres and tori are sampled on fixed points.".to_owned(),
        _ => String::new(),
    }
}

/// Of pairs of builds, the share that each prediction puts in the order of what rays paid.
fn which_holds(ui: &mut Ui, view: &AppView) {
    widgets::term_section(ui, Term::WhichHolds);
    let trees = view.forecasts;
    if trees.len() < 2 {
        let text = "Build other trees of this scene: pairs of them are put in order here, by each prediction and by what \
                    rays paid.";
        widgets::caption(ui, view.palette, text);
        return;
    }
    line(ui, "", RaySetKind::ALL.map(|kind| RichText::new(kind.name()).small().color(view.palette.muted)));
    for prediction in Prediction::ALL {
        let share = |kind| agreement(trees, prediction, kind);
        let shown = |share: f64| format!("{:.0} %", 100.0 * share);
        let cell = |kind| {
            RichText::new(share(kind).map_or(numbers::DASH.to_owned(), shown)).font(widgets::number_font(ui))
        };
        let cells = RaySetKind::ALL.map(cell);
        line(ui, term_of(prediction).label(), cells).on_hover_text(term_of(prediction).text());
    }
    widgets::caption(ui, view.palette, format!("Of {} builds, seen from here.", trees.len()));
}

/// A name, and a number for each kind of rays in columns of one width.
fn line(ui: &mut Ui, name: &str, cells: [RichText; 3]) -> Response {
    ui.horizontal(|ui| {
        let width = (0.2 * ui.available_width()).clamp(56.0, 90.0);
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            for cell in cells.into_iter().rev() {
                let right = Layout::right_to_left(Align::Center);
                ui.allocate_ui_with_layout(vec2(width, 16.0), right, |ui| {
                    ui.set_min_width(width);
                    ui.label(cell)
                });
            }
            ui.with_layout(Layout::left_to_right(Align::Center), |ui| ui.label(name)).inner
        })
        .inner
    })
    .inner
}

/// What the camera rays of the picture did, step by step.
fn camera_rays(ui: &mut Ui, view: &AppView, world: &World) {
    widgets::section(ui, "Camera rays");
    let p = view.palette;
    let predicted = world.figures.sah_cost.map(|c| c.total());
    let hit = view.rays.and_then(cost_of_hits);
    let ratio = hit.zip(predicted).map_or(String::new(), |(hit, predicted)| {
        format!("{} % of what the SAH cost predicts.", numbers::percent(hit, predicted))
    });
    Figure::new(Term::MeasuredHit, numbers::decimal(hit, 2)).unit("").note(ratio).show(ui, p);
    let all = view.rays.and_then(|r| r.ray_cost_mean);
    Figure::new(Term::MeasuredAll, numbers::decimal(all, 2)).unit("").part().show(ui, p);
    let missed = view.rays.map_or(numbers::DASH.to_owned(), |r| {
        numbers::percent(r.missed_root_count as f64, r.ray_count as f64)
    });
    Figure::new(Term::MissedRoot, missed).unit("%").show(ui, p);
    let means = [
        (Term::NodesVisited, view.rays.and_then(|r| r.nodes_visited_mean)),
        (Term::BoxTests, view.rays.and_then(|r| r.box_tests_mean)),
        (Term::ShapeTests, view.rays.and_then(|r| r.shape_tests_mean)),
        (Term::LeafVisits, view.rays.and_then(|r| r.leaf_visits_mean)),
        (Term::Lcv, view.rays.and_then(|r| r.lcv)),
    ];
    for (term, mean) in means {
        Figure::new(term, numbers::decimal(mean, 2)).unit("").show(ui, p);
    }
}

/// The mean ray cost of the rays that hit the root's box; `None` if none does.
fn cost_of_hits(rays: &RayFigures) -> Option<f64> {
    let hits = rays.ray_count.checked_sub(rays.missed_root_count).filter(|n| *n > 0)?;
    Some(rays.ray_cost_mean? * rays.ray_count as f64 / hits as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rays_that_miss_the_root_do_not_dilute_the_cost_of_those_that_hit_it() {
        let rays = RayFigures {
            ray_count: 100,
            missed_root_count: 75,
            ray_cost_mean: Some(5.0),
            ..RayFigures::default()
        };
        assert_eq!(cost_of_hits(&rays), Some(20.0));
        assert_eq!(cost_of_hits(&RayFigures { missed_root_count: 100, ..rays }), None);
        assert_eq!(cost_of_hits(&RayFigures { ray_cost_mean: None, ..rays }), None);
    }
}
