//! The page that simulates.

use std::path::Path;

use super::browse;
use crate::command::{code, repository, rsrs, stderr, text_in};

#[test]
fn the_page_passes_through_the_states_of_the_program_and_its_sweep_file_gives_the_same_counts() {
    let place = tempfile::tempdir().expect("a temporary folder");
    let here = place.path();
    let screenshots = Path::new(env!("CARGO_TARGET_TMPDIR")).join("simulator");
    let page = repository().join("docs/simulator.html");

    let found = browse("simulator.py", &page, &[&screenshots, here]);

    assert!(found.ends_with("all is well\n"), "{found}");
    assert_eq!(found.matches("state as in the program").count(), 3, "{found}");
    let swept = rsrs(here, &["sweep", "copied.yaml", "-o", "out"]);
    assert_eq!(code(&swept), 0, "{}", stderr(&swept));
    let cells = text_in(here, "out/cells.csv");
    let counted = text_in(here, "counts.csv");
    assert_eq!(counted.lines().count(), 88);
    for (cell, counted) in cells.lines().skip(1).zip(counted.lines()) {
        assert!(cell.starts_with(&format!("{counted},")), "{cell}: {counted}");
    }
}
