//! Fuzzing on stable Rust, without an instrumented build.
//!
//! A harness mutates the inputs of its corpus and gives them to the code under test, which says in a few
//! words what came of each. An input with an outcome that none had before joins the corpus for the rest of
//! the run, so that inputs get past one check after the other.
//!
//! `RSRS_FUZZ_S` sets for how many seconds each harness runs, and `RSRS_SEED` which mutations it draws. An
//! input is in a file of the temporary folder while it is run, so that it is there after a hang or an abort,
//! too. Copied into the corpus, it is run first.

mod mutation;

use std::collections::BTreeSet;
use std::fs::{self, File};
use std::io::Write;
use std::os::unix::fs::FileExt;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::time::{Duration, Instant};

use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};

use crate::environment::number;

pub use mutation::{base64, behind, bytes, cdr, text};

/// No input may take so long, on a machine that is busy with other tests.
const TOO_LONG: Duration = Duration::from_secs(20);

/// On a machine that is busy, so many inputs may take longer than the time.
const MIN_INPUTS: u64 = 200;

/// The corpus grows to so many inputs, none of which is longer than this.
const MAX_INPUTS: usize = 4_000;
const MAX_BYTES: usize = 64 << 10;

/// Changes an input, and may take a piece of another one.
pub type Mutation<'a> = &'a dyn Fn(&mut Vec<u8>, &[u8], &mut ChaCha8Rng);

/// What is run with which inputs.
pub struct Harness<'a> {
    /// The folder of the corpus, if there is one; its last part is the name of the harness.
    pub corpus: &'a str,
    /// Inputs that our own code makes, as a beginning.
    pub seeds: Vec<Vec<u8>>,
    /// What makes new inputs.
    pub mutation: Mutation<'a>,
}

impl Harness<'_> {
    /// Runs the corpus, and then mutations of it until the time is over, and counts the different
    /// outcomes.
    ///
    /// `execute` runs an input, and says what came of it; numbers and what is in quotes do not
    /// count.
    pub fn run(&self, mut execute: impl FnMut(&[u8]) -> String) -> usize {
        let name = Path::new(self.corpus).file_name().expect("a harness has a name").display();
        let path = std::env::temp_dir().join(format!("rsrs_fuzz_{name}_{}", std::process::id()));
        let file = File::create(&path).expect("temporary files can be made");
        let mut outcome_of = |input: &[u8]| {
            file.set_len(0).and_then(|()| file.write_all_at(input, 0)).expect("there is room");
            let start = has_run();
            let problem = match catch_unwind(AssertUnwindSafe(|| execute(input))) {
                Ok(outcome) if has_run().saturating_sub(start) < TOO_LONG => {
                    return essence(&outcome);
                }
                Ok(_) => "takes too long",
                Err(_) => "panics, see above",
            };
            panic!("{} {problem}; copy it into {} to run it again", path.display(), self.corpus);
        };
        let mut corpus = files_in(Path::new(self.corpus));
        corpus.extend(self.seeds.iter().cloned());
        let mut outcomes: BTreeSet<String> = corpus.iter().map(|input| outcome_of(input)).collect();
        let end = Instant::now() + duration();
        let mut draw = ChaCha8Rng::seed_from_u64(number("RSRS_SEED").unwrap_or(0));
        let mut n_inputs = 0;
        while n_inputs < MIN_INPUTS || Instant::now() < end {
            n_inputs += 1;
            let mut input = corpus[draw.random_range(0..corpus.len())].clone();
            for _ in 0..draw.random_range(1..5) {
                let other = &corpus[draw.random_range(0..corpus.len())];
                (self.mutation)(&mut input, other, &mut draw);
            }
            let is_new = outcomes.insert(outcome_of(&input));
            if is_new && corpus.len() < MAX_INPUTS && input.len() < MAX_BYTES {
                corpus.push(input);
            }
        }
        fs::remove_file(&path).expect("it was just written");
        let n_outcomes = outcomes.len();
        let tally = format!("{name}: {n_inputs} inputs, {n_outcomes} outcomes");
        writeln!(std::io::stdout(), "{tally}").expect("somebody reads");
        n_outcomes
    }
}

/// For how long a harness runs: 2 s, if `RSRS_FUZZ_S` does not say otherwise.
pub fn duration() -> Duration {
    Duration::from_secs(number("RSRS_FUZZ_S").unwrap_or(2))
}

/// For how long this thread has had a processor: a machine that stands still makes no input slow.
fn has_run() -> Duration {
    let text = fs::read_to_string("/proc/thread-self/schedstat").expect("the kernel counts it");
    let ns = text.split(' ').next().and_then(|ns| ns.parse().ok());
    Duration::from_nanos(ns.expect("it begins with a number"))
}

fn files_in(folder: &Path) -> Vec<Vec<u8>> {
    let Ok(entries) = folder.read_dir() else { return Vec::new() };
    let mut paths: Vec<_> = entries.map(|entry| entry.expect("it can be listed").path()).collect();
    paths.sort();
    paths.iter().map(|path| fs::read(path).expect("it can be read")).collect()
}

/// An outcome without its numbers and without what is in quotes.
fn essence(outcome: &str) -> String {
    let unquoted = outcome.split(['`', '"']).step_by(2).flat_map(str::chars);
    unquoted.filter(|character| !character.is_ascii_digit()).take(500).collect()
}
