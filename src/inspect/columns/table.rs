//! What each column says, in order.

use super::{Better, Column, Value};
use crate::inspect::prediction::{Forecast, Prediction};
use crate::inspect::stats::TreeStats;

/// Every column, in the order of JSON and CSV.
pub static COLUMNS: &[Column] = &[
    text("scene", "scene", "the scene's name", |s| s.scene.clone().into()),
    count("shape_count", "shapes", "bounded shapes of the scene", |s| s.shape_count.into()),
    text("name", "tree", "what this tree is called here", |s| s.name.clone().into()),
    text("builder", "builder", "how splits were found", |s| match s.imported {
        Some(_) => "imported".into(),
        None => s.config.builder.name().into(),
    }),
    count("width", "width", "most children of a node", |s| match &s.imported {
        Some(imported) => imported.width.into(),
        None => s.config.width.get().into(),
    }),
    count("bins", "bins", "bins an axis; only the builders binned and spatial look at it", |s| {
        if_built(s, s.config.bins)
    }),
    count("leaf", "leaf limit", "most references in a leaf", |s| if_built(s, s.config.leaf)),
    count("node_count", "nodes", "inner nodes and leaves", |s| s.figures.node_count.into()).lower(),
    count("leaf_count", "leaves", "nodes that hold references", |s| s.figures.leaf_count.into()),
    count("reference_count", "references", "entries of all leaves; a shape may have several", |s| {
        s.figures.reference_count.into()
    }),
    count("depth_max", "max depth", "depth of the deepest leaf; the root is at 0", |s| {
        s.figures.depth_max.into()
    })
    .lower(),
    real("depth_mean", "mean depth", "mean depth of the leaves; the root is at 0", |s| {
        s.figures.depth_mean.into()
    })
    .lower(),
    real(
        "sah_cost",
        "SAH cost",
        "what a random line that hits the root's box costs: C_t for each inner node, C_i for each shape",
        |s| s.figures.sah_cost.map(|c| c.total()).into(),
    )
    .lower(),
    real(
        "epo",
        "EPO",
        "end-point overlap: surface that lies in boxes it does not belong to, times what such a box costs",
        |s| s.epo.into(),
    )
    .lower(),
    real("lcv", "LCV", "standard deviation of the number of leaves that a ray visits", |s| s.rays.lcv.into())
        .lower(),
    real("nodes_visited_mean", "nodes / ray", "mean of the inner nodes and leaves that a ray visits", |s| {
        s.rays.nodes_visited_mean.into()
    })
    .lower(),
    real(
        "inner_visits_mean",
        "inner / ray",
        "mean of the inner nodes, a ray, whose children's boxes are tested",
        |s| s.rays.inner_visits_mean.into(),
    )
    .lower(),
    real("box_tests_mean", "boxes / ray", "mean of the boxes that are tested against a ray", |s| {
        s.rays.box_tests_mean.into()
    })
    .lower(),
    real("shape_tests_mean", "shapes / ray", "mean of the shapes that are tested against a ray", |s| {
        s.rays.shape_tests_mean.into()
    })
    .lower(),
    real(
        "ray_cost_mean",
        "ray cost",
        "mean of C_t x inner visits + C_i x shape tests: what the SAH cost predicts",
        |s| s.rays.ray_cost_mean.into(),
    )
    .lower(),
    real("build_ms", "build", "wall time of the build", |s| if_built(s, s.build_ms)).unit("ms").lower(),
    real(
        "traversal_ms",
        "traversal",
        "wall time of tracing all rays of one Whitted frame, median of 5",
        |s| s.times.map(|t| t.traversal_ms).into(),
    )
    .unit("ms")
    .lower(),
    real(
        "frames_per_s",
        "frames",
        "whole Whitted frames a second, shading included, without the build",
        |s| s.times.map(|t| t.frames_per_s).into(),
    )
    .unit("1/s")
    .decimals(1)
    .higher(),
    Column {
        shown_unit: 1024.0,
        ..count("bytes", "memory", "tree and shapes, ready to trace", |s| s.bytes.into())
    }
    .unit("KiB")
    .decimals(1)
    .lower(),
    real(
        "sah_epo",
        "SAH + EPO",
        "0.29 SAH cost + 0.71 EPO, the mixture that predicts times best (Aila, Karras, Laine 2013)",
        |s| Forecast::of(s).predicted(Prediction::SahEpo).into(),
    )
    .lower(),
    real("ray_cost_primary", "primary ray cost", "mean cost of a camera ray, of every n-th pixel", |s| {
        s.ray_costs.primary.into()
    })
    .lower(),
    real(
        "ray_cost_diffuse",
        "diffuse ray cost",
        "mean cost of a cosine-weighted bounce from where the camera rays hit",
        |s| s.ray_costs.diffuse.into(),
    )
    .lower(),
    real(
        "ray_cost_shadow",
        "shadow ray cost",
        "mean cost of a ray from there to a light, asked by occluded",
        |s| s.ray_costs.shadow.into(),
    )
    .lower(),
    real(
        "overlap",
        "overlap",
        "sum over inner nodes of the area that children share in pairs, by own area",
        |s| s.figures.overlap.into(),
    )
    .lower(),
    real(
        "empty_space",
        "empty space",
        "sum over inner nodes of the share of their volume that no child covers",
        |s| s.figures.empty_space.into(),
    ),
    real("empty_space_mean", "mean empty space", "the same as a mean over inner nodes with a volume", |s| {
        s.figures.empty_space_mean.into()
    }),
    real("slot_fill", "slot fill", "share of the child slots of inner nodes that are used", |s| {
        s.figures.slot_fill.into()
    })
    .higher(),
    real("leaf_fill", "leaf fill", "share of leaf lanes with a shape, where four are tested at once", |s| {
        s.figures.leaf_fill.into()
    })
    .higher(),
    real("bytes_per_shape", "bytes / shape", "memory of tree and shapes by the number of shapes", |s| {
        (s.shape_count > 0).then(|| s.bytes as f64 / s.shape_count as f64).into()
    })
    .decimals(1)
    .lower(),
    text("widen", "wide by", "how nodes of width 4 and 8 were made", |s| if_built(s, s.config.widen.name())),
    text("stop", "stop rule", "when a node became a leaf", |s| if_built(s, s.config.stop.name())),
    count("block", "blocks", "shapes that count as one in the split cost, rounded up", |s| {
        if_built(s, s.config.block.get())
    }),
    text("improver", "improver", "what made a better tree of the one that was built", |s| {
        if_built(s, s.config.improver.name())
    }),
    text("tree_file", "file", "the file that the tree is from, if it was not built", |s| {
        s.imported.as_ref().map_or(Value::Missing, |imported| imported.file.clone().into())
    }),
    text("layout", "layout", "how nodes lie in memory", |s| if_built(s, s.config.layout.name())),
    real(
        "pre_split",
        "pre-split",
        "references that cutting before the build may add, as a share of the shapes",
        |s| if_built(s, f64::from(s.config.pre_split)),
    ),
    text("update", "update", "what became of the tree when the scene moved", |s| {
        s.config.update.name().into()
    }),
    real("traversal_cost", "C_t", "price of visiting a node", |s| f64::from(s.config.traversal_cost).into()),
    real("intersection_cost", "C_i", "price of testing a shape", |s| {
        f64::from(s.config.intersection_cost).into()
    }),
    text("count", "rays", "which rays were counted", |s| s.count.name().into()),
];

/// What a tree from a file does not tell.
fn if_built(stats: &TreeStats, value: impl Into<Value>) -> Value {
    if stats.imported.is_some() { Value::Missing } else { value.into() }
}

const fn text(
    key: &'static str,
    title: &'static str,
    meaning: &'static str,
    value: fn(&TreeStats) -> Value,
) -> Column {
    Column { key, title, unit: "", meaning, better: Better::Neither, decimals: 0, shown_unit: 1.0, value }
}

const fn count(
    key: &'static str,
    title: &'static str,
    meaning: &'static str,
    value: fn(&TreeStats) -> Value,
) -> Column {
    text(key, title, meaning, value)
}

const fn real(
    key: &'static str,
    title: &'static str,
    meaning: &'static str,
    value: fn(&TreeStats) -> Value,
) -> Column {
    text(key, title, meaning, value).decimals(2)
}
