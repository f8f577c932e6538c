//! The commands: one file each. Parses a session, calls the library, prints.

mod animate;
mod args;
mod bench;
mod compare;
mod export_tree;
mod import;
mod list;
mod output;
mod progress;
mod render;
mod report;
mod stats;
mod sweep;
mod sweep_args;
mod table;
mod window;
mod workshop;

use std::io::{self, Write};
use std::process::ExitCode;

use clap::ArgMatches;

/// Why a command did not do what it was asked.
enum CliError {
    /// Wrong usage: exit code 2.
    Usage(clap::Error),
    /// It failed: exit code 1.
    Failed(anyhow::Error),
    /// Whoever read the results has gone, as `head` does: nobody is left to tell, and nothing went wrong.
    ReaderGone,
}

impl<E: Into<anyhow::Error>> From<E> for CliError {
    fn from(error: E) -> Self {
        Self::Failed(error.into())
    }
}

/// Runs the program with the process's arguments: 0 done, 1 failed, 2 wrong usage.
pub fn main() -> ExitCode {
    let matches = match args::program().try_get_matches() {
        Ok(matches) => matches,
        Err(error) => return report_usage(&error),
    };
    match run(&matches) {
        Ok(()) | Err(CliError::ReaderGone) => ExitCode::SUCCESS,
        Err(CliError::Usage(error)) => report_usage(&error),
        Err(CliError::Failed(error)) => {
            // Standard error may be closed, too.
            let _ = writeln!(io::stderr(), "error: {error:#}");
            ExitCode::FAILURE
        }
    }
}

fn run(matches: &ArgMatches) -> Result<(), CliError> {
    match matches.subcommand() {
        Some(("render", matches)) => render::run(matches),
        Some(("animate", matches)) => animate::run(matches),
        Some(("report", matches)) => report::run(matches),
        Some(("stats", matches)) => stats::run(matches),
        Some(("table", matches)) => table::run(matches),
        Some(("sweep", matches)) => sweep::run(matches),
        Some(("bench", matches)) => bench::run(matches),
        Some(("compare", matches)) => compare::run(matches),
        Some(("import", matches)) => import::run(matches),
        Some(("export-tree", matches)) => export_tree::run(matches),
        Some(("list", matches)) => list::run(matches),
        Some((other, _)) => unreachable!("clap knows no command {other}"),
        None => window::run(matches),
    }
}

/// Prints what clap has to say: an error, or the help and the version that were asked for.
fn report_usage(error: &clap::Error) -> ExitCode {
    // A closed pipe is no failure of ours.
    let _ = error.print();
    ExitCode::from(u8::try_from(error.exit_code()).unwrap_or(2))
}
