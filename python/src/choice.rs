//! A chosen cell, and how one is looked for.

use std::path::PathBuf;

use pyo3::prelude::*;
use rsrs_core::diagram::choice;
use rsrs_pipeline::choose::{Chosen, NoViableCell, SearchOptions, write};
use rsrs_pipeline::execution::Execution;
use rsrs_render::choice::{NoViableCellJson, none_viable, reason, viable};

use crate::error::{raised, refused};
use crate::json::to_python;
use crate::runs::runs;

/// How the best setting is looked for; checked.
#[derive(Clone, Copy)]
pub struct Setting {
    wanted: f64,
    robots: Option<usize>,
    confirm: u64,
}

impl Setting {
    pub fn options(self, execution: Execution<'_>) -> SearchOptions<'_> {
        let Self { wanted, robots, confirm } = self;
        SearchOptions { robots, wanted, confirm, execution }
    }
}

/// Checks how the best setting is to be looked for.
pub fn setting(wanted: f64, robots: Option<usize>, confirm: u64) -> PyResult<Setting> {
    if !(0.0..=1.0).contains(&wanted) {
        return Err(refused(format!("the wanted share is {wanted}, expected from 0 to 1")));
    }
    runs("confirm", confirm)?;
    if robots == Some(0) {
        return Err(refused("robots is 0, expected at least 1"));
    }
    Ok(Setting { wanted, robots, confirm })
}

/// The cell that may drift furthest, confirmed on fresh seeds; or that there is none, and the best.
#[pyclass(name = "Choice", module = "rsrs", frozen)]
pub struct Choice {
    chosen: Chosen,
    wanted: f64,
}

impl Choice {
    pub fn new(chosen: Chosen, wanted: f64) -> Self {
        Self { chosen, wanted }
    }

    /// The choice, if its cell is viable.
    pub fn viable(&self) -> Option<choice::Choice> {
        match &self.chosen {
            Chosen::Viable(choice) => Some(choice.clone()),
            Chosen::NoViableCell(_) => None,
        }
    }

    fn best(&self) -> &choice::Choice {
        match &self.chosen {
            Chosen::Viable(choice) => choice,
            Chosen::NoViableCell(NoViableCell { best, .. }) => best,
        }
    }
}

#[pymethods]
impl Choice {
    /// Whether the cell shows the wanted phase as often as wanted, made worse and as measured.
    #[getter]
    fn is_viable(&self) -> bool {
        self.viable().is_some()
    }
    /// The cell, as values by axis; the best of those that were confirmed if none is viable.
    #[getter]
    fn cell<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        to_python(py, &self.best().cell)
    }
    /// Share of fresh runs of robots made worse that show the wanted phase, from 0 to 1.
    #[getter]
    fn b_s(&self) -> f64 {
        self.best().b_s
    }
    /// Lower bound of its 95 % interval.
    #[getter]
    fn b_s_low(&self) -> f64 {
        self.best().b_s_low
    }
    /// Upper bound.
    #[getter]
    fn b_s_high(&self) -> f64 {
        self.best().b_s_high
    }
    /// Fresh runs behind it.
    #[getter]
    fn n_replicates(&self) -> u64 {
        self.best().n_replicates
    }
    /// Writes the choice as `rsrs choose -o` does: as `choice.json` in the folder of its sweep it marks
    /// diagrams and is what runs are compared with.
    fn save(&self, path: PathBuf) -> PyResult<()> {
        match &self.chosen {
            Chosen::Viable(choice) => write(&path, choice).map_err(raised),
            Chosen::NoViableCell(none) => Err(refused(format!("no viable cell: {}", reason(none)))),
        }
    }
    /// All of it, under the names of `choice.json`.
    fn as_dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        match &self.chosen {
            Chosen::Viable(choice) => to_python(py, choice),
            Chosen::NoViableCell(none) => to_python(py, &NoViableCellJson::from(none)),
        }
    }
    fn __repr__(&self) -> String {
        let best = self.best();
        let is_viable = if self.is_viable() { "viable" } else { "no viable cell; the best" };
        format!(
            "Choice({is_viable}: {}; {} in {:.1} % of {} fresh runs, {:.1} to {:.1} %)",
            best.cell,
            best.behaviour().noun(),
            100.0 * best.b_s,
            best.n_replicates,
            100.0 * best.b_s_low,
            100.0 * best.b_s_high
        )
    }
    fn __str__(&self) -> String {
        match &self.chosen {
            Chosen::Viable(choice) => viable(choice, self.wanted),
            Chosen::NoViableCell(none) => none_viable(none),
        }
        .to_string()
    }
}
