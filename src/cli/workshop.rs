//! What the commands share: an opened session, its threads, and work with progress.

use std::sync::Arc;

use anyhow::{Context, anyhow};
use rayon::{ThreadPool, ThreadPoolBuilder};

use super::{CliError, output, progress};
use crate::accel::BuildConfig;
use crate::inspect::stats::{Measurement, TreeStats};
use crate::render::CountKind;
use crate::scene::{Camera, Scene};
use crate::session::{Session, prepare};
use crate::task::{Cancelled, Task};
use crate::world::{TreeFile, World};

/// Builds of a tree whose build time is reported; the median counts.
const BUILDS: usize = 3;

/// A session with its scene loaded, and the threads that everything runs on.
pub struct Workshop {
    pub session: Session,
    /// At the session's time.
    pub scene: Arc<Scene>,
    /// As loaded.
    pub still: Arc<Scene>,
    /// The tree of the session's file, if it has one.
    pub tree: Option<Arc<TreeFile>>,
    pub camera: Camera,
    pool: Arc<ThreadPool>,
}

impl Workshop {
    /// Opens the session's scene; warnings go to standard error.
    pub fn open(mut session: Session) -> Result<Self, CliError> {
        // Of a session from another machine, perhaps.
        session.build().check().map_err(anyhow::Error::from)?;
        let threads = session.render.threads;
        let pool = ThreadPoolBuilder::new().num_threads(threads).build();
        let pool = Arc::new(pool.with_context(|| format!("cannot start {threads} threads"))?);
        let name = session.scene.reference.text();
        let task = Task::new();
        let opened = progress::watch(&format!("loading {name}"), &task, || {
            pool.install(|| prepare::open(&mut session, &task))
        });
        let prepared = opened?;
        prepared.warnings.iter().for_each(|warning| output::warn(warning));
        let prepare::Prepared { still, scene, camera, tree, .. } = prepared;
        Ok(Self { session, scene, still, tree, camera, pool })
    }

    /// The workshop of another session of the same scene: what was loaded is not loaded again, if it can be shared.
    pub fn reopen(&self, mut session: Session) -> Result<Self, CliError> {
        let of = |session: &Session| (session.scene.reference.clone(), session.up, session.render.threads);
        if of(&session) != of(&self.session) {
            return Self::open(session);
        }
        let tree = prepare::open_tree(&mut session, &self.still, &Task::new())?;
        let scene = prepare::stage(&self.still, &session);
        let camera = prepare::camera(&scene, &session);
        Ok(Self {
            session,
            scene,
            still: Arc::clone(&self.still),
            tree,
            camera,
            pool: Arc::clone(&self.pool),
        })
    }

    /// Says that a tree from a file is not the one that was measured.
    pub fn warn_if_broken(&self, measured: &TreeStats) {
        if let (Some(tree), None) = (&self.tree, &measured.imported) {
            output::warn(&format!(
                "{} has faults, and a tree that was built here is measured instead; `bvhscope import` lists them",
                tree.name
            ));
        }
    }

    /// Does work on the session's threads while its progress is shown.
    pub fn run<T: Send>(
        &self,
        what: &str,
        work: impl FnOnce(&Task) -> Result<T, Cancelled> + Send,
    ) -> Result<T, CliError> {
        let task = Task::new();
        let done = progress::watch(what, &task, || self.pool.install(|| work(&task)));
        done.map_err(|error| CliError::Failed(anyhow!(error)))
    }

    /// Does work on the session's threads.
    pub fn install<T: Send>(&self, work: impl FnOnce() -> T + Send) -> T {
        self.pool.install(work)
    }

    /// Builds the session's tree.
    pub fn build(&self) -> Result<World, CliError> {
        let what = format!("building a tree over {} shapes", self.scene.shape_count());
        self.run(&what, |task| self.world(task))
    }

    fn world(&self, task: &Task) -> Result<World, Cancelled> {
        World::of(Arc::clone(&self.scene), self.tree.as_ref(), self.session.build(), task)
    }

    /// Builds the session's tree several times on some threads; the report is that of the median build time.
    pub fn timed_build(&self, threads: usize) -> Result<World, CliError> {
        let pool = ThreadPoolBuilder::new().num_threads(threads).build()?;
        let what = format!("building on {threads} threads over {} shapes", self.scene.shape_count());
        let task = Task::new();
        let built = progress::watch(&what, &task, || {
            task.start(BUILDS as u64);
            let mut reports = Vec::new();
            loop {
                let build = || self.world(&task.step());
                let mut world = pool.install(build)?;
                task.advance(1);
                reports.push(world.report.clone());
                if reports.len() == BUILDS {
                    reports.sort_by(|a, b| a.build_ms.total_cmp(&b.build_ms));
                    world.report = reports.swap_remove(BUILDS / 2);
                    return Ok::<_, Cancelled>(world);
                }
            }
        });
        built.map_err(|error| CliError::Failed(anyhow!(error)))
    }

    /// What trees are measured on under this session.
    pub fn measurement(&self, count: CountKind) -> Measurement<'_> {
        Measurement {
            scene: &self.scene,
            camera: &self.camera,
            settings: &self.session.render,
            count,
            timed: true,
            builds: BUILDS,
        }
    }

    /// A line that says what was measured, for people.
    pub fn heading(&self, build: &BuildConfig, count: CountKind) -> String {
        let render = &self.session.render;
        let making = match &self.tree {
            Some(tree) => format!("the tree of {}", tree.name),
            None => format!("at most {} shapes a leaf, {} bins", build.leaf, build.bins),
        };
        format!(
            "{}, {} shapes; {} x {} pixels, {} rays; {making}; C_t {}, C_i {}; {} threads",
            self.scene.name,
            self.scene.shape_count(),
            render.width,
            render.height,
            count.name(),
            build.traversal_cost,
            build.intersection_cost,
            self.pool.current_num_threads(),
        )
    }

    pub fn threads(&self) -> usize {
        self.pool.current_num_threads()
    }
}
