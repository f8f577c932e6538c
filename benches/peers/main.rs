//! This program's trees beside other libraries' on the same triangles, the same rays and this machine: one thread, one
//! ray at a time. `benches/README.md` tells how to run it and how to read it.
//!
//! Every round builds and traces with each library once, in another order, so that a machine that slows down meanwhile
//! slows all of them down. What is printed are medians over the rounds.

mod contenders;
mod embree;
mod inputs;
mod report;

use std::path::PathBuf;
use std::time::Instant;

use bvhscope::export::ray_file;

use contenders::{Contender, Walker};
use inputs::Input;
use report::{Figures, Measured};

const BUILTIN_SCENES: [&str; 3] = ["bunny", "teapot", "soup:200000"];
const DEFAULT_ROUNDS: usize = 5;

fn main() {
    // `cargo test --all-targets` starts it, too, without this flag.
    if !std::env::args().any(|arg| arg == "--bench") {
        println!("nothing measured: run `cargo bench --bench peers`");
        return;
    }
    let work = std::env::var_os("PEERS_WORK").map(PathBuf::from);
    let rounds = match std::env::var("PEERS_ROUNDS") {
        Ok(text) => text.parse().expect("PEERS_ROUNDS is a number of rounds"),
        Err(_) => DEFAULT_ROUNDS,
    };
    let embree = work.as_ref().map(|work| work.join("embree")).filter(|binary| binary.is_file());
    let wanted: Vec<String> = std::env::args().skip(1).filter(|arg| !arg.starts_with('-')).collect();
    let is_wanted = |name: &str| wanted.is_empty() || wanted.iter().any(|w| name == w);

    let mut all = Vec::new();
    let builtin = BUILTIN_SCENES
        .into_iter()
        .map(str::to_owned)
        .filter(|name| is_wanted(name))
        .map(|name| Input::builtin(&name));
    let files = work.iter().flat_map(|work| {
        let names = inputs::names(work).into_iter().filter(|name| is_wanted(name));
        names.map(move |name| Input::from_files(work, &name))
    });
    for input in builtin.chain(files) {
        let measured = measure(&input, rounds, embree.as_ref());
        println!("{}", report::scene_table(&input, rounds, &measured));
        all.push(measured);
    }
    if all.len() > 1 {
        println!("{}", report::mean_table(&all));
    }
}

fn measure(input: &Input, rounds: usize, embree: Option<&PathBuf>) -> Vec<Measured> {
    let contenders = contenders::all();
    let expected = answers(contenders::reference().build(input).walker.as_ref(), input);
    let embree = embree.map(|binary| embree::Embree::prepare(binary, input, &expected));
    let mut measured: Vec<Measured> = contenders.iter().map(|c| Measured::new(c.name())).collect();
    for round in 0..rounds {
        for turn in 0..contenders.len() {
            let i = (turn + round) % contenders.len();
            measured[i].rounds.push(run(&contenders[i], input, &expected));
            eprint!(
                "\r{}: round {} of {rounds}, {} of {}   ",
                input.name,
                round + 1,
                turn + 1,
                contenders.len()
            );
        }
        for (name, figures) in embree.iter().flat_map(embree::Embree::run) {
            match measured.iter_mut().find(|m| m.name == name) {
                Some(row) => row.rounds.push(figures),
                None => measured.push(Measured { rounds: vec![figures], ..Measured::new(&name) }),
            }
        }
    }
    eprintln!();
    measured
}

/// One build, and every set of rays once.
fn run(contender: &Contender, input: &Input, expected: &[Vec<f32>; 3]) -> Figures {
    let built = contender.build(input);
    let mut figures = Figures { build_ms: built.build_ms, ..Figures::default() };
    for (kind, set) in input.sets.iter().enumerate() {
        // Written to before the clock starts, so that no memory is fetched meanwhile; and no answer by itself.
        let mut answers = vec![f32::NAN; set.rays.len()];
        let start = Instant::now();
        built.walker.trace(set, &mut answers);
        let count = set.rays.len() as f64;
        figures.mrays_per_s[kind] = count / start.elapsed().as_secs_f64() * 1e-6;
        figures.wrong[kind] = ray_file::mismatches(&answers, &expected[kind]) as f64 / count;
    }
    figures
}

fn answers(walker: &dyn Walker, input: &Input) -> [Vec<f32>; 3] {
    input.sets.each_ref().map(|set| {
        let mut answers = vec![0.0; set.rays.len()];
        walker.trace(set, &mut answers);
        answers
    })
}
