//! Whether the axes of a sweep are those of its controller.

use super::{SweepFile, SweepFileError};
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
        if let Some(ControllerSource::File(_)) = self.controller {
            return Ok(());
        }
        let table = self.table();
        if let Some(table) = table {
            let refuse = |source| SweepFileError::Controller { file: file.to_owned(), source };
            let check = table.check();
            let rows = |robot: &RobotProfile| table.check_rows(&robot.reading_names());
            check.and_then(|()| robot.map_or(Ok(()), rows)).map_err(refuse)?;
        }
        let fixed = self.fixed.values.iter().map(|(axis, _)| *axis);
        self.swept_axes().into_iter().chain(fixed).try_for_each(|axis| {
            let refuse = |source| SweepFileError::NotOfController { file: file.to_owned(), source };
            check_axis(axis, table).map_err(refuse)
        })
    }
}
