//! `bvhscope compare`: two settings, scenes or moments side by side, as a table and as pictures.

use std::path::{Path, PathBuf};

use clap::builder::ValueParser;
use clap::error::ErrorKind;
use clap::{Arg, ArgMatches, Command};
use image::RgbaImage;

use super::workshop::Workshop;
use super::{CliError, args, output, render};
use crate::export::comparison::{self, ComparedSide};
use crate::export::table::{self, TableFormat};
use crate::export::{atomic, session_file};
use crate::inspect::compare::Comparison;
use crate::inspect::difference::has_difference;
use crate::inspect::paired_cost::PairedRayCost;
use crate::inspect::stats::TreeStats;
use crate::render::{Film, View};
use crate::session::{Session, Variant};
use crate::world::World;

const NAMES: [&str; 2] = ["A", "B"];

pub fn command() -> Command {
    let side = |name: &'static str, help: &'static str| {
        Arg::new(name).long(name).value_name("FLAGS").allow_hyphen_values(true).help(help)
    };
    let picture = |name: &'static str, help: &'static str| {
        Arg::new(name)
            .long(name)
            .value_name("FILE.png")
            .value_parser(ValueParser::path_buf())
            .help(help)
            .help_heading("Output")
    };
    Command::new("compare")
        .about("Two settings, scenes or moments, A and B, and how every figure differs")
        .arg(side(
            "a",
            "Flags of A, and perhaps a scene, as one word: --a '--builder median', --a 'soup:1000'; default: the \
             session as it is",
        ))
        .arg(side("b", "The same of B: --b '--builder binned --bins 8', --b '--time 0.5', --b '--tree t.npz'"))
        .arg(picture("out", "Write the pictures of A and B side by side, on one range"))
        .arg(picture("difference", "Write the picture of B - A; needs a view of numbers, as --view ray-cost"))
}

pub fn run(matches: &ArgMatches) -> Result<(), CliError> {
    let sides = sides(&args::session(matches)?, matches)?;
    let wanted = Pictures::wanted(matches, &sides)?;
    let [a, b] = sides;
    let a = Workshop::open(a)?;
    let b = a.reopen(b)?;
    let mut comparison = Comparison::of(measured("A", &a)?, measured("B", &b)?);
    if !comparison.has_one_unit() {
        output::warn(
            "A and B have different costs C_t and C_i: their SAH costs and ray costs have different units",
        );
    }
    let worlds = [a.build()?, b.build()?];
    comparison.ray_cost = ray_cost([&a, &b], &worlds)?;
    wanted.write([&a, &b], &worlds)?;
    output::print(&match output::format(matches) {
        TableFormat::People => people(&comparison),
        TableFormat::Json => table::compared_json(&comparison),
        TableFormat::Csv => table::compared_csv(&comparison),
        TableFormat::Markdown => table::compared_markdown(&comparison),
    })
}

fn people(comparison: &Comparison) -> String {
    let scene = |stats: &TreeStats| format!("{}, {} shapes", stats.scene, stats.shape_count);
    let (a, b) = (scene(&comparison.a), scene(&comparison.b));
    let scenes = if a == b { a } else { format!("A: {a}; B: {b}") };
    format!("{scenes}; what is equal is left out\n\n{}", table::compared(comparison))
}

/// The sessions of A and B: the base with each one's flags, or a session's first two variants.
fn sides(base: &Session, matches: &ArgMatches) -> Result<[Session; 2], CliError> {
    let texts = ["a", "b"].map(|side| matches.get_one::<String>(side));
    if texts == [None, None] {
        if base.variants.len() < 2 {
            let message = "say what to compare: --a '--builder median' --b '--builder binned --bins 8', or a session \
                           with two variants";
            return Err(args::usage(ErrorKind::MissingRequiredArgument, message));
        }
        return Ok([0, 1].map(|index| base.activated(index)));
    }
    let mut sides = [base.clone(), base.clone()];
    for ((session, text), name) in sides.iter_mut().zip(texts).zip(["a", "b"]) {
        if let Some(text) = text {
            args::apply_text(session, text, name)?;
        }
    }
    Ok(sides)
}

fn measured(name: &str, workshop: &Workshop) -> Result<TreeStats, CliError> {
    let session = &workshop.session;
    let measurement = workshop.measurement(session.count);
    workshop
        .run(&format!("measuring {name}"), |task| {
            task.start(measurement.steps());
            measurement.of(name, session.build(), workshop.tree.as_ref(), task)
        })
        .inspect(|stats| workshop.warn_if_broken(stats))
}

/// `None` where the two have different numbers of camera rays.
fn ray_cost(sides: [&Workshop; 2], worlds: &[World; 2]) -> Result<Option<PairedRayCost>, CliError> {
    let size = |side: &Workshop| [side.session.render.width, side.session.render.height];
    if size(sides[0]) != size(sides[1]) {
        return Ok(None);
    }
    let cameras = sides.map(|side| &side.camera);
    let settings = &sides[0].session.render;
    let worlds = [&worlds[0], &worlds[1]];
    sides[0].run("pairing rays", |task| PairedRayCost::measure(worlds, cameras, settings, task))
}

/// Files that were asked for.
struct Pictures {
    out: Option<PathBuf>,
    difference: Option<PathBuf>,
}

impl Pictures {
    /// Says at once what cannot be done.
    fn wanted(matches: &ArgMatches, [a, b]: &[Session; 2]) -> Result<Self, CliError> {
        let path = |name: &str| matches.get_one::<PathBuf>(name).cloned();
        let wanted = Self { out: path("out"), difference: path("difference") };
        for (name, path) in [("out", &wanted.out), ("difference", &wanted.difference)] {
            let Some(path) = path else { continue };
            if !path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("png")) {
                let message = format!("--{name} '{}': the file must end in .png", path.display());
                return Err(args::usage(ErrorKind::ValueValidation, message));
            }
            atomic::check_writable(path)?;
        }
        let size = |session: &Session| [session.render.width, session.render.height];
        let subjects = [a.film_subject(), b.film_subject()];
        if wanted.difference.is_some() && (subjects[0] != subjects[1] || size(a) != size(b)) {
            let message = "--difference: A and B must show the same view, rays and size";
            return Err(args::usage(ErrorKind::ArgumentConflict, message));
        }
        if wanted.difference.is_some() && !has_difference(a.view) {
            let views: Vec<&str> =
                View::ALL.into_iter().filter(|view| has_difference(*view)).map(View::name).collect();
            let message = format!(
                "--difference: the view '{}' has no numbers to subtract; choose --view {}",
                a.view.name(),
                views.join(", ")
            );
            return Err(args::usage(ErrorKind::ArgumentConflict, message));
        }
        Ok(wanted)
    }

    fn write(&self, workshops: [&Workshop; 2], worlds: &[World; 2]) -> Result<(), CliError> {
        if self.out.is_none() && self.difference.is_none() {
            return Ok(());
        }
        let films = [render::film(workshops[0], &worlds[0])?, render::film(workshops[1], &worlds[1])?];
        let sides = [0, 1].map(|i| ComparedSide {
            name: NAMES[i],
            session: &workshops[i].session,
            film: &films[i],
            world: &worlds[i],
        });
        let session = session_of(workshops, &films[0]);
        if let Some(path) = &self.out {
            let boxes = [boxes(workshops[0], &worlds[0])?, boxes(workshops[1], &worlds[1])?];
            let draw_over = |i: usize, picture: &mut RgbaImage| {
                if let Some(boxes) = &boxes[i] {
                    crate::render::overlay::compose(picture, boxes);
                }
            };
            save(&comparison::side_by_side(sides, draw_over), &session, path)?;
        }
        if let Some(path) = &self.difference {
            let picture = comparison::difference(sides).expect("it was checked that they can be subtracted");
            save(&picture, &session, path)?;
        }
        Ok(())
    }
}

fn boxes(workshop: &Workshop, world: &World) -> Result<Option<crate::render::Overlay>, CliError> {
    let render = &workshop.session.render;
    render::drawn_boxes(workshop, world, render.width, render.height)
}

fn save(picture: &RgbaImage, session: &Session, path: &Path) -> Result<(), CliError> {
    render::writing(|| session_file::save_picture(picture, session, path))?;
    output::note(&format!("written: {}", path.display()));
    Ok(())
}

/// The session that the pictures carry: A's, with A and B as its states.
fn session_of(workshops: [&Workshop; 2], film: &Film) -> Session {
    let [a, b] = workshops.map(|workshop| &workshop.session);
    let state = |session: &Session, name: &str| Variant {
        name: name.to_owned(),
        scene: (session.scene.reference != a.scene.reference).then(|| session.scene.clone()),
        time: (session.time != a.time).then_some(session.time),
        ..session.variants[session.active].clone()
    };
    let variants = vec![state(a, NAMES[0]), state(b, NAMES[1])];
    let mut session = Session { variants, active: 0, ..a.clone() };
    session.render.spp = Some(film.samples);
    session
}
