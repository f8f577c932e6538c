//! Building the tree of the session, newest next, and counting its camera rays.

use std::sync::Arc;
use std::time::Duration;

use super::figures::{FiguresKey, count_camera_rays};
use super::gate::OnLease;
use super::keys::TreeKey;
use super::newest::Patience;
use super::{Context, Job, PoolKind, Run};
use crate::render::measure::RayFigures;
use crate::scene::{LoadError, Scene};
use crate::session::{Session, prepare};
use crate::task::{Cancelled, Task};
use crate::world::{TreeFile, World};

/// A build that takes longer than this gives way to a newer request.
pub const PATIENCE: Duration = Duration::from_millis(200);

/// A tree to build.
#[derive(Clone)]
pub struct BuildRequest {
    pub key: TreeKey,
    /// The scene as it was loaded.
    pub still: Arc<Scene>,
    /// The scene of the key's moment, if it is at hand.
    pub staged: Option<Arc<Scene>>,
    /// A world of the same settings at another moment, if one is at hand: perhaps it needs a refit alone.
    pub before: Option<Arc<World>>,
    pub session: Session,
    pub figures: FiguresKey,
}

/// What a build says.
pub enum BuildMessage {
    Built {
        key: TreeKey,
        world: Arc<World>,
    },
    /// The tree of the session's file could not be read.
    Failed {
        key: TreeKey,
        message: String,
    },
    Counted {
        key: FiguresKey,
        rays: RayFigures,
    },
}

pub type BuildJob = Job<BuildRequest, BuildMessage>;

pub fn job() -> BuildJob {
    Job::new(Patience::Within(PATIENCE), PoolKind::Build, |run| {
        // A cancelled build says nothing; the next one is on its way.
        let _ = build(run).map(|failed| {
            if let Some(message) = failed {
                run.emit(BuildMessage::Failed { key: run.request.key, message });
            }
        });
    })
}

/// For the screen: `building binned, 32 bins`.
pub fn what(session: &Session) -> String {
    if let Some(tree) = session.tree() {
        return format!("checking {}", tree.path.file_name().unwrap_or_default().to_string_lossy());
    }
    let config = session.build();
    let mut what = format!("building {}", config.builder.name());
    if config.width.get() > 2 {
        what += &format!(", width {}", config.width.name());
    }
    if config.builder.uses_bins() {
        what += &format!(", {} bins", config.bins);
    }
    what
}

/// What went wrong, if the tree is one of a file.
fn build(run: &Run<BuildRequest, BuildMessage>) -> Result<Option<String>, Cancelled> {
    let _pass = run.context.gate.enter(run.task, OnLease::Finish)?;
    let request = run.request;
    let scene = match &request.staged {
        Some(scene) => Arc::clone(scene),
        None => prepare::stage(&request.still, &request.session),
    };
    run.task.check()?;
    let file = match tree_file(run.context, &request.session, &scene, run.task) {
        Ok(file) => file,
        Err(LoadError::Cancelled) => return Err(Cancelled),
        Err(error) => return Ok(Some(error.to_string())),
    };
    let moved = request.before.as_ref().map(|before| before.moved(&scene, run.task)).transpose()?.flatten();
    let world = match moved {
        Some(world) => world,
        None => World::of(scene, file.as_ref(), &request.key.config, run.task)?,
    };
    let world = Arc::new(world);
    run.emit(BuildMessage::Built { key: request.key, world: Arc::clone(&world) });
    let rays = count(&world, request, run.task)?;
    run.emit(BuildMessage::Counted { key: request.figures, rays });
    Ok(None)
}

/// The tree of the session's file, if it has one: as it was read before, or from the file.
pub fn tree_file(
    context: &Context,
    session: &Session,
    scene: &Scene,
    task: &Task,
) -> Result<Option<Arc<TreeFile>>, LoadError> {
    let mut session = session.clone();
    let Some(tree) = session.tree() else { return Ok(None) };
    if let Some(known) = context.tree(tree) {
        return Ok(Some(known));
    }
    let read = prepare::open_tree(&mut session, scene, task)?;
    if let Some(tree) = &read {
        context.keep_tree(tree);
    }
    Ok(read)
}

fn count(world: &World, request: &BuildRequest, task: &Task) -> Result<RayFigures, Cancelled> {
    let settings = crate::render::RenderSettings {
        width: request.figures.width,
        height: request.figures.height,
        ..request.session.render
    };
    count_camera_rays(world, &request.figures.camera, &settings, task)
}
