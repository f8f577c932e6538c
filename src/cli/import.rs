//! `bvhscope import`: a tree from another program, checked, and measured if there is no fault in it.

use std::path::PathBuf;

use anyhow::anyhow;
use clap::builder::ValueParser;
use clap::error::ErrorKind;
use clap::{Arg, ArgMatches, Command};

use super::workshop::Workshop;
use super::{CliError, args, output};
use crate::export::findings;
use crate::export::table::{self, TableFormat};
use crate::export::tree_file::is_tree_path;
use crate::world::{Imported, World};

pub fn command() -> Command {
    Command::new("import")
        .about("Checks a tree from another program, and measures it: see docs/tree-format.md")
        .after_help("Exit codes: 0 the tree is valid, 1 it has faults or cannot be read, 2 wrong usage.")
        .arg(
            Arg::new("TREE")
                .required(true)
                .value_parser(ValueParser::path_buf())
                .help("The tree: .npz or .json. Without a SCENE its own triangles are the scene"),
        )
}

pub fn run(matches: &ArgMatches) -> Result<(), CliError> {
    let path = matches.get_one::<PathBuf>("TREE").expect("clap asks for it");
    if !is_tree_path(path) {
        let message = format!("{} is no tree: it is read from .npz or .json", path.display());
        return Err(args::usage(ErrorKind::ValueValidation, message));
    }
    let mut session = args::session(matches)?;
    session.set_tree(Some(path.clone()));
    if !matches.contains_id("SCENE") && !matches.contains_id("session") {
        args::show_shapes_of_tree(&mut session);
    }
    let workshop = Workshop::open(session)?;
    let world = workshop.build()?;
    let imported = world.imported.as_ref().expect("a tree was asked for");
    let format = output::format(matches);
    if !imported.findings.is_valid() {
        output::print(&match format {
            TableFormat::People | TableFormat::Markdown => findings::people(imported),
            TableFormat::Json => findings::json(imported, None),
            TableFormat::Csv => findings::csv(&imported.findings),
        })?;
        let verdict = findings::verdict(&imported.findings);
        return Err(CliError::Failed(anyhow!("{} is not valid: {verdict}", path.display())));
    }
    measured(&workshop, &world, imported, format)
}

fn measured(
    workshop: &Workshop,
    world: &World,
    imported: &Imported,
    format: TableFormat,
) -> Result<(), CliError> {
    let session = &workshop.session;
    let name = &session.variants[session.active].name;
    let measurement = workshop.measurement(session.count);
    let stats = workshop.run("measuring the tree", |task| measurement.of_world(name, world, task))?;
    let rows = std::slice::from_ref(&stats);
    output::print(&match format {
        TableFormat::People => {
            let heading = workshop.heading(session.build(), session.count);
            format!("{}\n{heading}\n\n{}", findings::people(imported), table::people_one(&stats))
        }
        TableFormat::Json => findings::json(imported, Some(&stats)),
        TableFormat::Csv => table::csv(rows),
        TableFormat::Markdown => table::markdown(rows),
    })
}
