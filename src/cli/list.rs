//! `bvhscope list`: the choices, with a line on each.

use clap::builder::PossibleValuesParser;
use clap::{Arg, ArgAction, ArgMatches, Command};
use serde_json::json;

use super::{CliError, output};
use crate::accel::Builder;
use crate::export::table;
use crate::render::{ColorMap, View};
use crate::scene::builtin;

const LISTS: [&str; 4] = ["builders", "views", "scenes", "colormaps"];

pub fn command() -> Command {
    Command::new("list")
        .about("The choices, with a line on each")
        .arg(Arg::new("WHAT").required(true).value_parser(PossibleValuesParser::new(LISTS)))
        .arg(Arg::new("json").long("json").action(ArgAction::SetTrue).help("Print JSON, for programs"))
}

pub fn run(matches: &ArgMatches) -> Result<(), CliError> {
    let choices = choices(matches.get_one::<String>("WHAT").expect("clap requires it"));
    if matches.get_flag("json") {
        let list: Vec<_> =
            choices.iter().map(|(name, about)| json!({ "name": name, "description": about })).collect();
        return output::print(&table::pretty(&list));
    }
    let widest = choices.iter().map(|(name, _)| name.len()).max().unwrap_or(0);
    let lines: Vec<_> = choices.iter().map(|(name, about)| format!("{name:widest$}  {about}")).collect();
    output::print(&lines.join("\n"))
}

fn choices(what: &str) -> Vec<(&'static str, &'static str)> {
    match what {
        "builders" => Builder::ALL.map(|b| (b.name(), b.description())).to_vec(),
        "views" => View::ALL.map(|v| (v.name(), v.description())).to_vec(),
        "scenes" => builtin::SCENES.to_vec(),
        "colormaps" => ColorMap::ALL.map(|c| (c.name(), c.description())).to_vec(),
        other => unreachable!("clap allows no list of {other}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_list_has_names_and_a_line_on_each() {
        for what in LISTS {
            let choices = choices(what);
            assert!(choices.len() >= 3, "{what}");
            assert!(choices.iter().all(|(name, about)| !name.is_empty() && about.len() > 8), "{what}");
        }
    }
}
