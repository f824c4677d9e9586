//! Notes on standard error.

use std::io::Write;

/// Prints a note on standard error.
pub fn print_note(note: &str) {
    // Without standard error there is no way to report it.
    drop(writeln!(std::io::stderr(), "{note}"));
}
