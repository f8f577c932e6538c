//! `bvhscope sweep`: a grid over bins and leaf limits.

use clap::error::ErrorKind;
use clap::{Arg, ArgMatches, Command};

use super::workshop::Workshop;
use super::{CliError, args, output};
use crate::accel::BuildConfig;
use crate::export::table::{self, TableFormat};
use crate::inspect::columns::Column;
use crate::inspect::sweep::{SweepGrid, sweep};

/// What is shown to people of each tree of the grid.
const SHOWN: [&str; 8] = [
    "name",
    "node_count",
    "depth_max",
    "sah_cost",
    "nodes_visited_mean",
    "ray_cost_mean",
    "build_ms",
    "traversal_ms",
];

pub fn command() -> Command {
    let list = |values: &[usize]| values.iter().map(usize::to_string).collect::<Vec<_>>().join(",");
    let grid = SweepGrid::default();
    Command::new("sweep")
        .about("A grid over numbers of bins and leaf limits, a tree each")
        .arg(
            Arg::new("bins-grid")
                .long("bins-grid")
                .value_name("N,N,...")
                .default_value(list(&grid.bins))
                .help("Numbers of bins, 2 to 256 each; builders without bins have one tree a leaf limit"),
        )
        .arg(
            Arg::new("leaf-grid")
                .long("leaf-grid")
                .value_name("N,N,...")
                .default_value(list(&grid.leaf))
                .help("Leaf limits, 1 to 64 each"),
        )
}

pub fn run(matches: &ArgMatches) -> Result<(), CliError> {
    let session = args::session(matches)?;
    let grid = SweepGrid {
        bins: numbers(matches, "bins-grid", BuildConfig::BINS)?,
        leaf: numbers(matches, "leaf-grid", BuildConfig::LEAF)?,
    };
    let workshop = Workshop::open(session)?;
    let session = &workshop.session;
    let measurement = workshop.measurement(session.count);
    let rows = workshop
        .run("measuring trees", |task| sweep(&measurement, session.build(), &grid, task, &mut |_| ()))?;
    output::print(&match output::format(matches) {
        TableFormat::People => {
            let columns = SHOWN.map(|key| Column::of(key).expect("the key of a column"));
            let render = &session.render;
            format!(
                "{}, {} shapes; {} builder, width {}; {} x {} pixels, {} rays\n\n{}\n\n* the best of its column",
                workshop.scene.name,
                workshop.scene.shape_count(),
                session.build().builder.name(),
                session.build().width.name(),
                render.width,
                render.height,
                session.count.name(),
                table::people_by_rows(&rows, &columns)
            )
        }
        TableFormat::Json => table::json(&rows),
        TableFormat::Csv => table::csv(&rows),
        TableFormat::Markdown => table::markdown(&rows),
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
        let message = format!(
            "--{flag} '{text}': allowed are whole numbers from {start} to {end} with commas between them"
        );
        args::usage(ErrorKind::ValueValidation, message)
    })
}
