//! Bags of runs on the command line, and whose labels of them count.

use std::fmt;
use std::path::PathBuf;
use std::str::FromStr;

use rsrs_core::comparison::MARGIN;

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
    /// Count runs that went on without a robot that was lost, too (default: they are listed, and do
    /// not count).
    #[arg(long)]
    pub with_lost_robots: bool,
    /// By how much real robots may mill less often than simulated ones and still support the claim;
    /// choose it before the first run (default: 0.1).
    #[arg(long, value_name = "SHARE", default_value_t = MARGIN, hide_default_value = true,
          value_parser = margin)]
    pub margin: f64,
}

/// Reads a margin.
fn margin(text: &str) -> Result<f64, String> {
    let margin: f64 = text.parse().map_err(|error| format!("`{text}` is not a number: {error}"))?;
    if (0.0..=0.5).contains(&margin) {
        Ok(margin)
    } else {
        Err(format!(
            "found {margin}, expected a share from 0 to 0.5, such as 0.1 for 10 percentage points"
        ))
    }
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
