//! The controller's table that an experiment names, or the sweep that its cell is from.

use std::path::Path;

use rsrs_core::conditions::controller_table::{ControllerSource, ControllerTable};
use rsrs_core::help::Helpful;
use rsrs_core::robot::profile::RobotProfile;
use rsrs_fleet::experiment::ExperimentFile;

use super::read_named;
use super::swept::SweptCell;

/// Puts the table in the place of its path; where the experiment names none, that of the sweep, if
/// it needs one. The text of a file that was read goes into the bag.
pub fn read(
    experiment: &mut ExperimentFile,
    swept: Option<&SweptCell>,
    (experiment_file, robot): (&Path, &RobotProfile),
) -> anyhow::Result<Option<String>> {
    if let Some(swept) = swept {
        if experiment.controller.is_some() {
            let twice = "the experiment names a `controller`, and its cell is from a sweep, which has \
                         its own";
            let help = "leave `controller` out, or give the cell without the sweep";
            return Err(Helpful::new(twice, help).into());
        }
        experiment.controller = swept.table.clone().map(ControllerSource::Read);
        return Ok(None);
    }
    let Some(ControllerSource::File(path)) = &experiment.controller else { return Ok(None) };
    let beside = experiment_file.parent().unwrap_or(Path::new(""));
    let file = experiment_file.display().to_string();
    let (name, text) = read_named("controller", &beside.join(path), &file)?;
    let table = ControllerTable::parse(&name, &text, robot).map_err(Helpful::from)?;
    experiment.controller = Some(ControllerSource::Read(table));
    Ok(Some(text))
}
