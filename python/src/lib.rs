//! The Python package `rsrs`: the judge, the simulator and the steps of the method.
//!
//! The steps are those of `rsrs_pipeline`, which the commands use as well: what is here is arguments,
//! arrays and waiting.

#![expect(
    clippy::needless_pass_by_value,
    clippy::too_many_arguments,
    reason = "functions that Python calls take what it gives"
)]

mod answers;
mod arrays;
mod bag;
mod choice;
mod comparison;
mod conditions;
mod episode;
mod error;
mod exploration;
mod folder;
mod json;
mod judge;
mod keys;
mod measurement;
mod picture;
mod profile;
mod runs;
mod sweep;
mod table;
mod trajectory;
mod verdict;
mod waiting;
mod worlds;

use pyo3::prelude::*;

/// The compiled part of the package; use `rsrs`.
#[pymodule]
mod _rsrs {
    use pyo3::prelude::*;
    use rsrs_core::program;

    #[pymodule_export]
    use crate::answers::{Answers, Diagnosis, answer_all, diagnose_all};
    #[pymodule_export]
    use crate::bag::Bag;
    #[pymodule_export]
    use crate::choice::Choice;
    #[pymodule_export]
    use crate::comparison::{Comparison, compare_runs, report};
    #[pymodule_export]
    use crate::conditions::PyConditions;
    #[pymodule_export]
    use crate::episode::episode;
    #[pymodule_export]
    use crate::error::RsrsError;
    #[pymodule_export]
    use crate::exploration::{Explored, explore_all};
    #[pymodule_export]
    use crate::judge::judge;
    #[pymodule_export]
    use crate::measurement::{Fit, Validation, fit, validate_sweep};
    #[pymodule_export]
    use crate::picture::Picture;
    #[pymodule_export]
    use crate::profile::Profile;
    #[pymodule_export]
    use crate::sweep::{Sweep, SweepResult};
    #[pymodule_export]
    use crate::table::Table;
    #[pymodule_export]
    use crate::trajectory::PyTrajectory;
    #[pymodule_export]
    use crate::verdict::{PyOrderParameters, Verdict};
    #[pymodule_export]
    use crate::worlds::PyWorlds;

    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        program::set_commit(env!("RSRS_COMMIT"));
        module.add("__version__", program::VERSION)
    }
}
