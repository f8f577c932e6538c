//! Medians of the rounds, and their tables in Markdown, with ratios to the first row.

use std::fmt::Write;

use super::inputs::Input;

/// Of one round.
#[derive(Clone, Copy, Debug, Default)]
pub struct Figures {
    pub build_ms: f64,
    /// Of primary, diffuse and shadow rays.
    pub mrays_per_s: [f64; 3],
    /// The share of the rays whose answer is not that of the first row.
    pub wrong: [f64; 3],
}

/// What the rounds gave for one library with one kind of tree.
#[derive(Clone, Debug)]
pub struct Measured {
    pub name: String,
    pub rounds: Vec<Figures>,
}

impl Measured {
    pub fn new(name: &str) -> Self {
        Self { name: name.to_owned(), rounds: Vec::new() }
    }

    /// Build time in ms, then the speeds.
    fn medians(&self) -> [f64; 4] {
        let median = |figure: &dyn Fn(&Figures) -> f64| {
            let mut all: Vec<f64> = self.rounds.iter().map(figure).collect();
            all.sort_by(f64::total_cmp);
            all[all.len() / 2]
        };
        std::array::from_fn(|i| match i {
            0 => median(&|f| f.build_ms),
            _ => median(&|f| f.mrays_per_s[i - 1]),
        })
    }

    fn ratios(&self, first: &Self) -> [f64; 4] {
        let (own, first) = (self.medians(), first.medians());
        std::array::from_fn(|i| own[i] / first[i])
    }
}

/// A scene: figures, and in brackets how many times those of the first row.
pub fn scene_table(input: &Input, rounds: usize, measured: &[Measured]) -> String {
    let counts = input.sets.each_ref().map(|set| set.rays.len());
    let mut text = format!(
        "### {}: {} triangles; {} primary, {} diffuse, {} shadow rays; medians of {rounds} rounds\n\n",
        input.name,
        input.triangles.len(),
        counts[0],
        counts[1],
        counts[2],
    );
    let heading = ["build ms", "primary Mrays/s", "diffuse Mrays/s", "shadow Mrays/s", "other answers, %"];
    push_row(&mut text, "", &heading.map(str::to_owned));
    push_rule(&mut text, heading.len());
    for row in measured {
        let (medians, ratios) = (row.medians(), row.ratios(&measured[0]));
        let mut cells: Vec<String> =
            (0..4).map(|i| format!("{:.2} ({:.2})", medians[i], ratios[i])).collect();
        let wrong = row.rounds.last().map_or([0.0; 3], |figures| figures.wrong);
        cells.push(wrong.map(|share| format!("{:.4}", share * 100.0)).join(" / "));
        push_row(&mut text, &row.name, &cells);
    }
    text
}

/// The geometric means of the ratios over all scenes.
pub fn mean_table(scenes: &[Vec<Measured>]) -> String {
    let mut text =
        format!("### Geometric means over {} scenes, as multiples of the first row\n\n", scenes.len());
    push_row(&mut text, "", &["build time", "primary", "diffuse", "shadow"].map(str::to_owned));
    push_rule(&mut text, 4);
    for (i, row) in scenes[0].iter().enumerate() {
        let mut logs = [0.0; 4];
        for scene in scenes {
            for (log, ratio) in logs.iter_mut().zip(scene[i].ratios(&scene[0])) {
                *log += ratio.ln() / scenes.len() as f64;
            }
        }
        push_row(&mut text, &row.name, &logs.map(|log| format!("{:.2}", log.exp())));
    }
    text
}

fn push_row(text: &mut String, name: &str, cells: &[String]) {
    let cells: String = cells.iter().fold(String::new(), |mut row, cell| {
        let _ = write!(row, " {cell:>22} |");
        row
    });
    let _ = writeln!(text, "| {name:<24} |{cells}");
}

fn push_rule(text: &mut String, columns: usize) {
    let _ = writeln!(text, "|{:-<26}|{}", "", format!("{:->24}|", ":").repeat(columns));
}
