//! The closed set of pictures.

use serde::{Deserialize, Serialize};

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
    pub const ALL: [Self; 16] = [
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
        }
    }

    pub fn class(self) -> ViewClass {
        match self {
            Self::Path
            | Self::Whitted
            | Self::ShadowIntersect
            | Self::ShadowOccluded
            | Self::ShadowFiltered => ViewClass::Radiance,
            Self::Albedo | Self::Normal | Self::ShapeId => ViewClass::Data,
            Self::Depth => ViewClass::Distance,
            Self::NodesVisited
            | Self::BoxTests
            | Self::ShapeTests
            | Self::LeafVisits
            | Self::RayCost
            | Self::ShadowSaving => ViewClass::Heat,
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
            | Self::ShadowDifference => None,
        }
    }

    /// Whether the picture changes when only the tree does.
    pub fn depends_on_tree(self) -> bool {
        self.class() == ViewClass::Heat
    }

    /// Whether more samples refine it (else one sample is all there is).
    pub fn refines(self, count: CountKind) -> bool {
        match self.class() {
            ViewClass::Radiance => true,
            ViewClass::Heat => self != Self::ShadowSaving && count != CountKind::Camera,
            ViewClass::Data | ViewClass::Distance | ViewClass::Class => false,
        }
    }

    /// The view of that name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|v| v.name() == name)
    }
}
