//! Where the robots of a search start, if not in a disc.

use std::path::Path;

use rsrs_core::conditions::Placement;
use rsrs_core::conditions::start_file::read_starts;

use crate::error::helped;
use crate::files::read_text;

/// A table of start poses, checked, and as it was read.
#[derive(Clone, Debug, PartialEq)]
pub struct StartTable {
    /// The table's text.
    pub text: String,
    /// Replicate k of a search takes set k, and after the last one the first again.
    pub placement: Placement,
}

impl StartTable {
    /// Reads a table, which must have headings.
    pub fn read(path: &Path) -> anyhow::Result<Self> {
        let text = read_text(path)?;
        let starts = read_starts(&path.display().to_string(), &text, None).map_err(helped)?;
        Ok(Self { text, placement: Placement::Given { starts: starts.starts } })
    }
}
