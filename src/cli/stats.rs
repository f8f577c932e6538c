//! `bvhscope stats`: one tree's numbers.

use clap::ArgMatches;

use super::workshop::Workshop;
use super::{CliError, args, output};
use crate::export::table::{self, TableFormat};

pub fn run(matches: &ArgMatches) -> Result<(), CliError> {
    let workshop = Workshop::open(args::session(matches)?)?;
    let session = &workshop.session;
    let name = &session.variants[session.active].name;
    let measurement = workshop.measurement(session.count);
    let stats = workshop.run("measuring the tree", |task| {
        task.start(measurement.steps());
        measurement.of(name, session.build(), workshop.tree.as_ref(), task)
    })?;
    workshop.warn_if_broken(&stats);
    let rows = std::slice::from_ref(&stats);
    output::print(&match output::format(matches) {
        TableFormat::People => {
            format!("{}\n\n{}", workshop.heading(session.build(), session.count), table::people_one(&stats))
        }
        TableFormat::Json => table::json_one(&stats),
        TableFormat::Csv => table::csv(rows),
        TableFormat::Markdown => table::markdown(rows),
    })
}
