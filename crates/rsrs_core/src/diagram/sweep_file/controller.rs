//! Whether the axes of a sweep are those of its controller.

use super::{SweepFile, SweepFileError};
use crate::conditions::check_axis;
use crate::conditions::controller_table::ControllerSource;

impl SweepFile {
    /// Whether the axes are those of the controller, once its table has been read.
    ///
    /// # Errors
    ///
    /// [`SweepFileError::Controller`] or [`SweepFileError::NotOfController`].
    pub fn check_controller(&self, file: &str) -> Result<(), SweepFileError> {
        if let Some(ControllerSource::File(_)) = self.controller {
            return Ok(());
        }
        let table = self.table();
        if let Some(table) = table {
            let refuse = |source| SweepFileError::Controller { file: file.to_owned(), source };
            table.check().map_err(refuse)?;
        }
        let fixed = self.fixed.values.iter().map(|(axis, _)| *axis);
        self.swept_axes().into_iter().chain(fixed).try_for_each(|axis| {
            let refuse = |source| SweepFileError::NotOfController { file: file.to_owned(), source };
            check_axis(axis, table).map_err(refuse)
        })
    }
}
