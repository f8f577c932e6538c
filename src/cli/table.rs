//! `bvhscope table`: the five trees side by side, all rays of a Whitted frame counted.

use clap::ArgMatches;

use super::workshop::Workshop;
use super::{CliError, args, output};
use crate::export::table::{self, TableFormat};
use crate::inspect::table::five_trees;
use crate::render::CountKind;

pub fn run(matches: &ArgMatches) -> Result<(), CliError> {
    let workshop = Workshop::open(args::session(matches)?)?;
    let build = workshop.session.build();
    let rows = workshop.run("measuring five trees", |task| {
        let settings = &workshop.session.render;
        five_trees(&workshop.scene, &workshop.camera, build, settings, task, &mut |_| ())
    })?;
    output::print(&match output::format(matches) {
        TableFormat::People => {
            let heading = workshop.heading(build, CountKind::All);
            format!(
                "{heading}\n\n{}\n\n* the best of its line\n\n{}",
                table::people(&rows),
                table::agreements(&rows)
            )
        }
        TableFormat::Json => table::json(&rows),
        TableFormat::Csv => table::csv(&rows),
        TableFormat::Markdown => table::markdown(&rows),
    })
}
