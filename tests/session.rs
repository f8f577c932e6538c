//! A session there and back: through its file, through a picture, and through the command line, for random sessions.

use std::path::{Path, PathBuf};

use bvhscope::accel::simd::SimdLevel;
use bvhscope::accel::{
    Block, BuildConfig, Builder, Improver, Layout, Morton, StopRule, Update, Widen, Width,
};
use bvhscope::export::session_file;
use bvhscope::render::{
    BoxStyle, ColorMap, ColorScale, CountKind, DisplaySettings, OverlaySettings, RenderSettings, ToneMap,
    View,
};
use bvhscope::scene::{Camera, SceneRef, ShadowRule, UpAxis};
use bvhscope::session::flags::{command_line, find};
use bvhscope::session::{Session, SessionScene, Variant, file};
use bvhscope::world::NodeFigure;
use glam::Vec3;
use proptest::option;
use proptest::prelude::*;
use proptest::sample::select;

/// Any finite number, the extreme ones included.
fn finite() -> impl Strategy<Value = f32> {
    prop_oneof![
        any::<f32>().prop_filter("finite", |x| x.is_finite()),
        -100.0f32..100.0,
        Just(0.0),
        Just(f32::MIN_POSITIVE),
        Just(1e-40),
        Just(16_777_217.0),
    ]
}

fn build() -> impl Strategy<Value = BuildConfig> {
    let choices = (
        select(&Builder::ALL[..]),
        select(&Width::ALL[..]).prop_flat_map(|width| {
            let layouts = if width == Width::W8 { &Layout::ALL[..] } else { &[Layout::Full] };
            (Just(width), select(layouts))
        }),
        select(&Widen::ALL[..]),
        select(&StopRule::ALL[..]),
        select(&Block::ALL[..]),
        select(&Improver::ALL[..]),
        select(&Morton::ALL[..]),
        select(&Update::ALL[..]),
    );
    let budget = || 0.0f32..=BuildConfig::MAX_BUDGET;
    let cuts = (BuildConfig::RADIUS, 0.0f32..=1.0, budget(), budget());
    let costs = (1e-6f32..1000.0, 1e-6f32..1000.0);
    let numbers = (
        BuildConfig::BINS,
        BuildConfig::LEAF,
        BuildConfig::ROUNDS,
        BuildConfig::MIN_SHARE..=1.0,
        costs,
        cuts,
    );
    (choices, numbers).prop_map(
        |(
            (builder, (width, layout), widen, stop, block, improver, morton, update),
            (bins, leaf, rounds, share, (ct, ci), (radius, split_alpha, split_budget, pre_split)),
        )| {
            BuildConfig {
                builder,
                width,
                layout,
                widen,
                stop,
                block,
                improver,
                morton,
                update,
                radius,
                split_alpha,
                split_budget,
                pre_split,
                rounds,
                share,
                bins,
                leaf,
                traversal_cost: ct,
                intersection_cost: ci,
                simd: SimdLevel::Scalar,
            }
        },
    )
}

fn camera() -> impl Strategy<Value = Camera> {
    let point = || (-1e6f32..1e6, -1e6f32..1e6, -1e6f32..1e6).prop_map(Vec3::from);
    (point(), point(), 0.1f32..=179.0)
        .prop_filter("two points", |(eye, target, _)| eye != target)
        .prop_map(|(eye, target, fov_y_degrees)| Camera { eye, target, fov_y_degrees, up: UpAxis::Y })
}

fn render() -> impl Strategy<Value = RenderSettings> {
    (1..=16_384u32, 1..=16_384u32, option::of(1..=1_000_000u32), any::<u64>(), 0..=64u32, 0..=1024usize)
        .prop_map(|(width, height, spp, seed, max_depth, threads)| RenderSettings {
            width,
            height,
            spp,
            seed,
            max_depth,
            threads,
        })
}

fn display() -> impl Strategy<Value = DisplaySettings> {
    let range = (finite(), finite()).prop_filter_map("a range", |(a, b)| (a <= b).then_some([a, b]));
    (
        select(&ColorMap::ALL[..]),
        select(&ColorScale::ALL[..]),
        option::of(range),
        option::of(finite()),
        -32.0f32..=32.0,
        select(&ToneMap::ALL[..]),
    )
        .prop_map(|(colormap, scale, range, threshold, exposure, tonemap)| DisplaySettings {
            colormap,
            scale,
            range,
            threshold,
            exposure,
            tonemap,
        })
}

fn overlay() -> impl Strategy<Value = OverlaySettings> {
    let depths = (0..=64u32, 0..=64u32).prop_map(|(a, b)| [a.min(b), a.max(b)]);
    (
        option::of(depths),
        any::<bool>(),
        select(&BoxStyle::ALL[..]),
        select(&NodeFigure::ALL[..]),
        any::<bool>(),
        1..=100_000_000u32,
    )
        .prop_map(|(depths, leaves_only, style, color, show_hidden, budget)| OverlaySettings {
            depths,
            leaves_only,
            style,
            color,
            show_hidden,
            budget,
        })
}

fn scene() -> impl Strategy<Value = SceneRef> {
    let name = select(&["bunny", "room", "cornell", "soup:123", "sliver"][..]);
    // Names that a shell or a parser could trip over.
    let path = "[a-zA-Z0-9 '\"$&;ü-]{1,12}".prop_map(|stem| PathBuf::from(format!("/models/{stem}.obj")));
    prop_oneof![
        name.prop_map(|name| SceneRef::Builtin(name.to_owned())),
        path.prop_map(SceneRef::File),
        Just(SceneRef::File(PathBuf::from("-odd.obj"))),
        Just(SceneRef::File(PathBuf::from("bunny"))),
    ]
}

/// Settings that one tree and one picture have: all that a command line can say.
fn one_variant() -> impl Strategy<Value = Session> {
    let look =
        (select(&View::ALL[..]), select(&CountKind::ALL[..]), select(&ShadowRule::ALL[..]), -1e6f32..=1e6);
    let place = (scene(), any::<bool>(), select(&UpAxis::ALL[..]), option::of(camera()));
    (look, place, build(), render(), display(), overlay()).prop_map(
        |(
            (view, count, shadow_rule, time),
            (reference, ground, up, camera),
            build,
            render,
            display,
            overlay,
        )| {
            Session {
                scene: SessionScene { reference, ..SessionScene::default() },
                time,
                ground,
                up,
                camera: camera.map(|camera| Camera { up, ..camera }),
                variants: vec![Variant { build, ..Variant::default() }],
                view,
                count,
                shadow_rule,
                render,
                display,
                overlay,
                ..Session::default()
            }
        },
    )
}

/// Any session: several variants, and a scene that is remembered.
fn any_session() -> impl Strategy<Value = Session> {
    let own = (option::of("soup:[1-9]"), option::of(-1e6f32..=1e6));
    let variant =
        ("[^\\x00-\\x1f\\x7f-\\x9f]{1,20}", build(), own).prop_map(|(name, build, (scene, time))| {
            let scene = scene
                .map(|name| SessionScene { reference: SceneRef::Builtin(name), ..SessionScene::default() });
            Variant { name, build, tree: None, scene, time }
        });
    let variants = (proptest::collection::vec(variant, 1..6), any::<prop::sample::Index>());
    let remembered = (option::of("[0-9a-f]{64}"), option::of(any::<u32>()));
    (one_variant(), variants, remembered).prop_map(|(session, (variants, active), (hash, count))| {
        let active = active.index(variants.len());
        let scene = SessionScene {
            content_hash: hash.unwrap_or_default(),
            shape_count: count.map(|c| c as usize),
            ..session.scene.clone()
        };
        // The active state has no scene and no moment of its own.
        Session { active, variants, scene, ..session }.activated(active)
    })
}

/// Reads `bvhscope render SCENE --out FILE --flag value ...` by the table of flags alone. (`tests/cli.rs` asks the
/// program itself.)
fn read_command(command: &str) -> Session {
    let words = shlex::split(command).expect("whole quotes");
    assert_eq!(words[..2], ["bvhscope", "render"]);
    assert_eq!(words[3], "--out");
    let mut session = Session::default();
    session.scene.reference = SceneRef::parse(&words[2]);
    let mut words = words[5..].iter();
    while let Some(word) = words.next() {
        let name = word.strip_prefix("--").expect("a flag");
        let (name, value) = name.split_once('=').unwrap_or((name, "on"));
        let flag = find(name).expect("a flag of the table");
        let value = if flag.is_switch() { value } else { words.next().expect("a value") };
        flag.read(&mut session, value).expect("a value that was written");
    }
    session
}

/// The scene's path as the shell would see it, without the `./` that keeps it from being read as something else.
fn plain(reference: &SceneRef) -> SceneRef {
    match reference {
        SceneRef::File(path) => SceneRef::File(path.strip_prefix(".").unwrap_or(path).to_owned()),
        SceneRef::Builtin(_) => reference.clone(),
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 256, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn through_text(session in any_session()) {
        let text = file::to_text(&session, None);
        let back = file::from_text(&text, None).expect(&text);
        prop_assert_eq!(back, session);
    }

    #[test]
    fn through_the_command_line(session in one_variant()) {
        let command = command_line(&session, "out.png");
        let mut back = read_command(&command);
        back.scene.reference = plain(&back.scene.reference);
        prop_assert_eq!(back, session, "{}", command);
    }

    #[test]
    fn every_session_that_can_be_made_passes_its_own_check(session in any_session()) {
        prop_assert!(file::check(&session).is_ok(), "{:?}", file::check(&session));
    }

    #[test]
    fn text_with_a_byte_changed_is_read_or_refused_but_never_panics(
        session in any_session(), at in any::<prop::sample::Index>(), byte in any::<u8>(),
    ) {
        let mut bytes = file::to_text(&session, None).into_bytes();
        let at = at.index(bytes.len());
        bytes[at] = byte;
        if let Ok(read) = file::from_text(&String::from_utf8_lossy(&bytes), None) {
            prop_assert!(file::check(&read).is_ok());
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 24, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn through_files(session in any_session()) {
        let folder = tempfile::tempdir().expect("a folder");
        let absolute = |session: &Session| {
            let mut session = session.clone();
            let own = session.variants.iter_mut().filter_map(|variant| variant.scene.as_mut());
            for scene in own.chain([&mut session.scene]) {
                if let SceneRef::File(path) = &mut scene.reference {
                    *path = std::path::absolute(&*path).expect("a path");
                }
            }
            session
        };
        let (ron, png) = (folder.path().join("s.ron"), folder.path().join("s.png"));
        session_file::save(&session, &ron).expect("saved");
        session_file::save_picture(&image::RgbaImage::new(3, 2), &session, &png).expect("saved");
        prop_assert_eq!(session_file::open(&ron).expect("opened"), absolute(&session));
        prop_assert_eq!(session_file::open(&png).expect("opened"), absolute(&session));
    }
}

#[test]
fn a_folder_with_its_session_and_model_can_be_moved() {
    let before = tempfile::tempdir().expect("a folder");
    let after = tempfile::tempdir().expect("a folder");
    let mut session = Session::default();
    session.scene.reference = SceneRef::File(before.path().join("models/a.obj"));
    session_file::save(&session, &before.path().join("s.ron")).expect("saved");
    std::fs::rename(before.path().join("s.ron"), after.path().join("s.ron")).expect("moved");
    let moved = session_file::open(&after.path().join("s.ron")).expect("opened");
    assert_eq!(moved.scene.reference, SceneRef::File(after.path().join("models/a.obj")));
}

#[test]
fn a_session_of_today_stays_readable() {
    // Written by hand in the form of version 1: what changes the form must still read this.
    let text = r#"(
        version: 1,
        scene: (reference: file("bunny.obj"), content_hash: "", shape_count: Some(12)),
        time: 0.5, ground: true, up: z,
        camera: Some((eye: (1.0, 2.0, 3.0), target: (0.0, 0.0, 0.0), fov_y_degrees: 40.0, up: z)),
        variants: [
            (name: "A", build: (builder: median, width: 2, leaf: 1)),
            (name: "B", build: (builder: binned, width: 8, widen: collapse, stop: cost, bins: 32)),
        ],
        active: 1,
        view: r#nodes-visited, count: all, shadow_rule: r#glass+mirror,
        render: (width: 640, height: 480, spp: Some(16), seed: 7, max_depth: 4),
        display: (colormap: viridis, range: Some((0.0, 50.0)), tonemap: reinhard, exposure: 1.5),
        overlay: (depths: Some((1, 5)), style: density, color: r#sah-share, leaves_only: true),
    )"#;
    let session = file::from_text(text, Some(Path::new("/models"))).expect("a session");
    assert_eq!(session.scene.reference, SceneRef::File(PathBuf::from("/models/bunny.obj")));
    assert_eq!((session.build().bins, session.build().width, session.build().leaf), (32, Width::W8, 2));
    assert_eq!((session.view, session.count), (View::NodesVisited, CountKind::All));
    assert_eq!(session.shadow_rule, ShadowRule::GlassMirror);
    assert_eq!((session.display.range, session.overlay.depths), (Some([0.0, 50.0]), Some([1, 5])));
}
