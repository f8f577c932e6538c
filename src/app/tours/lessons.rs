//! The six tours. What they say is checked by looking: change a scene or a default, and read them again.

use super::{Beside, Spot, Step, Tour};
use crate::app::ab::CompareStyle;
use crate::app::panels::PanelKind;
use crate::render::View;
use crate::world::NodeFigure;

/// All of them, in the order of the menu.
pub const TOURS: [Tour; 6] = [
    Tour {
        name: "Median against SAH",
        about: "Two trees over the same shapes: one cut by halves, one where rays pay least",
        scene: "bunny",
        steps: &[
            Step {
                title: "Cut by halves",
                text: "The builder median sorts the shapes of a node along its longest axis and cuts the \
                       row in the middle. Each pixel's colour is the number of nodes that its camera ray \
                       visits: the brighter, the slower. Keep the SAH cost in the panel Cost in mind, \
                       which predicts what a ray has to pay.",
                flags: "--builder median --width 2 --view nodes-visited --range 0..120",
                panels: &[PanelKind::Cost],
                ..Step::PLAIN
            },
            Step {
                title: "Cut where rays pay least",
                text: "The builder sweep tries every cut along every axis, and takes the one with the \
                       least split cost: the area of each side's box, by which rays hit it, times the \
                       shapes in it. The colours mean the same numbers as before. The SAH cost is a third \
                       of what it was, and the picture is as much darker.",
                flags: "--builder sweep --width 2 --view nodes-visited --range 0..120",
                panels: &[PanelKind::Cost],
                ..Step::PLAIN
            },
            Step {
                title: "One minus the other",
                text: "Now both at once: blue pixels visit fewer nodes in the tree by sweep, red ones \
                       more. The lines below their names in the panel Compare say how many nodes a ray \
                       visits on average; further down is the histogram of the differences, and every \
                       figure side by side. Try wipe instead of difference, and drag the line.",
                flags: "--builder median --width 2 --view nodes-visited",
                beside: Some(Beside::Tree {
                    names: ["median", "sweep"],
                    flags: "--builder sweep",
                    style: CompareStyle::Difference,
                }),
                panels: &[PanelKind::Compare],
                ..Step::PLAIN
            },
            Step {
                title: "The root's cut",
                text: "This is the tree by median again, and its root is selected. The curve in the panel \
                       Splits is the split cost of all cuts of it across x, its longest axis; the line is \
                       the cut that was made. It lies in the middle of the row, wherever the curve has \
                       its lowest point. Click the root's children in the panel Tree: every cut below \
                       wastes a little more.",
                flags: "--builder median --width 2 --view nodes-visited",
                panels: &[PanelKind::Cost, PanelKind::Splits],
                selects: Some(Spot::Root(0)),
                ..Step::PLAIN
            },
        ],
    },
    Tour {
        name: "What bins miss",
        about: "Why a few planes are nearly as good as all of them, and when they are not",
        scene: "spheres",
        steps: &[
            Step {
                title: "Eight bins",
                text: "Trying every cut takes long. The builder binned sorts shapes into bins instead, \
                       and looks only at the planes between them: seven an axis here. In the panel Splits \
                       the curve is the cost of all cuts of the root across y, the orange points are \
                       those that eight bins see. The lowest place of the curve lies before the first of \
                       them: that is what bins miss. The lines below the plot say how much.",
                flags: "--builder binned --bins 8 --width 2 --view path",
                panels: &[PanelKind::Splits],
                selects: Some(Spot::Root(1)),
                ..Step::PLAIN
            },
            Step {
                title: "More bins",
                text: "With 32 bins a plane lies close to the best place, and the points follow the \
                       curve. The slider Bins beside, above the plot, lays another number of bins over \
                       it: drag it down to 2 and up again. Hover a point to see the two boxes that it \
                       would make, in the viewport.",
                flags: "--builder binned --bins 32 --width 2 --view path",
                panels: &[PanelKind::Splits],
                selects: Some(Spot::Root(1)),
                ..Step::PLAIN
            },
            Step {
                title: "What it is worth",
                text: "The plot at the end of the panel Cost shows the SAH cost over the number of bins. \
                       It falls up to 32, and then hardly at all: the best first cut takes the wide \
                       ground from the small spheres just above it, and no plane lies there until bins \
                       are narrow. In the default scene four bins are nearly as good as all cuts. Drag \
                       Bins in the panel Build and watch.",
                flags: "--builder binned --bins 16 --width 2 --view nodes-visited",
                panels: &[PanelKind::Build, PanelKind::Cost],
                ..Step::PLAIN
            },
        ],
    },
    Tour {
        name: "Wide trees",
        about: "Nodes of eight children instead of two: fewer visits, more box tests, and why that is faster",
        scene: "bunny",
        steps: &[
            Step {
                title: "Fewer nodes",
                text: "At the left a binary tree, at the right one with up to eight children a node, on \
                       one range of colours. A ray through the wide tree visits far fewer nodes: one \
                       visit tests all children's boxes and skips levels that the binary tree walks one \
                       by one.",
                flags: "--builder binned --width 2 --view nodes-visited --range 0..60",
                beside: Some(Beside::Tree {
                    names: ["binary", "8-wide"],
                    flags: "--width 8",
                    style: CompareStyle::SideBySide,
                }),
                panels: &[PanelKind::Compare],
                ..Step::PLAIN
            },
            Step {
                title: "More boxes",
                text: "The same two trees, coloured by boxes tested: now the wide one is the brighter. It \
                       pays because the eight boxes of a node lie side by side in memory, and one row of \
                       SIMD instructions tests them together. That is why the SAH cost counts one price \
                       for a node, whatever its width.",
                flags: "--builder binned --width 2 --view box-tests --range 0..120",
                beside: Some(Beside::Tree {
                    names: ["binary", "8-wide"],
                    flags: "--width 8",
                    style: CompareStyle::SideBySide,
                }),
                panels: &[PanelKind::Compare],
                ..Step::PLAIN
            },
            Step {
                title: "Empty places",
                text: "A node that does not use all of its places wastes tests. The icicle plot in the \
                       panel Tree shows the whole tree, the root on top, and its colours say how full \
                       each node is. Most of what is poorly filled lies near the leaves, where too few \
                       shapes are left to share out.",
                flags: "--builder binned --width 8 --view leaf-fill",
                panels: &[PanelKind::Cost, PanelKind::Tree],
                selects: Some(Spot::Root(0)),
                colors: NodeFigure::Fill,
                ..Step::PLAIN
            },
        ],
    },
    Tour {
        name: "Why slivers hurt",
        about: "Long thin triangles in boxes that they hardly fill, and what cutting them up does",
        scene: "sliver",
        steps: &[
            Step {
                title: "Boxes full of nothing",
                text: "These triangles are long, thin and diagonal: each one touches only the corners of \
                       its box. Boxes of different triangles lie through each other, so no cut keeps them \
                       apart, and rays enter box after box in which nothing is hit. The picture counts \
                       the shapes that each ray tests.",
                flags: "--builder binned --width 2 --view shape-tests",
                panels: &[PanelKind::Cost],
                ..Step::PLAIN
            },
            Step {
                title: "Overlap, node by node",
                text: "Here the colour is the overlap of the node above the leaf that a ray hits: how \
                       much of its area its children share. The panel Tree lists the pairs of siblings \
                       that overlap most, at its end. Click one, and the two boxes are drawn in the \
                       picture.",
                flags: "--builder binned --width 2 --view parent-overlap",
                panels: &[PanelKind::Tree],
                selects: Some(Spot::Root(0)),
                ..Step::PLAIN
            },
            Step {
                title: "Cut them up",
                text: "Pre-split in the panel Build cuts large triangles before the tree is built; their \
                       parts go into different leaves, where boxes fit more tightly. Blue pixels test \
                       fewer shapes. The price is in the panel Compare: more references and more memory. \
                       The builder spatial, which cuts only where that pays at once, gains nothing on \
                       these triangles: try it.",
                flags: "--builder binned --width 2 --view shape-tests",
                beside: Some(Beside::Tree {
                    names: ["whole", "cut up"],
                    flags: "--pre-split 2",
                    style: CompareStyle::Difference,
                }),
                panels: &[PanelKind::Compare],
                ..Step::PLAIN
            },
        ],
    },
    Tour {
        name: "What an early-out shadow gets wrong",
        about: "A shadow ray that stops at the first thing it meets cannot know whether that was glass",
        scene: "bunny",
        steps: &[
            Step {
                title: "A shadow of glass",
                text: "The picture by Whitted's method lets light straight through glass: the cuboid \
                       throws no black shadow. For that each shadow ray asks for the nearest hit, looks \
                       at its material, and goes on if light passes. It is right, and it is the slow way.",
                flags: "--view whitted --shadow-rule glass --camera 0.1,1.75,2.8,-1.3,0.42,0.3,46",
                panels: &[PanelKind::Shadows],
                ..Step::PLAIN
            },
            Step {
                title: "Stop at anything",
                text: "At the left light by intersect, at the right by occluded, which answers as soon as \
                       anything lies in the way. It visits fewer nodes, but it cannot know what it has \
                       hit: drag the line between the two to the left, and the glass throws a black \
                       shadow. Black on the glass itself means that no light was asked for there.",
                flags: "--view whitted --shadow-rule glass --camera 0.1,1.75,2.8,-1.3,0.42,0.3,46",
                beside: Some(Beside::Views(
                    [View::ShadowIntersect, View::ShadowOccluded],
                    CompareStyle::Wipe,
                )),
                panels: &[PanelKind::Shadows],
                ..Step::PLAIN
            },
            Step {
                title: "Where they differ",
                text: "Every pixel by what the two say. The panel Shadows counts the classes and explains \
                       their colours. Dark only in occluded is the false shadow; dark only in intersect \
                       cannot happen, and a test of this program holds it at zero.",
                flags: "--view shadow-difference --shadow-rule glass --camera 0.1,1.75,2.8,-1.3,0.42,0.3,46",
                panels: &[PanelKind::Shadows],
                ..Step::PLAIN
            },
            Step {
                title: "Early out, and right",
                text: "Occluded with a filter passes over what lets light through, and stops at the first \
                       shape that blocks it. The panel Rays has the shadow ray of a pixel in the false \
                       shadow, asked all three ways, step by step: press the full stop key to step on, \
                       and see where each one stops. The colours are the nodes that intersect visits \
                       more.",
                flags: "--view shadow-saving --shadow-rule glass --camera 0.1,1.75,2.8,-1.3,0.42,0.3,46",
                panels: &[PanelKind::Shadows, PanelKind::Rays],
                selects: Some(Spot::Pixel([-0.23, 0.18])),
                ..Step::PLAIN
            },
        ],
    },
    Tour {
        name: "Refit and decay",
        about: "A tree that follows a moving scene by its boxes alone grows worse, moment by moment",
        scene: "bunny",
        steps: &[
            Step {
                title: "The still scene",
                text: "In an animation there is no time to build a tree for every frame. A refit keeps \
                       the nodes, and only fits their boxes to where the shapes have gone. This is the \
                       tree at t = 0, before anything moves. Note the SAH cost in the panel Cost.",
                flags: "--builder binned --width 2 --update refit --view nodes-visited --range 0..100",
                panels: &[PanelKind::Scene, PanelKind::Cost],
                ..Step::PLAIN
            },
            Step {
                title: "A moment later",
                text: "At 1.6 seconds the bunny has twisted. The refit took a small part of the time of \
                       the build, as the line at the bottom says. But triangles that were neighbours have \
                       moved apart, and share a node still: boxes have grown into each other, and the SAH \
                       cost with them. Press T, or drag Time at the end of the panel Scene.",
                flags: "--builder binned --width 2 --update refit --time 1.6 --view nodes-visited --range 0..100",
                panels: &[PanelKind::Scene, PanelKind::Cost],
                ..Step::PLAIN
            },
            Step {
                title: "Against a new tree",
                text: "The same moment: red pixels visit more nodes in the refitted tree than in one that \
                       is built anew. The panel Compare has both in figures: what a refit saves in \
                       building it pays back in rays. How long that is worth it depends on the motion. \
                       Where everything moves along together nothing is lost; a twist costs more and \
                       more.",
                flags: "--builder binned --width 2 --update rebuild --time 1.6 --view nodes-visited",
                beside: Some(Beside::Tree {
                    names: ["rebuilt", "refitted"],
                    flags: "--update refit",
                    style: CompareStyle::Difference,
                }),
                panels: &[PanelKind::Compare],
                ..Step::PLAIN
            },
        ],
    },
];
