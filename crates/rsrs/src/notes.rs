//! Notes on standard error, for whoever watches.

use std::io::Write;

/// Says on standard error what a person may want to know while it runs.
pub fn print_note(note: &str) {
    // Nobody is left to tell when standard error is gone.
    drop(writeln!(std::io::stderr(), "{note}"));
}
