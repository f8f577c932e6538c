//! What every term of the window means, in one sentence each. The one source of all tooltips of terms.

/// Makes the closed set of terms: a variant, the label that the window shows, and the sentence that explains it.
macro_rules! glossary {
    ($($term:ident $label:literal $text:literal)*) => {
        /// A term that the window uses.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        pub enum Term {
            $($term,)*
        }

        impl Term {
            #[cfg(test)]
            pub const ALL: &[Self] = &[$(Self::$term,)*];

            /// What the window calls it.
            pub fn label(self) -> &'static str {
                match self {
                    $(Self::$term => $label,)*
                }
            }

            /// One sentence that explains it.
            pub fn text(self) -> &'static str {
                match self {
                    $(Self::$term => $text,)*
                }
            }
        }
    };
}

glossary! {
    // Scene
    Shapes "Shapes" "Entries of the scene that trees are built over: triangles, spheres, cuboids, quads and tori."
    Triangles "Triangles" "Shapes that are triangles, degenerate ones included."
    Spheres "Spheres" "Shapes that are spheres."
    Cuboids "Cuboids" "Shapes that are oriented boxes."
    Quads "Quads" "Shapes that are flat rectangles or parallelograms."
    Tori "Tori" "Shapes that are rings."
    Planes "Planes" "Unbounded surfaces, which stay outside every tree and are tested for each ray."
    Bounds "Size" "The side lengths of the box around all shapes, in units of the scene."
    Materials "Materials" "Descriptions of how a surface answers light: diffuse, mirror, glass or emissive."
    Lights "Lights" "Light sources: emissive shapes, point lights and panels."
    Warnings "Repaired" "What had to be mended to load the file, each kind counted."
    OpenPath "File or name" "A model (OBJ, PLY, STL, glTF), a session, a PNG that carries one, or the name of a built-in scene."
    SoupSize "Soup size" "How many random triangles the scene soup is made of."
    UpAxis "Up axis" "The axis of the scene that points up: many OBJ and STL files have Z up."
    Ground "Ground" "A plane that the program puts under the scene, outside every tree and figure."
    Update "Trees" "What becomes of the tree when the scene moves."
    Animate "Animate" "Moves the scene on through time, and builds its tree anew for each moment."
    Time "Time" "The moment that is shown: the motion is a pure function of it, and 0 is the still scene."
    CameraText "Camera as text" "Eye, target and vertical field of view in degrees, as --camera takes them: type over it and press Enter."
    Bookmarks "Bookmarks" "Cameras that are kept with the session: type over a name to change it."
    Recent "Recent files" "The files opened last, the newest first."

    // Build
    Builder "Builder" "How splits are found."
    Width "Width" "How many children a node has at most."
    Layout "Layout" "How nodes lie in memory: compressed, a node of width 8 takes 80 bytes instead of 256, and its boxes are a little larger."
    Block "Blocks" "How many shapes count as one in the split cost, rounded up; 4 are tested at once."
    Widen "Wide nodes" "How nodes of width 4 and 8 are made: directly by several splits at once, or from the finished binary tree."
    Improver "Improver" "What makes a better tree of the one that was built, before it is widened."
    Rounds "Rounds" "The most rounds of the improver, which ends sooner when a round finds nothing."
    Share "Share" "Which share of all nodes a round of reinsertion looks for better places for: those with the largest areas."
    RoundCosts "SAH cost by round" "The SAH cost of the binary tree before the improver's first round and after each."
    Stop "Stop rule" "When a node becomes a leaf."
    Bins "Bins" "The builders binned and spatial sort shapes' centroids into this many bins an axis, and look for splits only between bins."
    Morton "Morton bits" "How finely centroids are told apart along the Morton curve, by which lbvh and ploc sort shapes."
    Radius "Radius" "How many neighbours on either side along the Morton curve ploc compares to find the nearest."
    SplitAlpha "Overlap from" "From which overlap on, as a share of the root's area, spatial tries to cut shapes: alpha of the paper."
    SplitBudget "Budget" "How many references cuts may add at most, as a share of the shapes."
    PreSplit "Pre-split" "How many references cutting large shapes before the build may add at most, as a share of the shapes: 0 cuts none."
    Leaf "Leaf limit" "The most shapes that a leaf may hold."
    TraversalCost "Traversal cost" "C_t of the SAH cost: the price of visiting an inner node."
    IntersectionCost "Intersection cost" "C_i of the SAH cost: the price of testing a shape."
    BuildTime "Build time" "Wall time of the build, the sum of its phases."
    BuildPhase "Phases" "The stages of the build, each with its wall time in milliseconds."
    Nodes "Nodes" "Inner nodes and leaves together."
    Leaves "Leaves" "Nodes that hold shapes."
    References "References" "Entries of all leaves together, which are more than the shapes only if a tree names shapes twice."
    DepthMax "Depth, deepest" "The depth of the deepest leaf, where the root is at depth 0."
    DepthMean "Depth, mean" "The mean depth over the leaves, where the root is at depth 0."
    SahCost "SAH cost" "What the surface areas of the boxes predict that a ray costs: (C_t x sum of inner areas + C_i x sum of leaf areas x shapes) / area of the root."
    Bytes "Memory" "Tree and shapes ready to trace."
    NodesVisited "Nodes visited" "Inner nodes whose children's boxes were tested and leaves whose shapes were tested, a mean per camera ray."
    History "Builds so far" "The last 50 builds of this run, of which a click brings back the settings."

    // Tree
    Outline "Outline" "The nodes of the tree, opened one by one."
    Icicle "Plot" "A row a depth, each node as wide as its share, its children below it: the wheel zooms, dragging moves, a click selects, a double click fills the plot with the node."
    IcicleWeight "Widths" "What a node's width in the plot is a share of."
    IcicleColor "Colours" "What a node's colour in the plot tells."
    SiblingOrder "Siblings" "In which order the children of a node stand."
    Find "Find" "Goes to a node, a leaf or a shape by its number: 12, leaf 3, shape 589."
    SelectedNode "Selected" "What is known of the node that was selected last."
    NodeDepth "Depth" "How far the node lies below the root, which is at depth 0."
    NodeReferences "Shapes below" "References in all leaves below the node."
    NodeSize "Size" "The side lengths of its box."
    AreaShare "Area, of the root's" "How likely a line that hits the root's box hits this node's."
    OwnSah "SAH cost" "What the node itself adds to the SAH cost of the tree."
    SahBelow "SAH share with all below" "The share of the tree's SAH cost that the node and all below it have."
    NodeOverlap "Overlap" "Of an inner node: the areas that its children's boxes share in pairs, as a share of its own."
    NodeEmpty "Empty space" "Of an inner node: the share of its volume that no child's box covers."
    NodeVisits "Visits in this frame" "How many of the rays that are counted visit the node."
    NodeParent "Parent" "The node above."
    Children "Children" "The nodes right below, in slot order."
    LeafShapes "Shapes" "The shapes of the leaf, in the order of its references."
    Overlaps "Overlapping siblings" "Pairs of children of a node whose boxes overlap most: rays that hit the common part must go down both."
    OverlapMeasure "Ranked by" "By which measure the pairs are put in order."

    // Rays
    RaySource "Rays of" "Whose rays are shown: by default those that the view in the viewport is made of."
    RaySample "Sample" "Which sample of the pixel, from 0: sample 0 goes through the pixel's centre."
    FreeRay "Free ray" "Origin, direction and perhaps the ends of a ray: ox,oy,oz,dx,dy,dz or with t_min,t_max."
    PixelRays "Rays of the pixel" "The camera ray, what it bounces to, and the shadow rays of every hit."
    RayFrom "From" "Where the ray begins."
    RayTowards "Towards" "Its direction."
    RayEnds "Between" "Hits count from t_min to t_max, in units of the direction."
    RayFound "Found" "The shape that answers the query, and how far along the ray it is."
    RayVisits "Nodes visited" "Inner nodes whose children's boxes were tested, and leaves whose shapes were tested."
    RayBoxTests "Box tests" "Boxes of children that were tested."
    RayShapeTests "Shape tests" "Shapes that were tested."
    RayCost "Ray cost" "C_t x inner visits + C_i x shape tests."
    RayWaiting "Left waiting" "Boxes that were entered and never looked into when the walk ended."
    RaySteps "Steps" "What the ray did in the tree, in order: a click goes there, and the viewport draws it."
    AskedAs "Asked" "By which query the ray's steps are shown."
    RayStack "Waiting" "The nodes on the stack after this step, the next one first, with where the ray enters them."
    RayWays "Three ways" "The same ray by intersect, by occluded, and by occluded with a filter for what lets light pass."
    PlaySpeed "Steps a second" "How fast the steps are played."

    // Splits
    SplitCurve "Split costs" "What splitting the node would cost a ray that hits its box, at every position of each axis: C_t + C_i x (N_left x A_left + N_right x A_right) / A."
    SplitAxis "Axis" "The axis whose curve stands out, and whose planes are drawn in the viewport."
    OtherBins "Bins beside" "Another number of bins, whose planes are held beside those of the build."
    PlanesDrawn "Draw planes" "Draws the planes between these bins in the viewport."
    LeafCost "As a leaf" "C_i x shapes: what the node would cost unsplit."
    BestSplit "Best of all" "The cheapest split at any position of any axis, which the full sweep would take."
    BestOfBuild "Best of the build's bins" "The cheapest plane between the bins that the tree is built with."
    BestBeside "Best of the bins beside" "The cheapest plane between the other number of bins."
    MadeSplit "As it was split" "What the node's own children cost."

    // Construction
    Construction "Construction" "How the tree came about, node by node from the root down, or round by round."
    ConstructionStep "Step" "How many steps have been made: what stands then is drawn in the viewport."
    SplitsMade "Splits made" "Inner nodes that have been split, of all."
    RoundsMade "Rounds made" "Rounds that have been made, of all."
    Clusters "Clusters" "Nodes that stand without a parent: in each round pairs of them are merged."
    NodesStanding "Nodes" "Nodes of the binary tree that the improver works on."
    StandingArea "Sum of areas" "The surface areas of all boxes that stand, over that of the root."

    // Boxes
    ShowBoxes "Show boxes" "Draws the boxes of the tree over the picture."
    BoxStyle "Style" "How a box is drawn: its edges, its sides, or as one of many that add up."
    BoxColor "Colour" "What the colour of a box tells."
    ColorScale "Scale" "What the colours of the boxes mean, from the lowest to the highest value."
    LeavesOnly "Leaves only" "Draws the boxes of leaves and leaves out inner nodes."
    Hidden "Hidden lines" "Draws what lies behind surfaces, too."
    Budget "Budget" "The most boxes that are drawn at once: the largest on screen go first."
    DepthRange "Depths" "The depths whose boxes are drawn, where the root is at depth 0."
    Selected "Selected" "Boxes within the depth range."
    Drawn "Drawn" "Boxes that are in the picture now."
    Outside "Out of sight" "Selected boxes outside the picture, which are not drawn."
    TooSmall "Below a pixel" "Selected boxes smaller than a pixel, which are not drawn."
    OverBudget "Over the budget" "Selected boxes beyond the budget, which are not drawn."

    // Heatmap
    Counter "Counter" "What is counted or measured for each pixel."
    Count "Rays" "Which rays count: a pixel's value is the sum over the counted rays of one sample."
    ColorMap "Colour map" "The colours from the lowest to the highest value of the range."
    NumberScale "Scale" "Where a number stands between the ends of the colour map."
    Range "Range" "The values at the two ends of the colour map: automatic is from 0 to the 99.5th percentile."
    RangeLow "From" "The value shown in the first colour of the map."
    RangeHigh "To" "The value shown in the last colour of the map."
    Threshold "Threshold" "Values of at least this are shown in one flat colour, and the rest dimmed."
    Region "Part of the picture" "The numbers of the pixels inside a rectangle that was marked in the viewport."
    RegionPixels "Pixels" "Pixels in the rectangle that have a number."
    LargestPixels "Most expensive pixels" "The pixels with the largest numbers, of the marked part if there is one, none close to another: a click selects what the pixel shows."
    UnderMouse "Under the mouse" "The number of the pixel that the mouse points at."
    Pixel "Pixel" "Column and row of the picture, from the top left."
    HoverShape "Shape" "The index of the shape that the pixel's camera ray hits first."
    HoverDistance "Distance" "From the camera to the first surface, in units of the scene."
    Mean "Mean" "The mean over all pixels that have a number."
    Median "Median" "Half of the pixels have at most this number."
    P95 "95th percentile" "95 of 100 pixels have at most this number."
    P99 "99th percentile" "99 of 100 pixels have at most this number."
    Maximum "Maximum" "The highest number of any pixel."

    Exposure "Exposure" "In stops: each doubles or halves the light that the picture shows."
    ToneCurve "Tone curve" "How light is mapped to what a display can show, after the exposure."

    // Cost
    SahInner "of inner nodes" "The traversal cost times the surface areas of all inner nodes, divided by the root's."
    SahLeaf "of leaves" "The intersection cost times the surface area and number of shapes of every leaf, divided by the root's area."
    PerDepth "SAH cost per depth" "How much of the SAH cost lies at each depth."
    LeafSizes "Leaf sizes" "How many leaves hold how many shapes."
    Predicted "SAH alone" "The SAH cost: the mean ray cost of lines spread evenly over all that hit the root's box."
    Predictions "Predictions" "What the boxes say in advance of the mean cost of a ray."
    Epo "EPO" "End-point overlap: the share of all surface that lies in boxes it does not belong to, times what such a box costs."
    SahEpo "SAH + EPO" "0.29 SAH cost + 0.71 EPO, the mixture that predicted times best (Aila, Karras, Laine 2013)."
    PrimaryCost "primary rays" "Through the centres of every n-th pixel: traversal cost times inner visits plus intersection cost times shape tests."
    DiffuseCost "diffuse rays" "From where the primary rays hit, one cosine-weighted bounce each, whatever the material."
    ShadowCost "shadow rays" "From where the primary rays hit to one point of a light, asked by occluded, which stops at any hit."
    WhichHolds "Which prediction holds" "Of all pairs of builds whose rays paid differently, the share that a prediction puts in the right order; by chance it is 50 %."
    MeasuredHit "Measured" "The mean ray cost of those camera rays that hit the root's box, traversal cost times inner visits plus intersection cost times shape tests."
    MeasuredAll "over all rays" "The mean ray cost of all camera rays, of which those that miss the root's box cost nothing."
    MissedRoot "Rays that miss the root" "The share of camera rays that miss the box of the root, and so visit nothing."
    Overlap "Overlap" "Summed over inner nodes: the area that children's boxes share in pairs, divided by the area of the node's box."
    Lcv "LCV" "Leaf count variability: the standard deviation of the number of leaves that a ray visits."
    BoxTests "Box tests" "Boxes of children tested, a mean per camera ray."
    ShapeTests "Shape tests" "Shapes tested, a mean per camera ray."
    LeafVisits "Leaf visits" "Leaves whose shapes were tested, a mean per camera ray."
    EmptySpace "Empty space" "The mean over inner nodes of the share of their volume that no child covers."
    SlotFill "Slots filled" "The share of child slots of all inner nodes that are used."
    LeafFill "Lanes filled" "The share of the lanes of all leaves with a shape, where four are tested at once."
    BytesPerShape "Memory a shape" "Tree and shapes ready to trace, by the number of shapes."
    BinCurve "What the bins do" "SAH cost, nodes visited and build time of the binned tree over the number of bins, counted on a fixed part of the rays."
    FullSweep "Full sweep" "The same tree built by trying every position on all three axes, which the bins approximate."

    // Compare
    States "States" "Settings that are kept side by side, each with its tree: the current one is what the other panels show and change."
    PinState "Pin" "Keeps the scene and the moment of this state when those of the window change."
    CompareA "Left" "The state on the left, in front of the line of a wipe, and first when they blink."
    CompareB "Right" "The state on the right: differences are right - left, so that less on the right is below zero."
    CompareStates "Show" "How the pictures of the two states share the viewport: both have one camera and one range of colours."
    BlinkInterval "Interval" "How long each of the two pictures is seen."
    OwnCameras "Each scene through its own camera" "Shows the other scene through the camera that it came with, not through the one that you move."
    CompareMoment "Later moment" "Compares this moment of a moving scene with the one so much later, and the trees of both."
    CompareOwnTree "Our own tree" "Compares the tree of the file with the one that the settings of the panel Build make."
    CompareScene "Another scene" "Compares with another scene under the same settings: a built-in name, or the path of a model."
    DifferencePixels "Difference of the pixels" "How many pixels have which difference, right - left, in the colours of the picture: red where the right one has more, blue where it has less."
    DifferenceMean "Mean difference" "The mean of right - left over all pixels that have numbers in both pictures."
    PairedRayCost "Mean ray cost" "C_t x inner visits + C_i x shape tests of a camera ray: mean and 95 % interval, of the difference over the same rays in both trees."
    TimeBoth "Time frames" "Times a Whitted frame with each of the two trees, the median of 5, while the picture stands still."
    HideEqual "Hide what is equal" "Leaves out the figures that both have in common."

    // Shadows
    ShadowRule "Light passes" "Which materials let shadow rays of the Whitted pictures go straight on."
    CompareWith "Compare" "Shows two of the pictures at once, next to each other or as a wipe."
    CompareLeft "Left" "The picture on the left."
    CompareRight "Right" "The picture on the right."
    PixelClasses "Pixels" "What each pixel shows when the answers of intersect and occluded are held against each other."
    ShadowNodes "Nodes per shadow ray" "Nodes visited by the same shadow ray in the same child order, asked in three ways."
    AskIntersect "intersect" "Looks for the nearest hit, and goes on behind it where its material lets light pass."
    AskOccluded "occluded" "Stops at any hit, and so cannot know what it hit: glass throws a black shadow."
    AskFiltered "occluded + filter" "Stops at any hit that blocks light, which a mask a shape says."
    Saved "Saved by the early out" "How many fewer nodes the filtered occluded visits than intersect, and both give the same answer."

    // Table
    FiveTrees "Five trees" "Median, full sweep and binned builds at widths 2 and 4, on this scene and view, with all rays of a Whitted frame counted."

    // Sweep
    SweepGrid "Grid" "Trees of all combinations of these settings, each built, and its rays counted, on this scene and view."
    BinsList "Bins" "Numbers of bins, with commas between; only the builders binned and spatial have bins."
    LeafList "Leaf limits" "Leaf limits, with commas between."
    TraversalList "C_t" "Traversal costs, with commas between; only the stop rule cost and optimal widening weigh them."
    TimedFrames "Time frames" "Times a Whitted frame with every tree, too, which takes several times as long."
    FindBest "Find the best" "Searches bins, leaf limit and costs of the chosen builders and widths for the best tree of this scene and view."
    Objective "Least" "What is to be least: the measured ray cost, or the time of a build and the rays of so many frames."
    Frames "Frames" "For how many frames the tree is built: their rays' times are added to the build's."
    SweepPlot "Plot" "Each point is a tree: the line joins the Pareto front, which no other tree beats in both figures."
    PlotX "Across" "The figure from left to right."
    PlotY "Up" "The figure from bottom to top."
    PlotColor "Colour" "The figure that the points' colours tell."
    SweepPoints "Points" "Every tree of the sweep; a click on a heading sorts, a click on a tree loads its settings."
    SweepFile "Points of the sweep" "All points of the Sweep panel as CSV or JSON by the file's ending, which the command sweep can resume."
    // Tree file
    FileNodes "Nodes" "Inner nodes in the file."
    FileLeaves "Leaves" "Leaves in the file."
    FileWidth "Slots a node" "How many children a node of the file has room for."
    FileReferences "References" "Entries of the file's list of shapes."
    InSeveral "Shapes in several leaves" "Shapes that more than one leaf refers to, as spatial splits make them: a figure, not a fault."
    ExtraReferences "Further references" "Entries of leaves beyond the first of each shape."
    Violations "Findings" "What the check found: faults give wrong pictures or none, remarks are only odd."

    // Export
    PictureSize "Size" "The picture is rendered at this size, not scaled to it."
    PictureWidth "Picture width" "In pixels."
    PictureHeight "Picture height" "In pixels."
    Samples "Samples" "Samples a pixel of the picture that is written."
    WithOverlay "With boxes" "Draws the boxes over the picture as in the viewport."
    WithLegend "With legend" "Adds the colour bar with its numbers and the settings below the picture."
    PictureFile "Picture" "The viewport as a PNG that carries its session: dropped on the window, it opens what it shows."
    TreeFile "Tree" "The tree that is traced, for other programs: arrays as NumPy writes them (NPZ), or JSON; docs/tree-format.md says how."
    AnimationFile "Animation" "Pictures in a row: an animated .png or .gif, or with #### in the name a .png a frame, of which the finished ones stay when it is cancelled."
    AnimationMotion "Motion" "What moves from frame to frame."
    AnimationTurn "Degrees" "How far the camera turns around its target; a whole turn goes on without a stop when it is repeated."
    AnimationFrom "From" "The moment of the first frame."
    AnimationTo "To" "The moment of the last frame."
    AnimationFrames "Frames" "How many pictures."
    AnimationFps "Per second" "How many pictures are shown in a second; a GIF rounds the time of each to hundredths."
    ReportFile "Report" "One page of HTML that needs nothing but itself: pictures in the size and samples above, figures, plots, settings, the five trees if they were measured."
    BoxesFile "Boxes" "The boxes of the selected nodes as a model (.obj), an object a node."
    BoxesBelow "And all below" "The boxes of all nodes below those that are selected, too."
    PlotFile "Plot" "The plot that was chosen last, as a picture (.png), a drawing (.svg) or its data (.csv)."
    WindowFile "Whole window" "The window as it is, at its own size, as a PNG."
    RawFile "Raw numbers" "The unmapped numbers or linear colours of the viewport, as EXR or CSV by the file's ending."
    FiguresFile "Figures" "All figures of the current tree with the settings that gave them, as JSON or CSV by the file's ending."
    SessionFile "Session" "Everything that is shown, as a text file that the program opens again."
    CommandLine "Command" "The command line that makes the same picture without a window."
}

#[cfg(test)]
mod tests {
    use super::Term;

    #[test]
    fn every_term_is_explained_in_one_sentence() {
        for term in Term::ALL {
            let text = term.text();
            assert!(text.ends_with('.') && !text.trim_end_matches('.').contains(". "), "{term:?}: {text}");
            assert!(text.starts_with(|c: char| c.is_uppercase() || c.is_ascii_digit()), "{term:?}: {text}");
            assert!(text.len() <= 190, "{term:?} is too long for a tooltip");
        }
    }

    #[test]
    fn no_term_repeats_its_label_as_its_explanation() {
        for term in Term::ALL {
            assert!(
                !term.label().is_empty() && term.text().trim_end_matches('.') != term.label(),
                "{term:?}"
            );
        }
    }
}
