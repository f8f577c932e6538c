//! `bvhscope export-tree`: a tree for other programs.

use clap::error::ErrorKind;
use clap::{ArgMatches, Command};

use super::workshop::Workshop;
use super::{CliError, args, output};
use crate::export::atomic;
use crate::export::tree_file::{is_tree_path, save};

pub fn command() -> Command {
    Command::new("export-tree")
        .about("Writes a tree for other programs, with the triangles it is over: see docs/tree-format.md")
        .arg(args::out("The file to write: .npz, or .json to be read by people"))
}

pub fn run(matches: &ArgMatches) -> Result<(), CliError> {
    let path = args::out_path(matches);
    if !is_tree_path(path) {
        let message = format!("--out {}: a tree is written as .npz or .json", path.display());
        return Err(args::usage(ErrorKind::ValueValidation, message));
    }
    let workshop = Workshop::open(args::session(matches)?)?;
    atomic::check_writable(path)?;
    let world = workshop.build()?;
    let with_shapes = save(&world.tree, &world.scene, path)?;
    if !with_shapes {
        output::note(&format!(
            "{} has shapes that are no triangles: the tree is written without them, so name the scene to read it back",
            world.scene.name
        ));
    }
    output::note(&format!(
        "{}: {} nodes and leaves, {} references",
        path.display(),
        world.tree.node_count(),
        world.tree.refs().len()
    ));
    Ok(())
}
