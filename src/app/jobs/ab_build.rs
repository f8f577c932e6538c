//! Building the tree of a state that is compared and not active: over the scene at hand, another moment of it, or another
//! scene, which is loaded first.

use std::sync::Arc;

use super::build::{PATIENCE, tree_file};
use super::gate::OnLease;
use super::keys::{SceneKey, TreeKey};
use super::newest::Patience;
use super::{Job, PoolKind, Run};
use crate::app::ab::{Kept, Wanted};
use crate::scene::{LoadError, Scene};
use crate::session::{Session, prepare};
use crate::world::World;

#[derive(Clone)]
pub struct AbBuildRequest {
    pub wanted: Wanted,
    /// Index of the state.
    pub variant: usize,
    /// In which the state is active.
    pub session: Session,
    /// The number of the load that its scene is, or will be.
    pub load: u64,
    /// Its scene as it was loaded; `None`: it is to be loaded.
    pub still: Option<Arc<Scene>>,
}

impl AbBuildRequest {
    /// For the screen.
    pub fn what(&self) -> String {
        let name = &self.session.variants[self.session.active].name;
        format!("{name}: {}", super::build::what(&self.session))
    }
}

pub enum AbBuildMessage {
    Built(Box<Kept>),
    Failed { wanted: Box<Wanted>, message: String },
}

pub type AbBuildJob = Job<AbBuildRequest, AbBuildMessage>;

pub fn job() -> AbBuildJob {
    Job::new(Patience::Within(PATIENCE), PoolKind::Build, |run| {
        let message = match build(run) {
            Ok(kept) => AbBuildMessage::Built(Box::new(kept)),
            // A cancelled build says nothing.
            Err(LoadError::Cancelled) => return,
            Err(error) => {
                let wanted = Box::new(run.request.wanted.clone());
                AbBuildMessage::Failed { wanted, message: error.to_string() }
            }
        };
        run.emit(message);
    })
}

fn build(run: &Run<AbBuildRequest, AbBuildMessage>) -> Result<Kept, LoadError> {
    let cancelled = |_| LoadError::Cancelled;
    let _pass = run.context.gate.enter(run.task, OnLease::Finish).map_err(cancelled)?;
    let AbBuildRequest { wanted, variant, session, load, still } = run.request;
    let mut session = session.clone();
    let (still, scene, file) = match still {
        Some(still) => {
            let scene = prepare::stage(still, &session);
            let file = tree_file(run.context, &session, &scene, run.task)?;
            (Arc::clone(still), scene, file)
        }
        None => {
            let prepared = prepare::open(&mut session, run.task)?;
            (prepared.still, prepared.scene, prepared.tree)
        }
    };
    run.task.check().map_err(cancelled)?;
    let world = World::of(scene, file.as_ref(), session.build(), run.task).map_err(cancelled)?;
    let tree = TreeKey::wanted(SceneKey::of(*load, &still, &session), &session);
    Ok(Kept { wanted: wanted.clone(), variant: *variant, tree, world: Arc::new(world), still })
}
