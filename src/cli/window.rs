//! `bvhscope [SCENE]`: the window.

use std::path::PathBuf;

use anyhow::anyhow;
use clap::ArgMatches;
use clap::parser::ValueSource;

use super::{CliError, args};
use crate::app::{self, Startup};
use crate::export::session_file;

pub fn run(matches: &ArgMatches) -> Result<(), CliError> {
    let session = args::session(matches)?;
    // A model that was named and is not there is said before a window opens; one that a session names is asked for there.
    let named = matches.get_one::<PathBuf>("SCENE").filter(|path| !session_file::is_session_path(path));
    if let (Some(_), crate::scene::SceneRef::File(path)) = (named, &session.scene.reference)
        && !path.exists()
    {
        return Err(CliError::Failed(anyhow!(
            "cannot read {}: there is no such file, and no built-in scene of that name (see: bvhscope list scenes)",
            path.display()
        )));
    }
    // Whoever names a session or says something of boxes gets what they ask for; a first look shows the tree.
    let opens_session = matches.contains_id("session")
        || matches.get_one::<PathBuf>("SCENE").is_some_and(|path| session_file::is_session_path(path));
    let says_boxes = matches.value_source("boxes") == Some(ValueSource::CommandLine);
    let says_tree = matches.value_source("tree") == Some(ValueSource::CommandLine);
    let names_something = matches.contains_id("SCENE") || matches.contains_id("session") || says_tree;
    let reopens = !names_something && !matches.get_flag("fresh");
    let startup = Startup {
        show_boxes: !opens_session && !says_boxes,
        reopen: reopens.then(|| args::given_flags(matches)),
        ..Startup::default()
    };
    Ok(app::run(session, startup)?)
}
