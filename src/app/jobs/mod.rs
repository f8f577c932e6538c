//! Everything that takes longer than a frame, one file a kind. Nothing in here draws; results are plain data.

pub mod ab_build;
pub mod ab_figures;
pub mod bin_curve;
pub mod build;
pub mod census;
pub mod construction;
pub mod dialog;
pub mod difference;
pub mod export;
pub mod figures;
pub mod forecast;
pub mod gate;
pub mod job;
pub mod keys;
pub mod load;
pub mod newest;
pub mod overlay;
pub mod pixel_rays;
pub mod pools;
pub mod present;
pub mod region;
pub mod render;
pub mod shadow;
pub mod splits;
pub mod sweep;
pub mod table;
pub mod visible;

use std::sync::{Arc, Mutex};

use crate::session::TreeRef;
use crate::world::TreeFile;

pub use gate::{Gate, OnLease};
pub use job::{Job, Run};
pub use keys::{FilmKey, OverlayKey, SceneKey, TreeKey};
pub use newest::Patience;
pub use pools::{PoolKind, Pools};

/// What all jobs share: threads, the gate of timed measurements, and how to wake the window.
#[derive(Clone)]
pub struct Context {
    pools: Arc<Mutex<Arc<Pools>>>,
    pub gate: Gate,
    /// The trees of files that were read last.
    trees: Arc<Mutex<Vec<Arc<TreeFile>>>>,
    window: egui::Context,
}

impl Context {
    /// `threads`: 0 for all.
    pub fn new(window: egui::Context, threads: usize) -> Self {
        let pools = Arc::new(Mutex::new(Arc::new(Pools::new(threads))));
        Self { pools, gate: Gate::default(), trees: Arc::default(), window }
    }

    /// A context without a window.
    #[cfg(test)]
    pub fn for_tests() -> Self {
        Self::new(egui::Context::default(), 2)
    }

    /// The current pools; work that runs keeps those that it started with.
    pub fn pools(&self) -> Arc<Pools> {
        Arc::clone(&self.pools.lock().expect("nothing panics while it holds the pools' lock"))
    }

    /// Makes new pools if the number of threads is another one.
    pub fn set_threads(&self, threads: usize) {
        let mut pools = self.pools.lock().expect("nothing panics while it holds the pools' lock");
        if pools.threads() != threads {
            *pools = Arc::new(Pools::new(threads));
        }
    }

    /// The tree of a file, if it was read not long ago.
    pub fn tree(&self, wanted: &TreeRef) -> Option<Arc<TreeFile>> {
        let trees = self.trees.lock().expect("nothing panics while it holds the trees' lock");
        let same =
            |tree: &&Arc<TreeFile>| tree.path == wanted.path && tree.content_hash == wanted.content_hash;
        trees.iter().find(same).cloned()
    }

    /// Keeps the tree of a file that was read.
    pub fn keep_tree(&self, tree: &Arc<TreeFile>) {
        const MOST: usize = 3;
        let mut trees = self.trees.lock().expect("nothing panics while it holds the trees' lock");
        trees.retain(|kept| kept.path != tree.path);
        trees.insert(0, Arc::clone(tree));
        trees.truncate(MOST);
    }

    /// Asks the window for a frame. From any thread.
    pub fn wake(&self) {
        self.window.request_repaint();
    }
}
