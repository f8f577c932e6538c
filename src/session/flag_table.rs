//! The one table of settings. A new setting is one entry here, and with it a flag, its help, its part of the command
//! that *Copy command* writes, and the check of its range when a session is read from a file.

use super::flags::{Flag, FlagGroup};
use super::values::{
    camera_text, choices, float_text, no_choices, optional_text, read_camera, read_depths, read_float,
    read_int, read_named, read_optional, read_size, read_span, read_switch, read_tree, span_text,
    switch_text,
};
use crate::accel::simd::SimdLevel;
use crate::accel::{Block, BuildConfig, Builder, Improver, Layout, Morton, StopRule, Update, Widen, Width};
use crate::render::{BoxStyle, ColorMap, ColorScale, CountKind, ToneMap, View};
use crate::scene::{ShadowRule, UpAxis};
use crate::world::NodeFigure;

/// Costs lie above zero: the smallest that still makes sense beside the largest.
const MIN_COST: f32 = 1e-6;
const ANY: std::ops::RangeInclusive<f32> = f32::MIN..=f32::MAX;

pub(super) static FLAGS: &[Flag] = &[
    Flag {
        name: "tree",
        value_name: Some("FILE"),
        group: FlagGroup::Tree,
        help: "A tree from another program (.npz, .json) instead of one that is built, or none",
        choices: no_choices,
        set: |s, text| read_optional(text, "none", read_tree).map(|path| s.set_tree(path)),
        get: |s| optional_text(s.tree(), "none", |tree| tree.path.to_string_lossy().into_owned()),
    },
    Flag {
        name: "builder",
        value_name: Some("NAME"),
        group: FlagGroup::Tree,
        help: "How splits are found",
        choices: choices::<Builder>,
        set: |s, text| read_named(text).map(|v| s.build_mut().builder = v),
        get: |s| s.build().builder.name().to_owned(),
    },
    Flag {
        name: "width",
        value_name: Some("N"),
        group: FlagGroup::Tree,
        help: "Most children of a node",
        choices: choices::<Width>,
        set: |s, text| read_named(text).map(|v| s.build_mut().width = v),
        get: |s| s.build().width.name().to_owned(),
    },
    Flag {
        name: "layout",
        value_name: Some("NAME"),
        group: FlagGroup::Tree,
        help: "How nodes lie in memory",
        choices: choices::<Layout>,
        set: |s, text| read_named(text).map(|v| s.build_mut().layout = v),
        get: |s| s.build().layout.name().to_owned(),
    },
    Flag {
        name: "widen",
        value_name: Some("HOW"),
        group: FlagGroup::Tree,
        help: "How nodes of width 4 and 8 are made",
        choices: choices::<Widen>,
        set: |s, text| read_named(text).map(|v| s.build_mut().widen = v),
        get: |s| s.build().widen.name().to_owned(),
    },
    Flag {
        name: "stop",
        value_name: Some("RULE"),
        group: FlagGroup::Tree,
        help: "When a node becomes a leaf",
        choices: choices::<StopRule>,
        set: |s, text| read_named(text).map(|v| s.build_mut().stop = v),
        get: |s| s.build().stop.name().to_owned(),
    },
    Flag {
        name: "bins",
        value_name: Some("N"),
        group: FlagGroup::Tree,
        help: "Bins an axis of the builders binned and spatial, 2 to 256",
        choices: no_choices,
        set: |s, text| read_int(text, BuildConfig::BINS).map(|v| s.build_mut().bins = v),
        get: |s| s.build().bins.to_string(),
    },
    Flag {
        name: "morton",
        value_name: Some("BITS"),
        group: FlagGroup::Tree,
        help: "Bits of a Morton code, of the builders lbvh and ploc",
        choices: choices::<Morton>,
        set: |s, text| read_named(text).map(|v| s.build_mut().morton = v),
        get: |s| s.build().morton.name().to_owned(),
    },
    Flag {
        name: "radius",
        value_name: Some("N"),
        group: FlagGroup::Tree,
        help: "Neighbours on either side that ploc compares, 1 to 128",
        choices: no_choices,
        set: |s, text| read_int(text, BuildConfig::RADIUS).map(|v| s.build_mut().radius = v),
        get: |s| s.build().radius.to_string(),
    },
    Flag {
        name: "split-alpha",
        value_name: Some("X"),
        group: FlagGroup::Tree,
        help: "From which overlap on, as a share of the root's area, spatial tries to cut shapes; up to 1",
        choices: no_choices,
        set: |s, text| read_float(text, 0.0..=1.0).map(|v| s.build_mut().split_alpha = v),
        get: |s| float_text(s.build().split_alpha),
    },
    Flag {
        name: "split-budget",
        value_name: Some("X"),
        group: FlagGroup::Tree,
        help: "Most references that spatial may add, as a share of the shapes; up to 4",
        choices: no_choices,
        set: |s, text| {
            read_float(text, 0.0..=BuildConfig::MAX_BUDGET).map(|v| s.build_mut().split_budget = v)
        },
        get: |s| float_text(s.build().split_budget),
    },
    Flag {
        name: "pre-split",
        value_name: Some("X"),
        group: FlagGroup::Tree,
        help: "Cut large shapes before the build: most references that this may add, as a share of the shapes; up to 4",
        choices: no_choices,
        set: |s, text| read_float(text, 0.0..=BuildConfig::MAX_BUDGET).map(|v| s.build_mut().pre_split = v),
        get: |s| float_text(s.build().pre_split),
    },
    Flag {
        name: "leaf",
        value_name: Some("N"),
        group: FlagGroup::Tree,
        help: "Most shapes in a leaf, 1 to 64; at most 3 in the layout compressed",
        choices: no_choices,
        set: |s, text| read_int(text, BuildConfig::LEAF).map(|v| s.build_mut().leaf = v),
        get: |s| s.build().leaf.to_string(),
    },
    Flag {
        name: "block",
        value_name: Some("N"),
        group: FlagGroup::Tree,
        help: "Shapes that count as one in the split cost, rounded up",
        choices: choices::<Block>,
        set: |s, text| read_named(text).map(|v| s.build_mut().block = v),
        get: |s| s.build().block.name().to_owned(),
    },
    Flag {
        name: "improver",
        value_name: Some("NAME"),
        group: FlagGroup::Tree,
        help: "What makes a better tree of the one that was built",
        choices: choices::<Improver>,
        set: |s, text| read_named(text).map(|v| s.build_mut().improver = v),
        get: |s| s.build().improver.name().to_owned(),
    },
    Flag {
        name: "rounds",
        value_name: Some("N"),
        group: FlagGroup::Tree,
        help: "Most rounds of the improver, 1 to 1000",
        choices: no_choices,
        set: |s, text| read_int(text, BuildConfig::ROUNDS).map(|v| s.build_mut().rounds = v),
        get: |s| s.build().rounds.to_string(),
    },
    Flag {
        name: "share",
        value_name: Some("X"),
        group: FlagGroup::Tree,
        help: "Which share of the nodes a round of reinsertion may move, those with the largest areas; up to 1",
        choices: no_choices,
        set: |s, text| read_float(text, BuildConfig::MIN_SHARE..=1.0).map(|v| s.build_mut().share = v),
        get: |s| float_text(s.build().share),
    },
    Flag {
        name: "update",
        value_name: Some("HOW"),
        group: FlagGroup::Tree,
        help: "What becomes of the tree when the scene moves",
        choices: choices::<Update>,
        set: |s, text| read_named(text).map(|v| s.build_mut().update = v),
        get: |s| s.build().update.name().to_owned(),
    },
    Flag {
        name: "traversal-cost",
        value_name: Some("X"),
        group: FlagGroup::Tree,
        help: "C_t of the SAH cost: the price of visiting a node",
        choices: no_choices,
        set: |s, text| {
            read_float(text, MIN_COST..=BuildConfig::MAX_COST).map(|v| s.build_mut().traversal_cost = v)
        },
        get: |s| float_text(s.build().traversal_cost),
    },
    Flag {
        name: "intersection-cost",
        value_name: Some("X"),
        group: FlagGroup::Tree,
        help: "C_i of the SAH cost: the price of testing a shape",
        choices: no_choices,
        set: |s, text| {
            read_float(text, MIN_COST..=BuildConfig::MAX_COST).map(|v| s.build_mut().intersection_cost = v)
        },
        get: |s| float_text(s.build().intersection_cost),
    },
    Flag {
        name: "simd",
        value_name: Some("LEVEL"),
        group: FlagGroup::Tree,
        help: "Instructions to build and trace with",
        choices: choices::<SimdLevel>,
        set: |s, text| {
            let build = BuildConfig { simd: read_named(text)?, ..*s.build() };
            build.check().map_err(|error| error.to_string())?;
            *s.build_mut() = build;
            Ok(())
        },
        get: |s| s.build().simd.name().to_owned(),
    },
    Flag {
        name: "camera",
        value_name: Some("ex,ey,ez,tx,ty,tz,fov"),
        group: FlagGroup::Scene,
        help: "Eye, target and vertical field of view in degrees, or scene for the scene's own camera",
        choices: no_choices,
        set: |s, text| {
            let up = s.up;
            read_optional(text, "scene", |text| read_camera(text, up)).map(|v| s.camera = v)
        },
        get: |s| optional_text(s.camera, "scene", camera_text),
    },
    Flag {
        name: "up",
        value_name: Some("AXIS"),
        group: FlagGroup::Scene,
        help: "The axis that points up",
        choices: choices::<UpAxis>,
        set: |s, text| {
            s.up = read_named(text)?;
            if let Some(camera) = &mut s.camera {
                camera.up = s.up;
            }
            Ok(())
        },
        get: |s| s.up.name().to_owned(),
    },
    Flag {
        name: "time",
        value_name: Some("T"),
        group: FlagGroup::Scene,
        help: "The moment of an animated scene, in seconds; 0 is the still scene",
        choices: no_choices,
        set: |s, text| read_float(text, -1e6..=1e6).map(|v| s.time = v),
        get: |s| float_text(s.time),
    },
    Flag {
        name: "ground",
        value_name: None,
        group: FlagGroup::Scene,
        help: "Lay a ground under the scene; it is outside every tree and figure",
        choices: no_choices,
        set: |s, text| read_switch(text).map(|v| s.ground = v),
        get: |s| switch_text(s.ground),
    },
    Flag {
        name: "view",
        value_name: Some("NAME"),
        group: FlagGroup::Picture,
        help: "What the picture shows",
        choices: choices::<View>,
        set: |s, text| read_named(text).map(|v| s.view = v),
        get: |s| s.view.name().to_owned(),
    },
    Flag {
        name: "count",
        value_name: Some("KIND"),
        group: FlagGroup::Picture,
        help: "Which rays heatmaps and figures count",
        choices: choices::<CountKind>,
        set: |s, text| read_named(text).map(|v| s.count = v),
        get: |s| s.count.name().to_owned(),
    },
    Flag {
        name: "shadow-rule",
        value_name: Some("RULE"),
        group: FlagGroup::Picture,
        help: "Which materials let shadow rays pass, in Whitted and shadow views",
        choices: choices::<ShadowRule>,
        set: |s, text| read_named(text).map(|v| s.shadow_rule = v),
        get: |s| s.shadow_rule.name().to_owned(),
    },
    Flag {
        name: "size",
        value_name: Some("WxH"),
        group: FlagGroup::Picture,
        help: "Width and height of the picture in pixels",
        choices: no_choices,
        set: |s, text| {
            [s.render.width, s.render.height] = read_size(text)?;
            Ok(())
        },
        get: |s| format!("{}x{}", s.render.width, s.render.height),
    },
    Flag {
        name: "spp",
        value_name: Some("N"),
        group: FlagGroup::Picture,
        help: "Samples a pixel; auto is 1 for commands, without end in the window",
        choices: no_choices,
        set: |s, text| {
            read_optional(text, "auto", |text| read_int(text, 1..=1_000_000)).map(|v| s.render.spp = v)
        },
        get: |s| optional_text(s.render.spp, "auto", |v| v.to_string()),
    },
    Flag {
        name: "seed",
        value_name: Some("N"),
        group: FlagGroup::Picture,
        help: "Seed of the random numbers; the same seed gives the same picture",
        choices: no_choices,
        set: |s, text| read_int(text, 0..=u64::MAX).map(|v| s.render.seed = v),
        get: |s| s.render.seed.to_string(),
    },
    Flag {
        name: "max-depth",
        value_name: Some("N"),
        group: FlagGroup::Picture,
        help: "Most bounces of a path, or reflections of a Whitted ray, 0 to 64",
        choices: no_choices,
        set: |s, text| read_int(text, 0..=64).map(|v| s.render.max_depth = v),
        get: |s| s.render.max_depth.to_string(),
    },
    Flag {
        name: "threads",
        value_name: Some("N"),
        group: FlagGroup::Picture,
        help: "Worker threads, 1 to 1024, or all",
        choices: no_choices,
        set: |s, text| {
            let threads = read_optional(text, "all", |text| read_int(text, 0..=1024))?;
            s.render.threads = threads.unwrap_or(0);
            Ok(())
        },
        get: |s| optional_text(Some(s.render.threads).filter(|n| *n > 0), "all", |v| v.to_string()),
    },
    Flag {
        name: "exposure",
        value_name: Some("EV"),
        group: FlagGroup::Display,
        help: "Exposure of the light views in stops",
        choices: no_choices,
        set: |s, text| read_float(text, -32.0..=32.0).map(|v| s.display.exposure = v),
        get: |s| float_text(s.display.exposure),
    },
    Flag {
        name: "tonemap",
        value_name: Some("NAME"),
        group: FlagGroup::Display,
        help: "Tone curve of the light views",
        choices: choices::<ToneMap>,
        set: |s, text| read_named(text).map(|v| s.display.tonemap = v),
        get: |s| s.display.tonemap.name().to_owned(),
    },
    Flag {
        name: "colormap",
        value_name: Some("NAME"),
        group: FlagGroup::Display,
        help: "Colours of heatmaps and distances",
        choices: choices::<ColorMap>,
        set: |s, text| read_named(text).map(|v| s.display.colormap = v),
        get: |s| s.display.colormap.name().to_owned(),
    },
    Flag {
        name: "scale",
        value_name: Some("NAME"),
        group: FlagGroup::Display,
        help: "Where numbers stand between the ends of the colour map",
        choices: choices::<ColorScale>,
        set: |s, text| read_named(text).map(|v| s.display.scale = v),
        get: |s| s.display.scale.name().to_owned(),
    },
    Flag {
        name: "range",
        value_name: Some("LO..HI"),
        group: FlagGroup::Display,
        help: "Values at the two ends of the colour map, or auto",
        choices: no_choices,
        set: |s, text| read_optional(text, "auto", read_span).map(|v| s.display.range = v),
        get: |s| optional_text(s.display.range, "auto", span_text),
    },
    Flag {
        name: "threshold",
        value_name: Some("X"),
        group: FlagGroup::Display,
        help: "Show heat of at least this in one flat colour and dim the rest, or off",
        choices: no_choices,
        set: |s, text| {
            read_optional(text, "off", |text| read_float(text, ANY)).map(|v| s.display.threshold = v)
        },
        get: |s| optional_text(s.display.threshold, "off", float_text),
    },
    Flag {
        name: "boxes",
        value_name: Some("MIN..MAX"),
        group: FlagGroup::Boxes,
        help: "Draw the boxes of these depths over the picture (one depth, a range, all), or off",
        choices: no_choices,
        set: |s, text| {
            let deepest = BuildConfig::MAX_DEPTH as u32;
            read_optional(text, "off", |text| read_depths(text, deepest)).map(|v| s.overlay.depths = v)
        },
        get: |s| optional_text(s.overlay.depths, "off", |[min, max]| format!("{min}..{max}")),
    },
    Flag {
        name: "boxes-style",
        value_name: Some("STYLE"),
        group: FlagGroup::Boxes,
        help: "How boxes are drawn",
        choices: choices::<BoxStyle>,
        set: |s, text| read_named(text).map(|v| s.overlay.style = v),
        get: |s| s.overlay.style.name().to_owned(),
    },
    Flag {
        name: "boxes-color",
        value_name: Some("NAME"),
        group: FlagGroup::Boxes,
        help: "What the colour of a box says",
        choices: choices::<NodeFigure>,
        set: |s, text| read_named(text).map(|v| s.overlay.color = v),
        get: |s| s.overlay.color.name().to_owned(),
    },
    Flag {
        name: "leaves-only",
        value_name: None,
        group: FlagGroup::Boxes,
        help: "Draw the boxes of leaves only",
        choices: no_choices,
        set: |s, text| read_switch(text).map(|v| s.overlay.leaves_only = v),
        get: |s| switch_text(s.overlay.leaves_only),
    },
    Flag {
        name: "boxes-hidden",
        value_name: None,
        group: FlagGroup::Boxes,
        help: "Draw the parts of boxes behind geometry, too",
        choices: no_choices,
        set: |s, text| read_switch(text).map(|v| s.overlay.show_hidden = v),
        get: |s| switch_text(s.overlay.show_hidden),
    },
    Flag {
        name: "boxes-budget",
        value_name: Some("N"),
        group: FlagGroup::Boxes,
        help: "Most boxes drawn; the largest on screen go first",
        choices: no_choices,
        set: |s, text| read_int(text, 1..=100_000_000).map(|v| s.overlay.budget = v),
        get: |s| s.overlay.budget.to_string(),
    },
];
