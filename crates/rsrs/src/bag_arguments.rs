//! How bags of runs are held against a sweep, from the command line.

use std::path::PathBuf;

use rsrs_core::robot::pose_source::PoseSource;

use crate::numbers::number;
use crate::profile_arguments::ProfileArguments;
use rsrs_pipeline::compare;
use rsrs_pipeline::label::Labeller;

/// How runs are held against a sweep.
#[derive(Clone, clap::Args)]
pub struct BagArguments {
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
    /// Count runs whose poses cannot be those of the commanded robots, or in which a robot did not
    /// move, too (default: they are listed, and do not count).
    #[arg(long)]
    pub with_implausible: bool,
    /// By how much real robots may mill less often than simulated ones and still support the claim;
    /// choose it before the first run (default: 0.1, or what was fixed for the campaign).
    #[arg(long, value_name = "SHARE", value_parser = margin())]
    pub margin: Option<f64>,
    /// Where poses come from in all of these bags (default: what each run went by).
    #[arg(long, value_parser = crate::pose_arguments::pose_sources())]
    pub poses: Option<PoseSource>,
    #[command(flatten)]
    pub other: ProfileArguments,
}

impl BagArguments {
    /// What is compared, and how.
    pub fn options(&self, bags: &[PathBuf]) -> compare::CompareOptions {
        let Self { labels, with_lost_robots, with_implausible, margin, poses, other } =
            self.clone();
        let (bags, other_profile) = (bags.to_vec(), other.profile());
        compare::CompareOptions {
            bags,
            labels,
            with_lost_robots,
            with_implausible,
            margin,
            poses,
            other_profile,
        }
    }
}

/// Reads a margin, a share from 0 to 0.5.
pub fn margin() -> impl Fn(&str) -> Result<f64, String> + Clone {
    number("a share from 0 to 0.5, such as 0.1 for 10 percentage points", |margin| {
        (0.0..=0.5).contains(&margin)
    })
}
