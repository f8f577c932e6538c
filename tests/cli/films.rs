//! Files of `animate`, `report` and `sweep --plot`.

use std::fs;

use super::{folder, program, refusal, small, stdout};

fn names(folder: &std::path::Path) -> Vec<String> {
    let entries = fs::read_dir(folder).expect("a folder");
    let mut names: Vec<_> =
        entries.map(|e| e.expect("an entry").file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    names
}

#[test]
fn animate_writes_a_file_a_frame_or_one_for_all() {
    let folder = folder();
    let sequence = folder.path().join("f-##.png");
    let gif = folder.path().join("turn.gif");
    let view = ["--view", "normal", "--frames", "3", "--fps", "10"];
    let out = sequence.display().to_string();
    let said = stdout(small("animate", &["--out", &out]).args(view));
    assert_eq!(said.trim(), out);
    stdout(small("animate", &["--out", &gif.display().to_string(), "--turn", "90"]).args(view));
    assert_eq!(names(folder.path()), ["f-01.png", "f-02.png", "f-03.png", "turn.gif"]);
    let frame =
        |i: u32| image::open(folder.path().join(format!("f-0{i}.png"))).expect("a picture").into_rgba8();
    assert_eq!(frame(1).dimensions(), (64, 36));
    assert_ne!(frame(1), frame(2), "the camera turns");
    // The first frame is the picture of `render`.
    let still = folder.path().join("still.png");
    stdout(
        small("render", &["--out", &still.display().to_string(), "--view", "normal"])
            .args(["--boxes", "off"]),
    );
    assert_eq!(frame(1), image::open(&still).expect("a picture").into_rgba8());
}

#[test]
fn animate_takes_a_range_of_time() {
    let folder = folder();
    let out = folder.path().join("time.png").display().to_string();
    let words = [
        "animate", "room", "--size", "48x27", "--view", "normal", "--to", "0.5", "--fps", "4", "--out", &out,
    ];
    stdout(&mut program(&words));
    let file = std::io::BufReader::new(fs::File::open(&out).expect("a file"));
    let decoder = image::codecs::png::PngDecoder::new(file).expect("a PNG");
    use image::AnimationDecoder as _;
    let frames = decoder.apng().expect("animated").into_frames().collect_frames().expect("frames");
    assert_eq!(frames.len(), 3, "half a second at 4 frames a second, both ends shown");
}

#[test]
fn animate_refuses_what_it_cannot_do_before_it_begins() {
    let folder = folder();
    let out = folder.path().join("film.mp4").display().to_string();
    let message = refusal(&mut small("animate", &["--out", &out]), 2);
    assert!(message.contains("'mp4'") && message.contains("frame-####.png"), "{message}");
    let out = folder.path().join("missing/f-#.png").display().to_string();
    assert!(refusal(&mut small("animate", &["--out", &out]), 1).contains("there is no folder"));
    refusal(&mut small("animate", &["--out", "a.gif", "--frames", "0"]), 2);
    refusal(&mut small("animate", &["--out", "a.gif", "--from", "1"]), 2);
    refusal(&mut small("animate", &["--out", "a.gif", "--turn", "nan"]), 2);
    assert!(names(folder.path()).is_empty());
}

#[test]
fn a_sweep_is_plotted_beside_its_points() {
    let folder = folder();
    for (name, begins) in [("p.svg", "<svg"), ("p.csv", "series,")] {
        let path = folder.path().join(name);
        stdout(&mut small(
            "sweep",
            &["--bins-grid", "4,16", "--leaf-grid", "2", "--plot", &path.display().to_string()],
        ));
        let drawn = std::fs::read_to_string(&path).expect("it was written");
        assert!(drawn.starts_with(begins), "{drawn}");
        assert!(drawn.contains("Pareto front"), "{drawn}");
    }
    let bad = folder.path().join("p.pdf").display().to_string();
    assert!(refusal(&mut small("sweep", &["--plot", &bad]), 1).contains("use .png, .svg or .csv"));
}

#[test]
fn a_report_is_one_page() {
    let folder = folder();
    let path = folder.path().join("r.html");
    stdout(&mut small("report", &["--out", &path.display().to_string(), "--table", "--leaf", "3"]));
    let page = std::fs::read_to_string(&path).expect("it was written");
    assert!(page.starts_with("<!DOCTYPE html>") && page.trim_end().ends_with("</html>"));
    for said in ["QBVH_BIN", "data:image/png;base64,", "<svg", "bvhscope stats soup:2000", "--leaf"] {
        assert!(page.contains(said), "{said}");
    }
    assert_eq!(names(folder.path()), ["r.html"]);
}
