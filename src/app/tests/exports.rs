//! Plots, films and reports, from the window to their files.

use super::super::commands::{Command, ExportRequest};
use super::{cornell, errors, push, start};
use crate::export::animation::Frames;
use crate::export::picture::Extras;
use crate::inspect::plot::tree;

#[test]
fn plots_films_and_reports_are_written() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| folder.path().join(name);
    let mut harness = start(cornell());
    let (size, samples) = ([40, 30], 1);
    let frames = Frames { count: 3, fps: 10, time: None, turn_degrees: 90.0 };
    push(&mut harness, Command::Export(ExportRequest::Plot { path: at("none.svg") }));
    assert!(errors(&harness)[0].contains("No plot was chosen yet"), "{:?}", errors(&harness));
    harness.state_mut().state.messages.dismiss(0);

    let world = harness.state().state().document.as_ref().expect("open").world.clone();
    harness.state_mut().state.plot = Some(tree::leaf_sizes(&world.figures).into());
    let extras = Extras { overlay: true, legend: true };
    let film = |name: &str| ExportRequest::Animation { path: at(name), size, samples, extras, frames };
    let requests = [
        ExportRequest::Plot { path: at("p.svg") },
        ExportRequest::Plot { path: at("p.png") },
        ExportRequest::Plot { path: at("p.csv") },
        film("f-#.png"),
        film("f.gif"),
        ExportRequest::Report { path: at("r.html"), size, samples },
    ];
    for request in requests {
        push(&mut harness, Command::Export(request));
    }
    assert!(errors(&harness).is_empty(), "{:?}", errors(&harness));
    for name in ["p.svg", "p.png", "p.csv", "f-1.png", "f-2.png", "f-3.png", "f.gif", "r.html"] {
        let bytes = std::fs::metadata(at(name)).unwrap_or_else(|error| panic!("{name}: {error}")).len();
        assert!(bytes > 20, "{name}: {bytes} bytes");
    }
}
