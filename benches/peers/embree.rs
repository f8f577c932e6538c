//! Embree, as the harness's own program runs it, on the same triangles and rays: its binary reads them from files.

use std::path::{Path, PathBuf};
use std::process::Command;

use tempfile::TempDir;

use super::inputs::Input;
use super::report::Figures;

/// The builds whose rows are kept, as the harness names them.
const QUALITIES: [&str; 4] = ["LOW", "MEDIUM", "HIGH", "MEDIUM robust"];

pub struct Embree {
    binary: PathBuf,
    work: TempDir,
    scene: String,
    ray_counts: [usize; 3],
}

impl Embree {
    /// Writes the input where the binary can read it.
    pub fn prepare(binary: &Path, input: &Input, expected: &[Vec<f32>; 3]) -> Self {
        let work = tempfile::tempdir().expect("a folder for Embree's inputs");
        let scene = input.name.replace(':', "-");
        input.write(work.path(), &scene, expected);
        let ray_counts = input.sets.each_ref().map(|set| set.rays.len());
        Self { binary: binary.to_owned(), work, scene, ray_counts }
    }

    /// One round: a row a build quality.
    pub fn run(&self) -> Vec<(String, Figures)> {
        let mut command = Command::new(&self.binary);
        command.arg(&self.scene).env("PEERS_WORK", self.work.path()).env("REPS", "1");
        let output = command.output().expect("Embree's binary runs");
        assert!(
            output.status.success(),
            "Embree's binary fails: {}",
            String::from_utf8_lossy(&output.stderr)
        );
        String::from_utf8_lossy(&output.stdout).lines().filter_map(|line| self.row(line)).collect()
    }

    /// ROW, library, quality, scene, threads, build ms, Mrays/s of the three sets, three figures of the tree, then hits and
    /// mean t of two sets and hits of the third; last, of each set, how many hits or misses are wrong, and how many t of
    /// the first two.
    fn row(&self, line: &str) -> Option<(String, Figures)> {
        let cells: Vec<&str> = line.split('\t').collect();
        let is_ours =
            cells.len() == 22 && cells[0] == "ROW" && cells[4] == "1" && QUALITIES.contains(&cells[2]);
        if !is_ours {
            return None;
        }
        let number = |i: usize| cells[i].parse::<f64>().expect("a number");
        let wrong = [number(17) + number(18), number(19) + number(20), number(21)];
        let figures = Figures {
            build_ms: number(5),
            mrays_per_s: [number(6), number(7), number(8)],
            wrong: std::array::from_fn(|kind| wrong[kind] / self.ray_counts[kind] as f64),
        };
        Some((format!("Embree {}", cells[2].to_lowercase()), figures))
    }
}
