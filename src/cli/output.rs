//! Results on standard output, warnings on standard error; neither panics when the other end has gone.

use std::io::{self, ErrorKind, Write};

use clap::{Arg, ArgAction, ArgGroup, ArgMatches, Command};

use super::CliError;
use crate::export::table::TableFormat;

/// Adds `--json`, `--csv` and `--markdown`, of which one can be given.
pub fn with_formats(command: Command) -> Command {
    let flag = |name: &'static str, help: &'static str| {
        Arg::new(name).long(name).help(help).action(ArgAction::SetTrue).help_heading("Output")
    };
    command
        .arg(flag("json", "Print JSON, for programs"))
        .arg(flag("csv", "Print CSV, for programs"))
        .arg(flag("markdown", "Print a Markdown table"))
        .group(ArgGroup::new("format").args(["json", "csv", "markdown"]))
}

/// The format that was asked for.
pub fn format(matches: &ArgMatches) -> TableFormat {
    let asked = |format: &TableFormat| *format != TableFormat::People && matches.get_flag(format.name());
    TableFormat::ALL.into_iter().find(asked).unwrap_or_default()
}

/// Prints a result and ends its last line.
pub fn print(text: &str) -> Result<(), CliError> {
    let mut out = io::stdout().lock();
    let end = if text.ends_with('\n') { "" } else { "\n" };
    let written = write!(out, "{text}{end}").and_then(|()| out.flush());
    written.map_err(|error| match error.kind() {
        ErrorKind::BrokenPipe => CliError::ReaderGone,
        _ => CliError::Failed(anyhow::anyhow!("cannot write to standard output: {error}")),
    })
}

/// Says something beside the result. Nobody may be listening.
pub fn warn(text: &str) {
    let _ = writeln!(io::stderr(), "warning: {text}");
}

/// Says what was done, on standard error.
pub fn note(text: &str) {
    let _ = writeln!(io::stderr(), "{text}");
}
