//! Many trees on one scene and view: which, how far it is, a plot, a table, and the best that a search found.

mod grid;
mod plot;
mod points;

use egui::{Button, DragValue, Ui};

use crate::accel::BuildConfig;
use crate::app::commands::{Command, Commands};
use crate::app::jobs::sweep::SweepPlan;
use crate::app::view::{AppView, JobStatus, Stale};
use crate::export::points as text;
use crate::inspect::best::{BUDGET, Objective, Search, Verdict};
use crate::inspect::columns::{Better, Column};
use crate::inspect::pareto::front;
use crate::inspect::sweep::{MOST_POINTS, rough_time};

use super::build::summary;
use super::glossary::Term;
use super::numbers;
use super::widgets::{self, Figure};
use grid::GridForm;

/// Figures of the winner that are shown beside the default's.
const GAINS: [(&str, Term); 5] = [
    ("ray_cost_mean", Term::MeasuredAll),
    ("sah_cost", Term::SahCost),
    ("build_ms", Term::BuildTime),
    ("traversal_ms", Term::TimedFrames),
    ("bytes", Term::Bytes),
];

/// View state of the Sweep panel.
pub struct SweepPanel {
    /// Made of the session's settings when the panel is first drawn.
    form: Option<GridForm>,
    timed: bool,
    objective: Objective,
    frames: u32,
    plot: plot::PlotForm,
    table: points::PointTable,
}

impl Default for SweepPanel {
    fn default() -> Self {
        Self {
            form: None,
            timed: false,
            objective: Objective::default(),
            frames: 100,
            plot: plot::PlotForm::default(),
            table: points::PointTable::default(),
        }
    }
}

impl SweepPanel {
    pub fn ui(&mut self, ui: &mut Ui, view: &AppView, commands: &mut Commands) {
        self.grid(ui, view, commands);
        self.find_best(ui, view, commands);
        let sweep = view.sweep;
        if sweep.points.is_empty() {
            return;
        }
        stale(ui, view);
        let chosen = self.plot.ui(ui, view, commands);
        let listed = self.table.ui(ui, view, &self.plot.front(&sweep.points));
        if let Some(config) = chosen.or(listed) {
            load(config, commands);
        }
        self.copy(ui, view, commands);
    }

    fn grid(&mut self, ui: &mut Ui, view: &AppView, commands: &mut Commands) {
        widgets::term_section(ui, Term::SweepGrid);
        let base = *view.session.build();
        let form = self.form.get_or_insert_with(|| GridForm::of(&base));
        let grid = form.ui(ui, &base);
        ui.checkbox(&mut self.timed, Term::TimedFrames.label()).on_hover_text(Term::TimedFrames.text());
        let count = grid.as_ref().map_or(0, |grid| grid.count(&base));
        let text = match &grid {
            Err(reason) => {
                widgets::notice(ui, view.palette.error, reason);
                String::new()
            }
            Ok(_) if count > MOST_POINTS => {
                let most = numbers::count(MOST_POINTS);
                format!("{} trees; {most} is the most.", numbers::count(count))
            }
            Ok(_) => expectation(view, count, self.timed),
        };
        if !text.is_empty() {
            widgets::caption(ui, view.palette, text);
        }
        if let Some(job) = view.sweep.running.as_ref() {
            running(ui, view, job, commands);
            return;
        }
        ui.horizontal(|ui| {
            if view.sweep.waiting {
                if ui.button("Pause").clicked() {
                    commands.push(Command::SetSweepPaused(true));
                }
                return;
            }
            let ready = view.scene.is_some() && count > 0 && count <= MOST_POINTS;
            let start = ui
                .add_enabled(ready, Button::new("Start"))
                .on_hover_text("Measures the trees with nothing else running: the picture waits meanwhile.");
            if let (true, Ok(grid)) = (start.clicked(), &grid) {
                let plan = SweepPlan { grid: grid.clone(), search: None, timed: self.timed, base };
                commands.push(Command::StartSweep(Box::new(plan)));
            }
            if view.sweep.can_resume && ui.button("Resume").clicked() {
                commands.push(Command::SetSweepPaused(false));
            }
            let any = !view.sweep.points.is_empty();
            if ui.add_enabled(any, Button::new("Clear")).on_hover_text("Forgets all points.").clicked() {
                commands.push(Command::ClearSweep);
            }
        });
        if view.sweep.waiting {
            widgets::caption(ui, view.palette, "Goes on when nothing changes any more.");
        } else if view.sweep.can_resume {
            let (done, total) = (view.sweep.done, view.sweep.total);
            widgets::caption(ui, view.palette, format!("Paused after {done} of {total} trees."));
        }
    }

    fn find_best(&mut self, ui: &mut Ui, view: &AppView, commands: &mut Commands) {
        widgets::term_section(ui, Term::FindBest);
        let describe = |o: Objective| (o.name(), o.description());
        let objective = Some(self.objective);
        if let Some(o) = widgets::segmented(ui, Term::Objective, objective, &Objective::ALL, &describe) {
            self.objective = o;
        }
        if self.objective == Objective::Time {
            let field = DragValue::new(&mut self.frames).range(1..=1_000_000).speed(1.0);
            widgets::number(ui, Term::Frames, field);
        }
        let base = *view.session.build();
        let grid = self.form.as_ref().and_then(|form| form.grid(&base).ok());
        let busy = view.sweep.running.is_some() || view.sweep.waiting;
        let ready = view.scene.is_some() && !busy && grid.is_some();
        let find = ui.add_enabled(ready, Button::new("Find the best")).on_hover_text(format!(
            "Measures at most {BUDGET} trees of the builders and widths above, and says what the best gains over the default."
        ));
        if let (true, Some(grid)) = (find.clicked(), grid) {
            let search = Search {
                objective: self.objective,
                frames: self.frames,
                builders: grid.builders.clone(),
                widths: grid.widths.clone(),
                budget: BUDGET,
            };
            let timed = self.timed || self.objective == Objective::Time;
            let plan = SweepPlan { grid, search: Some(search), timed, base };
            commands.push(Command::StartSweep(Box::new(plan)));
        }
        found(ui, view, commands);
    }

    fn copy(&self, ui: &mut Ui, view: &AppView, commands: &mut Commands) {
        let Some(question) = &view.sweep.question else { return };
        let points = &view.sweep.points;
        ui.horizontal(|ui| {
            let front = || front(points, &self.plot.columns());
            if ui
                .button("Copy as CSV")
                .on_hover_text("All columns with all digits, for programs; the Export panel writes files.")
                .clicked()
            {
                let text = text::csv(points, &front(), question);
                commands.push(Command::CopyText { text, what: "points" });
            }
            if ui.button("Copy as JSON").on_hover_text("An object a tree, for programs.").clicked() {
                let text = text::json(points, &front(), question);
                commands.push(Command::CopyText { text, what: "points" });
            }
        });
    }
}

fn load(config: BuildConfig, commands: &mut Commands) {
    commands.edit(move |s| *s.build_mut() = config);
}

/// How many trees, and how long they take, by what the current tree or the points so far took.
fn expectation(view: &AppView, count: usize, timed: bool) -> String {
    let trees = if count == 1 { "1 tree".to_owned() } else { format!("{} trees", numbers::count(count)) };
    // A frame is counted once; with times it is traced about twelve times more.
    let frames = if timed { 13.0 } else { 1.0 };
    let guess = view.world.zip(view.render.sample_ms).map(|(world, sample)| {
        let builds = f64::from(u32::try_from(crate::app::jobs::sweep::BUILDS).unwrap_or(1));
        1e-3 * (builds * world.report.build_ms + frames * sample)
    });
    let a_point = view.sweep.a_point.map(|time| time.as_secs_f64()).or(guess);
    match a_point {
        Some(seconds) => {
            let time = std::time::Duration::from_secs_f64(seconds * count as f64);
            format!("{trees}, about {}.", rough_time(time))
        }
        None => format!("{trees}."),
    }
}

fn running(ui: &mut Ui, view: &AppView, job: &JobStatus, commands: &mut Commands) {
    if widgets::progress(ui, view.palette, job, "Pause") {
        commands.push(Command::SetSweepPaused(true));
    }
    let sweep = view.sweep;
    let of = if sweep.search { "of at most" } else { "of" };
    let left = sweep.left.map_or_else(String::new, |left| format!(", about {} left", rough_time(left)));
    widgets::caption(ui, view.palette, format!("{} {of} {} trees{left}", sweep.done, sweep.total));
}

fn stale(ui: &mut Ui, view: &AppView) {
    let text = match view.sweep.stale {
        None => return,
        Some(Stale::Scene) => "These points are of another scene, or of another moment of it.",
        Some(Stale::View) => {
            "These points were measured through another camera, at another size, or on other rays."
        }
    };
    widgets::notice(ui, view.palette.warning, text);
}

/// What a search found.
fn found(ui: &mut Ui, view: &AppView, commands: &mut Commands) {
    let Some(best) = &view.sweep.best else { return };
    let color = if best.verdict == Verdict::Better { view.palette.good } else { view.palette.muted };
    widgets::notice(ui, color, best.sentence());
    if best.verdict != Verdict::Better {
        return;
    }
    widgets::caption(ui, view.palette, summary(&best.best.config));
    for (key, term) in GAINS {
        let column = Column::of(key).expect("the key of a column");
        let (now, before) = (best.best.number(key), best.default.number(key));
        if now.is_none() {
            continue;
        }
        Figure::new(term, column.show(&column.value(&best.best)))
            .label(column.title)
            .unit(column.unit)
            .change(now, before, Better::Lower)
            .note("Held against the default's.".to_owned())
            .show(ui, view.palette);
    }
    if ui.button("Load it").on_hover_text("Builds with these settings.").clicked() {
        load(best.best.config, commands);
    }
}
