//! Sweeps: what is to be simulated, and what came out.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use pyo3::exceptions::PyUserWarning;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use rsrs_core::capability::lost_capabilities;
use rsrs_core::diagram::{DiagramCell, PhaseDiagram};
use rsrs_core::judge::counts::PhaseCounts;
use rsrs_core::judge::phase::Phase;
use rsrs_core::quantity::{Axis, Cell};
use rsrs_core::statistics::share::Share;
use rsrs_pipeline::choose::choose;
use rsrs_pipeline::sweep::folder;
use rsrs_pipeline::sweep::result::{self, World};
use rsrs_pipeline::sweep::source::ResolvedSweep;
use rsrs_pipeline::sweep::sweep_into;
use rsrs_render::picture::{self, CellNumber, DiagramOptions, Worlds};
use rsrs_sim::draw::Seed;
use rsrs_view::diagram::Numbers;

use crate::choice::{Choice, setting};
use crate::conditions::PyConditions;
use crate::episode::simulated;
use crate::error::{our_mistake, raised, refused};
use crate::folder::Folder;
use crate::json::{axis, cell, to_python};
use crate::keys::of_keys;
use crate::picture::Picture;
use crate::table::{Columns, Table};
use crate::trajectory::PyTrajectory;
use crate::waiting::{Progress, work};

/// A sweep that can be simulated: `rsrs.Sweep("sweep.yaml")`, or the keys of such a file as arguments.
///
/// Parameters
/// ----------
/// path
///     A sweep file, or the `sweep.yaml` of a folder of results.
/// **keys
///     The keys of a sweep file (see `docs/reference.md`) in place of one: `profile` (a Profile, or a path
///     relative to the working directory), `axes` (values by axis, or {"from": 0.05, "to": 0.3, "steps": 11}), `fixed`,
///     `harsher`, `placement`, `cells`, `replicates`, `duration_s` in seconds, `seed`, `behaviour`,
///     `adaptive`.
///
/// Raises
/// ------
/// RsrsError
///     If a file cannot be read, a key is unknown, or a cell cannot be simulated.
#[pyclass(name = "Sweep", module = "rsrs", frozen)]
pub struct Sweep {
    pub name: String,
    pub source: ResolvedSweep,
}

#[pymethods]
impl Sweep {
    #[new]
    #[pyo3(signature = (path=None, /, **keys))]
    fn new(path: Option<PathBuf>, keys: Option<&Bound<'_, PyDict>>) -> PyResult<Self> {
        let (name, source) = match (path, keys.filter(|keys| !keys.is_empty())) {
            (Some(path), None) => (path.display().to_string(), ResolvedSweep::read_either(&path)),
            (None, Some(keys)) => {
                let name = "Sweep".to_owned();
                let source = of_keys(&name, keys)?;
                (name, source)
            }
            _ => return Err(refused("give either the path of a sweep file or its keys")),
        };
        let source = source.map_err(raised)?;
        // What cannot be simulated is refused here, and not after minutes.
        source.cells(&name).map_err(raised)?;
        Ok(Self { name, source })
    }
    /// The cells, each a dictionary of values by axis; the first axis varies slowest.
    #[getter]
    fn cells<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        to_python(py, &self.source.sweep.all_cells())
    }
    /// The swept axes by their names: "speed_m_s".
    #[getter]
    fn axes(&self) -> Vec<&'static str> {
        self.source.sweep.swept_axes().into_iter().map(Axis::key).collect()
    }
    /// What the swarm is judged for.
    #[getter]
    fn behaviour(&self) -> &'static str {
        self.source.sweep.behaviour.known().key()
    }
    /// Replicates of each cell, in each world.
    #[getter]
    fn replicates(&self) -> u64 {
        self.source.sweep.replicates
    }
    /// Simulated time of each replicate, in seconds.
    #[getter]
    fn duration_s(&self) -> f64 {
        self.source.sweep.duration_s
    }
    /// The seed.
    #[getter]
    fn seed(&self) -> u64 {
        self.source.sweep.seed
    }
    /// Names the results: equal sweeps have equal digests, of 16 hexadecimal digits.
    #[getter]
    fn digest(&self) -> String {
        self.source.digest()
    }
    /// The conditions of one cell: everything that its runs depend on.
    ///
    /// `cell` has a value for each swept axis: {"speed_m_s": 0.15}; `world` is "harsher" (robots made
    /// worse) or "as_measured".
    #[pyo3(signature = (cell, *, world="harsher"))]
    fn conditions(&self, cell: &Bound<'_, PyAny>, world: &str) -> PyResult<PyConditions> {
        let index = self.index(&self::cell(cell)?)?;
        self.conditions_of(index, self::world(world)?)
    }
    /// The sweep with its profile as YAML, which needs no other file.
    pub fn to_yaml(&self) -> String {
        self.source.to_yaml()
    }
    /// Simulates every cell in both worlds: with the robots made worse, and as measured.
    ///
    /// Other Python threads run on, and Ctrl-C stops it at any moment: what was finished is kept in
    /// `output`, where the same call goes on. Results do not depend on the number of threads.
    ///
    /// Parameters
    /// ----------
    /// output
    ///     Folder for the results, as `rsrs sweep -o` makes it; without one they last as long as the object.
    /// threads
    ///     As many as the machine runs at once if not given.
    /// progress
    ///     True shows a line on the standard error; a function is called with what is being done, how many
    ///     runs are done, and of how many.
    #[pyo3(signature = (output=None, *, threads=None, progress=None))]
    fn run(
        &self,
        py: Python<'_>,
        output: Option<PathBuf>,
        threads: Option<usize>,
        progress: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<SweepResult> {
        warn_of_lost_capabilities(py, &self.source)?;
        let progress = Progress::new(progress)?;
        let is_kept = output.is_some();
        let folder = match output {
            Some(path) => Folder::kept(path),
            None => Folder::temporary("sweep")?,
        };
        let draw = if is_kept { picture::into_folder } else { |_: &Path, _: &_| Ok(()) };
        let result = work(py, threads, &progress, |execution| {
            sweep_into(&folder.path, &self.name, self.source.clone(), execution, draw)
        })?;
        Ok(SweepResult { folder: Arc::new(folder), result })
    }
    fn __repr__(&self) -> String {
        let Self { source, .. } = self;
        let worlds = if source.as_measured().is_some() { 2 } else { 1 };
        format!(
            "Sweep({} cells of {}, {} replicates of {} s in {worlds} worlds, seed {})",
            source.sweep.all_cells().len(),
            self.axes().join(" x "),
            source.sweep.replicates,
            source.sweep.duration_s,
            source.sweep.seed
        )
    }
}

impl Sweep {
    /// The index of a cell among all.
    fn index(&self, cell: &Cell) -> PyResult<usize> {
        let cells = self.source.sweep.all_cells();
        let axes = self.source.sweep.swept_axes();
        let counts = PhaseCounts::default();
        let cells = cells.into_iter().map(|cell| DiagramCell { cell, counts }).collect();
        PhaseDiagram { axes, cells }.locate(cell).map_err(refused)
    }

    fn conditions_of(&self, index: usize, world: World) -> PyResult<PyConditions> {
        let measured = (world == World::AsMeasured).then(|| self.source.as_measured()).flatten();
        let source = measured.as_ref().unwrap_or(&self.source);
        let conditions = source.conditions_of(index).map_err(raised)?;
        Ok(PyConditions::new(conditions, &self.source.profile))
    }
}

/// A world by its name.
fn world(key: &str) -> PyResult<World> {
    let worlds = [World::Harsher, World::AsMeasured];
    let named = worlds.into_iter().find(|world| world.key() == key);
    named.ok_or_else(|| refused(format!("unknown world `{key}`, expected harsher or as_measured")))
}

/// Warns of the capabilities that the factors take away, before anything is simulated.
fn warn_of_lost_capabilities(py: Python<'_>, source: &ResolvedSweep) -> PyResult<()> {
    let simulated = source.sweep.factors(&source.profile).apply(&source.profile);
    if let Ok(simulated) = &simulated {
        for lost in lost_capabilities(&source.profile, simulated) {
            let text = std::ffi::CString::new(lost.to_string()).map_err(our_mistake)?;
            PyErr::warn(py, &py.get_type::<PyUserWarning>(), &text, 2)?;
        }
    }
    Ok(())
}

/// The results of a sweep: `rsrs.SweepResult("results/flockbot")` reads the folder of one.
#[pyclass(name = "SweepResult", module = "rsrs", frozen)]
pub struct SweepResult {
    folder: Arc<Folder>,
    result: result::SweepResult,
}

impl SweepResult {
    pub fn path(&self) -> &Path {
        &self.folder.path
    }

    /// Both worlds with their names, as far as they are there.
    fn worlds(&self) -> Vec<(World, &PhaseDiagram)> {
        match &self.result.as_measured {
            Some(measured) => {
                vec![(World::Harsher, &self.result.diagram), (World::AsMeasured, measured)]
            }
            None if self.result.source.as_measured().is_some() => {
                vec![(World::Harsher, &self.result.diagram)]
            }
            None => vec![(World::AsMeasured, &self.result.diagram)],
        }
    }
}

#[pymethods]
impl SweepResult {
    #[new]
    fn new(folder: PathBuf) -> PyResult<Self> {
        let result = folder::read(&folder).map_err(raised)?;
        Ok(Self { folder: Arc::new(Folder::kept(folder)), result })
    }
    /// The folder with the results.
    #[getter]
    fn folder(&self) -> &Path {
        self.path()
    }
    /// The sweep.
    #[getter]
    fn sweep(&self) -> Sweep {
        Sweep { name: "Sweep".to_owned(), source: self.result.source.clone() }
    }
    /// The swept axes by their names.
    #[getter]
    fn axes(&self) -> Vec<&'static str> {
        self.result.diagram.axes.iter().map(|axis| axis.key()).collect()
    }
    /// One row for each cell in each world: its values by axis, `world` ("harsher" or "as_measured"), `n`
    /// replicates, how many ended in each phase, the most frequent `phase`, and the share `b_s` of the
    /// wanted phase with its 95 % interval from `b_s_low` to `b_s_high`.
    #[getter]
    fn cells(&self) -> PyResult<Table> {
        let sweep = &self.result.source.sweep;
        let worlds = self.worlds();
        let rows: Vec<(World, &DiagramCell)> = worlds
            .iter()
            .flat_map(|(world, diagram)| diagram.cells.iter().map(|entry| (*world, entry)))
            .collect();
        let doubles = |of: &dyn Fn(&DiagramCell) -> f64| -> Vec<f64> {
            rows.iter().map(|(_, entry)| of(entry)).collect()
        };
        let counts = |of: &dyn Fn(&DiagramCell) -> u64| -> Vec<u64> {
            rows.iter().map(|(_, entry)| of(entry)).collect()
        };
        let interval = |entry: &DiagramCell| {
            let share = Share::milling(&entry.counts);
            sweep.interval_kind().interval(share.hits, share.n)
        };
        let mut columns = Columns::default();
        for axis in &self.result.diagram.axes {
            columns
                .doubles(axis.key(), doubles(&|entry| entry.cell.get(*axis).unwrap_or(f64::NAN)));
        }
        columns.words("world", rows.iter().map(|(world, _)| Some(world.key())).collect());
        columns.counts("n", counts(&|entry| entry.counts.total()));
        for phase in sweep.behaviour.known().phases() {
            columns.counts(phase.key(), counts(&|entry| entry.counts.get(*phase)));
        }
        let majority = |(_, entry): &(World, &DiagramCell)| entry.counts.majority().map(Phase::key);
        columns.words("phase", rows.iter().map(majority).collect());
        columns.doubles("b_s", doubles(&|entry| entry.counts.wanted_share()));
        columns.doubles("b_s_low", doubles(&|entry| interval(entry).low));
        columns.doubles("b_s_high", doubles(&|entry| interval(entry).high));
        columns.table()
    }
    /// One row for each replicate: its cell, number and seed, phase, order parameters, and world.
    #[getter]
    fn replicates(&self) -> PyResult<Table> {
        Table::file(&self.folder, "replicates.parquet")
    }
    /// The cells as an `xarray.Dataset`, with a dimension for each axis and `world`; needs xarray.
    fn to_xarray(slf: Bound<'_, Self>) -> PyResult<Bound<'_, PyAny>> {
        slf.py().import("rsrs._xarray")?.call_method1("dataset", (&slf,))
    }
    /// Chooses the cell that may drift furthest and still show the wanted phase, and confirms it on fresh
    /// seeds in both worlds.
    ///
    /// Parameters
    /// ----------
    /// viable
    ///     Least confirmed lower bound of the share of the wanted phase, from 0 to 1.
    /// robots
    ///     Number of robots; any that was swept if not given.
    /// confirm
    ///     Fresh runs that confirm a cell, in each world.
    #[pyo3(signature = (*, viable=0.8, robots=None, confirm=1000,
                        threads=None, progress=None))]
    fn choose(
        &self,
        py: Python<'_>,
        viable: f64,
        robots: Option<usize>,
        confirm: u64,
        threads: Option<usize>,
        progress: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Choice> {
        let progress = Progress::new(progress)?;
        let setting = setting(viable, robots, confirm)?;
        let chosen = work(py, threads, &progress, |execution| {
            choose(self.path(), setting.options(execution))
        })?;
        Ok(Choice::new(chosen, viable))
    }
    /// One of the replicates, run again to the bit: poses, detections and commands.
    ///
    /// `cell` has a value for each swept axis, `replicate` counts from 0, and `world` is "harsher" (robots
    /// made worse) or "as_measured".
    #[pyo3(signature = (cell, *, replicate=0, world="harsher"))]
    fn episode(
        &self,
        py: Python<'_>,
        cell: &Bound<'_, PyAny>,
        replicate: u64,
        world: &str,
    ) -> PyResult<PyTrajectory> {
        let sweep = &self.result.source.sweep;
        let conditions = self.sweep().conditions(cell, world)?;
        let seed = Seed { seed: sweep.seed, replicate };
        simulated(py, &conditions, seed, sweep.duration_s, None)
    }
    /// The phase diagram as a picture, which a notebook shows.
    ///
    /// Parameters
    /// ----------
    /// x, y
    ///     Horizontal and vertical axis; the first two swept ones if not given.
    /// at
    ///     Values on further axes: {"robots": 9}.
    /// world
    ///     "harsher" (robots made worse), "as_measured", or "both".
    /// title
    ///     One with the robot's name if not given.
    /// numbers
    ///     Whether shares are written into the cells.
    /// choice
    ///     The chosen cell, which is marked; that of `choice.json` in the folder if not given.
    /// value
    ///     What cells show in place of their phases: the mean of an order parameter by its name,
    ///     "settling_time_s", or "difference" of robots as measured to those made worse.
    #[pyo3(signature = (*, x=None, y=None, at=None, world="harsher", title=None, numbers=true, choice=None,
                        value=None))]
    fn diagram(
        &self,
        py: Python<'_>,
        x: Option<&str>,
        y: Option<&str>,
        at: Option<&Bound<'_, PyAny>>,
        world: &str,
        title: Option<String>,
        numbers: bool,
        choice: Option<&Choice>,
        value: Option<&str>,
    ) -> PyResult<Picture> {
        let worlds = match world {
            "both" => Worlds::Both,
            one => Worlds::One(self::world(one)?),
        };
        let chosen = match choice {
            Some(choice) => choice.viable(),
            None => folder::read_choice(self.path()).map_err(raised)?,
        };
        let value = value.map(|key| {
            CellNumber::from_key(key).ok_or_else(|| {
                let keys = CellNumber::keys().collect::<Vec<_>>().join(", ");
                refused(format!("unknown value `{key}`, expected one of {keys}"))
            })
        });
        let value = value.transpose()?;
        let values = py.detach(|| {
            value.map(|value| value.of_sweep(self.path(), &self.result, worlds.all())).transpose()
        });
        let options = DiagramOptions {
            x: x.map(axis).transpose()?,
            y: y.map(axis).transpose()?,
            at: at.map(cell).transpose()?.map(|cell| cell.iter().collect()).unwrap_or_default(),
            chosen,
            title,
            values: values.map_err(raised)?,
            numbers: if numbers { Numbers::Shown } else { Numbers::Hidden },
            worlds,
            validation: picture::validation(self.path(), &self.result.source).map_err(raised)?,
            ..DiagramOptions::default()
        };
        let svg = py.detach(|| picture::of_sweep(&self.result, &options));
        Ok(Picture::new(svg.map_err(raised)?))
    }
    fn __len__(&self) -> usize {
        self.result.diagram.cells.len()
    }
    fn __repr__(&self) -> String {
        let best = self.result.diagram.cells.iter().map(|entry| entry.counts.wanted_share());
        let best = best.fold(0.0, f64::max);
        let n: u64 =
            self.worlds().iter().flat_map(|(_, it)| &it.cells).map(|it| it.counts.total()).sum();
        format!(
            "SweepResult({} cells of {}, {n} runs; {} in up to {:.0} % of the runs of a cell)",
            self.result.diagram.cells.len(),
            self.axes().join(" x "),
            self.result.source.sweep.behaviour.known().noun(),
            100.0 * best
        )
    }
    /// The phase diagram, in a notebook.
    fn _repr_svg_(&self, py: Python<'_>) -> PyResult<String> {
        Ok(self.diagram(py, None, None, None, "harsher", None, true, None, None)?.svg().to_owned())
    }
}
