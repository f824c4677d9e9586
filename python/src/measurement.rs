//! Step 1 and 2: from trials to a profile, and whether the simulated robot is the worse one.

use std::path::{Path, PathBuf};

use pyo3::prelude::*;
use pyo3::types::PyString;
use rsrs_core::quantity::Axis;
use rsrs_core::robot::wheels::Wheels;
use rsrs_core::statistics::variance::Estimate;
use rsrs_core::trials::fit::{self as fitting, Details, Population, Unmeasured};
use rsrs_pipeline::error::{help_of, texts, with_help};
use rsrs_pipeline::init::{check_name, check_number, check_radius, check_wheel_base};
use rsrs_pipeline::measure::fit::{FittedFiles, Mixture, fit_files};
use rsrs_pipeline::measure::sources::Paths;
use rsrs_pipeline::validate::file::ValidationReport;
use rsrs_pipeline::validate::{self, StandIn};
use rsrs_render::picture_file::PageStyle;
use rsrs_render::validation::{text, write};
use rsrs_sim::reachable_set::ReachOptions;

use crate::answers::source;
use crate::error::{raised, refused};
use crate::json::{cell, to_python};
use crate::profile::Profile;
use crate::table::{Columns, Table};
use crate::waiting::work_to_end;

/// Tables of trials that are no files yet.
struct Tables(tempfile::TempDir);

impl Tables {
    fn new() -> PyResult<Self> {
        tempfile::TempDir::with_prefix("rsrs_").map(Self).map_err(refused)
    }

    /// The path of a table, which is written for it if it is an object.
    fn path(&self, table: &Bound<'_, PyAny>, name: &str) -> PyResult<PathBuf> {
        if table.is_instance_of::<PyString>() || table.hasattr("__fspath__")? {
            return table.extract();
        }
        let py = table.py();
        let text = py.import("rsrs._csv")?.call_method1("text", (table,));
        let text: String =
            text.map_err(|error| refused(format!("{name}: {}", error.value(py))))?.extract()?;
        let path = self.0.path().join(name);
        std::fs::write(&path, text).map_err(refused)?;
        Ok(path)
    }

    fn optional(&self, table: Option<&Bound<'_, PyAny>>, name: &str) -> PyResult<Option<PathBuf>> {
        table.map(|table| self.path(table, name)).transpose()
    }

    /// Tables or bags; a table is called by its place.
    fn all(&self, tables: &[Bound<'_, PyAny>]) -> PyResult<Vec<PathBuf>> {
        let named = tables.iter().zip(1..);
        named.map(|(table, place)| self.path(table, &format!("trajectories_{place}.csv"))).collect()
    }

    /// A text in which tables are called by their names alone.
    fn named(&self, text: &str) -> String {
        text.replace(&format!("{}{}", self.0.path().display(), std::path::MAIN_SEPARATOR), "")
    }

    fn name_in_error(&self, error: &anyhow::Error) -> anyhow::Error {
        let text = self.named(&texts(error).join(": "));
        match help_of(error) {
            Some(help) => with_help(text, self.named(&help)),
            None => anyhow::anyhow!(text),
        }
    }
}

/// A profile that was fitted to trials, and how sure each of its numbers is.
#[pyclass(name = "Fit", module = "rsrs", frozen)]
pub struct Fit {
    name: String,
    fitted: fitting::Fit,
    unmeasured: Unmeasured,
    notes: Vec<String>,
}

#[pymethods]
impl Fit {
    /// The profile, which a sweep takes.
    #[getter]
    fn profile(&self) -> Profile {
        Profile(self.fitted.profile(&self.name, &self.unmeasured))
    }
    /// One row for each number: `quantity`, of which `robot` (none for all together), at which `command` in
    /// `unit`, its `value` and 95 % interval from `low` to `high` (none where the data give none), and
    /// behind it `n` trials or readings.
    #[getter]
    fn intervals(&self) -> PyResult<Table> {
        rows(&self.fitted)
    }
    /// What does not count, and what makes some numbers less sure than they look.
    #[getter]
    fn notes(&self) -> Vec<String> {
        let cautions = self.fitted.details.cautions.iter().map(ToString::to_string);
        cautions.chain(self.notes.iter().cloned()).collect()
    }
    /// All of it, under the names of `rsrs measure fit --format json`.
    fn as_dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let dict = to_python(py, &self.fitted)?;
        dict.set_item("details", to_python(py, &self.fitted.details)?)?;
        Ok(dict)
    }
    fn __repr__(&self) -> String {
        let Details { speed, turn, .. } = &self.fitted.details;
        format!(
            "Fit({}: {} straight runs and {} turns of {} robots; {} notes)",
            self.name,
            speed.n_trials,
            turn.n_trials,
            speed.n_robots.max(turn.n_robots),
            self.notes().len()
        )
    }
}

/// A row of the table of intervals.
struct Row {
    quantity: &'static str,
    robot: Option<String>,
    command: Option<f64>,
    unit: &'static str,
    estimate: Estimate,
    n: Option<usize>,
}

impl Row {
    /// One of all robots, at any command.
    fn of_all(
        quantity: &'static str,
        unit: &'static str,
        estimate: Estimate,
        n: Option<usize>,
    ) -> Self {
        Self { quantity, robot: None, command: None, unit, estimate, n }
    }
}

fn rows(fitted: &fitting::Fit) -> PyResult<Table> {
    let details = &fitted.details;
    let mut rows: Vec<Row> = Vec::new();
    for it in &fitted.speed {
        let estimate = Estimate { value: it.gain, low: it.gain_low, high: it.gain_high };
        let (robot, command) = (Some(it.robot.clone()), Some(it.commanded_m_s));
        let n = Some(it.n_trials);
        rows.push(Row { quantity: "speed_gain", robot, command, unit: "m/s", estimate, n });
    }
    for it in &fitted.turn {
        let estimate = Estimate { value: it.gain, low: it.gain_low, high: it.gain_high };
        let (robot, command) = (Some(it.robot.clone()), Some(it.commanded_rad_s));
        let n = Some(it.n_trials);
        rows.push(Row { quantity: "turn_gain", robot, command, unit: "rad/s", estimate, n });
    }
    let mut of_all = |names: [&'static str; 3], population: &Population, unit: &'static str| {
        let [gain, robot_sd, trial_sd] = names;
        for at in &population.by_command {
            let of_all = Row::of_all(gain, unit, at.gain, None);
            rows.push(Row { command: Some(at.command), ..of_all });
        }
        for (quantity, estimate) in
            [(robot_sd, population.robot_sd), (trial_sd, population.trial_sd)]
        {
            let n = Some(population.n_trials);
            rows.extend(estimate.map(|estimate| Row::of_all(quantity, unit, estimate, n)));
        }
    };
    of_all(["speed_gain", "speed_gain_robot_sd", "speed_gain_trial_sd"], &details.speed, "m/s");
    of_all(["turn_gain", "turn_gain_robot_sd", "turn_gain_trial_sd"], &details.turn, "rad/s");
    if let Some(arc) = &details.arc {
        let names =
            ["driving_turn_gain", "driving_turn_gain_robot_sd", "driving_turn_gain_trial_sd"];
        of_all(names, arc, "rad/s");
    }
    let mut one = |quantity, estimate: Option<Estimate>, n| {
        rows.extend(estimate.map(|estimate| Row::of_all(quantity, "", estimate, n)));
    };
    for (quantity, rate) in [
        ("true_positive", details.sensor.true_positive),
        ("false_positive", details.sensor.false_positive),
    ] {
        let estimate = Estimate { value: rate.value, low: Some(rate.low), high: Some(rate.high) };
        one(quantity, Some(estimate), usize::try_from(rate.samples).ok());
    }
    if let Some(lag) = details.yaw_lag {
        one("yaw_lag_s", Some(lag.lag_s), Some(lag.n_trials));
    }
    if let Some(drift) = details.drift {
        one("bias_sd_rad_s", Some(drift.bias_sd_rad_s), Some(drift.n_trials));
        one("heading_noise_sd_rad", drift.heading_noise_sd_rad, Some(drift.n_trials));
        one("gust_sd_m_s", drift.gust_sd_m_s, Some(drift.n_trials));
    }
    if let Some(steps) = details.steps {
        let n = Some(steps.n_trials);
        one("heading_noise_sd_rad_by_steps", Some(steps.heading_noise_sd_rad), n);
        one("speed_step_sd", steps.speed_step_sd, n);
    }
    if let Some(period) = details.period {
        one("period_s", Some(period.period_s), None);
        one("jitter_s", period.jitter_s, None);
    }
    let mut columns = Columns::default();
    columns.words("quantity", rows.iter().map(|row| Some(row.quantity)).collect());
    columns.words("robot", rows.iter().map(|row| row.robot.as_deref()).collect());
    columns.optional_doubles("command", rows.iter().map(|row| row.command).collect());
    columns.words("unit", rows.iter().map(|row| Some(row.unit)).collect());
    columns.doubles("value", rows.iter().map(|row| row.estimate.value).collect());
    columns.optional_doubles("low", rows.iter().map(|row| row.estimate.low).collect());
    columns.optional_doubles("high", rows.iter().map(|row| row.estimate.high).collect());
    columns.optional_doubles("n", rows.iter().map(|row| row.n.map(|n| n as f64)).collect());
    columns.table()
}

/// Fits a profile to trials: every number with its interval and where it comes from.
///
/// Each table is a path, a data frame (polars, pandas, Arrow) or a dictionary of columns; all of them may
/// come out of bags instead, and straight runs and turns out of trajectories.
///
/// Parameters
/// ----------
/// name
///     Name of the kind of robot: letters, digits and `_`.
/// speed
///     Straight runs: robot, commanded_m_s, distance_m, duration_s, and if they were measured lateral_m,
///     heading_change_rad.
/// turn
///     Turns in place: robot, commanded_rad_s, angle_rad, duration_s.
/// detection
///     Detections: robot, distance_m, bearing_rad, samples, detections; no distance means no neighbour.
/// arcs
///     Turns while driving: robot, commanded_m_s, commanded_rad_s, angle_rad, duration_s.
/// period
///     Control periods: robot, period_s.
/// trajectories
///     Trajectories: robot, trial, time_s, x_m, y_m, heading_rad, commanded_m_s, commanded_rad_s.
/// bags
///     Paths of bags of trials.
/// plan
///     Folder of `rsrs measure plan`, filled in, in place of the tables above.
/// mixed
///     Whether trials of the simulator and of robots may make one profile.
/// radius_m
///     Radius of a robot's body, in metres; 0.075 if not given.
/// contact
///     What robots do when they touch: "stop", "push" or "none".
/// wheels
///     Distance of the two wheels, in metres, and fastest speed of a wheel, in m/s, of a robot that
///     drives on two.
#[pyfunction]
#[pyo3(signature = (name, *, speed=None, turn=None, detection=None, arcs=None, period=None,
                    trajectories=None, bags=None, plan=None, mixed=false, radius_m=None,
                    contact="stop", wheels=None))]
pub fn fit(
    py: Python<'_>,
    name: String,
    speed: Option<&Bound<'_, PyAny>>,
    turn: Option<&Bound<'_, PyAny>>,
    detection: Option<&Bound<'_, PyAny>>,
    arcs: Option<&Bound<'_, PyAny>>,
    period: Option<&Bound<'_, PyAny>>,
    trajectories: Option<Vec<Bound<'_, PyAny>>>,
    bags: Option<Vec<PathBuf>>,
    plan: Option<PathBuf>,
    mixed: bool,
    radius_m: Option<f64>,
    contact: &str,
    wheels: Option<(f64, f64)>,
) -> PyResult<Fit> {
    check_name(&name).map_err(raised)?;
    let mut unmeasured =
        Unmeasured { contact: contact.parse().map_err(refused)?, ..Unmeasured::default() };
    if let Some(radius_m) = radius_m {
        check_radius(radius_m).map_err(raised)?;
        unmeasured.radius_m = radius_m;
        unmeasured.radius_source = Some("given to rsrs.fit".to_owned());
    }
    if let Some((base_m, speed_max_m_s)) = wheels {
        check_wheel_base(base_m).map_err(raised)?;
        check_number(Axis::Speed, speed_max_m_s).map_err(raised)?;
        unmeasured.wheels = Some(Wheels { base_m, speed_max_m_s });
    }
    let tables = Tables::new()?;
    let paths = Paths {
        speed: tables.optional(speed, "speed.csv")?,
        turn: tables.optional(turn, "turn.csv")?,
        arcs: tables.optional(arcs, "arcs.csv")?,
        detection: tables.optional(detection, "detection.csv")?,
        period: tables.optional(period, "period.csv")?,
        trajectories: tables.all(&trajectories.unwrap_or_default())?,
        bags: bags.unwrap_or_default(),
    };
    let is_given = [&paths.speed, &paths.turn, &paths.arcs, &paths.detection, &paths.period];
    let paths = match plan {
        None => paths,
        Some(_) if is_given.iter().any(|path| path.is_some()) || !paths.bags.is_empty() => {
            return Err(refused("a plan has its own tables and bags; give none beside it"));
        }
        Some(plan) => {
            let of_plan = Paths::of_plan(&plan).map_err(raised)?;
            Paths { trajectories: paths.trajectories, ..of_plan }
        }
    };
    let is_driven = !(paths.trajectories.is_empty() && paths.bags.is_empty());
    let tables_needed = [("speed", &paths.speed), ("turn", &paths.turn)];
    if let Some((name, _)) =
        tables_needed.into_iter().find(|(_, table)| table.is_none() && !is_driven)
    {
        return Err(refused(format!(
            "no {name}: give its table, or trajectories or bags that show it"
        )));
    }
    let mixture = if mixed { Mixture::Allowed } else { Mixture::Refused };
    work_to_end(py, move || {
        let FittedFiles { fit: mut fitted, notes, .. } = fit_files(&paths, &unmeasured, mixture)
            .map_err(|error| tables.name_in_error(&error))?;
        let files = &mut fitted.details.files;
        for file in [&mut files.speed, &mut files.turn, &mut files.detection]
            .into_iter()
            .chain(files.arc.iter_mut())
            .chain(files.period.iter_mut())
        {
            *file = tables.named(file);
        }
        let notes = notes.iter().map(|note| tables.named(note)).collect();
        Ok(Fit { name, fitted, unmeasured, notes })
    })
}

/// Whether the simulated robot is the worse one: real trajectories lie inside its reach, and it is nowhere
/// better.
#[pyclass(name = "Validation", module = "rsrs", frozen)]
pub struct Validation(ValidationReport);

#[pymethods]
impl Validation {
    /// Whether trials are contained and the simulated robot is nowhere better.
    #[getter]
    fn is_harsher(&self) -> bool {
        self.0.is_harsher
    }
    /// Whether the trials are contained.
    #[getter]
    fn is_contained(&self) -> bool {
        self.0.validation.is_contained
    }
    /// Trials that were held against the reach.
    #[getter]
    fn n_trials(&self) -> usize {
        self.0.validation.n_trials
    }
    /// Those that never left it.
    #[getter]
    fn n_inside(&self) -> usize {
        self.0.validation.n_inside
    }
    /// All of it, under the names of `rsrs validate --format json`.
    fn as_dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        to_python(py, &self.0)
    }
    fn __repr__(&self) -> String {
        let is_harsher = if self.is_harsher() { "harsher" } else { "not harsher" };
        let (n_inside, n_trials) = (self.n_inside(), self.n_trials());
        format!(
            "Validation({is_harsher}: {n_inside} of {n_trials} trials inside the simulated reach)"
        )
    }
    fn __str__(&self) -> String {
        text(&self.0).to_string()
    }
}

/// Most simulated robots of a reach.
const MOST_ROBOTS: usize = 1_000_000;

/// Checks that the simulated robot of a sweep is worse than the real ones: step 2 of the method.
///
/// Parameters
/// ----------
/// sweep
///     A sweep (by path, or a Sweep), or the results of one; into their folder, or `output`, go
///     `validation.json` and pictures.
/// trajectories
///     Real trajectories of robots that drive alone: tables as for `fit`, or bags.
/// detection
///     Table of detections, as for `fit`.
/// simulated
///     Whether trajectories of the simulator may stand in for real ones; the result says so.
/// at
///     Values of the capabilities that the sweep varies: {"range_m": 0.75}.
/// robot_class
///     The class whose robot is judged, where classes of the sweep's world have profiles of their own; of bags in which
///     there are several classes, its robots' trajectories count.
/// robots
///     Simulated robots, from 200 to 1,000,000.
/// tolerance_m, tolerance_rad
///     How far measured positions and headings may be off, in metres and radians.
#[pyfunction]
#[pyo3(name = "validate")]
#[pyo3(signature = (sweep, trajectories, *, detection=None, simulated=false, at=None, robot_class=None,
                    robots=None, tolerance_m=None, tolerance_rad=None, output=None))]
pub fn validate_sweep(
    py: Python<'_>,
    sweep: &Bound<'_, PyAny>,
    trajectories: Vec<Bound<'_, PyAny>>,
    detection: Option<&Bound<'_, PyAny>>,
    simulated: bool,
    at: Option<&Bound<'_, PyAny>>,
    robot_class: Option<String>,
    robots: Option<usize>,
    tolerance_m: Option<f64>,
    tolerance_rad: Option<f64>,
    output: Option<PathBuf>,
) -> PyResult<Validation> {
    let (source, tables) = (source(sweep)?, Tables::new()?);
    let usual = ReachOptions::default();
    let n_robots = robots.unwrap_or(usual.n_robots);
    if n_robots > MOST_ROBOTS {
        return Err(refused(format!("robots is {n_robots}, expected from 200 to {MOST_ROBOTS}")));
    }
    let options = validate::ValidateOptions {
        trajectories: tables.all(&trajectories)?,
        detection: tables.optional(detection, "detection.csv")?,
        stand_in: if simulated { StandIn::Allowed } else { StandIn::Refused },
        at: at.map(cell).transpose()?.unwrap_or_default(),
        class: robot_class,
        reach: ReachOptions {
            n_robots,
            tolerance_m: tolerance_m.unwrap_or(usual.tolerance_m),
            tolerance_rad: tolerance_rad.unwrap_or(usual.tolerance_rad),
            ..usual
        },
    };
    work_to_end(py, move || {
        let output: Option<&Path> = output.as_deref();
        let answered = || {
            let validated = validate::validate(&source.path, &options)?;
            write(&validated, &source.path, output, PageStyle::default())?;
            Ok(validated.answer)
        };
        answered().map_err(|error| tables.name_in_error(&error))
    })
    .map(Validation)
}
