//! The render thread on a small scene, without a window.

use std::time::{Duration, Instant};

use super::*;
use crate::accel::BuildConfig;
use crate::app::jobs::keys::{SceneKey, TreeKey};
use crate::render::film::FilmSubject;
use crate::render::{CountKind, View};
use crate::scene::{Camera, ShadowRule, builtin};

struct Stage {
    world: Arc<World>,
    config: BuildConfig,
    camera: Camera,
    settings: RenderSettings,
}

impl Stage {
    fn new() -> Self {
        let scene = Arc::new(builtin::make("cornell").expect("a built-in scene"));
        let camera = scene.camera;
        let config = BuildConfig::default();
        let world = World::build(scene, &config, &Task::new()).expect("not cancelled");
        let settings = RenderSettings { width: 32, height: 24, ..Default::default() };
        Self { world: Arc::new(world), config, camera, settings }
    }

    fn key(&self, view: View) -> FilmKey {
        let subject = FilmSubject { view, count: CountKind::Camera, shadow_rule: ShadowRule::default() };
        let tree = TreeKey { scene: SceneKey::for_tests(1), config: self.config, file: None };
        FilmKey::new(&tree, &self.camera, &self.settings, subject)
    }

    fn picture(&self, slot: usize, key: FilmKey) -> WantedPicture {
        WantedPicture { slot, key, world: Arc::clone(&self.world) }
    }

    fn request(&self, views: &[View], goal: u32) -> RenderRequest {
        RenderRequest {
            pictures: views.iter().enumerate().map(|(slot, v)| self.picture(slot, self.key(*v))).collect(),
            settings: self.settings,
            display: DisplaySettings::default(),
            goal: Some(goal),
            pace: Pace::Direct,
        }
    }
}

/// Takes frames until the renderer rests; the newest of each slot.
fn settle(renderer: &Renderer) -> Vec<Frame> {
    let start = Instant::now();
    let mut newest: Vec<Frame> = Vec::new();
    loop {
        let idle = renderer.is_idle();
        for frame in renderer.take_frames() {
            newest.retain(|f| f.slot != frame.slot);
            newest.push(frame);
        }
        if idle {
            assert_eq!(renderer.take_failure(), None);
            newest.sort_by_key(|f| f.slot);
            return newest;
        }
        assert!(start.elapsed() < Duration::from_secs(30), "the renderer does not rest");
        std::thread::sleep(Duration::from_millis(1));
    }
}

#[test]
fn a_film_goes_on_where_it_was_when_its_view_comes_back() {
    let stage = Stage::new();
    let renderer = Renderer::start(&Context::for_tests());
    renderer.request(stage.request(&[View::Path], 3));
    let first = settle(&renderer);
    assert_eq!((first.len(), first[0].film.samples, first[0].scale), (1, 3, 1));
    renderer.request(stage.request(&[View::Normal], 3));
    assert_eq!(settle(&renderer)[0].film.samples, 1, "a second sample would change nothing");
    renderer.request(stage.request(&[View::Path], 3));
    let again = settle(&renderer);
    assert_eq!(again[0].film, first[0].film);
    assert_eq!(again[0].presented.image.size, [32, 24]);
}

#[test]
fn two_pictures_are_refined_side_by_side() {
    let stage = Stage::new();
    let renderer = Renderer::start(&Context::for_tests());
    renderer.request(stage.request(&[View::ShadowIntersect, View::ShadowOccluded], 2));
    let frames = settle(&renderer);
    let seen: Vec<_> = frames.iter().map(|f| (f.slot, f.key.subject.view, f.film.samples)).collect();
    assert_eq!(seen, [(0, View::ShadowIntersect, 2), (1, View::ShadowOccluded, 2)]);
}

#[test]
fn a_pause_shows_what_is_new_once_and_then_goes_on() {
    let stage = Stage::new();
    let renderer = Renderer::start(&Context::for_tests());
    renderer.request(RenderRequest { pace: Pace::Paused, ..stage.request(&[View::Path], 3) });
    assert_eq!(settle(&renderer)[0].film.samples, 1);
    renderer.request(stage.request(&[View::Path], 3));
    assert_eq!(settle(&renderer)[0].film.samples, 3);
    renderer.request(RenderRequest { pace: Pace::Paused, ..stage.request(&[View::Path], 9) });
    assert!(settle(&renderer).is_empty());
}

#[test]
fn a_lease_stops_the_samples_until_it_is_given_back() {
    let stage = Stage::new();
    let context = Context::for_tests();
    let renderer = Renderer::start(&context);
    let endless = RenderRequest { goal: None, ..stage.request(&[View::Path], 0) };
    renderer.request(endless);
    while renderer.take_frames().is_empty() {
        std::thread::sleep(Duration::from_millis(1));
    }
    let lease = context.gate.lease(&Task::new()).expect("not cancelled");
    renderer.take_frames();
    std::thread::sleep(Duration::from_millis(60));
    assert!(renderer.take_frames().is_empty(), "a sample was taken during the lease");
    drop(lease);
    let start = Instant::now();
    while renderer.take_frames().is_empty() {
        assert!(start.elapsed() < Duration::from_secs(20), "rendering does not go on");
        std::thread::sleep(Duration::from_millis(1));
    }
}

#[test]
fn a_first_look_outlives_a_camera_move_but_not_another_view() {
    let stage = Stage::new();
    let key = stage.key(View::Path);
    let running = |first_look, refines| RunningStep { key, first_look, refines, task: Task::new() };
    let (first, second, later) = (running(true, false), running(false, false), running(false, true));
    let moved = RenderRequest {
        pictures: vec![
            stage.picture(0, FilmKey { camera: Camera { fov_y_degrees: 10.0, ..stage.camera }, ..key }),
        ],
        ..stage.request(&[View::Path], 1)
    };
    assert!(worth_finishing(&first, &moved));
    assert!(!worth_finishing(&second, &moved) && !worth_finishing(&later, &moved));
    assert!(worth_finishing(&later, &stage.request(&[View::Path], 1)));
    assert!(!worth_finishing(&first, &stage.request(&[View::Depth], 1)));
    let paused = RenderRequest { pace: Pace::Paused, ..stage.request(&[View::Path], 1) };
    assert!(!worth_finishing(&later, &paused));
    assert!(worth_finishing(&second, &paused), "a pause shows one whole sample");
}

#[test]
fn two_pictures_of_one_film_are_both_shown_and_a_slot_may_be_empty() {
    let stage = Stage::new();
    let renderer = Renderer::start(&Context::for_tests());
    renderer.request(stage.request(&[View::Path, View::Path], 2));
    let seen: Vec<_> = settle(&renderer).iter().map(|f| (f.slot, f.film.samples)).collect();
    assert_eq!(seen, [(0, 2), (1, 2)]);
    let right = RenderRequest {
        pictures: vec![stage.picture(1, stage.key(View::Depth))],
        ..stage.request(&[View::Depth], 1)
    };
    renderer.request(right);
    let seen: Vec<_> = settle(&renderer).iter().map(|f| (f.slot, f.key.subject.view)).collect();
    assert_eq!(seen, [(1, View::Depth)]);
}
