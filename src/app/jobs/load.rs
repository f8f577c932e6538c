//! Opening a scene or a session: file, scene, moment, tree, all off the window's thread. Until it is done, and if it
//! fails, what was open stays.

use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use super::gate::OnLease;
use super::keys::{SceneKey, TreeKey};
use super::newest::Patience;
use super::{Job, PoolKind, Run};
use crate::export::session_file;
use crate::scene::{LoadError, Scene, SceneRef};
use crate::session::{Session, SessionScene, prepare};
use crate::world::World;

/// What to open.
#[derive(Clone, Debug)]
pub enum Source {
    /// A scene; the other settings of the session stay.
    Scene(SceneRef),
    /// A tree from another program: over the scene of now if its triangles are the same or it has none, else over its own.
    Tree(PathBuf),
    /// A session's file, or a PNG that carries one.
    SessionFile(PathBuf),
    /// The scene of the session of now; the one that the program was started with.
    Current,
    /// A session with another scene, as a whole.
    Session(Box<Session>),
}

#[derive(Clone)]
pub struct LoadRequest {
    /// Counts the loads.
    pub number: u64,
    pub source: Source,
    /// The session of now.
    pub session: Session,
    /// The scene of now, as it was loaded.
    pub still: Option<Arc<Scene>>,
    /// Set when the tree is being built.
    building: Arc<AtomicBool>,
}

/// Something that was opened.
pub struct Opened {
    pub source: Source,
    pub session: Session,
    pub still: Arc<Scene>,
    pub world: Arc<World>,
    pub key: TreeKey,
    pub warnings: Vec<String>,
}

pub enum LoadMessage {
    Opened(Box<Opened>),
    Failed { message: String },
}

pub type LoadJob = Job<LoadRequest, LoadMessage>;

pub fn job() -> LoadJob {
    Job::new(Patience::None, PoolKind::Work, |run| match open(run) {
        Ok(opened) => run.emit(LoadMessage::Opened(Box::new(opened))),
        Err(_) if run.task.is_cancelled() => {}
        Err(message) => run.emit(LoadMessage::Failed { message }),
    })
}

impl LoadRequest {
    pub fn new(number: u64, source: Source, session: Session, still: Option<Arc<Scene>>) -> Self {
        Self { number, source, session, still, building: Arc::default() }
    }

    /// For the screen.
    pub fn what(&self) -> String {
        let name = match &self.source {
            Source::Scene(scene) => short_name(scene),
            Source::SessionFile(path) | Source::Tree(path) => {
                path.file_name().map_or_else(|| path.display().to_string(), |n| n.to_string_lossy().into())
            }
            Source::Current => short_name(&self.session.scene.reference),
            Source::Session(session) => short_name(&session.scene.reference),
        };
        if self.building.load(Ordering::Relaxed) {
            match self.source {
                Source::Tree(_) => format!("checking {name}"),
                _ => format!("building the tree of {name}"),
            }
        } else {
            format!("loading {name}")
        }
    }
}

/// A scene's name without its folders.
pub fn short_name(scene: &SceneRef) -> String {
    match scene {
        SceneRef::Builtin(name) => name.clone(),
        SceneRef::File(path) => {
            path.file_name().map_or_else(|| scene.text(), |n| n.to_string_lossy().into_owned())
        }
    }
}

fn open(run: &Run<LoadRequest, LoadMessage>) -> Result<Opened, String> {
    let request = run.request;
    let _pass = run.context.gate.enter(run.task, OnLease::Finish).map_err(|c| c.to_string())?;
    let mut session = wanted_session(request)?;
    let prepared = match &request.source {
        Source::Tree(path) => prepare::import(&mut session, request.still.as_ref(), path, run.task),
        Source::Scene(_) | Source::SessionFile(_) | Source::Current | Source::Session(_) => {
            prepare::open(&mut session, run.task)
        }
    };
    let prepared = prepared.map_err(|error: LoadError| error.to_string())?;
    if let Some(tree) = &prepared.tree {
        run.context.keep_tree(tree);
    }
    request.building.store(true, Ordering::Relaxed);
    let config = *session.build();
    config.check().map_err(|error| error.to_string())?;
    let world = World::of(Arc::clone(&prepared.scene), prepared.tree.as_ref(), &config, run.task);
    let world = world.map_err(|c| c.to_string())?;
    let key = TreeKey::wanted(SceneKey::of(request.number, &prepared.still, &session), &session);
    Ok(Opened {
        source: request.source.clone(),
        session,
        still: prepared.still,
        world: Arc::new(world),
        key,
        warnings: prepared.warnings,
    })
}

/// The session as it will be when everything has been opened.
fn wanted_session(request: &LoadRequest) -> Result<Session, String> {
    match &request.source {
        Source::Scene(scene) => {
            let mut session = request.session.clone();
            session.scene = SessionScene { reference: scene.clone(), ..SessionScene::default() };
            // A tree of a file is one over another scene.
            session.set_tree(None);
            session.camera = None;
            session.time = 0.0;
            session.display.range = None;
            session.display.threshold = None;
            if let SceneRef::Builtin(_) = scene {
                session.up = crate::scene::UpAxis::Y;
                session.ground = false;
            }
            Ok(session)
        }
        Source::SessionFile(path) => session_file::open(path).map_err(|error| error.to_string()),
        Source::Current | Source::Tree(_) => Ok(request.session.clone()),
        Source::Session(session) => Ok(Session::clone(session)),
    }
}
