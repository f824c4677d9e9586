//! Notes on standard error.

use std::io::Write;

use crate::output::{Detail, detail};
use rsrs_render::words::Words;

/// Prints a note on standard error; a quiet program leaves it out.
pub fn print_note(note: impl Into<Words>) {
    if detail() > Detail::Needed {
        print_always(note);
    }
}

/// Prints on standard error what a person must not miss: a warning, a question, an error.
pub fn print_always(words: impl Into<Words>) {
    print_painted(&words.into().painted());
}

/// Prints on standard error a text that has its colours already.
pub fn print_painted(text: &str) {
    // What was logged before comes before it.
    rsrs_ros::logging::flush();
    // Without standard error there is no way to report it.
    drop(writeln!(anstream::stderr(), "{text}"));
}
