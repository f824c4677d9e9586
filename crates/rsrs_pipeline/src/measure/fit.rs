//! From files of trials to a profile.

use std::path::Path;

use anyhow::Context;
use rsrs_core::trials::fit::{Fit, SensorMap, Unmeasured, fit};
use rsrs_view::distribution::{self, DistributionPicture};
use rsrs_view::sensor::{self, SensorPicture};

use super::sources::{Paths, Sources};
use crate::error::helped;
use crate::files::write_file;
use crate::picture::PNG_WIDTH_PX;

/// Fits a profile.
///
/// # Returns
///
/// The fit, and notes on what it left out.
///
/// # Errors
///
/// If a file is wrong, with its line, or holds too little.
pub fn fit_files(paths: &Paths, unmeasured: &Unmeasured) -> anyhow::Result<(Fit, Vec<String>)> {
    let sources = Sources::read(paths)?;
    let fitted = fit(sources.tables(), unmeasured).map_err(helped)?;
    Ok((fitted, sources.notes()))
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
pub fn draw(folder: &Path, fitted: &Fit, name: &str, radius_m: f64) -> anyhow::Result<()> {
    std::fs::create_dir_all(folder).with_context(|| format!("cannot make {}", folder.display()))?;
    let map: &SensorMap = &fitted.details.sensor;
    let speeds = distribution::svg(&DistributionPicture {
        speeds: &fitted.speed,
        title: format!("Speeds of {name}"),
        subtitle: format!(
            "{} trials of {} robots",
            fitted.details.speed.n_trials, fitted.details.speed.n_robots
        ),
    })?;
    let seen = sensor::svg(&SensorPicture {
        map,
        simulated_m: &map.polygon_m,
        radius_m,
        title: format!("Sensor of {name}"),
        subtitle: format!(
            "{} places; detects {:.2} in the polygon, {:.3} without a neighbour",
            map.nodes.len(),
            map.true_positive.value,
            map.false_positive.value
        ),
    })?;
    for (picture, svg) in [("speeds", speeds), ("sensor", seen)] {
        write_file(&folder.join(format!("{picture}.svg")), svg.as_bytes())?;
        let png = rsrs_view::raster::png(&svg, PNG_WIDTH_PX)?;
        write_file(&folder.join(format!("{picture}.png")), &png)?;
    }
    Ok(())
}
