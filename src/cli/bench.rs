//! `bvhscope bench`: rays a second and build times; rays from a file, and answers to and from files.

use std::path::PathBuf;

use clap::builder::{PossibleValuesParser, ValueParser};
use clap::{Arg, ArgAction, ArgMatches, Command};
use serde::Serialize;

use super::workshop::Workshop;
use super::{CliError, args, output};
use crate::accel::{BuildConfig, BuildPhase, Builder, Layout, Width};
use crate::export::table::{self, TableFormat};
use crate::export::{atomic, ray_file};
use crate::render::RenderSettings;
use crate::render::bench::{Query, RaySet, RaySetKind, TraceResult, make_rays, trace_rays};
use crate::scene::Camera;
use crate::session::Session;
use crate::world::World;

/// The name of the set whose rays come from a file.
const FILE_SET: &str = "file";

pub fn command() -> Command {
    let file = |name: &'static str, help: &'static str| {
        Arg::new(name).long(name).value_name("FILE").value_parser(ValueParser::path_buf()).help(help)
    };
    Command::new("bench")
        .about("Rays a second on one thread and on all, and build times")
        .long_about(
            "Traces three sets of rays on one thread and on all: primary (camera), diffuse (one cosine-weighted bounce \
             from each primary hit), shadow (from each hit to the light). Or the rays of a file.",
        )
        .arg(Arg::new("all").long("all").action(ArgAction::SetTrue).help(
            "Measure the trees of all builders at all widths; --builder and --width are not looked at",
        ))
        .arg(Arg::new("packets").long("packets").action(ArgAction::SetTrue).help(
            "Trace the rays in packets of 64, as the views do with camera rays; each should be a square of 8 x 8 pixels",
        ))
        .arg(file(
            "rays",
            "Take the rays from a file: little-endian u32 count, then a ray each of eight f32 (origin x y z, t_min, \
             direction x y z, t_max)",
        ))
        .arg(
            Arg::new("query")
                .long("query")
                .value_name("QUERY")
                .value_parser(PossibleValuesParser::new(Query::ALL.map(Query::name)))
                .default_value(Query::default().name())
                .requires("rays")
                .help("What the rays of the file ask: the nearest hit, or any hit"),
        )
        .arg(file(
            "answers",
            "Write the answers: u32 count, then an f32 each (the hit's t, infinity for a miss; for occluded 1 or 0)",
        ).requires("rays"))
        .arg(file("expect", "Compare with the answers of a file, and print the mismatches").requires("rays"))
}

/// One set of rays, traced on some threads.
struct Row {
    set: &'static str,
    query: Query,
    packets: bool,
    threads: usize,
    result: TraceResult,
    /// Against the expected answers, where there are any.
    mismatches: Option<usize>,
}

pub fn run(matches: &ArgMatches) -> Result<(), CliError> {
    let path = |name: &str| matches.get_one::<PathBuf>(name);
    let session = args::session(matches)?;
    let from_file = path("rays").map(|file| ray_file::read_rays(file)).transpose()?;
    let expected = path("expect").map(|file| ray_file::read_answers(file)).transpose()?;
    if let (Some(rays), Some(expected)) = (&from_file, &expected)
        && rays.len() != expected.len()
    {
        let (rays, answers) = (rays.len(), expected.len());
        return Err(anyhow::anyhow!("--expect holds {answers} answers, but there are {rays} rays").into());
    }
    if let Some(out) = path("answers") {
        atomic::check_writable(out)?;
    }

    let workshop = Workshop::open(session)?;
    let every = matches.get_flag("all");
    let mut from_file = from_file.map(|rays| vec![(FILE_SET, RaySet { rays, query: query(matches) })]);
    let mut trees = Vec::new();
    for session in if every { every_tree(&workshop.session) } else { vec![workshop.session.clone()] } {
        let workshop = workshop.reopen(session)?;
        let one_thread_ms = workshop.timed_build(1)?.report.build_ms;
        let world = workshop.timed_build(workshop.threads())?;
        // The same for every tree.
        let sets = match &from_file {
            Some(sets) => sets,
            None => from_file.insert(camera_sets(&workshop, &world)?),
        };
        let rows = traced(&workshop, &world, sets, matches.get_flag("packets"), expected.as_deref())?;
        trees.push(BenchedTree { workshop, world, one_thread_ms, rows });
    }
    let last = trees.last().and_then(|tree| tree.rows.last());
    if let (Some(out), Some(row)) = (path("answers"), last) {
        ray_file::write_answers(out, &row.result.answers)?;
    }
    output::print(&match (output::format(matches), &trees[..]) {
        (TableFormat::People, [tree]) => tree.people(),
        (TableFormat::People, trees) => {
            let (heading, cells) = summary(trees);
            format!(
                "{}\n\n{}",
                workshop_heading(&workshop, trees),
                table::aligned(heading, cells.into_iter())
            )
        }
        (TableFormat::Json, [tree]) => table::pretty(&tree.record()),
        (TableFormat::Json, trees) => {
            table::pretty(&trees.iter().map(BenchedTree::record).collect::<Vec<_>>())
        }
        (TableFormat::Csv, trees) => csv(trees),
        (TableFormat::Markdown, [tree]) => {
            let heading = HEADING.map(str::to_owned);
            let is_text: Vec<_> = (0..heading.len()).map(|i| i < 2).collect();
            let cells = tree.rows.iter().map(|row| row.cells(|v| format!("{v:.3}")));
            table::markdown_text(&heading, &is_text, cells)
        }
        (TableFormat::Markdown, trees) => {
            let (heading, cells) = summary(trees);
            let is_text: Vec<_> = (0..heading.len()).map(|i| i < 1).collect();
            table::markdown_text(&heading, &is_text, cells.into_iter())
        }
    })
}

/// The session with each builder at each width.
fn every_tree(session: &Session) -> Vec<Session> {
    let trees = Builder::ALL.into_iter().flat_map(|builder| Width::ALL.map(|width| (builder, width)));
    let with = |(builder, width)| {
        let mut session = session.clone();
        let build = session.build_mut();
        (build.builder, build.width) = (builder, width);
        if !BuildConfig::NODES.contains(&(width, build.layout)) {
            build.layout = Layout::Full;
        }
        session.set_tree(None);
        session
    };
    trees.map(with).collect()
}

fn query(matches: &ArgMatches) -> Query {
    let name = matches.get_one::<String>("query").expect("it has a default");
    Query::ALL.into_iter().find(|query| query.name() == name).unwrap_or_default()
}

fn camera_sets(workshop: &Workshop, world: &World) -> Result<Vec<(&'static str, RaySet)>, CliError> {
    workshop.run("making rays", |task| {
        let set = |kind: RaySetKind| {
            let rays = make_rays(kind, world, &workshop.camera, &workshop.session.render, &task.step())?;
            task.advance(1);
            Ok((kind.name(), rays))
        };
        task.start(RaySetKind::ALL.len() as u64);
        RaySetKind::ALL.into_iter().map(set).collect()
    })
}

fn traced(
    workshop: &Workshop,
    world: &World,
    sets: &[(&'static str, RaySet)],
    packets: bool,
    expected: Option<&[f32]>,
) -> Result<Vec<Row>, CliError> {
    // On one thread and on all; the same where all are one.
    let mut threads = vec![1, workshop.threads()];
    threads.dedup();
    workshop.run("tracing rays", |task| {
        task.start((sets.len() * threads.len()) as u64);
        let mut rows = Vec::new();
        for (name, set) in sets {
            for &threads in &threads {
                task.check()?;
                let result = trace_rays(world, set, threads, packets);
                let mismatches = expected.map(|expected| ray_file::mismatches(&result.answers, expected));
                rows.push(Row { set: name, query: set.query, packets, threads, result, mismatches });
                task.advance(1);
            }
        }
        Ok(rows)
    })
}

const HEADING: [&str; 8] = ["set", "query", "threads", "rays", "hits", "sum_t", "mrays_per_s", "mismatches"];

impl Row {
    fn cells(&self, real: impl Fn(f64) -> String) -> Vec<String> {
        let result = &self.result;
        vec![
            self.set.to_owned(),
            self.query.name().to_owned(),
            self.threads.to_string(),
            result.ray_count.to_string(),
            result.hit_count.to_string(),
            real(result.sum_t),
            result.mrays_per_s().map_or_else(String::new, real),
            self.mismatches.map_or_else(String::new, |n| n.to_string()),
        ]
    }

    fn record(&self) -> SetRecord {
        let result = &self.result;
        SetRecord {
            set: self.set,
            query: self.query.name(),
            packets: self.packets,
            threads: self.threads,
            rays: result.ray_count,
            hits: result.hit_count,
            sum_t: result.sum_t,
            mrays_per_s: result.mrays_per_s(),
            mismatches: self.mismatches,
        }
    }
}

#[derive(Serialize)]
struct SetRecord {
    set: &'static str,
    query: &'static str,
    /// Whether the rays were traced in packets.
    packets: bool,
    threads: usize,
    rays: usize,
    hits: usize,
    sum_t: f64,
    mrays_per_s: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    mismatches: Option<usize>,
}

/// The tree and the settings that gave it, under the keys of the other commands.
#[derive(Serialize)]
struct TreeSettings<'a> {
    scene: &'a str,
    shape_count: usize,
    name: &'a str,
    builder: &'static str,
    width: usize,
    /// Of a tree from a file they are not known, as in the other commands.
    bins: Option<usize>,
    leaf: Option<usize>,
    node_count: usize,
    build_ms: Option<f64>,
    bytes: usize,
    widen: &'static str,
    stop: &'static str,
    block: usize,
    morton: usize,
    radius: usize,
    split_alpha: f32,
    split_budget: f32,
    pre_split: f32,
    layout: &'static str,
    improver: &'a str,
    rounds: usize,
    share: f32,
    traversal_cost: f32,
    intersection_cost: f32,
}

impl<'a> TreeSettings<'a> {
    fn of(workshop: &'a Workshop, world: &'a World) -> Self {
        let (build, is_built) = (&world.report.config, world.traced_file().is_none());
        Self {
            scene: &world.scene.name,
            shape_count: world.scene.shape_count(),
            name: &workshop.session.variants[workshop.session.active].name,
            builder: world.builder_name(),
            width: world.width(),
            bins: is_built.then_some(build.bins),
            leaf: is_built.then_some(build.leaf),
            node_count: world.figures.node_count,
            build_ms: is_built.then_some(world.report.build_ms),
            bytes: world.bytes(),
            widen: build.widen.name(),
            stop: build.stop.name(),
            block: build.block.get(),
            morton: build.morton.get(),
            radius: build.radius,
            split_alpha: build.split_alpha,
            split_budget: build.split_budget,
            pre_split: build.pre_split,
            layout: build.layout.name(),
            improver: build.improver.name(),
            rounds: build.rounds,
            share: build.share,
            traversal_cost: build.traversal_cost,
            intersection_cost: build.intersection_cost,
        }
    }
}

/// A tree and what was measured on it.
struct BenchedTree {
    workshop: Workshop,
    world: World,
    one_thread_ms: f64,
    rows: Vec<Row>,
}

#[derive(Serialize)]
struct TreeRecord<'a> {
    #[serde(flatten)]
    tree: TreeSettings<'a>,
    /// Build time on one thread; `build_ms` is that on all.
    build_one_thread_ms: f64,
    threads: usize,
    phases: &'a [BuildPhase],
    settings: RenderSettings,
    camera: Camera,
    sets: Vec<SetRecord>,
}

impl BenchedTree {
    fn record(&self) -> TreeRecord<'_> {
        let Self { workshop, world, one_thread_ms, rows } = self;
        TreeRecord {
            tree: TreeSettings::of(workshop, world),
            build_one_thread_ms: *one_thread_ms,
            threads: workshop.threads(),
            phases: &world.report.phases,
            settings: workshop.session.render,
            camera: workshop.camera,
            sets: rows.iter().map(Row::record).collect(),
        }
    }

    fn people(&self) -> String {
        let Self { world, one_thread_ms, rows, .. } = self;
        let made = if world.traced_file().is_some() { "checked" } else { "built" };
        let columns = if rows.iter().any(|row| row.mismatches.is_some()) { 8 } else { 7 };
        let cells = |row: &Row| {
            let mut cells = row.cells(|value| format!("{value:.3}"));
            cells.truncate(columns);
            cells
        };
        format!(
            "{}, {} shapes; {} builder, width {}, {} nodes, {made} in {:.2} ms on one thread, {:.2} ms on {}{}\n\n{}",
            world.scene.name,
            world.scene.shape_count(),
            world.builder_name(),
            world.width(),
            world.figures.node_count,
            one_thread_ms,
            world.report.build_ms,
            world.report.threads,
            in_packets(rows),
            table::aligned(
                HEADING[..columns].iter().map(|&h| h.to_owned()).collect(),
                rows.iter().map(cells)
            )
        )
    }
}

fn in_packets(rows: &[Row]) -> &'static str {
    if rows.iter().any(|row| row.packets) { "; rays in packets" } else { "" }
}

/// A line a tree: build times, and millions of rays a second of each set, on one thread and on all.
fn summary(trees: &[BenchedTree]) -> (Vec<String>, Vec<Vec<String>>) {
    let texts = |texts: &[&str]| -> Vec<String> { texts.iter().map(|&text| text.to_owned()).collect() };
    let mut heading = texts(&["builder", "width", "nodes", "build_ms/1"]);
    if let Some(tree) = trees.first() {
        heading.push(format!("build_ms/{}", tree.workshop.threads()));
        heading.extend(tree.rows.iter().map(|row| format!("{}/{}", row.set, row.threads)));
        if tree.rows.iter().any(|row| row.mismatches.is_some()) {
            heading.push("mismatches".to_owned());
        }
    }
    let cells = |tree: &BenchedTree| {
        let BenchedTree { world, one_thread_ms, rows, .. } = tree;
        let mut cells = texts(&[world.builder_name(), &world.width().to_string()]);
        cells.push(world.figures.node_count.to_string());
        cells.extend([*one_thread_ms, world.report.build_ms].map(|ms| format!("{ms:.2}")));
        let speeds = rows.iter().map(|row| row.result.mrays_per_s());
        cells.extend(speeds.map(|speed| speed.map_or_else(String::new, |speed| format!("{speed:.3}"))));
        let mismatches: Option<usize> = rows.iter().filter_map(|row| row.mismatches).max();
        cells.extend(mismatches.map(|n| n.to_string()));
        cells
    };
    (heading, trees.iter().map(cells).collect())
}

/// What a summary is of.
fn workshop_heading(workshop: &Workshop, trees: &[BenchedTree]) -> String {
    let build = workshop.session.build();
    format!(
        "{}, {} shapes; at most {} a leaf, {} bins{}; millions of rays a second by set and number of threads",
        workshop.scene.name,
        workshop.scene.shape_count(),
        build.leaf,
        build.bins,
        trees.first().map_or("", |tree| in_packets(&tree.rows)),
    )
}

/// A line a set and number of threads, with the tree that answered.
fn csv(trees: &[BenchedTree]) -> String {
    let of_tree = ["packets", "scene", "shape_count", "builder", "width", "bins", "leaf", "build_ms"];
    let heading = HEADING.into_iter().chain(of_tree).map(str::to_owned).collect();
    let lines = trees.iter().flat_map(|BenchedTree { workshop, world, rows, .. }| {
        let tree = TreeSettings::of(workshop, world);
        let line = |row: &Row| {
            let mut cells = row.cells(|v| v.to_string());
            cells.push(row.packets.to_string());
            cells.extend([tree.scene.to_owned(), tree.shape_count.to_string(), tree.builder.to_owned()]);
            let shown = |n: Option<usize>| n.map_or_else(String::new, |n| n.to_string());
            cells.extend([Some(tree.width), tree.bins, tree.leaf].map(shown));
            cells.push(tree.build_ms.map_or_else(String::new, |ms| ms.to_string()));
            cells
        };
        rows.iter().map(line).collect::<Vec<_>>()
    });
    table::csv_text(heading, lines)
}
