//! `bvhscope sweep`: a grid of trees, or a search for the best one.

use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard};
use std::time::{Duration, Instant};

use anyhow::anyhow;
use clap::error::ErrorKind;
use clap::{Arg, ArgAction, ArgMatches, Command, value_parser};

use super::progress::{Said, watch_saying};
use super::sweep_args::{self, Asked};
use super::workshop::Workshop;
use super::{CliError, args, output};
use crate::accel::BuildConfig;
use crate::export::plot::{self, Look, PlotFormat};
use crate::export::points::{self, KeptPoints, Question};
use crate::export::table::{self, TableFormat};
use crate::export::{ExportError, atomic};
use crate::inspect::best::{BUDGET, Best, Objective};
use crate::inspect::columns::{Column, Value};
use crate::inspect::pareto::front;
use crate::inspect::stats::Measurement;
use crate::inspect::sweep::plot::{SweepPlot, spans_a_decade};
use crate::inspect::sweep::{Progress, SweepEvent, SweepGrid, SweepPoint, Sweeper, same_tree};
use crate::task::{Cancelled, Task};

/// What is shown to people of each tree, where any has it.
const SHOWN: [&str; 10] = [
    "name",
    "node_count",
    "sah_cost",
    "epo",
    "nodes_visited_mean",
    "ray_cost_mean",
    "build_ms",
    "traversal_ms",
    "frames_per_s",
    "bytes",
];

/// The file is written no more often than this while points come in.
const WRITE_EVERY: Duration = Duration::from_secs(1);

pub fn command() -> Command {
    let command = Command::new("sweep")
        .about("A grid of trees: what each costs to build and to trace; or a search for the best one")
        .after_help(
            "The grid is the product of all lists, without trees that would be the same again. Figures of all trees are \
             taken under the session's C_t and C_i, whatever each was built with.",
        );
    let text = |name: &'static str, value: &'static str, help: &'static str| {
        Arg::new(name).long(name).value_name(value).help(help)
    };
    let path = |name: &'static str, help: &'static str| {
        text(name, "FILE", help).value_parser(clap::builder::ValueParser::path_buf())
    };
    sweep_args::with_lists(command, &SweepGrid::default())
        .arg(
            Arg::new("timed")
                .long("timed")
                .action(ArgAction::SetTrue)
                .help("Time a Whitted frame with every tree, too"),
        )
        .arg(path("out", "Write the points here as they come, .csv or .json"))
        .arg(path(
            "resume",
            "Take the points of this file, measure those that are missing, and write it anew",
        ))
        .arg(path(
            "plot",
            "Plot the points over the figures of --x and --y: .svg, .png, or .csv for the data",
        ))
        .arg(text("x", "KEY", "First figure of the Pareto front").default_value("build_ms"))
        .arg(text("y", "KEY", "Second figure of the Pareto front").default_value("ray_cost_mean"))
        .arg(
            text(
                "find-best",
                "WHAT",
                "Search bins, leaf limit and costs instead: for the least ray-cost or time",
            )
            .value_parser(Objective::ALL.map(Objective::name)),
        )
        .arg(
            text("frames", "N", "Frames that the least time is for: a build and the rays of so many")
                .default_value("100")
                .value_parser(value_parser!(u32).range(1..=1_000_000)),
        )
        .arg(
            text("budget", "N", "Most trees that a search measures")
                .default_value(BUDGET.to_string())
                .value_parser(value_parser!(u32).range(1..=10_000)),
        )
}

pub fn run(matches: &ArgMatches) -> Result<(), CliError> {
    let session = args::session(matches)?;
    let asked = Asked::read(matches, session.build())?;
    if let Some(path) = &asked.out {
        points::PointsFormat::of(path)?;
        atomic::check_writable(path)?;
    }
    if let Some(path) = &asked.plot {
        PlotFormat::of(path)?;
        atomic::check_writable(path)?;
    }
    let workshop = Workshop::open(session)?;
    let question = Question::new(&workshop.session, &workshop.camera);
    let kept = kept(&asked, &question)?;
    let task = Task::new();
    stop_at_ctrl_c(&task)?;
    let journal = Mutex::new(Journal::new(&asked, &question, kept));
    let sweep = Sweep { workshop: &workshop, asked: &asked, task: &task, journal: &journal };
    match &asked.search {
        None => sweep.grid(),
        Some(_) => sweep.best(),
    }
}

/// The points of an earlier sweep.
fn kept(asked: &Asked, question: &Question) -> Result<Vec<SweepPoint>, CliError> {
    let Some(path) = &asked.resume else { return Ok(Vec::new()) };
    let KeptPoints { points, others } = points::open(path, question)?;
    if others > 0 && asked.out.as_ref() == Some(path) {
        return Err(CliError::Failed(anyhow!(
            "{} holds {others} points of another scene, camera, size or cost, which would be lost: resume with what \
             they were measured on, or name another file with --out",
            path.display()
        )));
    }
    if others > 0 {
        output::warn(&format!("{others} points of {} are of another question", path.display()));
    }
    output::note(&format!("{} points taken from {}", points.len(), path.display()));
    Ok(points)
}

/// The first Ctrl-C ends the sweep in order, the second at once.
pub fn stop_at_ctrl_c(task: &Task) -> Result<(), CliError> {
    const INTERRUPTED: i32 = 130;
    let task = task.clone();
    ctrlc::set_handler(move || {
        if task.is_cancelled() {
            std::process::exit(INTERRUPTED);
        }
        task.cancel();
    })
    .map_err(|error| CliError::Failed(anyhow!("cannot listen for Ctrl-C: {error}")))
}

/// What is there so far, in memory and in the file.
struct Journal<'a> {
    asked: &'a Asked,
    question: &'a Question,
    points: Vec<SweepPoint>,
    progress: Progress,
    written: Option<Instant>,
    /// Why the file could not be written.
    failure: Option<ExportError>,
}

impl<'a> Journal<'a> {
    fn new(asked: &'a Asked, question: &'a Question, points: Vec<SweepPoint>) -> Self {
        Self { asked, question, points, progress: Progress::default(), written: None, failure: None }
    }

    fn hear(&mut self, event: SweepEvent) {
        match event {
            SweepEvent::Started { name, .. } => self.progress.started(name, Instant::now()),
            SweepEvent::Known { point } => self.progress.finished(&point.config, None),
            SweepEvent::Measured { point, took } => {
                self.progress.finished(&point.config, Some(took));
                match self.points.iter_mut().find(|p| same_tree(&p.config, &point.config)) {
                    Some(known) => *known = point.clone(),
                    None => self.points.push(point.clone()),
                }
                if self.written.is_none_or(|at| at.elapsed() >= WRITE_EVERY) {
                    self.write(&self.points.clone());
                }
            }
        }
    }

    fn write(&mut self, points: &[SweepPoint]) {
        let Some(path) = &self.asked.out else { return };
        let front = front(points, &self.asked.front);
        self.failure = points::save(path, points, &front, self.question).err();
        self.written = Some(Instant::now());
    }
}

/// A sweep on its way.
struct Sweep<'a> {
    workshop: &'a Workshop,
    asked: &'a Asked,
    task: &'a Task,
    journal: &'a Mutex<Journal<'a>>,
}

impl<'a> Sweep<'a> {
    fn grid(&self) -> Result<(), CliError> {
        let base = self.workshop.session.build();
        let grid = &self.asked.grid;
        let configs = grid.points(base);
        let known = self.lock().points.clone();
        let sweeper = self.sweeper(&known);
        let rest: Vec<_> = configs.iter().filter(|c| sweeper.find(c).is_none()).copied().collect();
        output::note(&format!("{} trees, {} of them to be measured", configs.len(), rest.len()));
        self.lock().progress = Progress::of(rest);
        let say = || {
            let journal = self.lock();
            Said {
                what: format!("measuring {}", journal.progress.current().unwrap_or("trees")),
                fraction: self.task.fraction(),
                left: journal.progress.time_left(Instant::now()),
            }
        };
        let ended = self
            .watch(&say, || sweeper.grid(grid, base, self.task, &mut |event| self.hear(event)).map(|_| ()));
        // In the order of the grid, then what else the file held.
        let points = std::mem::take(&mut self.lock().points);
        let place = |p: &SweepPoint| configs.iter().position(|c| same_tree(c, &p.config));
        let mut points: Vec<_> = points.into_iter().map(|p| (place(&p).unwrap_or(usize::MAX), p)).collect();
        points.sort_by_key(|(place, _)| *place);
        let done = points.iter().filter(|(place, _)| *place != usize::MAX).count();
        let points: Vec<_> = points.into_iter().map(|(_, p)| p).collect();
        self.finish(&points)?;
        self.plot(&points, None)?;
        self.print(&points)?;
        ended.map_err(|Cancelled| self.stopped(&format!("{done} of {} trees", configs.len())))
    }

    fn best(&self) -> Result<(), CliError> {
        let search = self.asked.search.as_ref().expect("the caller looked");
        let known = self.lock().points.clone();
        let sweeper = self.sweeper(&known);
        output::note(&format!("at most {} trees", search.budget));
        let say = || {
            let journal = self.lock();
            let done = self.task.fraction().map_or(0.0, |f| f * search.budget as f32) as usize;
            let left = journal.progress.time_for(search.budget.saturating_sub(done));
            let current = journal.progress.current().unwrap_or("trees");
            Said { what: format!("searching, {current}"), fraction: self.task.fraction(), left }
        };
        let found = self.watch(&say, || {
            let measure = &mut |name: &str, config: &_, fresh: bool| {
                sweeper.point(name, config, fresh, self.task, &mut |event| self.hear(event))
            };
            search.run(self.workshop.session.build(), self.task, measure)
        });
        match found {
            Ok(best) => {
                let points = self.lock().points.clone();
                self.finish(&points)?;
                self.plot(&best.tried, Some(&best.best.config))?;
                self.print_best(&best)
            }
            Err(Cancelled) => {
                let points = self.lock().points.clone();
                self.finish(&points)?;
                self.print(&points)?;
                Err(self.stopped(&format!("{} trees", points.len())))
            }
        }
    }

    fn sweeper<'k>(&'k self, known: &'k [SweepPoint]) -> Sweeper<'k> {
        let measurement = self.workshop.measurement(self.workshop.session.count);
        let timed = self.asked.timed;
        let costs = self.lock().question.costs();
        Sweeper { measurement: Measurement { timed, ..measurement }, costs, known }
    }

    fn watch<T: Send>(&self, say: &(dyn Fn() -> Said + Sync), work: impl FnOnce() -> T + Send) -> T {
        watch_saying(say, || self.workshop.install(work))
    }

    fn lock(&self) -> MutexGuard<'a, Journal<'a>> {
        self.journal.lock().expect("nothing panics while it holds the journal's lock")
    }

    fn hear(&self, event: SweepEvent) {
        let mut journal = self.lock();
        journal.hear(event);
        if journal.failure.is_some() {
            self.task.cancel();
        }
    }

    /// Writes the file for the last time.
    fn finish(&self, points: &[SweepPoint]) -> Result<(), CliError> {
        let mut journal = self.lock();
        journal.write(points);
        journal.failure.take().map_or(Ok(()), |error| Err(error.into()))
    }

    /// Plots the points, if that is asked for; the tree of `chosen` settings is marked.
    fn plot(&self, points: &[SweepPoint], chosen: Option<&BuildConfig>) -> Result<(), CliError> {
        let Some(path) = &self.asked.plot else { return Ok(()) };
        let [x, y] = self.asked.front;
        let log = [x, y].map(|column| spans_a_decade(points, column));
        let figures = SweepPlot { x, y, log, ..SweepPlot::default() };
        let mut drawn = figures.plot(points, chosen);
        drawn.title = format!("{} trees", points.len());
        drawn.subject = self.workshop.scene.name.clone();
        plot::save(&drawn, Look::Light, path)?;
        Ok(())
    }

    fn stopped(&self, done: &str) -> CliError {
        let hint = self
            .asked
            .out
            .as_ref()
            .map_or_else(String::new, |path| format!("; go on with --resume {}", path.display()));
        CliError::Failed(anyhow!("stopped after {done}{hint}"))
    }

    fn print(&self, points: &[SweepPoint]) -> Result<(), CliError> {
        let front = front(points, &self.asked.front);
        output::print(&match self.asked.format {
            TableFormat::People => format!(
                "{}\n\n{}\n\n{}",
                self.heading(),
                table::people_with_front(points, &self.shown(points), &front),
                self.legend()
            ),
            TableFormat::Json => points::json(points, &front, self.lock().question),
            TableFormat::Csv => points::csv(points, &front, self.lock().question),
            TableFormat::Markdown => table::markdown(points),
        })
    }

    fn print_best(&self, best: &Best) -> Result<(), CliError> {
        let front = front(&best.tried, &self.asked.front);
        let gains = table::compared_figures(&best.gains(), ["default", "best", "best - default"]);
        output::print(&match self.asked.format {
            TableFormat::People => format!(
                "{}\n\n{}\n\n{}\n\n{}\n\nFlags of the best: {}\n\n{gains}",
                self.heading(),
                table::people_with_front(&best.tried, &self.shown(&best.tried), &front),
                self.legend(),
                best.sentence(),
                Some(points::build_flags(&best.best.config))
                    .filter(|f| !f.is_empty())
                    .as_deref()
                    .unwrap_or("none, it is the default"),
            ),
            TableFormat::Json => points::best_json(best, &front, self.lock().question),
            TableFormat::Csv => points::csv(&best.tried, &front, self.lock().question),
            TableFormat::Markdown => format!("{}\n\n{}", best.sentence(), table::markdown(&best.tried)),
        })
    }

    /// Columns for people: those that any tree has something in, and those of the front.
    fn shown(&self, points: &[SweepPoint]) -> Vec<&'static Column> {
        let usual = SHOWN.iter().map(|key| Column::of(key).expect("the key of a column"));
        let has = |c: &&Column| points.iter().any(|p| c.value(p) != Value::Missing);
        let mut columns: Vec<_> = usual.filter(has).collect();
        for column in &self.asked.front {
            if !columns.iter().any(|c| c.key == column.key) {
                columns.push(column);
            }
        }
        columns
    }

    fn heading(&self) -> String {
        let session = &self.workshop.session;
        let [c_t, c_i] = self.lock().question.costs();
        format!(
            "{}, {} shapes; {} x {} pixels, {} rays; figures under C_t {c_t}, C_i {c_i}; {} threads",
            self.workshop.scene.name,
            self.workshop.scene.shape_count(),
            session.render.width,
            session.render.height,
            session.count.name(),
            self.workshop.threads()
        )
    }

    fn legend(&self) -> String {
        let [x, y] = [0, 1].map(|i| self.asked.front[i].heading());
        format!("• on the Pareto front of {x} and {y}   * the best of its column")
    }
}

/// A wrong value of a flag: what is allowed.
pub fn refused(flag: &str, text: &str, allowed: &str) -> CliError {
    args::usage(ErrorKind::ValueValidation, format!("--{flag} '{text}': {allowed}"))
}

/// Where points are written.
pub fn out_path(matches: &ArgMatches) -> (Option<PathBuf>, Option<PathBuf>) {
    let path = |name| matches.get_one::<PathBuf>(name).map(|p: &PathBuf| Path::new(p).to_owned());
    let resume = path("resume");
    (path("out").or_else(|| resume.clone()), resume)
}
