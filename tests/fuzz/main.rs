//! A short run of each target of fuzzing. `cargo run -p planish-tests --bin fuzz` runs longer ones.

use peak_alloc::PeakAlloc;
use planish_tests::fuzz::{Mutator, TARGETS, Target, corpus};

#[global_allocator]
static MEMORY: PeakAlloc = PeakAlloc;

/// Number of mutated inputs of each target.
const RUNS: usize = 3000;

/// Runs a target on its corpus and on mutations of it, and fails with the input that was too much.
fn run(target: &Target) {
    let corpus = corpus(target.name);
    assert!(!corpus.is_empty(), "{} has no corpus", target.name);
    let mut mutator = Mutator::new(7);
    let mutated: Vec<Vec<u8>> = (0..RUNS).map(|_| mutator.mutated(&corpus)).collect();
    for data in corpus.iter().chain(&mutated) {
        MEMORY.reset_peak_usage();
        let before = MEMORY.current_usage();
        let outcome = std::panic::catch_unwind(|| (target.run)(data));
        let peak = MEMORY.peak_usage().saturating_sub(before);
        let shown = || data.escape_ascii().to_string();
        assert!(outcome.is_ok(), "{} panics on b\"{}\"", target.name, shown());
        let allowed = target.base + target.factor * data.len();
        assert!(peak <= allowed, "{} takes {peak} bytes for b\"{}\"", target.name, shown());
    }
}

/// One test for all: they share one count of memory.
#[test]
fn mutated_inputs_neither_panic_nor_take_memory_that_their_size_does_not_justify() {
    TARGETS.iter().for_each(run);
}

#[test]
fn the_same_seed_makes_the_same_inputs() {
    let corpus = corpus("obj");
    let made = |seed| {
        let mut mutator = Mutator::new(seed);
        (0..20).map(|_| mutator.mutated(&corpus)).collect::<Vec<_>>()
    };
    assert_eq!(made(1), made(1));
    assert_ne!(made(1), made(2));
    assert!(corpus.iter().any(|data| std::str::from_utf8(data).unwrap().starts_with("v ")));
}
