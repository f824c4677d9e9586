//! Bags: recorded runs.

use std::path::{Path, PathBuf};

use pyo3::prelude::*;
use rsrs_pipeline::label::{CutRun, LabelOptions, read_run};
use rsrs_pipeline::recorded_run;

use crate::error::{named, raised};
use crate::json::to_python;
use crate::trajectory::PyTrajectory;
use crate::waiting::work_to_end;

/// A recorded run: a rosbag2 folder or a single .mcap file.
#[pyclass(name = "Bag", module = "rsrs", frozen)]
pub struct Bag {
    path: PathBuf,
}

#[pymethods]
impl Bag {
    #[new]
    fn new(py: Python<'_>, path: PathBuf) -> PyResult<Self> {
        let opened = py.detach(|| recorded_run::open(&path).map(drop));
        opened.map_err(raised)?;
        Ok(Self { path })
    }
    /// Where it is.
    #[getter]
    fn path(&self) -> &Path {
        &self.path
    }
    /// What is in it, under the names of `rsrs bag info --format json`: topics, times, damage.
    fn info<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let info = py.detach(|| recorded_run::open(&self.path).map(|bag| bag.info()));
        to_python(py, &info.map_err(raised)?)
    }
    /// The record of its experiment: conditions, seed, robots; None in a bag of somebody else.
    #[getter]
    fn record<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyAny>>> {
        let record = py.detach(|| recorded_run::record_in(&recorded_run::open(&self.path)?));
        record.map_err(raised)?.map(|record| to_python(py, &record)).transpose()
    }
    /// What the robots did while the run was running, as the judge takes it.
    fn trajectory(&self, py: Python<'_>) -> PyResult<PyTrajectory> {
        let path = self.path.clone();
        let options = LabelOptions { cut: CutRun::Judged, ..LabelOptions::default() };
        let run = work_to_end(py, move || read_run(&path, options))?;
        let known = (run.bodies, run.behaviour);
        PyTrajectory::new(py, &run.recorded.trajectory, None, run.recorded.robots, known)
    }
    fn __fspath__(&self) -> String {
        named(&self.path)
    }
    fn __repr__(&self) -> String {
        format!("Bag({})", named(&self.path))
    }
}
