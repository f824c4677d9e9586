//! The sweep file: which cells to simulate, how often, and from which seed.

mod check;
mod digest;
mod schema;

use serde::de::{self, Deserialize, Deserializer, MapAccess, Visitor};
use serde::ser::SerializeMap;
use serde::{Serialize, Serializer};

use crate::conditions::controller_table::{ControllerSource, ControllerTable, TableFlaw};
use crate::conditions::start_file::StartPlacement;
use crate::conditions::{ARENA_M, ClassChanges, Conditions, ConditionsError, Settings, Walls};
use crate::diagram::adaptive::Adaptive;
use crate::document::{self, DocumentError};
use crate::help::Help;
use crate::judge::behaviour::named::NamedBehaviour;
use crate::out_of_range::OutOfRange;
use crate::quantity::{Axis, AxisValues, Cell, OtherUnit};
use crate::robot::harsher::{Harsher, HarsherFactors, NotHarsher};
use crate::robot::profile::RobotProfile;
use crate::statistics::interval_kind::IntervalKind;
use crate::world::{WorldFile, WorldSource};

pub use check::check_run;
pub use digest::OtherSweep;

/// A sweep as written by a person: YAML with units in its keys.
#[derive(Clone, Debug, PartialEq, Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SweepFile {
    /// Path of the measured robot's profile, relative to the sweep file.
    pub profile: String,
    /// Path of the robots' controller, relative to the sweep file; without it, two commands over one detection, whose speeds
    /// and turning rates are axes.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub controller: Option<ControllerSource>,
    /// How the simulated robot is worse; each factor has a default.
    #[serde(default)]
    pub harsher: Harsher,
    /// What the swarm is judged for, by its name, or by the path of a file relative to the sweep file (default: `milling`).
    #[serde(default, skip_serializing_if = "NamedBehaviour::is_usual")]
    pub behaviour: NamedBehaviour,
    /// Swept axes; the grid is their product.
    #[serde(default, skip_serializing_if = "Axes::is_empty")]
    pub axes: Axes,
    /// Values that hold in every cell.
    #[serde(default)]
    pub fixed: Fixed,
    /// Where the robots start, if not in a disc of `placement_radius_m`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub placement: Option<StartPlacement>,
    /// Path of what is in the arena besides the robots, and of which classes these are, relative to the sweep file
    /// (default: nothing).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub world: Option<WorldSource>,
    /// A list of cells instead of a grid.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cells: Option<Vec<Cell>>,
    /// Replicates of each cell, in each of both worlds (default: 100); of an adaptive sweep, those that each cell begins with.
    #[serde(default = "usual_replicates")]
    pub replicates: u64,
    /// Simulated time of each replicate, in seconds.
    pub duration_s: f64,
    /// Seed of the sweep, below 2^63.
    pub seed: u64,
    /// When a cell has had enough replicates; without it, every cell has the same number.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub adaptive: Option<Adaptive>,
}

fn usual_replicates() -> u64 {
    100
}

/// Swept axes in the order of the file; the first is the picture's x.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Axes(pub Vec<(Axis, AxisValues)>);

/// Values that hold in every cell.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Fixed {
    /// Values by axis.
    pub values: Vec<(Axis, f64)>,
    /// What happens at the arena's border.
    pub walls: Walls,
}

/// Why a sweep file cannot be swept.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SweepFileError {
    /// The text is not a sweep file.
    #[error(transparent)]
    Document(#[from] DocumentError),
    /// What it holds makes no sweep.
    #[error("{file}: {source}")]
    Sweep {
        /// The file.
        file: String,
        /// Why.
        source: SweepProblem,
    },
}

fn in_file(file: &str) -> impl FnOnce(SweepProblem) -> SweepFileError {
    move |source| SweepFileError::Sweep { file: file.to_owned(), source }
}

/// Why what a sweep file holds makes no sweep.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SweepProblem {
    /// Neither `axes` nor `cells`, or both.
    #[error("give either `axes` or `cells`")]
    GridOrList,
    /// An axis or the list of cells is empty.
    #[error("`{0}` has no values")]
    Empty(String),
    /// The cells of a list do not share their axes, or a cell occurs twice.
    #[error("cell `{cell}` {problem}")]
    Cells {
        /// The cell.
        cell: Cell,
        /// What is wrong with it.
        problem: &'static str,
    },
    /// A value of an axis that makes no cell of its own.
    #[error("`{axis}` has the value {found}, which {problem}")]
    Value {
        /// The axis.
        axis: Axis,
        /// The value.
        found: f64,
        /// What is wrong with it.
        problem: &'static str,
    },
    /// A value that is likely in another unit.
    #[error(transparent)]
    Unit(#[from] OtherUnit),
    /// A part whose file was not read.
    #[error("the {part} is in {path}, which was not read")]
    NotRead {
        /// Which part: `behaviour`.
        part: &'static str,
        /// Where it is.
        path: String,
    },
    /// The table of the controller is none.
    #[error(transparent)]
    Controller(#[from] TableFlaw),
    /// An axis that is not of the controller.
    #[error(transparent)]
    NotOfController(#[from] ConditionsError),
    /// An axis with two claims on its value.
    #[error("`{axis}` is {problem}")]
    Twice {
        /// The axis.
        axis: Axis,
        /// Where.
        problem: &'static str,
    },
    /// A placement that is a trial's.
    #[error(
        "`placement` is a pair, expected disc_facing_out, box_facing_out, box_facing_any_way or file"
    )]
    Pair,
    /// More cells than can be kept.
    #[error("the axes span {0:e} cells, expected at most {MOST_CELLS}")]
    TooManyCells(f64),
    /// A number outside what it can mean.
    #[error(transparent)]
    OutOfRange(#[from] OutOfRange),
    /// The factors would make a better robot.
    #[error(transparent)]
    NotHarsher(#[from] NotHarsher),
    /// A cell that cannot be simulated, or that the robots must not be commanded.
    #[error("cell `{cell}`: {source}")]
    Cell {
        /// The cell.
        cell: Cell,
        /// Why.
        source: ConditionsError,
    },
}

impl Help for SweepFileError {
    fn help(&self) -> Option<String> {
        match self {
            Self::Document(error) => error.help(),
            Self::Sweep { source, .. } => source.help(),
        }
    }
}

impl Help for SweepProblem {
    fn help(&self) -> Option<String> {
        match self {
            Self::Controller(flaw) => flaw.help(),
            Self::NotOfController(error) | Self::Cell { source: error, .. } => error.help(),
            Self::Twice { axis: Axis::PlacementRadius, .. } => {
                Some("keep `placement` or `placement_radius_m`".to_owned())
            }
            Self::Pair => {
                Some("trials of two robots are driven by `rsrs measure drive`".to_owned())
            }
            Self::Twice { axis, .. } => Some(format!("keep one value or one list of `{axis}`")),
            _ => None,
        }
    }
}

/// Seeds are below this, so that they fit the signed integers of ROS parameters and YAML tools.
pub const SEED_LIMIT: u64 = 1 << 63;

/// Limit on the number of cells; more are a mistake.
pub const MOST_CELLS: usize = 1_000_000;

/// Limit on the replicates of a cell; more are a mistake.
pub const MOST_REPLICATES: u64 = 1_000_000_000_000;

impl SweepFile {
    /// Reads a sweep file and checks all that can be checked without the profile.
    pub fn parse(file: &str, text: &str) -> Result<Self, SweepFileError> {
        let sweep: Self = document::parse(file, text)?;
        sweep.check(file)?;
        Ok(sweep)
    }

    /// The sweep as a YAML document.
    pub fn to_yaml(&self) -> String {
        document::to_yaml(self)
    }

    /// The kind of interval that its counts allow for.
    pub fn interval_kind(&self) -> IntervalKind {
        match self.adaptive {
            None => IntervalKind::ClopperPearson,
            Some(_) => IntervalKind::AnytimeValid,
        }
    }

    /// All cells of the sweep, the first axis varying slowest.
    pub fn all_cells(&self) -> Vec<Cell> {
        if let Some(cells) = &self.cells {
            return cells.clone();
        }
        let mut partial: Vec<Vec<(Axis, f64)>> = vec![Vec::new()];
        for (axis, values) in &self.axes.0 {
            partial = partial
                .iter()
                .flat_map(|cell| {
                    values.0.iter().map(|value| {
                        let mut longer = cell.clone();
                        longer.push((*axis, *value));
                        longer
                    })
                })
                .collect();
        }
        partial
            .into_iter()
            .map(|values| Cell::new(values).expect("axes are distinct and values finite"))
            .collect()
    }

    /// The swept axes, in order.
    pub fn swept_axes(&self) -> Vec<Axis> {
        match &self.cells {
            Some(cells) => cells.first().map(Cell::axes).unwrap_or_default(),
            None => self.axes.0.iter().map(|(axis, _)| *axis).collect(),
        }
    }

    /// The settings that hold in every cell.
    pub fn settings(&self) -> Settings {
        Settings {
            values: self.fixed.values.clone(),
            walls: self.fixed.walls,
            placement: self.placement.as_ref().and_then(StartPlacement::placement),
            behaviour: self.behaviour.known(),
            controller: self.table().cloned(),
            world: self.world().cloned().unwrap_or_default(),
            class_changes: ClassChanges::default(),
        }
    }

    /// What is in the arena besides the robots, once it has been read; `None` where the file names nothing.
    pub fn world(&self) -> Option<&WorldFile> {
        self.world.as_ref().and_then(WorldSource::read)
    }

    /// Sides of the arenas of all cells, in metres.
    pub fn arenas_m(&self) -> Vec<f64> {
        let sides_m = self.values_on(Axis::Arena);
        if sides_m.is_empty() { vec![ARENA_M] } else { sides_m }
    }

    /// How many robots the cells have.
    pub fn numbers_of_robots(&self) -> Vec<usize> {
        self.values_on(Axis::Robots).into_iter().map(|robots| robots as usize).collect()
    }

    /// The values that the cells have on an axis; empty where it is not given.
    fn values_on(&self, wanted: Axis) -> Vec<f64> {
        let fixed = self.fixed.values.iter().find(|(axis, _)| *axis == wanted);
        let swept = self.axes.0.iter().find(|(axis, _)| *axis == wanted);
        let listed = || self.cells.iter().flatten().filter_map(|cell| cell.get(wanted));
        match (swept, fixed) {
            (Some((_, values)), _) => values.0.clone(),
            (None, Some((_, value))) => vec![*value],
            (None, None) => listed().collect(),
        }
    }

    /// The table of the controller, once it has been read; `None` where the file names none.
    pub fn table(&self) -> Option<&ControllerTable> {
        self.controller.as_ref().and_then(ControllerSource::read)
    }

    /// The conditions of every cell, in the order of [`Self::all_cells`]; `measured` is the profile
    /// that `profile` names.
    pub fn resolve(
        &self,
        file: &str,
        measured: &RobotProfile,
    ) -> Result<Vec<(Cell, Conditions)>, SweepFileError> {
        self.resolved(measured).map_err(in_file(file))
    }

    fn resolved(&self, measured: &RobotProfile) -> Result<Vec<(Cell, Conditions)>, SweepProblem> {
        self.check_axes(Some(measured))?;
        let not_read = |part, path: &String| SweepProblem::NotRead { part, path: path.clone() };
        if let NamedBehaviour::File(path) = &self.behaviour {
            return Err(not_read("behaviour", path));
        }
        if let Some(WorldSource::File(path)) = &self.world {
            return Err(not_read("world", path));
        }
        let factors = self.factors(measured);
        let simulated = factors.apply(measured)?;
        let class_changes = ClassChanges::as_of(measured, factors);
        let settings = Settings { class_changes, ..self.settings() };
        let conditions = |cell: &Cell| -> Result<Conditions, ConditionsError> {
            let conditions = Conditions::resolve(&simulated, &settings.with_cell(cell))?;
            measured.check_limits(&conditions.controller)?;
            conditions.world.check_limits(&conditions.controller)?;
            Ok(conditions)
        };
        let resolve = |cell: Cell| match conditions(&cell) {
            Ok(conditions) => Ok((cell, conditions)),
            Err(source) => Err(SweepProblem::Cell { cell, source }),
        };
        self.all_cells().into_iter().map(resolve).collect()
    }

    /// The sweep without the cells that ask more of a wheel than these robots have, or those of a class that has a
    /// profile of its own: for sweeps that nobody wrote. If that is any, its cells are a list.
    #[must_use]
    pub fn within_wheels(self, measured: &RobotProfile) -> Self {
        let settings = self.settings();
        let can = |cell: &Cell| {
            let conditions = Conditions::resolve(measured, &settings.with_cell(cell));
            // What makes no conditions is named when the sweep is resolved.
            conditions.map_or(true, |Conditions { controller, world, .. }| {
                let of_classes = world.profiles().map(|(_, own)| own);
                std::iter::once(measured)
                    .chain(of_classes)
                    .all(|robot| robot.check_wheels(&controller).is_ok())
            })
        };
        let all = self.all_cells();
        let fitting: Vec<Cell> = all.iter().filter(|cell| can(cell)).cloned().collect();
        if fitting.len() == all.len() {
            return self;
        }
        Self { axes: Axes::default(), cells: Some(fitting), ..self }
    }

    /// The factors of `harsher`, those that it leaves out as this robot needs them.
    pub fn factors(&self, measured: &RobotProfile) -> HarsherFactors {
        self.harsher.factors(measured)
    }
}

impl Axes {
    fn is_empty(&self) -> bool {
        self.0.is_empty()
    }
}

impl Serialize for Axes {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_map(self.0.iter().map(|(axis, values)| (axis, values)))
    }
}

impl<'de> Deserialize<'de> for Axes {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct AxesVisitor;
        impl<'de> Visitor<'de> for AxesVisitor {
            type Value = Axes;
            fn expecting(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                formatter.write_str("a map from axes to their values")
            }
            fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Axes, A::Error> {
                let mut axes: Vec<(Axis, AxisValues)> = Vec::new();
                while let Some((axis, values)) = map.next_entry::<Axis, AxisValues>()? {
                    if axes.iter().any(|(other, _)| *other == axis) {
                        return Err(de::Error::custom(format!("axis `{axis}` is given twice")));
                    }
                    axes.push((axis, values));
                }
                Ok(Axes(axes))
            }
        }
        deserializer.deserialize_map(AxesVisitor)
    }
}

impl Serialize for Fixed {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(Some(self.values.len() + 1))?;
        for (axis, value) in &self.values {
            map.serialize_entry(axis, value)?;
        }
        map.serialize_entry("walls", &self.walls)?;
        map.end()
    }
}

impl<'de> Deserialize<'de> for Fixed {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct FixedVisitor;
        impl<'de> Visitor<'de> for FixedVisitor {
            type Value = Fixed;
            fn expecting(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                formatter.write_str("a map from axes to numbers, and `walls`")
            }
            fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Fixed, A::Error> {
                let mut fixed = Fixed::default();
                while let Some(key) = map.next_key::<String>()? {
                    if key == "walls" {
                        fixed.walls = map.next_value()?;
                    } else {
                        let axis = key.parse().map_err(de::Error::custom)?;
                        fixed.values.push((axis, map.next_value()?));
                    }
                }
                Ok(fixed)
            }
        }
        deserializer.deserialize_map(FixedVisitor)
    }
}
