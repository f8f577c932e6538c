//! `bvhscope render`: one picture, or its raw numbers, without a window.

use std::path::Path;
use std::time::Instant;

use clap::error::ErrorKind;
use clap::{Arg, ArgAction, ArgMatches, Command};
use image::RgbaImage;

use super::workshop::Workshop;
use super::{CliError, args, output, progress};
use crate::export::legend::Legend;
use crate::export::{ExportError, atomic, exr, raw_csv, session_file};
use crate::render::{Film, Overlay, display, integrate, overlay};
use crate::session::{Session, file};
use crate::task::Task;
use crate::world::World;

/// Kinds of files, by extension.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Format {
    /// The picture as the window shows it.
    Png,
    /// Raw numbers or linear colours.
    Exr,
    Csv,
}

impl Format {
    const ALL: [Self; 3] = [Self::Png, Self::Exr, Self::Csv];

    fn extension(self) -> &'static str {
        match self {
            Self::Png => "png",
            Self::Exr => "exr",
            Self::Csv => "csv",
        }
    }

    fn of(path: &Path) -> Option<Self> {
        let extension = path.extension()?.to_string_lossy().to_ascii_lowercase();
        Self::ALL.into_iter().find(|format| format.extension() == extension)
    }
}

pub fn command() -> Command {
    Command::new("render")
        .about("One picture without a window, or the raw numbers behind it")
        .arg(args::out("Where to: .png for the picture, .exr or .csv for raw numbers or linear colours"))
        .arg(
            Arg::new("legend")
                .long("legend")
                .action(ArgAction::SetTrue)
                .help("Add a legend below the picture: colour bar with numbers, settings"),
        )
}

pub fn run(matches: &ArgMatches) -> Result<(), CliError> {
    let session = args::session(matches)?;
    let out = args::out_path(matches);
    let format = Format::of(out).ok_or_else(|| {
        let message = format!("--out '{}': the file must end in .png, .exr or .csv", out.display());
        args::usage(ErrorKind::ValueValidation, message)
    })?;
    atomic::check_writable(out)?;

    let start = Instant::now();
    let workshop = Workshop::open(session)?;
    let world = workshop.build()?;
    let film = film(&workshop, &world)?;
    let legend = matches.get_flag("legend");
    if format != Format::Png && (legend || workshop.session.overlay.depths.is_some()) {
        output::warn("a file of raw numbers holds neither boxes nor a legend");
    }
    let session = finished(&workshop.session, &film);
    match format {
        Format::Png => {
            let mut picture = display::picture(&film, &session.display);
            draw_boxes(&workshop, &world, &mut picture)?;
            if legend {
                picture = Legend::of(&session, &film, &world).below(&picture);
            }
            writing(|| session_file::save_picture(&picture, &session, out))?;
        }
        Format::Exr => {
            let text = file::to_text(&session, out.parent());
            writing(|| exr::save(&[&film], Some(&text), out))?;
        }
        Format::Csv => writing(|| raw_csv::save(&film, out))?,
    }
    output::note(&format!(
        "{}: {} x {} pixels, {} a pixel, {:.1} s",
        film.subject.view.name(),
        film.width,
        film.height,
        if film.samples == 1 { "1 sample".to_owned() } else { format!("{} samples", film.samples) },
        start.elapsed().as_secs_f64()
    ));
    output::print(&out.display().to_string())
}

/// The film of the session's view.
pub fn film(workshop: &Workshop, world: &World) -> Result<Film, CliError> {
    let session = &workshop.session;
    let settings = &session.render;
    let what = format!("rendering {}", session.view.name());
    workshop.run(&what, |task| {
        let samples = settings.spp.unwrap_or(1);
        integrate::render(session.film_subject(), world, &workshop.camera, settings, samples, task)
    })
}

/// The session of the finished picture: opened, it shows the same.
fn finished(session: &Session, film: &Film) -> Session {
    let mut session = session.clone();
    session.render.spp = Some(film.samples);
    session
}

fn draw_boxes(workshop: &Workshop, world: &World, picture: &mut RgbaImage) -> Result<(), CliError> {
    if let Some(drawn) = drawn_boxes(workshop, world, picture.width(), picture.height())? {
        overlay::compose(picture, &drawn);
    }
    Ok(())
}

/// The boxes that the session shows; `None` if it shows none.
pub fn drawn_boxes(
    workshop: &Workshop,
    world: &World,
    width: u32,
    height: u32,
) -> Result<Option<Overlay>, CliError> {
    let settings = workshop.session.overlay;
    if settings.depths.is_none() {
        return Ok(None);
    }
    let camera = &workshop.camera;
    let drawn = workshop.run("drawing boxes", |task| {
        let distances = overlay::first_hit_distances(world, camera, width, height, task)?;
        overlay::draw_boxes(world, camera, &settings, &[], &distances, [width, height], task)
    })?;
    warn_of_omissions(&drawn);
    Ok(Some(drawn))
}

fn warn_of_omissions(drawn: &Overlay) {
    if drawn.over_budget > 0 {
        output::warn(&format!(
            "{} of {} boxes are left out beyond the budget; --boxes-budget raises it",
            drawn.over_budget, drawn.selected
        ));
    }
}

/// Large files take their time, too.
pub fn writing(write: impl FnOnce() -> Result<(), ExportError>) -> Result<(), ExportError> {
    progress::watch("writing the file", &Task::new(), write)
}
