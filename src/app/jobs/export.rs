//! Writing what is shown to files, with progress, off the window's thread.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use egui::ColorImage;
use image::RgbaImage;

use super::gate::OnLease;
use super::newest::Patience;
use super::{Job, PoolKind, Run};
use crate::accel::NodeId;
use crate::export::animation::{FrameFormat, Frames, Stage, animate};
use crate::export::picture::{self, Extras};
use crate::export::plot::{self, Look};
use crate::export::points::{self, Question};
use crate::export::report::{Measured, Report};
use crate::export::{atomic, boxes, exr, raw_csv, session_file, tree_file};
use crate::inspect::columns::{COLUMNS, Column, TreeRecord};
use crate::inspect::pareto::front;
use crate::inspect::plot::Plot;
use crate::inspect::stats::{TreeStats, tree_stats};
use crate::inspect::sweep::SweepPoint;
use crate::render::{Film, RenderSettings};
use crate::scene::{Camera, Scene};
use crate::session::{Session, file};
use crate::task::Task;
use crate::world::{TreeFile, World};

/// A file to write, with all that goes into it.
#[derive(Clone)]
pub struct ExportWork {
    pub path: PathBuf,
    pub session: Session,
    pub content: ExportContent,
}

#[derive(Clone)]
pub enum ExportContent {
    /// Rendered anew, at the size and with the samples of the session.
    Picture {
        world: Arc<World>,
        camera: Camera,
        extras: Extras,
    },
    /// Rendered frame by frame, at the size and with the samples of the session.
    Animation {
        still: Arc<Scene>,
        tree: Option<Arc<TreeFile>>,
        camera: Camera,
        extras: Extras,
        frames: Frames,
    },
    /// The window as it was drawn.
    Window {
        image: Arc<ColorImage>,
    },
    Raw {
        film: Arc<Film>,
    },
    Figures {
        world: Arc<World>,
        camera: Camera,
    },
    /// With the front of build time and ray cost marked.
    Sweep {
        points: Arc<Vec<SweepPoint>>,
        question: Box<Question>,
    },
    Tree {
        world: Arc<World>,
    },
    Boxes {
        world: Arc<World>,
        nodes: Vec<NodeId>,
        below: bool,
    },
    Report {
        world: Arc<World>,
        camera: Camera,
        measured: Arc<Measured>,
    },
    Plot {
        plot: Arc<Plot>,
        look: Look,
    },
    Session,
}

/// The path that was written, or why not.
pub type ExportDone = Result<PathBuf, String>;

pub type ExportJob = Job<ExportWork, ExportDone>;

pub fn job() -> ExportJob {
    Job::new(Patience::Within(std::time::Duration::MAX), PoolKind::Work, |run| {
        let result = write(run);
        if !run.task.is_cancelled() {
            run.emit(result.map(|()| run.request.path.clone()));
        }
    })
}

impl ExportWork {
    /// Parts of it that are finished stay where a cancel stops it.
    pub fn comes_in_parts(&self) -> bool {
        matches!(self.content, ExportContent::Animation { .. })
            && FrameFormat::of(&self.path).is_ok_and(|format| format == FrameFormat::Sequence)
    }

    /// For the screen.
    pub fn what(&self) -> String {
        format!("writing {}", self.path.file_name().unwrap_or_default().to_string_lossy())
    }
}

fn write(run: &Run<ExportWork, ExportDone>) -> Result<(), String> {
    let ExportWork { path, session, content } = run.request;
    let say = |error: crate::export::ExportError| error.to_string();
    // Before a long render, not after it.
    atomic::check_writable(path).map_err(say)?;
    let _pass = run.context.gate.enter(run.task, OnLease::Finish).map_err(|c| c.to_string())?;
    match content {
        ExportContent::Picture { world, camera, extras } => {
            let film = picture::film(session, world, camera, run.task);
            let image = film.and_then(|f| picture::of_film(&f, session, world, camera, *extras, run.task));
            session_file::save_picture(&image.map_err(|c| c.to_string())?, session, path).map_err(say)
        }
        ExportContent::Animation { still, tree, camera, extras, frames } => {
            let stage = Stage { session, still, tree: tree.as_ref(), camera: *camera, extras: *extras };
            animate(&stage, frames, path, run.task).map_err(|error| error.to_string())
        }
        ExportContent::Window { image } => {
            session_file::save_picture(&rgba(image), session, path).map_err(say)
        }
        ExportContent::Raw { film } => match extension(path).as_str() {
            "exr" => exr::save(&[film], Some(&file::to_text(session, path.parent())), path).map_err(say),
            "csv" => raw_csv::save(film, path).map_err(say),
            other => Err(unknown_extension(path, other, "exr or .csv")),
        },
        ExportContent::Figures { world, camera } => {
            let stats = figures(session, world, camera, run.task).map_err(|c| c.to_string())?;
            let text = match extension(path).as_str() {
                "json" => json(&stats),
                "csv" => csv(&stats),
                other => return Err(unknown_extension(path, other, "json or .csv")),
            };
            atomic::write_bytes(path, text.as_bytes()).map_err(say)
        }
        ExportContent::Sweep { points, question } => {
            let columns = ["build_ms", "ray_cost_mean"].map(|key| Column::of(key).expect("a column's key"));
            points::save(path, points, &front(points, &columns), question).map_err(say)
        }
        ExportContent::Tree { world } => {
            tree_file::save(&world.tree, &world.scene, path).map(drop).map_err(say)
        }
        ExportContent::Boxes { world, nodes, below } => match extension(path).as_str() {
            "obj" => boxes::save(world.shown_tree(), nodes, *below, path, run.task).map(drop).map_err(say),
            other => Err(unknown_extension(path, other, "obj")),
        },
        ExportContent::Report { world, camera, measured } => {
            let report = Report::make(session, world, *camera, Measured::clone(measured), run.task);
            report.map_err(|error| error.to_string())?.save(path).map_err(say)
        }
        ExportContent::Plot { plot, look } => plot::save(plot, *look, path).map_err(say),
        ExportContent::Session => session_file::save(session, path).map_err(say),
    }
}

fn figures(
    session: &Session,
    world: &World,
    camera: &Camera,
    task: &Task,
) -> Result<TreeStats, crate::task::Cancelled> {
    let name = &session.variants[session.active].name;
    tree_stats(name, world, camera, &session.render, session.count, false, task)
}

fn json(stats: &TreeStats) -> String {
    let mut text = serde_json::to_string_pretty(&TreeRecord(stats)).expect("figures are plain data");
    text.push('\n');
    text
}

fn csv(stats: &TreeStats) -> String {
    let mut writer = csv::Writer::from_writer(Vec::new());
    let values = COLUMNS.iter().map(|column| column.value(stats).plain());
    writer.write_record(COLUMNS.iter().map(|c| c.key)).expect("memory takes every row");
    writer.write_record(values).expect("memory takes every row");
    let bytes = writer.into_inner().expect("memory takes every row");
    String::from_utf8(bytes).expect("columns are text")
}

fn rgba(image: &ColorImage) -> RgbaImage {
    let [width, height] = image.size.map(|n| n as u32);
    let bytes = image.pixels.iter().flat_map(|p| p.to_array()).collect();
    RgbaImage::from_raw(width, height, bytes).expect("a colour image has all its pixels")
}

fn extension(path: &Path) -> String {
    path.extension().unwrap_or_default().to_string_lossy().to_lowercase()
}

fn unknown_extension(path: &Path, extension: &str, choices: &str) -> String {
    format!("cannot write {}: the extension '{extension}' is unknown; use .{choices}", path.display())
}

/// The settings of an exported picture: its own size and number of samples.
pub fn sized(session: &Session, width: u32, height: u32, samples: u32) -> Session {
    let render = RenderSettings { width, height, spp: Some(samples.max(1)), ..session.render };
    Session { render, ..session.clone() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::accel::BuildConfig;
    use crate::app::jobs::Context;
    use crate::scene::builtin;
    use std::time::{Duration, Instant};

    fn export(work: ExportWork) -> ExportDone {
        let context = Context::for_tests();
        let mut job = job();
        job.request(&context, work);
        let start = Instant::now();
        loop {
            if let Some(done) = job.poll(&context).pop() {
                return done;
            }
            assert!(start.elapsed() < Duration::from_secs(30), "the export does not end");
            std::thread::sleep(Duration::from_millis(1));
        }
    }

    fn cornell() -> (Arc<World>, Camera) {
        let scene = Arc::new(builtin::make("cornell").expect("a built-in scene"));
        let camera = scene.camera;
        let world = World::build(scene, &BuildConfig::default(), &Task::new()).expect("not cancelled");
        (Arc::new(world), camera)
    }

    #[test]
    fn a_picture_has_its_own_size_and_carries_its_session() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("picture.png");
        let (world, camera) = cornell();
        let session = sized(&Session::default(), 40, 30, 2);
        let content =
            ExportContent::Picture { world, camera, extras: Extras { overlay: true, legend: false } };
        let work = ExportWork { path: path.clone(), session: session.clone(), content };
        assert_eq!(export(work), Ok(path.clone()));
        let image = image::open(&path).expect("a picture").into_rgba8();
        assert_eq!(image.dimensions(), (40, 30));
        let carried = session_file::open(&path).expect("a session");
        assert_eq!(carried.render, session.render);
    }

    #[test]
    fn figures_are_the_keys_of_the_design_in_both_forms() {
        let folder = tempfile::tempdir().expect("a folder");
        let (world, camera) = cornell();
        let session = sized(&Session::default(), 16, 16, 1);
        let mut texts = Vec::new();
        for name in ["figures.json", "figures.csv"] {
            let path = folder.path().join(name);
            let content = ExportContent::Figures { world: Arc::clone(&world), camera };
            let work = ExportWork { path: path.clone(), session: session.clone(), content };
            export(work).expect("it is written");
            texts.push(std::fs::read_to_string(path).expect("text"));
        }
        let nodes = world.figures.node_count.to_string();
        let json: serde_json::Value = serde_json::from_str(&texts[0]).expect("JSON");
        assert_eq!(json["node_count"].to_string(), nodes);
        let mut rows = texts[1].lines().map(|line| line.split(',').collect::<Vec<_>>());
        let (keys, values) = (rows.next().expect("keys"), rows.next().expect("values"));
        let i = keys.iter().position(|k| *k == "node_count").expect("the key");
        assert_eq!(values[i], nodes);
    }

    #[test]
    fn an_unknown_extension_and_a_missing_folder_are_explained() {
        let (world, camera) = cornell();
        let content = ExportContent::Figures { world, camera };
        let folder = tempfile::tempdir().expect("a folder");
        for (path, part) in [
            (folder.path().join("figures.txt"), "use .json or .csv"),
            (folder.path().join("nowhere/figures.json"), "cannot write"),
        ] {
            let work = ExportWork { path, session: Session::default(), content: content.clone() };
            let message = export(work).expect_err("it cannot be written");
            assert!(message.contains(part), "{message}");
        }
        assert_eq!(std::fs::read_dir(folder.path()).expect("a folder").count(), 0, "nothing half-written");
    }
}
