//! From files of trials to a fit, which makes the profile.

use rsrs_core::robot::profile::TrialOrigin;
use rsrs_core::trials::fit::{Fit, Unmeasured, fit};
use rsrs_core::trials::trial::{SpeedTrial, Trials};

use super::sources::{Paths, Sources};
use crate::error::{helped, with_help};

/// Whether trials of the simulator and of robots may make one profile.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mixture {
    /// They may not.
    Refused,
    /// They may.
    Allowed,
}

/// A fit of files.
#[derive(Clone, Debug)]
pub struct FittedFiles {
    /// The fit.
    pub fit: Fit,
    /// The straight runs behind it.
    pub speed: Trials<SpeedTrial>,
    /// What it left out.
    pub notes: Vec<String>,
}

/// Fits a profile. Trials of the simulator among those of robots are refused, unless `mixture`
/// allows them.
pub fn fit_files(
    paths: &Paths,
    unmeasured: &Unmeasured,
    mixture: Mixture,
) -> anyhow::Result<FittedFiles> {
    let sources = Sources::read(paths)?;
    let moved_by = sources.tables().moved_by;
    if mixture == Mixture::Refused && moved_by.origin() == Some(TrialOrigin::PartlySimulated) {
        return Err(with_help(
            format!(
                "{} of {} trials are of the simulator, the others of robots or made by hand",
                moved_by.simulator,
                moved_by.simulator + moved_by.fleet + moved_by.unknown
            ),
            "a profile of both describes neither; delete the rows with `sim` under `backend`, and \
             their bags, or give `--mixed` to fit them together all the same",
        ));
    }
    let fitted = fit(sources.tables(), unmeasured).map_err(helped)?;
    let notes = sources.notes();
    let speed = sources.tables().speed.clone();
    Ok(FittedFiles { fit: fitted, speed, notes })
}
