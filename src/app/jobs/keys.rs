//! What a result depends on, as values that can be compared: equal keys, equal results.

use std::hash::{BuildHasher, BuildHasherDefault, DefaultHasher};

use crate::accel::BuildConfig;
use crate::render::film::FilmSubject;
use crate::render::{CountKind, OverlaySettings, RenderSettings, View, ViewClass};
use crate::scene::{Camera, Scene, ShadowRule, UpAxis};
use crate::session::{Session, TreeRef};

/// One scene at one moment.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct SceneKey {
    /// Counts the loads of this run.
    pub load: u64,
    /// The bits of the time in seconds.
    time: u32,
    /// Across which axis a ground lies, if there is one.
    ground: Option<UpAxis>,
}

impl SceneKey {
    /// The session's moment of the scene that was loaded as number `load`.
    pub fn of(load: u64, still: &Scene, session: &Session) -> Self {
        let time = if still.is_animated() { session.time } else { 0.0 };
        Self::new(load, time, session.ground.then_some(session.up))
    }

    fn new(load: u64, time: f32, ground: Option<UpAxis>) -> Self {
        // Zero and negative zero are the same moment.
        Self { load, time: (time + 0.0).to_bits(), ground }
    }

    /// A still scene.
    #[cfg(test)]
    pub fn for_tests(load: u64) -> Self {
        Self::new(load, 0.0, None)
    }
}

/// The tree of a file, by a hash of its path and content.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FileKey(u64);

impl FileKey {
    pub fn of(tree: &TreeRef) -> Self {
        Self(BuildHasherDefault::<DefaultHasher>::new().hash_one(tree))
    }
}

/// One tree over one scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TreeKey {
    pub scene: SceneKey,
    pub config: BuildConfig,
    /// The file whose tree is shown instead of the one that `config` describes.
    pub file: Option<FileKey>,
}

impl TreeKey {
    /// The tree that a session asks for.
    pub fn wanted(scene: SceneKey, session: &Session) -> Self {
        Self { scene, config: *session.build(), file: session.tree().map(FileKey::of) }
    }
}

/// Everything that the raw content of a film depends on. How a film is shown is not among it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FilmKey {
    pub scene: SceneKey,
    /// `None` where the picture is the same for every tree.
    pub tree: Option<(BuildConfig, Option<FileKey>)>,
    pub camera: Camera,
    pub width: u32,
    pub height: u32,
    pub seed: u64,
    pub max_depth: u32,
    pub subject: FilmSubject,
    /// What is hidden, counted; 0 for nothing.
    pub hidden: u64,
}

impl FilmKey {
    pub fn new(tree: &TreeKey, camera: &Camera, settings: &RenderSettings, subject: FilmSubject) -> Self {
        let subject = normal_subject(subject);
        Self {
            scene: tree.scene,
            tree: subject.view.depends_on_tree().then_some((tree.config, tree.file)),
            camera: *camera,
            width: settings.width,
            height: settings.height,
            seed: settings.seed,
            max_depth: settings.max_depth,
            subject,
            hidden: 0,
        }
    }

    /// Whether more than one sample refines the film.
    pub fn refines(&self) -> bool {
        self.subject.view.refines(self.subject.count)
    }
}

/// The subject with what does not matter for its view set to the default.
fn normal_subject(subject: FilmSubject) -> FilmSubject {
    let view = subject.view;
    let asks_shadows = match view.class() {
        ViewClass::Data | ViewClass::Distance | ViewClass::Leaf => false,
        ViewClass::Class | ViewClass::Heat => true,
        ViewClass::Radiance => view != View::Path,
    };
    FilmSubject {
        view,
        count: if view.counts_rays() { subject.count } else { CountKind::default() },
        shadow_rule: if asks_shadows { subject.shadow_rule } else { ShadowRule::default() },
    }
}

/// What drawn boxes depend on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OverlayKey {
    pub tree: TreeKey,
    pub camera: Camera,
    pub settings: OverlaySettings,
    pub width: u32,
    pub height: u32,
    /// What is hidden, counted; 0 for nothing.
    pub hidden: u64,
}

/// What the first hit distances under the boxes depend on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DepthKey {
    pub scene: SceneKey,
    pub camera: Camera,
    pub width: u32,
    pub height: u32,
    pub hidden: u64,
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::accel::Builder;

    fn key(view: View, config: BuildConfig) -> FilmKey {
        let tree = TreeKey { scene: SceneKey::for_tests(1), config, file: None };
        let subject = FilmSubject { view, count: CountKind::All, shadow_rule: ShadowRule::GlassMirror };
        FilmKey::new(&tree, &Camera::default(), &RenderSettings::default(), subject)
    }

    #[test]
    fn another_tree_keeps_every_picture_but_the_counts() {
        let (a, b) = (BuildConfig::default(), BuildConfig { builder: Builder::Sweep, ..Default::default() });
        for view in View::ALL {
            let same = key(view, a) == key(view, b);
            assert_eq!(same, !view.depends_on_tree(), "{}", view.name());
        }
    }

    #[test]
    fn settings_that_a_view_does_not_read_do_not_change_its_key() {
        let config = BuildConfig::default();
        assert_eq!(key(View::Path, config).subject.count, CountKind::default());
        assert_eq!(key(View::Path, config).subject.shadow_rule, ShadowRule::default());
        assert_eq!(key(View::NodesVisited, config).subject.count, CountKind::All);
        assert_eq!(key(View::ShadowSaving, config).subject.count, CountKind::default());
        assert_eq!(key(View::ShadowDifference, config).subject.shadow_rule, ShadowRule::GlassMirror);
    }

    #[test]
    fn camera_size_seed_scene_and_time_change_every_key() {
        let config = BuildConfig::default();
        let tree = TreeKey { scene: SceneKey::for_tests(1), config, file: None };
        let subject = key(View::Path, config).subject;
        let settings = RenderSettings::default();
        let camera = Camera::default();
        let base = FilmKey::new(&tree, &camera, &settings, subject);
        let other_camera = Camera { fov_y_degrees: 30.0, ..camera };
        assert_ne!(base, FilmKey::new(&tree, &other_camera, &settings, subject));
        for other in [
            RenderSettings { width: 7, ..settings },
            RenderSettings { seed: 7, ..settings },
            RenderSettings { max_depth: 7, ..settings },
        ] {
            assert_ne!(base, FilmKey::new(&tree, &camera, &other, subject));
        }
        // The number of threads and the goal change no sample.
        let same = RenderSettings { threads: 3, spp: Some(9), ..settings };
        assert_eq!(base, FilmKey::new(&tree, &camera, &same, subject));
        for scene in
            [SceneKey::new(2, 0.0, None), SceneKey::new(1, 0.5, None), SceneKey::new(1, 0.0, Some(UpAxis::Y))]
        {
            assert_ne!(
                base,
                FilmKey::new(&TreeKey { scene, config, file: None }, &camera, &settings, subject)
            );
        }
        assert_eq!(SceneKey::new(1, 0.0, None), SceneKey::new(1, -0.0, None));
    }
}
