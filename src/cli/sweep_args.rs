//! What `bvhscope sweep` was asked: its lists, and everything else.

use std::path::PathBuf;

use clap::{Arg, ArgMatches, Command};

use super::sweep::{out_path, refused};
use super::{CliError, output};
use crate::accel::{Block, BuildConfig, Builder, Improver, StopRule, Widen, Width};
use crate::export::table::TableFormat;
use crate::inspect::best::{Objective, Search};
use crate::inspect::columns::{Better, COLUMNS, Column};
use crate::inspect::sweep::{MOST_POINTS, SweepGrid};

/// What is to be done.
pub struct Asked {
    pub grid: SweepGrid,
    /// Instead of the grid.
    pub search: Option<Search>,
    pub timed: bool,
    pub out: Option<PathBuf>,
    pub resume: Option<PathBuf>,
    /// Where the points are plotted.
    pub plot: Option<PathBuf>,
    /// The two figures of the front.
    pub front: [&'static Column; 2],
    pub format: TableFormat,
}

/// Lists that a search varies by itself.
const NOT_IN_A_SEARCH: [&str; 8] = [
    "widens",
    "stops",
    "bins-grid",
    "leaf-grid",
    "blocks",
    "improvers",
    "traversal-costs",
    "intersection-costs",
];

/// Adds the flags of all lists.
pub fn with_lists(command: Command, grid: &SweepGrid) -> Command {
    let numbers = |values: &[usize]| values.iter().map(usize::to_string).collect::<Vec<_>>().join(",");
    let list = |name: &'static str, value: &'static str, help: &'static str| {
        let arg = Arg::new(name).long(name).value_name(value).help(help).help_heading("Grid");
        if NOT_IN_A_SEARCH.contains(&name) { arg.conflicts_with("find-best") } else { arg }
    };
    command
        .arg(list("builders", "NAME,...", "Builders, or all; default: that of --builder"))
        .arg(list("widths", "N,...", "Widths, or all; default: that of --width"))
        .arg(list("widens", "HOW,...", "Ways to make wide nodes, or all; default: that of --widen"))
        .arg(list("stops", "RULE,...", "Stop rules, or all; default: that of --stop"))
        .arg(
            list("bins-grid", "N,N,...", "Numbers of bins, 2 to 256 each, for the builders that have them")
                .default_value(numbers(&grid.bins)),
        )
        .arg(list("leaf-grid", "N,N,...", "Leaf limits, 1 to 64 each").default_value(numbers(&grid.leaf)))
        .arg(list("blocks", "N,...", "Blocks, or all; default: that of --block"))
        .arg(list("improvers", "NAME,...", "Improvers, or all; default: that of --improver"))
        .arg(list(
            "traversal-costs",
            "X,...",
            "C_t, for the stop rule cost and for optimal widening; default: that of --traversal-cost",
        ))
        .arg(list("intersection-costs", "X,...", "C_i, likewise; default: that of --intersection-cost"))
}

impl Asked {
    /// # Errors
    /// [`CliError::Usage`] that says what is allowed.
    pub fn read(matches: &ArgMatches, base: &BuildConfig) -> Result<Self, CliError> {
        let grid = grid(matches, base)?;
        let search = search(matches, &grid);
        let size = grid.count(base);
        if size > MOST_POINTS && search.is_none() {
            return Err(CliError::Failed(anyhow::anyhow!(
                "this grid has {size} trees; {MOST_POINTS} is the most. Leave some values out"
            )));
        }
        let (out, resume) = out_path(matches);
        let timed = matches.get_flag("timed")
            || search.as_ref().is_some_and(|search| search.objective == Objective::Time);
        let front = [figure(matches, "x")?, figure(matches, "y")?];
        let plot = matches.get_one::<PathBuf>("plot").cloned();
        Ok(Self { grid, search, timed, out, resume, plot, front, format: output::format(matches) })
    }
}

fn search(matches: &ArgMatches, grid: &SweepGrid) -> Option<Search> {
    let name = matches.get_one::<String>("find-best")?;
    let objective = Objective::ALL.into_iter().find(|o| o.name() == name).expect("clap allows no other");
    let number = |name| *matches.get_one::<u32>(name).expect("it has a default");
    Some(Search {
        objective,
        frames: number("frames"),
        builders: grid.builders.clone(),
        widths: grid.widths.clone(),
        budget: number("budget") as usize,
    })
}

fn grid(matches: &ArgMatches, base: &BuildConfig) -> Result<SweepGrid, CliError> {
    let own = SweepGrid::around(base);
    Ok(SweepGrid {
        builders: named(matches, "builders", &Builder::ALL, Builder::name, own.builders)?,
        widths: named(matches, "widths", &Width::ALL, Width::name, own.widths)?,
        widens: named(matches, "widens", &Widen::ALL, Widen::name, own.widens)?,
        stops: named(matches, "stops", &StopRule::ALL, StopRule::name, own.stops)?,
        bins: numbers(matches, "bins-grid", BuildConfig::BINS)?,
        leaf: numbers(matches, "leaf-grid", BuildConfig::LEAF)?,
        blocks: named(matches, "blocks", &Block::ALL, Block::name, own.blocks)?,
        improvers: named(matches, "improvers", &Improver::ALL, Improver::name, own.improvers)?,
        traversal_costs: costs(matches, "traversal-costs", own.traversal_costs)?,
        intersection_costs: costs(matches, "intersection-costs", own.intersection_costs)?,
    })
}

/// Names of a closed set between commas, or `all`.
fn named<T: Copy>(
    matches: &ArgMatches,
    flag: &str,
    all: &[T],
    name: fn(T) -> &'static str,
    own: Vec<T>,
) -> Result<Vec<T>, CliError> {
    let Some(text) = matches.get_one::<String>(flag) else { return Ok(own) };
    if text == "all" {
        return Ok(all.to_vec());
    }
    let found: Option<Vec<_>> =
        text.split(',').map(|part| all.iter().copied().find(|v| name(*v) == part.trim())).collect();
    found.ok_or_else(|| {
        let names: Vec<_> = all.iter().map(|v| name(*v)).collect();
        refused(flag, text, &format!("allowed are all, or some of {} with commas between", names.join(", ")))
    })
}

/// Whole numbers between commas, each in a range.
fn numbers(
    matches: &ArgMatches,
    flag: &str,
    range: std::ops::RangeInclusive<usize>,
) -> Result<Vec<usize>, CliError> {
    let text = matches.get_one::<String>(flag).expect("it has a default");
    let number = |part: &str| part.trim().parse::<usize>().ok().filter(|n| range.contains(n));
    let found: Option<Vec<_>> = text.split(',').map(number).collect();
    found.ok_or_else(|| {
        let (start, end) = (range.start(), range.end());
        refused(
            flag,
            text,
            &format!("allowed are whole numbers from {start} to {end} with commas between them"),
        )
    })
}

fn costs(matches: &ArgMatches, flag: &str, own: Vec<f32>) -> Result<Vec<f32>, CliError> {
    let Some(text) = matches.get_one::<String>(flag) else { return Ok(own) };
    let most = BuildConfig::MAX_COST;
    let cost = |part: &str| part.trim().parse::<f32>().ok().filter(|x| *x >= 1e-6 && *x <= most);
    let found: Option<Vec<_>> = text.split(',').map(cost).collect();
    found.ok_or_else(|| {
        refused(flag, text, &format!("allowed are numbers above 0 and up to {most} with commas between them"))
    })
}

/// A column by its key, of which less or more is better.
fn figure(matches: &ArgMatches, flag: &str) -> Result<&'static Column, CliError> {
    let key = matches.get_one::<String>(flag).expect("it has a default");
    let is_figure = |c: &&Column| c.better != Better::Neither;
    Column::of(key).filter(is_figure).ok_or_else(|| {
        let keys: Vec<_> = COLUMNS.iter().filter(is_figure).map(|c| c.key).collect();
        refused(flag, key, &format!("choose one of {}", keys.join(", ")))
    })
}
