//! The real window under Xvfb: it opens, shows a rendered scene with the boxes over it and the panels around it, and
//! survives what a broken file of its own would do to it.
//!
//! Needs `Xvfb` and Mesa's software drivers. Without them it says that it is skipped, and why; with
//! `BVHSCOPE_REQUIRE_WINDOW=1` it fails instead.

use std::fs;
use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

use image::{Rgba, RgbaImage};

/// Ample for a machine that builds something else meanwhile.
const PATIENCE: Duration = Duration::from_secs(150);

/// The size of the window at its first start.
const SIZE: (u32, u32) = (1280, 800);

/// A display of its own, gone when dropped.
struct Display {
    server: Child,
    name: String,
}

impl Display {
    /// # Errors
    /// Why there can be none.
    fn start() -> Result<Self, String> {
        let mut server = Command::new("Xvfb")
            .args(["-displayfd", "1", "-screen", "0", "1400x900x24", "-noreset", "-nolisten", "tcp"])
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .map_err(|error| format!("Xvfb cannot be started: {error}"))?;
        let mut line = String::new();
        let stdout = server.stdout.take().expect("a pipe was asked for");
        BufReader::new(stdout).read_line(&mut line).map_err(|error| error.to_string())?;
        match line.trim().parse::<u32>() {
            Ok(number) => Ok(Self { server, name: format!(":{number}") }),
            Err(_) => {
                let _ = server.kill();
                let _ = server.wait();
                Err("Xvfb opened no display".to_owned())
            }
        }
    }
}

impl Drop for Display {
    fn drop(&mut self) {
        // It may have ended by itself; either way it is gone now.
        let _ = self.server.kill();
        let _ = self.server.wait();
    }
}

/// Skips, or fails where the window is required.
fn skip(reason: &str) {
    let required = std::env::var_os("BVHSCOPE_REQUIRE_WINDOW").is_some_and(|v| v == "1");
    assert!(!required, "BVHSCOPE_REQUIRE_WINDOW=1, but: {reason}");
    eprintln!("skipped: {reason}");
}

/// Starts the window, which takes a picture of itself and closes. `None` where it cannot open one here.
fn shoot(display: &Display, home: &Path, arguments: &[&str]) -> Option<RgbaImage> {
    let path = home.join("window.png");
    let runtime = home.join("runtime");
    fs::create_dir_all(&runtime).expect("a folder");
    let mut program = Command::new(env!("CARGO_BIN_EXE_bvhscope"))
        .args(arguments)
        .env("DISPLAY", &display.name)
        .env_remove("WAYLAND_DISPLAY")
        .env("LIBGL_ALWAYS_SOFTWARE", "1")
        .env("HOME", home)
        .env("XDG_DATA_HOME", home.join("data"))
        .env("XDG_RUNTIME_DIR", &runtime)
        .env("BVHSCOPE_SCREENSHOT", &path)
        .env("BVHSCOPE_SCREENSHOT_SAMPLES", "3")
        .env("BVHSCOPE_SCREENSHOT_SECONDS", "100")
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the program starts");
    let start = Instant::now();
    while program.try_wait().expect("the program can be asked").is_none() {
        if start.elapsed() > PATIENCE {
            let _ = program.kill();
            let output = program.wait_with_output().expect("its output");
            panic!("the window took no picture of itself within {PATIENCE:?}: {}", said(&output));
        }
        std::thread::sleep(Duration::from_millis(20));
    }
    let output = program.wait_with_output().expect("its output");
    if !output.status.success() && said(&output).contains("cannot open a window") {
        skip(&format!("no window opens here (Mesa's drivers missing?): {}", said(&output)));
        return None;
    }
    assert!(output.status.success(), "the program failed: {}", said(&output));
    let picture = image::open(&path).unwrap_or_else(|error| panic!("no picture: {error}; {}", said(&output)));
    Some(picture.into_rgba8())
}

fn said(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).trim().to_owned()
}

/// The part of the window from `min` to `max`.
fn part(window: &RgbaImage, min: (u32, u32), max: (u32, u32)) -> RgbaImage {
    image::imageops::crop_imm(window, min.0, min.1, max.0 - min.0, max.1 - min.1).to_image()
}

fn luminance(pixel: &Rgba<u8>) -> f64 {
    let [r, g, b, _] = pixel.0.map(f64::from);
    0.2126 * r + 0.7152 * g + 0.0722 * b
}

/// Mean and standard deviation of the luminance, and the number of different colours.
fn statistics(picture: &RgbaImage) -> (f64, f64, usize) {
    let count = f64::from(picture.width()) * f64::from(picture.height());
    let mean = picture.pixels().map(luminance).sum::<f64>() / count;
    let variance = picture.pixels().map(|p| (luminance(p) - mean).powi(2)).sum::<f64>() / count;
    let mut colors: Vec<[u8; 4]> = picture.pixels().map(|p| p.0).collect();
    colors.sort_unstable();
    colors.dedup();
    (mean, variance.sqrt(), colors.len())
}

/// The colour that most pixels have, and the share that has it.
fn commonest(picture: &RgbaImage) -> ([u8; 4], f64) {
    let mut counts = std::collections::HashMap::new();
    for pixel in picture.pixels() {
        *counts.entry(pixel.0).or_insert(0_u32) += 1;
    }
    let (color, count) = counts.into_iter().max_by_key(|(_, n)| *n).expect("a picture has pixels");
    (color, f64::from(count) / (f64::from(picture.width()) * f64::from(picture.height())))
}

/// A rendered scene: neither black nor white nor uniform, with the many colours of light on surfaces.
fn assert_scene(window: &RgbaImage, name: &str) {
    let viewport = part(window, (340, 90), (920, 740));
    let (mean, deviation, colors) = statistics(&viewport);
    assert!((15.0..240.0).contains(&mean), "{name}: mean luminance {mean}");
    assert!(deviation > 12.0, "{name}: the picture is uniform, deviation {deviation}");
    assert!(colors > 800, "{name}: only {colors} colours");
}

/// A panel: one flat ground, with text and controls on it that stand out.
fn assert_panel(window: &RgbaImage, min: (u32, u32), max: (u32, u32), name: &str) {
    let panel = part(window, min, max);
    let (ground, share) = commonest(&panel);
    assert!((0.35..0.99).contains(&share), "{name}: the ground has {share:.2} of the pixels");
    let ground = luminance(&Rgba(ground));
    let marks = panel.pixels().filter(|p| (luminance(p) - ground).abs() > 60.0).count();
    let marks = marks as f64 / f64::from(panel.width() * panel.height());
    assert!(marks > 0.01, "{name}: only {marks:.4} of the pixels stand out from the ground");
}

fn assert_panels(window: &RgbaImage) {
    assert_eq!(window.dimensions(), SIZE);
    assert_panel(window, (4, 62), (312, 400), "Build");
    assert_panel(window, (4, 430), (312, 760), "Boxes");
    assert_panel(window, (950, 62), (1270, 760), "Cost");
    assert_panel(window, (0, 0), (320, 28), "menus");
    assert_panel(window, (0, 28), (700, 58), "toolbar");
}

#[test]
fn the_window_shows_a_rendered_scene_with_panels_around_it() {
    let display = match Display::start() {
        Ok(display) => display,
        Err(reason) => return skip(&reason),
    };
    let home = tempfile::tempdir().expect("a folder");
    let Some(plain) = shoot(&display, home.path(), &["--boxes", "off"]) else { return };
    assert_panels(&plain);
    assert_scene(&plain, "without boxes");

    // A second start finds what the first one stored; this one finds it broken, and other scene and view asked for.
    let stored = home.path().join("data/bvhscope/app.ron");
    assert!(stored.exists(), "the layout is kept in {}", stored.display());
    fs::write(&stored, "(\"bvhscope_layout_1\": \"(tree:(root:Some((7))\"").expect("it can be written");
    let Some(heat) = shoot(&display, home.path(), &["cornell", "--view", "nodes-visited"]) else { return };
    assert_panels(&heat);
    let differing = plain.pixels().zip(heat.pixels()).filter(|(a, b)| a != b).count();
    assert!(differing > 100_000, "another scene and view look the same: {differing} pixels differ");
}

#[test]
fn boxes_are_drawn_over_the_picture_at_first_start() {
    let display = match Display::start() {
        Ok(display) => display,
        Err(reason) => return skip(&reason),
    };
    let home = tempfile::tempdir().expect("a folder");
    let arguments = ["--view", "normal"];
    let Some(boxes) = shoot(&display, home.path(), &arguments) else { return };
    let Some(plain) = shoot(&display, home.path(), &[&arguments[..], &["--boxes", "off"]].concat()) else {
        return;
    };
    assert_scene(&boxes, "with boxes");
    let (min, max) = ((340, 90), (920, 740));
    let differing =
        part(&boxes, min, max).pixels().zip(part(&plain, min, max).pixels()).filter(|(a, b)| a != b).count();
    assert!(differing > 3_000, "no boxes: only {differing} pixels of the picture differ");
}
