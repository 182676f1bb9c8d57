//! Fuzzes the readers and the bake by mutation, the same way for the same seed, without a special compiler.
//!
//!     cargo run --release -p planish-tests --bin fuzz -- TARGET|all SECONDS [SEED]
//!     cargo run -p planish-tests --bin fuzz -- corpus DIR
//!
//! The first prints how many inputs were run, and writes each that panics, hangs or takes too much memory to `fuzz-findings/`. The
//! second writes the corpus of each target to a folder of its own, for other fuzzers.

#![expect(clippy::print_stdout, clippy::print_stderr, reason = "the program reports on the terminal")]

use peak_alloc::PeakAlloc;
use planish_tests::fuzz::{Mutator, TARGETS, Target, corpus};
use std::path::Path;
use std::process::ExitCode;
use std::time::{Duration, Instant};

#[global_allocator]
static MEMORY: PeakAlloc = PeakAlloc;

/// Time after which an input counts as a hang.
const LONGEST: Duration = Duration::from_secs(10);

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
    match words.as_slice() {
        ["corpus", folder] => {
            for target in &TARGETS {
                let folder = Path::new(folder).join(target.name);
                std::fs::create_dir_all(&folder).expect("the folder can be made");
                for (number, data) in corpus(target.name).iter().enumerate() {
                    std::fs::write(folder.join(format!("{number:02}")), data).expect("the file can be written");
                }
            }
            ExitCode::SUCCESS
        }
        [name, seconds, seed @ ..] => {
            let seconds = Duration::from_secs_f64(seconds.parse().expect("SECONDS is a number"));
            let seed = seed.first().map_or(1, |seed| seed.parse().expect("SEED is a number"));
            let chosen: Vec<&Target> = TARGETS.iter().filter(|target| [target.name, "all"].contains(name)).collect();
            assert!(!chosen.is_empty(), "there is no target {name}");
            // A panic is counted, and its message is all that is wanted of it.
            let findings: usize = chosen.into_iter().map(|target| run(target, seconds, seed)).sum();
            ExitCode::from(u8::from(findings > 0))
        }
        _ => {
            let names: Vec<&str> = TARGETS.iter().map(|target| target.name).collect();
            eprintln!("Usage: fuzz TARGET SECONDS [SEED] | fuzz corpus DIR; targets: all {}", names.join(" "));
            ExitCode::from(2)
        }
    }
}

/// Runs a target for a time and returns the number of findings.
fn run(target: &Target, time: Duration, seed: u64) -> usize {
    let (corpus, start) = (corpus(target.name), Instant::now());
    let mut mutator = Mutator::new(seed);
    let (mut runs, mut findings, mut longest, mut largest) = (0u64, 0, Duration::ZERO, 0);
    while start.elapsed() < time {
        let data = mutator.mutated(&corpus);
        MEMORY.reset_peak_usage();
        let before = MEMORY.current_usage();
        let begun = Instant::now();
        let outcome = std::panic::catch_unwind(|| (target.run)(&data));
        let (took, peak) = (begun.elapsed(), MEMORY.peak_usage().saturating_sub(before));
        runs += 1;
        (longest, largest) = (longest.max(took), largest.max(peak));
        if outcome.is_err() || took > LONGEST || peak > target.base + target.factor * data.len() {
            let path = Path::new("fuzz-findings").join(format!("{}-{seed}-{runs}", target.name));
            let written = std::fs::create_dir_all("fuzz-findings").and_then(|()| std::fs::write(&path, &data));
            written.expect("a finding can be written");
            println!("{}: {took:?}, {peak} bytes: {}", target.name, path.display());
            findings += 1;
        }
    }
    let seconds = start.elapsed().as_secs();
    println!(
        "{:9} {seconds:5} s {runs:9} runs {findings:3} findings, longest {longest:.3?}, most memory {} MB",
        target.name,
        largest >> 20
    );
    findings
}
