//! The folder of a plan: a sheet for people, and the tables to fill in.

use std::path::Path;

use rsrs_core::trials::plan::Plan;
use rsrs_core::trials::trial::TrialKind;
use rsrs_fleet::fleet_file::FleetFile;

use crate::error::{helped, with_help};
use crate::files::{make_folder, read_text, write_file};

/// Names of the robots of a fleet file that may be used.
pub fn enabled_robots(fleet: &Path) -> anyhow::Result<Vec<String>> {
    let name = fleet.display().to_string();
    let fleet = FleetFile::parse(&name, &read_text(fleet)?).map_err(helped)?;
    Ok(fleet.enabled().into_iter().map(str::to_owned).collect())
}

/// Makes the folder of a plan, which must not exist, with its sheet and its tables.
pub fn write(folder: &Path, plan: &Plan) -> anyhow::Result<()> {
    if folder.exists() {
        return Err(with_help(
            format!("{} exists", folder.display()),
            "give another folder with `-o`: tables that are filled in are not overwritten",
        ));
    }
    make_folder(folder)?;
    for (name, text) in [
        ("sheet.txt", plan.text()),
        (TrialKind::Speed.file(), plan.speed_csv()),
        (TrialKind::Turn.file(), plan.turn_csv()),
        (TrialKind::Arc.file(), plan.arc_csv()),
        (TrialKind::Detection.file(), plan.detection_csv()),
        (TrialKind::Period.file(), plan.period_csv()),
    ] {
        write_file(&folder.join(name), text.as_bytes())?;
    }
    Ok(())
}
