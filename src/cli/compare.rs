//! `bvhscope compare`: two settings side by side.

use clap::error::ErrorKind;
use clap::{Arg, ArgMatches, Command};

use super::workshop::Workshop;
use super::{CliError, args, output};
use crate::export::table::{self, TableFormat};
use crate::inspect::compare::Comparison;
use crate::inspect::stats::TreeStats;
use crate::session::Session;

pub fn command() -> Command {
    let side = |name: &'static str, help: &'static str| {
        Arg::new(name).long(name).value_name("FLAGS").allow_hyphen_values(true).help(help)
    };
    Command::new("compare")
        .about("Two settings, A and B, and how every figure differs")
        .arg(side("a", "Flags of A, as one word: --a '--builder median'; default: the session as it is"))
        .arg(side("b", "Flags of B: --b '--builder binned --bins 8'"))
}

pub fn run(matches: &ArgMatches) -> Result<(), CliError> {
    let [a, b] = sides(&args::session(matches)?, matches)?;
    let a = Workshop::open(a)?;
    let b = a.reopen(b)?;
    let comparison = Comparison::of(measured("A", &a)?, measured("B", &b)?);
    output::print(&match output::format(matches) {
        TableFormat::People => {
            let stats = &comparison.a;
            format!(
                "{}, {} shapes; what is equal is left out\n\n{}",
                stats.scene,
                stats.shape_count,
                table::compared(&comparison)
            )
        }
        TableFormat::Json => table::compared_json(&comparison),
        TableFormat::Csv => table::compared_csv(&comparison),
        TableFormat::Markdown => table::compared_markdown(&comparison),
    })
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
        return Ok([0, 1].map(|active| Session { active, ..base.clone() }));
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
