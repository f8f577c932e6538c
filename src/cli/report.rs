//! `bvhscope report`: a session as one page of HTML.

use std::time::Instant;

use anyhow::anyhow;
use clap::{Arg, ArgAction, ArgMatches, Command};

use super::workshop::Workshop;
use super::{CliError, args, output, progress};
use crate::export::atomic;
use crate::export::report::{Measured, Report};
use crate::inspect::table::five_trees;
use crate::task::Task;

pub fn command() -> Command {
    Command::new("report")
        .about("Pictures, figures, plots and settings as one page of HTML")
        .arg(args::out("Where to: an .html file that needs nothing but itself"))
        .arg(
            Arg::new("table")
                .long("table")
                .action(ArgAction::SetTrue)
                .help("Measure the five trees, too, and put them side by side"),
        )
}

pub fn run(matches: &ArgMatches) -> Result<(), CliError> {
    let session = args::session(matches)?;
    let out = args::out_path(matches);
    atomic::check_writable(out)?;
    let start = Instant::now();
    let workshop = Workshop::open(session)?;
    let world = workshop.build()?;
    let mut measured = Measured::default();
    if matches.get_flag("table") {
        let (build, settings) = (workshop.session.build(), &workshop.session.render);
        measured.table = workshop.run("measuring five trees", |task| {
            five_trees(&workshop.scene, &workshop.camera, build, settings, task, &mut |_| ())
        })?;
    }
    let task = Task::new();
    let report = progress::watch("making the report", &task, || {
        workshop.install(|| Report::make(&workshop.session, &world, workshop.camera, measured, &task))
    });
    let report = report.map_err(|error| CliError::Failed(anyhow!(error)))?;
    report.save(out)?;
    output::note(&format!("a page of HTML, {:.1} s", start.elapsed().as_secs_f64()));
    output::print(&out.display().to_string())
}
