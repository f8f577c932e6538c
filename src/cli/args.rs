//! The command line as clap sees it: every flag comes from the session's one table; and the session that it describes.

use std::path::{Path, PathBuf};

use clap::builder::PossibleValuesParser;
use clap::builder::{PossibleValue, ValueParser};
use clap::error::ErrorKind;
use clap::parser::ValueSource;
use clap::{Arg, ArgAction, ArgMatches, Command};

use super::CliError;
use super::{animate, bench, compare, export_tree, import, list, output, render, report, sweep};
use crate::export::session_file;
use crate::scene::SceneRef;
use crate::scene::load::TreeFormat;
use crate::session::flags::{Flag, flags};
use crate::session::{Session, SessionScene};

const EXAMPLES: &str = "\
Examples:
  bvhscope                                      the window, with the built-in bunny
  bvhscope model.obj                            the window, with a model of yours
  bvhscope picture.png                          the window, showing what a saved picture shows
  bvhscope render --out heat.png --view nodes-visited --boxes 0..4
  bvhscope table soup:100000 --json
  bvhscope import tree.npz                      checks and measures a tree from another program
  bvhscope compare --a '--builder median' --b '--builder binned --bins 8'
  bvhscope compare --view nodes-visited --b '--time 0.5' --difference moved.png

Exit codes: 0 done, 1 failed, 2 wrong usage.";

/// The whole command line.
pub fn program() -> Command {
    with_session(Command::new("bvhscope"))
        .arg(Arg::new("fresh").long("fresh").action(ArgAction::SetTrue).help(
            "The window starts with the default scene and settings instead of what it showed last time",
        ))
        .version(env!("CARGO_PKG_VERSION"))
        .about("An inspector for bounding volume hierarchies: see why the rays cost what they cost.")
        .after_help(EXAMPLES)
        .args_conflicts_with_subcommands(true)
        .disable_help_subcommand(true)
        .args_override_self(true)
        .subcommands([
            with_session(render::command()),
            with_session(animate::command()),
            with_session(report::command()),
            with_session(output::with_formats(
                Command::new("stats").about("All figures of one tree, with what each means"),
            )),
            with_session(output::with_formats(
                Command::new("table").about("Five trees side by side on one scene and view"),
            )),
            with_session(output::with_formats(sweep::command())),
            with_session(output::with_formats(bench::command())),
            with_session(output::with_formats(compare::command())),
            with_session(output::with_formats(import::command())),
            with_session(export_tree::command()),
            list::command(),
        ])
}

/// Adds the scene, the session's file and every flag.
fn with_session(command: Command) -> Command {
    command
        .args_override_self(true)
        .arg(
            Arg::new("SCENE")
                .value_parser(ValueParser::path_buf())
                .help("A model, a session (.ron, or a .png that bvhscope wrote), a tree (.npz, .json), or a built-in scene (see: bvhscope list scenes)")
                .long_help(
                    "A model (.obj .ply .stl .gltf .glb), a session (.ron, or a .png that bvhscope wrote), a tree with its \
                     triangles (.npz .json), or the name of a built-in scene, as bunny or soup:1000000; bvhscope list scenes shows them. Default: bunny",
                ),
        )
        .arg(
            Arg::new("session")
                .long("session")
                .value_name("FILE")
                .value_parser(ValueParser::path_buf())
                .help("Start from the settings of a session (.ron or .png); flags and SCENE change it"),
        )
        .args(flags().iter().map(flag_arg))
}

/// One flag of the table.
fn flag_arg(flag: &'static Flag) -> Arg {
    let arg = Arg::new(flag.name)
        .long(flag.name)
        .help(flag.help)
        .help_heading(flag.group.name())
        .default_value(flag.write(&Session::default()));
    let Some(value_name) = flag.value_name else {
        return arg
            .action(ArgAction::Set)
            .value_name("on|off")
            .num_args(0..=1)
            .require_equals(true)
            .default_missing_value("on")
            .value_parser(["on", "off"])
            .hide_possible_values(true);
    };
    let choices = (flag.choices)();
    let arg = arg.value_name(value_name).allow_negative_numbers(true);
    if choices.is_empty() {
        // `-1,2,3,...` and `-2..5` are no negative numbers to clap.
        let begins_with_a_sign = matches!(flag.name, "camera" | "range");
        return arg.allow_hyphen_values(begins_with_a_sign);
    }
    let values = choices.iter().map(|choice| {
        let value = PossibleValue::new(choice.name);
        if choice.description.is_empty() { value } else { value.help(choice.description) }
    });
    arg.value_parser(PossibleValuesParser::new(values))
}

/// The flag `--out` of commands that write one file.
pub fn out(help: &'static str) -> Arg {
    Arg::new("out")
        .long("out")
        .value_name("FILE")
        .required(true)
        .value_parser(ValueParser::path_buf())
        .help(help)
}

/// The path that [`out`] was given.
pub fn out_path(matches: &ArgMatches) -> &PathBuf {
    matches.get_one("out").expect("clap requires --out")
}

/// The session that the command line describes: defaults, then a session's file, then the scene, then the flags.
pub fn session(matches: &ArgMatches) -> Result<Session, CliError> {
    let file = matches.get_one::<PathBuf>("session");
    let scene = matches.get_one::<PathBuf>("SCENE");
    let scene_session = scene.filter(|path| session_file::is_session_path(path));
    if let (Some(_), Some(scene)) = (file, scene_session) {
        let message = format!("{} is a session itself; leave out --session", scene.display());
        return Err(usage(ErrorKind::ArgumentConflict, message));
    }
    let mut session = match file.or(scene_session) {
        Some(path) => session_file::open(path)?,
        None => Session::default(),
    };
    if let Some(scene) = scene.filter(|_| scene_session.is_none()) {
        set_scene(&mut session, scene);
    }
    apply_flags(&mut session, matches)?;
    if scene.is_none() && file.is_none() && given(matches, "tree") {
        show_shapes_of_tree(&mut session);
    }
    Ok(session)
}

/// Another scene, or the same; a tree's file comes with its tree.
fn set_scene(session: &mut Session, scene: &Path) {
    let reference = match scene.to_str() {
        Some(text) => SceneRef::parse(text),
        None => SceneRef::File(scene.to_owned()),
    };
    if session.scene.reference != reference {
        // What was remembered was of another scene.
        session.scene = SessionScene { reference, ..SessionScene::default() };
    }
    if TreeFormat::of(scene).is_some() {
        session.set_tree(Some(scene.to_owned()));
    }
}

/// Without a scene beside it, a tree comes with its shapes.
pub fn show_shapes_of_tree(session: &mut Session) {
    if let Some(tree) = session.tree() {
        session.scene =
            SessionScene { reference: SceneRef::File(tree.path.clone()), ..SessionScene::default() };
    }
}

/// Whether a flag was given by the user.
fn given(matches: &ArgMatches, flag: &str) -> bool {
    matches.value_source(flag) == Some(ValueSource::CommandLine)
}

/// The flags of the table that the user gave, as text.
pub fn given_flags(matches: &ArgMatches) -> Vec<(&'static str, String)> {
    let text = |name| matches.get_one::<String>(name).expect("a flag that was given has a value").clone();
    flags().iter().filter(|flag| given(matches, flag.name)).map(|flag| (flag.name, text(flag.name))).collect()
}

/// Applies flags, and perhaps a scene, given as one text: what `compare` takes for A and B.
pub fn apply_text(session: &mut Session, text: &str, name: &'static str) -> Result<(), CliError> {
    let words = shlex::split(text).ok_or_else(|| {
        usage(ErrorKind::ValueValidation, format!("--{name} '{text}': a quote is not closed"))
    })?;
    let parser = Command::new(format!("bvhscope compare --{name}"))
        .no_binary_name(true)
        .disable_help_flag(true)
        .args_override_self(true)
        .arg(Arg::new("SCENE").value_parser(ValueParser::path_buf()))
        .args(flags().iter().map(flag_arg));
    let matches = parser.try_get_matches_from(words).map_err(CliError::Usage)?;
    if let Some(scene) = matches.get_one::<PathBuf>("SCENE") {
        if session_file::is_session_path(scene) {
            let message = format!("--{name} '{text}': {} is a session; name a scene", scene.display());
            return Err(usage(ErrorKind::ValueValidation, message));
        }
        set_scene(session, scene);
    }
    apply_flags(session, &matches)
}

fn apply_flags(session: &mut Session, matches: &ArgMatches) -> Result<(), CliError> {
    for flag in flags() {
        if given(matches, flag.name) {
            let text = matches.get_one::<String>(flag.name).expect("a flag that was given has a value");
            flag.read(session, text).map_err(|error| usage(ErrorKind::ValueValidation, error.to_string()))?;
        }
    }
    // What goes together, and what does not.
    session.build().check().map_err(|error| usage(ErrorKind::ArgumentConflict, error))
}

/// An error in what was typed: exit code 2.
pub fn usage(kind: ErrorKind, message: impl std::fmt::Display) -> CliError {
    CliError::Usage(program().error(kind, message))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::accel::Builder;
    use crate::render::View;

    fn parsed(words: &str) -> Result<Session, String> {
        let words = std::iter::once("bvhscope".to_owned()).chain(shlex::split(words).expect("whole quotes"));
        let matches = program().try_get_matches_from(words).map_err(|error| error.to_string())?;
        let inner = matches.subcommand().map_or(&matches, |(_, inner)| inner);
        session(inner).map_err(|error| match error {
            CliError::Usage(error) => error.to_string(),
            CliError::Failed(error) => error.to_string(),
            CliError::ReaderGone => unreachable!("nothing was printed"),
        })
    }

    #[test]
    fn clap_finds_no_fault_in_the_table() {
        program().debug_assert();
    }

    #[test]
    fn no_flags_give_the_default_session() {
        assert_eq!(parsed(""), Ok(Session::default()));
        assert_eq!(parsed("render --out F.png"), Ok(Session::default()));
    }

    #[test]
    fn flags_of_every_kind_are_read_and_the_last_one_counts() {
        let text = "stats soup:50 --builder median --builder binned --leaf 4 --leaves-only --ground=off \
                    --camera -1,2,3,0,0,0,50 --range -2..5 --time -1.5 --view ray-cost --boxes 2 --up z";
        let session = parsed(text).expect("a session");
        assert_eq!(session.scene.reference, SceneRef::Builtin("soup:50".to_owned()));
        assert_eq!((session.build().builder, session.build().leaf), (Builder::Binned, 4));
        assert_eq!((session.view, session.display.range), (View::RayCost, Some([-2.0, 5.0])));
        assert_eq!((session.time, session.overlay.depths), (-1.5, Some([2, 2])));
        assert!(session.overlay.leaves_only && !session.ground);
        assert_eq!(session.camera.map(|c| (c.eye.x, c.up.name())), Some((-1.0, "z")));
    }

    #[test]
    fn wrong_values_say_what_is_allowed() {
        for (text, expected) in [
            ("--bins 300", "--bins '300': allowed is a whole number from 2 to 256"),
            ("--builder best", "possible values: median, sweep, binned, spatial"),
            ("--view nodes", "nodes-visited"),
            ("--size 10", "WIDTHxHEIGHT"),
            ("render", "--out"),
            ("--no-such-flag", "unexpected argument"),
            ("stats --json --csv", "cannot be used with"),
            ("--session a.ron b.png", "is a session itself"),
            ("list nothing", "scenes"),
        ] {
            let message = parsed(text).expect_err(text);
            assert!(message.contains(expected), "{text}: {message}");
        }
    }

    #[test]
    fn the_command_that_is_copied_is_the_one_that_is_read() {
        let text = "render room --out F.png --width 4 --bins 9 --camera 1,2,3,4,5,6.25,30 --boxes-hidden --exposure -1";
        let session = parsed(text).expect("a session");
        let copied = crate::session::flags::command_line(&session, "F.png");
        assert_eq!(parsed(copied.strip_prefix("bvhscope ").expect("the program")), Ok(session));
    }

    #[test]
    fn flags_as_text_change_a_copy() {
        let mut session = Session::default();
        assert!(apply_text(&mut session, "--builder 'median' --leaf 8", "a").is_ok());
        assert_eq!((session.build().builder, session.build().leaf), (Builder::Median, 8));
        assert!(matches!(apply_text(&mut session, "--builder 'median", "a"), Err(CliError::Usage(_))));
        assert!(matches!(apply_text(&mut session, "--json", "a"), Err(CliError::Usage(_))));
        assert!(matches!(apply_text(&mut session, "a.ron", "a"), Err(CliError::Usage(_))));
        assert!(matches!(apply_text(&mut session, "soup:5 room", "a"), Err(CliError::Usage(_))));
        assert!(apply_text(&mut session, "soup:5 --time 0.5", "a").is_ok());
        assert_eq!(session.scene.reference, SceneRef::Builtin("soup:5".to_owned()));
        assert_eq!((session.time, session.build().builder), (0.5, Builder::Median));
    }
}
