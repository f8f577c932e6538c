//! The closed set of pictures.

use serde::{Deserialize, Serialize};

use crate::world::NodeFigure;

/// Every picture that the program makes, as in `--view NAME`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum View {
    #[default]
    Path,
    Whitted,
    Albedo,
    Normal,
    Depth,
    ShapeId,
    NodesVisited,
    BoxTests,
    ShapeTests,
    LeafVisits,
    RayCost,
    ShadowIntersect,
    ShadowOccluded,
    ShadowFiltered,
    ShadowDifference,
    ShadowSaving,
    LeafDepth,
    LeafSize,
    LeafSahShare,
    LeafEpo,
    LeafFill,
    LeafRays,
    ParentOverlap,
    ParentEmptySpace,
    LeafId,
    Material,
}

/// What a view's film holds, and what it depends on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ViewClass {
    /// Linear light; exposure and tone mapping apply. Does not depend on the tree.
    Radiance,
    /// Linear colour shown as it is. Does not depend on the tree.
    Data,
    /// A number a pixel, shown through a colour map. Does not depend on the tree.
    Distance,
    /// A count a pixel, shown through a colour map; depends on the tree.
    Heat,
    /// A figure of the leaf at each pixel, shown through a colour map; depends on the tree.
    Leaf,
    /// A pixel class of [`super::shadow::ShadowClass`].
    Class,
}

/// What a heatmap counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Counter {
    NodesVisited,
    BoxTests,
    ShapeTests,
    LeafVisits,
    RayCost,
    /// Nodes visited by `intersect` minus those by the filtered `occluded`, of the same shadow ray.
    ShadowSaving,
}

/// Which rays a heatmap counts: rays of the Whitted frame of the same sample, so that a heatmap and the figures of
/// [`super::measure`] tell of the same rays.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum CountKind {
    /// One ray through the pixel's centre.
    #[default]
    Camera,
    /// Reflected and refracted rays.
    Bounce,
    /// Rays towards the lights.
    Shadow,
    All,
}

impl CountKind {
    pub const ALL: [Self; 4] = [Self::Camera, Self::Bounce, Self::Shadow, Self::All];

    pub fn name(self) -> &'static str {
        match self {
            Self::Camera => "camera",
            Self::Bounce => "bounce",
            Self::Shadow => "shadow",
            Self::All => "all",
        }
    }

    pub fn description(self) -> &'static str {
        match self {
            Self::Camera => "one ray through the centre of each pixel",
            Self::Bounce => "reflected and refracted rays of a Whitted picture",
            Self::Shadow => "rays towards the lights of a Whitted picture",
            Self::All => "camera, bounce and shadow rays together",
        }
    }
}

impl View {
    pub const ALL: [Self; 26] = [
        Self::Path,
        Self::Whitted,
        Self::Albedo,
        Self::Normal,
        Self::Depth,
        Self::ShapeId,
        Self::NodesVisited,
        Self::BoxTests,
        Self::ShapeTests,
        Self::LeafVisits,
        Self::RayCost,
        Self::ShadowIntersect,
        Self::ShadowOccluded,
        Self::ShadowFiltered,
        Self::ShadowDifference,
        Self::ShadowSaving,
        Self::LeafDepth,
        Self::LeafSize,
        Self::LeafSahShare,
        Self::LeafEpo,
        Self::LeafFill,
        Self::LeafRays,
        Self::ParentOverlap,
        Self::ParentEmptySpace,
        Self::LeafId,
        Self::Material,
    ];

    pub fn name(self) -> &'static str {
        match self {
            Self::Path => "path",
            Self::Whitted => "whitted",
            Self::Albedo => "albedo",
            Self::Normal => "normal",
            Self::Depth => "depth",
            Self::ShapeId => "shape-id",
            Self::NodesVisited => "nodes-visited",
            Self::BoxTests => "box-tests",
            Self::ShapeTests => "shape-tests",
            Self::LeafVisits => "leaf-visits",
            Self::RayCost => "ray-cost",
            Self::ShadowIntersect => "shadow-intersect",
            Self::ShadowOccluded => "shadow-occluded",
            Self::ShadowFiltered => "shadow-filtered",
            Self::ShadowDifference => "shadow-difference",
            Self::ShadowSaving => "shadow-saving",
            Self::LeafDepth => "leaf-depth",
            Self::LeafSize => "leaf-size",
            Self::LeafSahShare => "leaf-sah-share",
            Self::LeafEpo => "leaf-epo",
            Self::LeafFill => "leaf-fill",
            Self::LeafRays => "leaf-rays",
            Self::ParentOverlap => "parent-overlap",
            Self::ParentEmptySpace => "parent-empty-space",
            Self::LeafId => "leaf-id",
            Self::Material => "material",
        }
    }

    /// One sentence for lists and tooltips.
    pub fn description(self) -> &'static str {
        match self {
            Self::Path => "path tracing: light from everywhere, refined sample by sample",
            Self::Whitted => "Whitted ray tracing: direct light, mirrors and glass",
            Self::Albedo => "the colour of the first surface, unlit",
            Self::Normal => "the shading normal of the first surface as a colour",
            Self::Depth => "the distance to the first surface",
            Self::ShapeId => "a colour for each shape",
            Self::NodesVisited => "nodes visited: inner nodes whose children's boxes were tested, and leaves",
            Self::BoxTests => "boxes tested",
            Self::ShapeTests => "shapes tested",
            Self::LeafVisits => "leaves whose shapes were tested",
            Self::RayCost => "traversal cost x inner visits + intersection cost x shape tests",
            Self::ShadowIntersect => {
                "direct light with shadows by nearest hits, going on through what lets light pass"
            }
            Self::ShadowOccluded => "direct light with shadows by any hit: glass throws a black shadow",
            Self::ShadowFiltered => "direct light with shadows by any hit that blocks light",
            Self::ShadowDifference => "where a shadow by occluded differs from one by intersect",
            Self::ShadowSaving => "nodes that the early out of occluded saves over intersect",
            Self::LeafDepth => "the depth of the first surface's leaf",
            Self::LeafSize => "shapes in the first surface's leaf",
            Self::LeafSahShare => "the share of the SAH cost that the first surface's leaf has",
            Self::LeafEpo => "the part of the end-point overlap that the first surface's leaf has",
            Self::LeafFill => "how full the first surface's leaf is: the share of lanes that are used",
            Self::LeafRays => "camera rays that visit the first surface's leaf",
            Self::ParentOverlap => {
                "how much the leaf and its siblings overlap: of the node above the first surface's leaf"
            }
            Self::ParentEmptySpace => "the empty space in the node above the first surface's leaf",
            Self::LeafId => "a colour for each leaf",
            Self::Material => "a colour for each material",
        }
    }

    pub fn class(self) -> ViewClass {
        match self {
            Self::Path
            | Self::Whitted
            | Self::ShadowIntersect
            | Self::ShadowOccluded
            | Self::ShadowFiltered => ViewClass::Radiance,
            Self::Albedo | Self::Normal | Self::ShapeId | Self::LeafId | Self::Material => ViewClass::Data,
            Self::Depth => ViewClass::Distance,
            Self::NodesVisited
            | Self::BoxTests
            | Self::ShapeTests
            | Self::LeafVisits
            | Self::RayCost
            | Self::ShadowSaving => ViewClass::Heat,
            Self::LeafDepth
            | Self::LeafSize
            | Self::LeafSahShare
            | Self::LeafEpo
            | Self::LeafFill
            | Self::LeafRays
            | Self::ParentOverlap
            | Self::ParentEmptySpace => ViewClass::Leaf,
            Self::ShadowDifference => ViewClass::Class,
        }
    }

    /// What a heatmap counts; `None` for every other view.
    pub fn counter(self) -> Option<Counter> {
        match self {
            Self::NodesVisited => Some(Counter::NodesVisited),
            Self::BoxTests => Some(Counter::BoxTests),
            Self::ShapeTests => Some(Counter::ShapeTests),
            Self::LeafVisits => Some(Counter::LeafVisits),
            Self::RayCost => Some(Counter::RayCost),
            Self::ShadowSaving => Some(Counter::ShadowSaving),
            Self::Path
            | Self::Whitted
            | Self::Albedo
            | Self::Normal
            | Self::Depth
            | Self::ShapeId
            | Self::ShadowIntersect
            | Self::ShadowOccluded
            | Self::ShadowFiltered
            | Self::ShadowDifference
            | Self::LeafDepth
            | Self::LeafSize
            | Self::LeafSahShare
            | Self::LeafEpo
            | Self::LeafFill
            | Self::LeafRays
            | Self::ParentOverlap
            | Self::ParentEmptySpace
            | Self::LeafId
            | Self::Material => None,
        }
    }

    /// Whether a pixel counts what its rays of some kind meet.
    pub fn counts_rays(self) -> bool {
        self.counter().is_some() && self != Self::ShadowSaving
    }

    /// The figure of a leaf, or of the node above it, that the view shows.
    pub fn leaf_figure(self) -> Option<NodeFigure> {
        match self {
            Self::LeafDepth => Some(NodeFigure::Depth),
            Self::LeafSize => Some(NodeFigure::LeafSize),
            Self::LeafSahShare => Some(NodeFigure::SahShare),
            Self::LeafEpo => Some(NodeFigure::Epo),
            Self::LeafFill => Some(NodeFigure::Fill),
            Self::LeafRays => Some(NodeFigure::Visits),
            Self::ParentOverlap => Some(NodeFigure::Overlap),
            Self::ParentEmptySpace => Some(NodeFigure::EmptySpace),
            Self::LeafId => Some(NodeFigure::Unique),
            Self::Path
            | Self::Whitted
            | Self::Albedo
            | Self::Normal
            | Self::Depth
            | Self::ShapeId
            | Self::NodesVisited
            | Self::BoxTests
            | Self::ShapeTests
            | Self::LeafVisits
            | Self::RayCost
            | Self::ShadowIntersect
            | Self::ShadowOccluded
            | Self::ShadowFiltered
            | Self::ShadowDifference
            | Self::ShadowSaving
            | Self::Material => None,
        }
    }

    /// Whether the picture changes when only the tree does.
    pub fn depends_on_tree(self) -> bool {
        self.class() == ViewClass::Heat || self.leaf_figure().is_some()
    }

    /// Whether more samples refine it (else one sample is all there is).
    pub fn refines(self, count: CountKind) -> bool {
        match self.class() {
            ViewClass::Radiance => true,
            ViewClass::Heat => self.counts_rays() && count != CountKind::Camera,
            ViewClass::Data | ViewClass::Distance | ViewClass::Leaf | ViewClass::Class => false,
        }
    }

    /// The view of that name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|v| v.name() == name)
    }
}
