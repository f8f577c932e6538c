//! A tree from a file in the place of one of ours: checked against the scene, and traced if there is no fault in it.

use std::path::{Path, PathBuf};
use std::sync::{Arc, OnceLock};
use std::time::Instant;

use super::blockers::Blockers;
use super::{BuildPhase, PrimStore, World, built_over, elapsed_ms};
use crate::accel::quality::TreeFigures;
use crate::accel::simd::SimdToken;
use crate::accel::validate::Findings;
use crate::accel::{BuildConfig, BuildReport, RawTree, Tree, Update};
use crate::scene::Scene;
use crate::scene::load::TreeArrays;
use crate::task::{Cancelled, Task};

/// A tree as it was read from a file.
#[derive(Debug)]
pub struct TreeFile {
    pub path: PathBuf,
    /// The file's name, without its folders.
    pub name: String,
    pub raw: RawTree,
    /// Triangles in the file, if it has any.
    pub triangle_count: Option<usize>,
    /// SHA-256 of the file, hexadecimal.
    pub content_hash: String,
}

/// A file's tree and what the check against the scene found.
#[derive(Clone, Debug)]
pub struct Imported {
    pub file: Arc<TreeFile>,
    pub findings: Findings,
    /// Of a tree with a fault: what of it can be drawn. The world's own tree is then one of ours.
    drawable: Option<Tree>,
}

/// A tree that is over other shapes than the scene's.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "it holds a tree over {triangle_count} triangles, but the scene {scene} has {shape_count} shapes; open it with the \
     scene that it was built over, or without one"
)]
pub struct OtherScene {
    pub scene: String,
    pub triangle_count: usize,
    pub shape_count: usize,
}

impl TreeFile {
    /// The tree of a file's arrays.
    pub fn new(path: &Path, arrays: TreeArrays) -> Self {
        let TreeArrays {
            width, child_min, child_max, child_index, leaf_first, leaf_count, shape_index, ..
        } = arrays;
        let width = width.max(*RawTree::WIDTHS.start());
        let raw = RawTree { width, child_min, child_max, child_index, leaf_first, leaf_count, shape_index };
        Self {
            path: path.to_owned(),
            name: path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned(),
            raw,
            triangle_count: arrays.triangles.map(|t| t.len()),
            content_hash: arrays.content_hash,
        }
    }

    /// Whether the scene can be the one that the tree was built over, by the number of its shapes.
    ///
    /// # Errors
    /// [`OtherScene`]
    pub fn check_scene(&self, scene: &Scene) -> Result<(), OtherScene> {
        let shape_count = scene.shape_count();
        match self.triangle_count {
            Some(triangle_count) if triangle_count != shape_count => {
                Err(OtherScene { scene: scene.name.clone(), triangle_count, shape_count })
            }
            _ => Ok(()),
        }
    }
}

impl World {
    /// The scene with the tree of a file if there is one, else with that of `config`.
    ///
    /// # Errors
    /// [`Cancelled`] when the task was.
    ///
    /// # Panics
    /// As [`World::build`].
    pub fn of(
        scene: Arc<Scene>,
        file: Option<&Arc<TreeFile>>,
        config: &BuildConfig,
        task: &Task,
    ) -> Result<Self, Cancelled> {
        match file {
            Some(file) => Self::with_tree(scene, Arc::clone(file), config, task),
            None => Self::build(scene, config, task),
        }
    }

    /// The scene with the tree of a file; with that of `config` if the file's has a fault. The costs, the instructions and the
    /// update of `config` hold for both: a tree that is to be refitted is one of the still scene.
    ///
    /// # Errors
    /// [`Cancelled`] when the task was.
    ///
    /// # Panics
    /// As [`World::build`].
    pub fn with_tree(
        scene: Arc<Scene>,
        file: Arc<TreeFile>,
        config: &BuildConfig,
        task: &Task,
    ) -> Result<Self, Cancelled> {
        task.check()?;
        let start = Instant::now();
        let boxes = built_over(&scene, config).shape_bounds();
        let (findings, tree) = file.raw.checked(&boxes, task)?;
        let Some(tree) = tree else {
            let drawable = Some(file.raw.drawable(&boxes, task)?);
            let imported = Some(Imported { file, findings, drawable });
            return Ok(Self { imported, ..Self::build(scene, config, task)? });
        };
        let check = BuildPhase { name: "check", ms: elapsed_ms(start) };
        let imported = Some(Imported { file, findings, drawable: None });
        if scene.still.is_some() && config.update == Update::Refit {
            let report = BuildReport {
                config: *config,
                build_ms: 0.0,
                phases: Vec::new(),
                rounds: Vec::new(),
                threads: rayon::current_num_threads(),
            };
            return Ok(Self { imported, ..Self::with_refitted(scene, &tree, report, task)? });
        }
        let start = Instant::now();
        let store = PrimStore::new(&scene, &tree, task)?;
        let pack = BuildPhase { name: "pack", ms: elapsed_ms(start) };
        let report = BuildReport {
            config: *config,
            build_ms: check.ms + pack.ms,
            phases: vec![check, pack],
            rounds: Vec::new(),
            threads: rayon::current_num_threads(),
        };
        let figures = TreeFigures::measure(&tree, config.traversal_cost, config.intersection_cost);
        let blockers = Blockers::new(&scene);
        let (epo, simd) = (OnceLock::new(), SimdToken::of(config));
        Ok(Self { scene, tree, report, figures, imported, store, blockers, epo, simd })
    }

    /// The file whose tree is traced, if it is not one of ours.
    pub fn traced_file(&self) -> Option<&TreeFile> {
        self.imported.as_ref().filter(|imported| imported.drawable.is_none()).map(|imported| &*imported.file)
    }

    /// Who built the tree that is traced: a builder of ours, or `imported`.
    pub fn builder_name(&self) -> &'static str {
        if self.traced_file().is_some() { "imported" } else { self.report.config.builder.name() }
    }

    /// Most children of a node of the tree that is traced.
    pub fn width(&self) -> usize {
        self.traced_file().map_or(self.report.config.width.get(), |file| file.raw.width)
    }

    /// The tree whose boxes are shown: the file's also when it has faults.
    pub fn shown_tree(&self) -> &Tree {
        self.imported.as_ref().and_then(|imported| imported.drawable.as_ref()).unwrap_or(&self.tree)
    }
}
