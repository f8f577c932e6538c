//! A session as one page of HTML: pictures, figures, plots, settings, and how to make it all again. It needs nothing but
//! itself, and is read on a dark and on a light ground.

use std::path::Path;

use base64::Engine as _;
use maud::{DOCTYPE, Markup, PreEscaped, html};

use super::plot::{Look, svg};
use super::{ExportError, atomic, png};
use crate::inspect::columns::{COLUMNS, comparing, grouped};
use crate::inspect::histogram::Histogram;
use crate::inspect::numbers;
use crate::inspect::plot::{Plot, tree};
use crate::inspect::stats::{TreeStats, tree_stats};
use crate::render::display::effective_range;
use crate::render::{Film, View, ViewClass};
use crate::scene::Camera;
use crate::session::flags::{command, command_line, flags};
use crate::session::{Session, file};
use crate::task::{Cancelled, Task};
use crate::world::World;

use super::picture::{self, Extras};

/// Bars of a histogram.
const BINS: usize = 96;

const STYLE: &str = "\
:root { color-scheme: light dark; --ground: #ffffff; --well: #f3f4f6; --text: #1c1f24; --muted: #646a74; --line: #d8dbe0; --accent: #1468be; }
@media (prefers-color-scheme: dark) { :root { --ground: #1a1c20; --well: #24272d; --text: #dfe2e8; --muted: #9aa0ac; --line: #3a3e46; --accent: #5eb2ff; } }
body { background: var(--ground); color: var(--text); font: 15px/1.5 system-ui, sans-serif; margin: 0 auto; max-width: 1100px; padding: 24px; }
h1 { font-size: 26px; margin: 0; } h2 { font-size: 19px; margin: 36px 0 10px; }
.quiet, figcaption { color: var(--muted); }
figure { margin: 0 0 18px; } figure img { display: block; width: 100%; height: auto; border-radius: 4px; }
.two { display: grid; grid-template-columns: repeat(auto-fit, minmax(420px, 1fr)); gap: 18px; }
.two svg { width: 100%; height: auto; background: var(--well); border-radius: 4px; }
.wide { overflow-x: auto; }
table { border-collapse: collapse; } th, td { border-bottom: 1px solid var(--line); padding: 3px 14px 3px 0; text-align: left; vertical-align: top; }
td.number, th.number { text-align: right; font-variant-numeric: tabular-nums; white-space: nowrap; }
pre { background: var(--well); border-radius: 4px; overflow-x: auto; padding: 10px 14px; white-space: pre-wrap; overflow-wrap: anywhere; }
b.best { color: var(--accent); }
@media print { body { max-width: none; } h2 { break-after: avoid; } figure, tr { break-inside: avoid; } }
";

/// What goes into a report beside what is rendered for it.
#[derive(Clone, Debug, Default)]
pub struct Measured {
    /// The five trees, if they were measured.
    pub table: Vec<TreeStats>,
    /// Further plots.
    pub plots: Vec<Plot>,
}

/// Everything that a report says.
#[derive(Clone, Debug)]
pub struct Report {
    session: Session,
    stats: TreeStats,
    pictures: Vec<Shot>,
    plots: Vec<Plot>,
    table: Vec<TreeStats>,
}

/// A picture in a report.
#[derive(Clone, Debug)]
struct Shot {
    caption: String,
    png: Vec<u8>,
}

/// What stops a report.
#[derive(Debug, thiserror::Error)]
pub enum ReportError {
    #[error("cancelled; nothing was written")]
    Cancelled,
    #[error(transparent)]
    Export(#[from] ExportError),
}

impl From<Cancelled> for ReportError {
    fn from(_: Cancelled) -> Self {
        Self::Cancelled
    }
}

impl Report {
    /// Renders the session's view, and a heatmap beside it if that is none itself; counts rays, and gathers the rest.
    /// Progress on `task` in steps.
    ///
    /// # Errors
    /// [`ReportError`]
    pub fn make(
        session: &Session,
        world: &World,
        camera: Camera,
        measured: Measured,
        task: &Task,
    ) -> Result<Self, ReportError> {
        let mut session = Session { camera: Some(camera), ..session.clone() };
        // Without end in the window.
        session.render.spp.get_or_insert(1);
        let heat = Session { view: View::NodesVisited, ..session.clone() };
        let shown: Vec<&Session> =
            if session.view.class() == ViewClass::Heat { vec![&session] } else { vec![&session, &heat] };
        task.start(shown.len() as u64 + 1);
        let mut pictures = Vec::new();
        let mut plots = tree_plots(world);
        for (index, session) in shown.into_iter().enumerate() {
            let film = picture::film(session, world, &camera, &task.step())?;
            // Boxes would hide the heat.
            let extras = Extras { overlay: index == 0, legend: true };
            let image = picture::of_film(&film, session, world, &camera, extras, &task.step())?;
            let text = file::to_text(session, None);
            pictures.push(Shot { caption: caption(session), png: png::encode(&image, Some(&text))? });
            plots.extend(histogram(&film, session));
            task.advance(1);
        }
        plots.extend(measured.plots);
        let name = &session.variants[session.active].name;
        let stats = tree_stats(name, world, &camera, &session.render, session.count, false, &task.step())?;
        task.advance(1);
        Ok(Self { session, stats, pictures, plots, table: measured.table })
    }

    /// Writes the page.
    ///
    /// # Errors
    /// [`ExportError::Write`]
    pub fn save(&self, path: &Path) -> Result<(), ExportError> {
        atomic::write_bytes(path, self.html().as_bytes())
    }

    /// The page.
    pub fn html(&self) -> String {
        let title = format!("{} - bvhscope", self.stats.scene);
        let page = html! {
            (DOCTYPE)
            html lang="en" {
                head {
                    meta charset="utf-8";
                    meta name="viewport" content="width=device-width, initial-scale=1";
                    meta name="generator" content={ "bvhscope " (env!("CARGO_PKG_VERSION")) };
                    title { (title) }
                    style { (PreEscaped(STYLE)) }
                }
                body {
                    h1 { (self.stats.scene) }
                    p.quiet {
                        (grouped(self.stats.shape_count as f64, 0)) " shapes, "
                        (self.session.render.width) " × " (self.session.render.height) " pixels, "
                        (self.session.count.name()) " rays counted"
                    }
                    @for shot in &self.pictures { (shot.markup()) }
                    (self.figures())
                    (self.five_trees())
                    (self.build())
                    h2 { "Plots" }
                    div.two {
                        @for plot in &self.plots { figure { (PreEscaped(svg(plot, Look::Page))) } }
                    }
                    (self.settings())
                    (self.again())
                }
            }
        };
        page.into_string()
    }

    fn figures(&self) -> Markup {
        html! {
            h2 { "Figures" }
            div.wide { table {
                tr { th { "Figure" } th.number { (self.stats.name) } th { "Meaning" } }
                @for column in COLUMNS.iter().filter(|column| !column.is_text()) {
                    tr {
                        td { (column.heading()) }
                        td.number { (column.shown(&self.stats)) }
                        td.quiet { (column.meaning) }
                    }
                }
            } }
        }
    }

    fn five_trees(&self) -> Markup {
        if self.table.is_empty() {
            return html! {};
        }
        html! {
            h2 { "Trees side by side" }
            p.quiet { "All rays of a Whitted frame are counted; the best of each line stands out." }
            div.wide { table {
                tr {
                    th { "Figure" }
                    @for row in &self.table { th.number { (row.name) } }
                }
                @for column in comparing().filter(|column| column.key != "name") {
                    @let best = crate::inspect::columns::best_rows(&self.table, column);
                    tr {
                        td { (column.heading()) }
                        @for (index, row) in self.table.iter().enumerate() {
                            td.number {
                                @if best.contains(&index) { b.best { (column.shown(row)) } } @else { (column.shown(row)) }
                            }
                        }
                    }
                }
            } }
        }
    }

    fn build(&self) -> Markup {
        html! {
            h2 { "Build" }
            table {
                tr { th { "Phase" } th.number { "Time (ms)" } th.number { "Share (%)" } }
                @for phase in &self.stats.phases {
                    tr {
                        td { (phase.name) }
                        td.number { (numbers::decimal(phase.ms, 2)) }
                        td.number { (numbers::percent(phase.ms, self.stats.build_ms)) }
                    }
                }
                tr {
                    td { "all" }
                    td.number { (numbers::decimal(self.stats.build_ms, 2)) }
                    td.number { (numbers::percent(1.0, 1.0)) }
                }
            }
        }
    }

    fn settings(&self) -> Markup {
        let default = Session::default();
        html! {
            h2 { "Settings" }
            p.quiet { "Those that are not the default stand out." }
            div.wide { table {
                tr { th { "Flag" } th { "Value" } th { "Meaning" } }
                @for flag in flags() {
                    @let value = flag.write(&self.session);
                    tr {
                        td { "--" (flag.name) }
                        td { @if value == flag.write(&default) { (value) } @else { b.best { (value) } } }
                        td.quiet { (flag.help) }
                    }
                }
            } }
        }
    }

    fn again(&self) -> Markup {
        let mut heat = self.session.clone();
        heat.view = View::NodesVisited;
        let mut lines = vec![command_line(&self.session, "picture.png")];
        if self.pictures.len() > 1 {
            lines.push(command_line(&heat, "heat.png"));
        }
        lines.push(command(&self.session, "stats", &[]));
        if !self.table.is_empty() {
            lines.push(command(&self.session, "table", &[]));
        }
        lines.push(command(&self.session, "report", &["--out", "report.html"]));
        html! {
            h2 { "To make it again" }
            pre { (lines.join("\n")) }
            p.quiet { "Each picture of this page carries its session: saved as a file, it opens in bvhscope." }
        }
    }
}

impl Shot {
    fn markup(&self) -> Markup {
        let data = base64::engine::general_purpose::STANDARD.encode(&self.png);
        html! {
            figure {
                img src={ "data:image/png;base64," (data) } alt=(self.caption);
                figcaption { (self.caption) }
            }
        }
    }
}

fn caption(session: &Session) -> String {
    let name = session.view.name().replace('-', " ");
    format!("{name}: {}", session.view.description())
}

fn tree_plots(world: &World) -> Vec<Plot> {
    let figures = &world.figures;
    let costs: Vec<f64> = world.report.rounds.iter().map_while(|cost| *cost).collect();
    let mut plots =
        vec![tree::sah_by_depth(figures), tree::nodes_by_depth(figures), tree::leaf_sizes(figures)];
    if costs.len() > 1 {
        plots.push(tree::round_costs(&costs));
    }
    plots
}

/// Of a film of numbers.
fn histogram(film: &Film, session: &Session) -> Option<Plot> {
    let numbers = film.numbers()?;
    let histogram = Histogram::of(&numbers, BINS, None)?;
    let range = effective_range(film, &session.display).unwrap_or(histogram.range).map(f64::from);
    Some(tree::histogram(&histogram, &session.view.name().replace('-', " "), range))
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::inspect::table::five_trees;
    use crate::scene::builtin;

    fn report(table: bool) -> Report {
        let mut session = Session::default();
        session.scene.reference = crate::scene::SceneRef::Builtin("cornell".to_owned());
        (session.render.width, session.render.height) = (32, 24);
        session.build_mut().leaf = 5;
        session.variants[0].name = "<A & B>".to_owned();
        let scene = Arc::new(builtin::make("cornell").expect("a built-in scene"));
        let task = Task::new();
        let world = World::build(Arc::clone(&scene), session.build(), &task).expect("not cancelled");
        let table = if table {
            five_trees(&scene, &scene.camera, session.build(), &session.render, &task, &mut |_| ())
                .expect("not cancelled")
        } else {
            Vec::new()
        };
        let measured = Measured { table, plots: Vec::new() };
        Report::make(&session, &world, scene.camera, measured, &task).expect("made")
    }

    #[test]
    fn a_page_needs_nothing_but_itself_and_says_everything() {
        let page = report(true).html();
        for link in ["http://", "https://", "src=\"/", "<script", "<link"] {
            let rest = page.replace("http://www.w3.org/2000/svg", "");
            assert!(!rest.contains(link), "the page asks for {link}");
        }
        for said in [
            "Figures",
            "QBVH_BIN",
            "--leaf",
            "bvhscope stats cornell",
            "report --out report.html",
            "nodes visited",
            "&lt;A &amp; B&gt;",
        ] {
            let words: Vec<_> = said.split(' ').collect();
            assert!(page.contains(said) || words.iter().all(|word| page.contains(word)), "{said}");
        }
        assert!(!page.contains("<A & B>"), "names are escaped");
        assert_eq!(page.matches("data:image/png;base64,").count(), 2);
        assert!(page.matches("<svg").count() >= 4 && page.contains("prefers-color-scheme: dark"));
        assert!(!report(false).html().contains("QBVH_BIN"));
    }

    #[test]
    fn its_pictures_carry_their_sessions() {
        let report = report(false);
        let page = report.html();
        let start = page.find("base64,").expect("a picture") + 7;
        let end = start + page[start..].find('"').expect("an end");
        let bytes = base64::engine::general_purpose::STANDARD.decode(&page[start..end]).expect("base64");
        let text = png::session_text(std::io::Cursor::new(bytes)).expect("a PNG").expect("a session");
        let session = file::from_text(&text, None).expect("a session");
        assert_eq!((session.build().leaf, session.view), (5, View::Path));
    }

    #[test]
    fn a_cancel_stops_it() {
        let scene = Arc::new(builtin::make("cornell").expect("a built-in scene"));
        let world =
            World::build(Arc::clone(&scene), Session::default().build(), &Task::new()).expect("built");
        let task = Task::new();
        task.cancel();
        let made = Report::make(&Session::default(), &world, scene.camera, Measured::default(), &task);
        assert!(matches!(made, Err(ReportError::Cancelled)));
    }
}
