//! `bvhscope animate`: a range of time or a turn of the camera as pictures in a row, without a window.

use std::time::Instant;

use anyhow::anyhow;
use clap::error::ErrorKind;
use clap::{Arg, ArgAction, ArgMatches, Command, value_parser};

use super::workshop::Workshop;
use super::{CliError, args, output, progress, sweep};
use crate::export::animation::{FrameFormat, Frames, Stage, animate};
use crate::export::atomic;
use crate::export::picture::Extras;
use crate::task::Task;

/// Seconds of a turn for which no number of frames is named.
const TURN_SECONDS: u32 = 4;

pub fn command() -> Command {
    let number = |name: &'static str, value: &'static str, help: &'static str| {
        Arg::new(name).long(name).value_name(value).allow_negative_numbers(true).help(help)
    };
    Command::new("animate")
        .about("A range of time or a turn of the camera, as files in a row or one animated file")
        .arg(args::out("Where to: frame-####.png for a file a frame, or an animated .png or .gif"))
        .arg(
            number("frames", "N", "Frames; by default as many as time takes to pass, or 4 seconds of a turn")
                .value_parser(value_parser!(u32).range(1..=i64::from(Frames::MOST))),
        )
        .arg(
            number("fps", "N", "Frames a second")
                .value_parser(value_parser!(u32).range(1..=i64::from(Frames::MOST_FPS)))
                .default_value("25"),
        )
        .arg(
            number("from", "T", "The first moment, in seconds")
                .value_parser(value_parser!(f32))
                .requires("to"),
        )
        .arg(
            number("to", "T", "The last moment, in seconds; from 0 unless --from says otherwise")
                .value_parser(value_parser!(f32)),
        )
        .arg(
            number("turn", "DEGREES", "Turn the camera around its target; a whole turn if no time is named")
                .value_parser(value_parser!(f32)),
        )
        .arg(
            Arg::new("legend")
                .long("legend")
                .action(ArgAction::SetTrue)
                .help("Add a legend below each picture: colour bar with numbers, settings"),
        )
}

pub fn run(matches: &ArgMatches) -> Result<(), CliError> {
    let session = args::session(matches)?;
    let out = args::out_path(matches);
    let format = FrameFormat::of(out)
        .map_err(|error| args::usage(ErrorKind::ValueValidation, format!("--out: {error}")))?;
    let frames = frames(matches)?;
    atomic::check_writable(out)?;

    let start = Instant::now();
    let workshop = Workshop::open(session)?;
    if frames.time.is_some() && !workshop.still.is_animated() {
        output::warn("nothing moves in this scene: all moments look the same");
    }
    let task = Task::new();
    sweep::stop_at_ctrl_c(&task)?;
    let stage = Stage {
        session: &workshop.session,
        still: &workshop.still,
        tree: workshop.tree.as_ref(),
        camera: workshop.camera,
        extras: Extras { overlay: true, legend: matches.get_flag("legend") },
    };
    let what = format!("rendering {} frames", frames.count);
    let done = progress::watch(&what, &task, || workshop.install(|| animate(&stage, &frames, out, &task)));
    done.map_err(|error| CliError::Failed(anyhow!(error)))?;
    output::note(&format!(
        "{} frames, {:.1} s at {} a second; rendered in {:.1} s",
        frames.count,
        frames.seconds(),
        frames.fps,
        start.elapsed().as_secs_f64()
    ));
    if format == FrameFormat::Sequence {
        output::note("frames are numbered from 1 on");
    }
    output::print(&out.display().to_string())
}

fn frames(matches: &ArgMatches) -> Result<Frames, CliError> {
    let number = |name: &str| matches.get_one::<f32>(name).copied();
    for name in ["from", "to", "turn"] {
        if number(name).is_some_and(|value| !value.is_finite() || value.abs() > 1e6) {
            let message = format!("--{name}: allowed is a number from -1000000 to 1000000");
            return Err(args::usage(ErrorKind::ValueValidation, message));
        }
    }
    let fps = *matches.get_one::<u32>("fps").expect("it has a default");
    let time = number("to").map(|to| [number("from").unwrap_or(0.0), to]);
    let turn_degrees = number("turn").unwrap_or(if time.is_some() { 0.0 } else { 360.0 });
    let count = matches.get_one::<u32>("frames").copied();
    let count =
        count.unwrap_or_else(|| time.map_or(TURN_SECONDS * fps, |time| Frames::in_real_time(time, fps)));
    Ok(Frames { count, fps, time, turn_degrees })
}
