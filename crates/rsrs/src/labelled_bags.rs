//! Bags of runs on the command line, and whose labels of them count.

use std::fmt;
use std::path::PathBuf;
use std::str::FromStr;

use crate::human_labels::JUDGE;

/// Which runs are held against a sweep.
#[derive(clap::Args)]
pub struct LabelledBags {
    /// Bags of runs: rosbag2 folders or single .mcap files.
    #[arg(long, required = true, num_args = 1.., value_name = "BAG")]
    pub bags: Vec<PathBuf>,
    /// Whose labels count: the judge's, or those of one person, as `human:WHO` (default: judge).
    #[arg(
        long,
        value_name = "judge|human:WHO",
        default_value = "judge",
        hide_default_value = true
    )]
    pub labels: Labeller,
}

/// Whose labels count.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Labeller {
    /// Those of the one judge.
    Judge,
    /// Those of this person.
    Human(String),
}

impl FromStr for Labeller {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text.split_once(':') {
            None if text == JUDGE => Ok(Self::Judge),
            Some(("human", who)) if !who.trim().is_empty() => {
                Ok(Self::Human(who.trim().to_owned()))
            }
            _ => Err(format!("`{text}` is neither `{JUDGE}` nor `human:` and a name")),
        }
    }
}

impl fmt::Display for Labeller {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Judge => formatter.write_str(JUDGE),
            Self::Human(who) => write!(formatter, "human:{who}"),
        }
    }
}
