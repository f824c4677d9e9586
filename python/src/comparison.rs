//! Real runs beside the sweep that predicts them.

use std::path::PathBuf;

use pyo3::prelude::*;
use rsrs_core::comparison::MARGIN;
use rsrs_core::robot::other_profile::OtherProfile;
use rsrs_pipeline::compare::{CompareOptions, compare};
use rsrs_pipeline::files::write_file;
use rsrs_pipeline::label::Labeller;
use rsrs_render::comparison::{Report, text, verdict_name};
use rsrs_render::report::html;

use crate::answers::source;
use crate::error::{named, refused, refused_with_help};
use crate::json::to_python;
use crate::waiting::work_to_end;

// Python's help shows numbers in signatures, and no names of constants.
const _: () = assert!(MARGIN.to_bits() == 0.1_f64.to_bits());

/// Real runs, held against a sweep: do robots show the wanted phase at least as often as simulated ones?
#[pyclass(name = "Comparison", module = "rsrs", frozen)]
pub struct Comparison(Report);

#[pymethods]
impl Comparison {
    /// "supported", "violated", "undecided" or "no_claim".
    #[getter]
    fn verdict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        to_python(py, &self.0.verdict)
    }
    /// What it means, or rests on, in a few words.
    #[getter]
    fn summary(&self) -> &str {
        &self.0.summary
    }
    /// Cell by cell, the runs and what was simulated.
    #[getter]
    fn cells<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        to_python(py, &self.0.cells)
    }
    /// All of it, under the names of `rsrs compare --format json`.
    fn as_dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        to_python(py, &self.0)
    }
    fn __repr__(&self) -> String {
        let (n, n_left) = (self.0.bags.len(), self.0.not_counted.len());
        let verdict = verdict_name(self.0.verdict);
        format!("Comparison({verdict}: {}; {n} runs count, {n_left} do not)", self.0.summary)
    }
    fn __str__(&self) -> String {
        text(&self.0).to_string()
    }
}

/// Which runs, and how.
fn options(
    bags: Vec<PathBuf>,
    labels: &str,
    margin: Option<f64>,
    (with_lost_robots, with_implausible, other_profile): (bool, bool, bool),
) -> PyResult<CompareOptions> {
    if bags.is_empty() {
        return Err(refused("no bags, expected at least one"));
    }
    if let Some(margin) = margin.filter(|margin| !(0.0..=0.5).contains(margin)) {
        return Err(refused(format!("margin is {margin}, expected a share from 0 to 0.5")));
    }
    let labels: Labeller = labels.parse().map_err(refused)?;
    let other_profile = OtherProfile::from(other_profile);
    Ok(CompareOptions {
        bags,
        labels,
        with_lost_robots,
        with_implausible,
        margin,
        poses: None,
        other_profile,
    })
}

/// Holds recorded runs against the sweep that predicts them.
///
/// Parameters
/// ----------
/// result
///     The results of a sweep, or their folder; with `choice.json` in it, the chosen cell is compared with
///     its fresh runs.
/// bags
///     Paths of bags: rosbag2 folders or .mcap files.
/// labels
///     Whose labels count: "judge", or "human:WHO".
/// margin
///     By how much real robots may show the wanted phase less often than simulated ones and still support
///     the claim, from 0 to 0.5; to be chosen before the first run. None is what was fixed for the
///     campaign, or 0.1.
/// with_lost_robots, with_implausible
///     Whether runs count that went on without a robot, or whose poses cannot be those of the robots.
/// other_profile
///     Whether runs of robots with another profile count.
#[pyfunction]
#[pyo3(name = "compare")]
#[pyo3(signature = (result, bags, *, labels="judge", margin=None, with_lost_robots=false,
                    with_implausible=false, other_profile=false))]
pub fn compare_runs(
    py: Python<'_>,
    result: &Bound<'_, PyAny>,
    bags: Vec<PathBuf>,
    labels: &str,
    margin: Option<f64>,
    with_lost_robots: bool,
    with_implausible: bool,
    other_profile: bool,
) -> PyResult<Comparison> {
    let folder = source(result)?;
    let options =
        options(bags, labels, margin, (with_lost_robots, with_implausible, other_profile))?;
    work_to_end(py, move || compare(&folder.path, &options).map(Report::new)).map(Comparison)
}

/// Writes one HTML file with the diagram and, if bags are given, the comparison and every run in motion; it
/// needs no other file.
///
/// Returns the comparison, if there is one.
///
/// Parameters
/// ----------
/// result, bags, labels, margin, with_lost_robots, with_implausible, other_profile
///     As for `compare`; without bags the report is of the sweep alone.
/// output
///     The file, whose name ends in .html; one that exists is replaced.
#[pyfunction]
#[pyo3(signature = (result, output, *, bags=None, labels="judge", margin=None, with_lost_robots=false,
                    with_implausible=false, other_profile=false))]
pub fn report(
    py: Python<'_>,
    result: &Bound<'_, PyAny>,
    output: PathBuf,
    bags: Option<Vec<PathBuf>>,
    labels: &str,
    margin: Option<f64>,
    with_lost_robots: bool,
    with_implausible: bool,
    other_profile: bool,
) -> PyResult<Option<Comparison>> {
    if output.extension().is_none_or(|ending| ending != "html") {
        return Err(refused_with_help(
            format!("{} does not end in .html", named(&output)),
            Some("name the report report.html".to_owned()),
        ));
    }
    let folder = source(result)?;
    let flags = (with_lost_robots, with_implausible, other_profile);
    let options = bags.map(|bags| options(bags, labels, margin, flags)).transpose()?;
    let comparison = work_to_end(py, move || {
        let (html, comparison) = html(&folder.path, options.as_ref())?;
        write_file(&output, html.as_bytes())?;
        Ok(comparison)
    })?;
    Ok(comparison.map(Comparison))
}
