//! Whether the axes of a sweep are those of its controller.

use super::{SweepFile, SweepFileError, SweepProblem, in_file};
use crate::conditions::check_axis;
use crate::conditions::controller_table::ControllerSource;
use crate::robot::profile::RobotProfile;

impl SweepFile {
    /// Whether the axes are those of the controller, once its table has been read, and its rows are for what these
    /// robots report, if they are known.
    pub fn check_controller(
        &self,
        file: &str,
        robot: Option<&RobotProfile>,
    ) -> Result<(), SweepFileError> {
        self.check_axes(robot).map_err(in_file(file))
    }

    pub(super) fn check_axes(&self, robot: Option<&RobotProfile>) -> Result<(), SweepProblem> {
        if let Some(ControllerSource::File(_)) = self.controller {
            return Ok(());
        }
        let table = self.table();
        if let Some(table) = table {
            table.check()?;
            robot.map_or(Ok(()), |robot| table.check_rows(&robot.reading_names()))?;
        }
        let fixed = self.fixed.values.iter().map(|(axis, _)| *axis);
        let mut axes = self.swept_axes().into_iter().chain(fixed);
        Ok(axes.try_for_each(|axis| check_axis(axis, table))?)
    }
}
