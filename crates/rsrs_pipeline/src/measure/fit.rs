//! From files of trials to a profile.

use std::path::Path;

use anyhow::Context;
use rsrs_core::robot::profile::TrialOrigin;
use rsrs_core::trials::fit::{Fit, SensorMap, Unmeasured, fit};
use rsrs_core::trials::trial::SpeedTrial;
use rsrs_view::distribution::{self, DistributionPicture, DrivenSpeed};
use rsrs_view::sensor::{self, SensorPicture};

use super::sources::{Paths, Sources};
use crate::error::{helped, with_help};
use crate::picture_file::{PageStyle, write_svg_and_png};

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
    /// The straight runs behind it, for pictures.
    pub speeds: Vec<DrivenSpeed>,
    /// What it left out.
    pub notes: Vec<String>,
}

/// Fits a profile.
///
/// # Errors
///
/// If a file is wrong, with its line, or holds too little; if trials of the simulator are among those
/// of robots, and that is refused.
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
    let speed = sources.tables().speed;
    let driven = |trial: &SpeedTrial| DrivenSpeed {
        robot: speed.robots[trial.robot].clone(),
        commanded_m_s: trial.commanded_m_s,
        measured_m_s: trial.distance_m / trial.duration_s,
    };
    let speeds = speed.rows.iter().map(driven).collect();
    Ok(FittedFiles { fit: fitted, speeds, notes })
}

/// Draws the speeds of each robot, and the sensor, as SVG and PNG.
///
/// # Arguments
///
/// * `name` — of the kind of robot.
/// * `radius_m` — of its body, in metres.
///
/// # Errors
///
/// If the folder cannot be made or written.
pub fn draw(
    folder: &Path,
    files: &FittedFiles,
    name: &str,
    radius_m: f64,
    style: PageStyle,
) -> anyhow::Result<()> {
    let fitted = &files.fit;
    std::fs::create_dir_all(folder).with_context(|| format!("cannot make {}", folder.display()))?;
    let map: &SensorMap = &fitted.details.sensor;
    let origin = fitted.details.moved_by.origin();
    let whose = origin.map(|origin| format!("; trials of {}", origin.whose())).unwrap_or_default();
    let speeds = distribution::svg(&DistributionPicture {
        speeds: &fitted.speed,
        trials: &files.speeds,
        title: format!("Speeds of {name}"),
        subtitle: format!(
            "{} trials of {} robots{whose}",
            fitted.details.speed.n_trials, fitted.details.speed.n_robots
        ),
        theme: style.theme,
    })?;
    let seen = sensor::svg(&SensorPicture {
        map,
        simulated_m: &map.polygon_m,
        radius_m,
        title: format!("Sensor of {name}"),
        subtitle: format!(
            "{} places; detects {:.2} in the polygon, {:.3} without a neighbour{whose}",
            map.nodes.len(),
            map.true_positive.value,
            map.false_positive.value
        ),
        theme: style.theme,
    })?;
    write_svg_and_png(folder, "speeds", &speeds, style)?;
    write_svg_and_png(folder, "sensor", &seen, style)
}
