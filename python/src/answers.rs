//! What the steps answer, each with the text of its command and with what that prints as JSON.

use std::path::Path;

use pyo3::prelude::*;
use rsrs_core::diagram::choice::VIABLE_B_S_LOW;
use rsrs_core::quantity::Axis;
use rsrs_core::robot::other_profile::OtherProfile;
use rsrs_pipeline::answer::BestSetting;
use rsrs_pipeline::choose::CONFIRM;
use rsrs_pipeline::{answer, diagnose};
use rsrs_render::picture::of_answers;
use rsrs_render::picture_file::PageStyle;
use rsrs_render::{answers, diagnosis};

use crate::choice::setting;
use crate::error::{raised, refused};
use crate::folder::Folder;
use crate::json::{axis, to_python};
use crate::picture::Picture;
use crate::profile::Profile;
use crate::runs::runs;
use crate::sweep::{Sweep, SweepResult};
use crate::waiting::{Progress, work};

// Python's help shows numbers in signatures, and no names of constants.
const _: () = assert!(VIABLE_B_S_LOW.to_bits() == 0.8_f64.to_bits());
const _: () = assert!(answer::REPLICATES == 250 && CONFIRM == 1000);

/// What a step reads from a file: by its path, or an object of this package, which is written for the
/// step: a profile, a sweep, or the results of one.
pub fn source(value: &Bound<'_, PyAny>) -> PyResult<Folder> {
    if let Ok(sweep) = value.cast::<Sweep>() {
        return Folder::holding("sweep.yaml", &sweep.get().to_yaml());
    }
    if let Ok(profile) = value.cast::<Profile>() {
        return Folder::holding("profile.yaml", &profile.get().to_yaml());
    }
    if let Ok(result) = value.cast::<SweepResult>() {
        return Ok(Folder::kept(result.get().path().to_path_buf()));
    }
    value.extract().map(Folder::kept).map_err(|_| {
        refused(format!("expected a path, a Profile, a Sweep or a SweepResult, found {value}"))
    })
}

/// The five answers on a robot: how many, how fast, how sharply, how good the sensors, how alike.
#[pyclass(name = "Answers", module = "rsrs", frozen)]
pub struct Answers(answer::Answers);

#[pymethods]
impl Answers {
    /// Whether the robots show the wanted phase as often as wanted at the recommendation.
    #[getter]
    fn is_viable(&self) -> bool {
        self.0.best.viable
    }
    /// The recommended cell, as values by axis.
    #[getter]
    fn cell<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        to_python(py, &self.0.best.cell)
    }
    /// Share of fresh runs there that show the wanted phase, in the world in which it is rarer.
    #[getter]
    fn b_s(&self) -> f64 {
        self.0.best.b_s
    }
    /// Lower bound of its 95 % interval.
    #[getter]
    fn b_s_low(&self) -> f64 {
        self.0.best.b_s_low
    }
    /// The five questions, each with its quantities, their ranges and curves.
    #[getter]
    fn questions<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        to_python(py, &answers::questions(&self.0))
    }
    /// All curves as a picture.
    fn picture(&self) -> PyResult<Picture> {
        of_answers(&self.0, PageStyle::default()).map(Picture::new).map_err(raised)
    }
    fn _repr_svg_(&self) -> PyResult<String> {
        Ok(self.picture()?.svg().to_owned())
    }
    /// All of it, under the names of `rsrs answer --format json`.
    fn as_dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        to_python(py, &answers::json(&self.0))
    }
    fn __repr__(&self) -> String {
        let BestSetting { robot, viable, cell, b_s, b_s_low, behaviour, .. } = &self.0.best;
        let verb = behaviour.verb();
        let does = if *viable { verb.plain.to_owned() } else { format!("do not {}", verb.plain) };
        format!(
            "Answers({robot}: they {does} at {cell}; {:.0} % of fresh runs, lower bound {:.0} %)",
            100.0 * b_s,
            100.0 * b_s_low
        )
    }
    fn __str__(&self) -> String {
        answers::text(&self.0).to_string()
    }
}

/// Answers the paper's five questions on a robot: how many, how fast, how sharply turning, how good the
/// sensors, how alike.
///
/// Parameters
/// ----------
/// robot
///     A profile (by path, or a Profile), a sweep (by path, or a Sweep), or the results of one.
/// sweep
///     A sweep whose settings are tried in place of a built-in grid.
/// wanted
///     The wanted share of runs in the wanted phase, from 0 to 1.
/// replicates
///     Runs of each point of a curve, in each world.
/// robots
///     Number of robots; any that is tried if not given.
/// confirm
///     Fresh runs that confirm a setting, in each world.
/// other_profile
///     Whether the sweep may be of robots with another profile.
#[pyfunction]
#[pyo3(name = "answer")]
#[pyo3(signature = (robot, *, sweep=None, wanted=0.8, replicates=250, robots=None,
                    confirm=1000, other_profile=false, threads=None, progress=None))]
pub fn answer_all(
    py: Python<'_>,
    robot: &Bound<'_, PyAny>,
    sweep: Option<&Bound<'_, PyAny>>,
    wanted: f64,
    replicates: u64,
    robots: Option<usize>,
    confirm: u64,
    other_profile: bool,
    threads: Option<usize>,
    progress: Option<&Bound<'_, PyAny>>,
) -> PyResult<Answers> {
    let (robot, sweep) = (source(robot)?, sweep.map(source).transpose()?);
    let setting = setting(wanted, robots, confirm)?;
    let replicates = runs("replicates", replicates)?;
    let progress = Progress::new(progress)?;
    work(py, threads, &progress, |execution| {
        let options = answer::AnswerOptions {
            sweep: path_of(sweep.as_ref()),
            other_profile: OtherProfile::from(other_profile),
            replicates,
            best: setting.options(execution),
        };
        answer::answer(&robot.path, options)
    })
    .map(Answers)
}

fn path_of(source: Option<&Folder>) -> Option<&Path> {
    source.map(|source| source.path.as_path())
}

/// Why robots do not show the wanted phase, and what would have to be changed about them; for robots that
/// do, what could be worse.
#[pyclass(name = "Diagnosis", module = "rsrs", frozen)]
pub struct Diagnosis(diagnose::Diagnosis);

#[pymethods]
impl Diagnosis {
    /// Whether the robots show the wanted phase as often as wanted in some setting.
    #[getter]
    fn is_viable(&self) -> bool {
        self.0.best.viable
    }
    /// Their best setting, as values by axis.
    #[getter]
    fn cell<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        to_python(py, &self.0.best.cell)
    }
    /// Share of fresh runs there that show the wanted phase, in the world in which it is rarer.
    #[getter]
    fn b_s(&self) -> f64 {
        self.0.best.b_s
    }
    /// Changes after which the robots would do, the first one first; empty if they do.
    #[getter]
    fn causes<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        to_python(py, &diagnosis::causes(&self.0))
    }
    /// What may be worse, if the robots do.
    #[getter]
    fn spare<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        to_python(py, &diagnosis::spare(&self.0))
    }
    /// All of it, under the names of `rsrs diagnose --format json`.
    fn as_dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        to_python(py, &diagnosis::json(&self.0))
    }
    fn __repr__(&self) -> String {
        let diagnose::Diagnosis { best, causes, .. } = &self.0;
        let verdict = match (best.viable, causes.first()) {
            (true, _) => "nothing is wrong".to_owned(),
            (false, _) if best.b_s >= best.wanted => "more fresh runs are needed".to_owned(),
            (false, Some(cause)) => {
                format!("something must change, first {}", diagnosis::change(cause))
            }
            (false, None) => "something must change".to_owned(),
        };
        format!("Diagnosis({}: {verdict})", best.robot)
    }
    fn __str__(&self) -> String {
        diagnosis::text(&self.0).to_string()
    }
}

/// Finds out why robots do not show the wanted phase, and what would have to be changed about them.
///
/// Parameters
/// ----------
/// robot
///     A profile (by path, or a Profile), a sweep (by path, or a Sweep), or the results of one.
/// sweep
///     A sweep whose settings are tried in place of a built-in grid.
/// wanted
///     The wanted share of runs in the wanted phase, from 0 to 1.
/// costs
///     What a change of a capability costs, in any currency, by axis: {"range_m": 200}; changes are put in
///     order by it.
/// robots, confirm
///     As for `answer`.
#[pyfunction]
#[pyo3(name = "diagnose")]
#[pyo3(signature = (robot, *, sweep=None, wanted=0.8, costs=None, robots=None, confirm=1000,
                    threads=None, progress=None))]
pub fn diagnose_all(
    py: Python<'_>,
    robot: &Bound<'_, PyAny>,
    sweep: Option<&Bound<'_, PyAny>>,
    wanted: f64,
    costs: Option<std::collections::BTreeMap<String, f64>>,
    robots: Option<usize>,
    confirm: u64,
    threads: Option<usize>,
    progress: Option<&Bound<'_, PyAny>>,
) -> PyResult<Diagnosis> {
    let (robot, sweep) = (source(robot)?, sweep.map(source).transpose()?);
    let setting = setting(wanted, robots, confirm)?;
    let costs = costs.unwrap_or_default().into_iter().map(|(key, cost)| Ok((axis(&key)?, cost)));
    let costs: Vec<(Axis, f64)> = costs.collect::<PyResult<_>>()?;
    let progress = Progress::new(progress)?;
    work(py, threads, &progress, |execution| {
        let options = diagnose::DiagnoseOptions {
            sweep: path_of(sweep.as_ref()),
            costs: &costs,
            best: setting.options(execution),
        };
        diagnose::diagnose(&robot.path, options)
    })
    .map(Diagnosis)
}
