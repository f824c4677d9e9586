//! What the page shows: a sweep of a robot, and what somebody has set differently.

use rsrs_core::conditions::operator::OperatorConditions;
use rsrs_core::conditions::start_file::StartPlacement;
use rsrs_core::conditions::{Conditions, ConditionsError};
use rsrs_core::diagram::sweep_file::{Axes, SweepFile, SweepFileError};
use rsrs_core::help::Help;
use rsrs_core::judge::phase::Phase;
use rsrs_core::program;
use rsrs_core::quantity::{Axis, AxisValues, Cell};
use rsrs_core::robot::harsher::{Harsher, HarsherFactors};
use rsrs_core::robot::profile::RobotProfile;
use rsrs_sim::draw::Seed;
use rsrs_sim::world::World;
use serde::{Deserialize, Serialize};

use crate::yaml;

/// What errors call the sweep that the page makes.
const FILE: &str = "sweep.yaml";

/// So many replicates of a cell must find room, where starts are random.
const N_PLACED: u64 = 20;

/// A sweep with its robot: what `sweep.yaml` in a folder of results holds, without where it comes from.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Source {
    /// The sweep.
    pub sweep: SweepFile,
    /// The measured robot.
    pub profile: RobotProfile,
}

/// A sweep, and what is set differently.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Scene {
    source: Source,
    /// Values by axis: of the shown cell, and of all that was changed.
    cell: Cell,
    /// The grid of the diagram, if it is not the sweep's.
    #[serde(default)]
    axes: Option<Axes>,
    /// Whether the robots are as measured instead of worse.
    #[serde(default)]
    as_measured: bool,
    /// Where robots start, if not as in the sweep; a disc has its radius among the values.
    #[serde(default)]
    start: Option<StartPlacement>,
    #[serde(default)]
    seed: Option<u64>,
}

/// Why a scene cannot be shown, in words.
pub type Refusal = String;

fn refusal(error: &SweepFileError) -> Refusal {
    let text = error.to_string();
    // There is no file for whoever moves sliders.
    let text = text.strip_prefix(&format!("{FILE}: ")).unwrap_or(&text);
    match error.help() {
        Some(help) => format!("{text}\n{help}"),
        None => text.to_owned(),
    }
}

impl Scene {
    /// Reads what the page has put together.
    pub fn parse(text: &str) -> Result<Self, Refusal> {
        let scene: Self = serde_json::from_str(text).map_err(|error| error.to_string())?;
        scene.source.profile.check().map_err(|error| error.to_string())?;
        Ok(scene)
    }

    /// The axes of the diagram: the first two of the sweep, if the page names no others.
    pub fn axes(&self) -> Axes {
        self.axes.clone().unwrap_or_else(|| {
            let sweep = &self.source.sweep;
            let grid = match &sweep.cells {
                None => sweep.axes.0.clone(),
                Some(cells) => of_list(cells),
            };
            Axes(grid.into_iter().take(2).collect())
        })
    }

    /// The sweep over the diagram's axes, with all else as it is set.
    pub fn sweep(&self) -> Result<SweepFile, Refusal> {
        let axes = self.axes();
        let sweep = self.source.sweep.clone();
        let mut values = sweep.fixed.values.clone();
        // Of an axis that occurs twice the later value counts.
        values.extend(self.cell.iter());
        let mut placement = sweep.placement.clone();
        match &self.start {
            Some(StartPlacement::DiscFacingOut { .. }) => placement = None,
            Some(start) => placement = Some(start.clone()),
            None => {}
        }
        if let Some(StartPlacement::DiscFacingOut { radius_m }) = placement {
            values.insert(0, (Axis::PlacementRadius, radius_m));
            placement = None;
        }
        let is_fixed = |axis: &Axis| {
            let is_swept = axes.0.iter().any(|(swept, _)| swept == axis);
            !is_swept && (placement.is_none() || *axis != Axis::PlacementRadius)
        };
        let last = |axis: Axis| values.iter().rev().find(|(other, _)| *other == axis).copied();
        let fixed = Axis::ALL.into_iter().filter(is_fixed).filter_map(last).collect();
        let as_measured = Harsher::from(HarsherFactors::NONE);
        let sweep = SweepFile {
            harsher: if self.as_measured { as_measured } else { sweep.harsher },
            fixed: rsrs_core::diagram::sweep_file::Fixed { values: fixed, ..sweep.fixed },
            axes,
            placement,
            cells: None,
            seed: self.seed.unwrap_or(sweep.seed),
            ..sweep
        };
        sweep.check(FILE).map_err(|error| refusal(&error))?;
        Ok(sweep)
    }

    /// The same sweep with the shown cell as its only one.
    fn sweep_of_cell(&self) -> Result<SweepFile, Refusal> {
        let mut axes = self.axes();
        let mut cell = self.clone();
        let shown = |axis: Axis| self.cell.get(axis).or_else(|| self.in_source(axis));
        axes.0.retain(|(axis, _)| shown(*axis).is_some());
        for (axis, values) in &mut axes.0 {
            values.0 = shown(*axis).into_iter().collect();
        }
        if axes.0.is_empty() {
            // A sweep has an axis; that it has the value that it has anyway changes no bit.
            let speed = shown(Axis::Speed).ok_or("there is no speed")?;
            axes.0.push((Axis::Speed, AxisValues(vec![speed])));
        }
        cell.axes = Some(axes);
        cell.sweep()
    }

    fn in_source(&self, axis: Axis) -> Option<f64> {
        let fixed = &self.source.sweep.fixed.values;
        fixed.iter().rev().find(|(other, _)| *other == axis).map(|(_, value)| *value)
    }

    /// The conditions of the shown cell.
    pub fn conditions(&self) -> Result<Conditions, Refusal> {
        let sweep = self.sweep_of_cell()?;
        let mut resolved =
            sweep.resolve(FILE, &self.source.profile).map_err(|error| refusal(&error))?;
        Ok(resolved.swap_remove(0).1)
    }

    /// The seed of the sweep.
    pub fn seed(&self) -> u64 {
        self.seed.unwrap_or(self.source.sweep.seed)
    }

    /// How long a run lasts, in seconds.
    pub fn duration_s(&self) -> f64 {
        self.source.sweep.duration_s
    }

    /// The robot that is simulated, with every capability as it is set.
    fn robot(&self) -> Result<RobotProfile, Refusal> {
        let sweep = self.sweep_of_cell()?;
        let profile = &self.source.profile;
        let worse = sweep.factors(profile).apply(profile).map_err(|error| error.to_string())?;
        let axes = sweep.axes.0.iter().map(|(axis, values)| (*axis, values.0[0]));
        let values: Vec<(Axis, f64)> = sweep.fixed.values.iter().copied().chain(axes).collect();
        let capabilities: Vec<_> =
            values.into_iter().filter(|(axis, _)| axis.is_capability()).collect();
        worse.with_capabilities(&capabilities).map_err(|error: ConditionsError| error.to_string())
    }

    /// All that the page shows of it beside its robots in motion.
    pub fn describe(&self) -> Result<serde_json::Value, Refusal> {
        let conditions = self.conditions()?;
        let robot = self.robot()?;
        let setting = OperatorConditions::new(&conditions, self.duration_s());
        let value = |axis: Axis| setting.setting(axis).or_else(|| robot.capability(axis));
        let values: serde_json::Map<_, _> = Axis::ALL
            .into_iter()
            .filter_map(|axis| Some((axis.key().to_owned(), value(axis)?.into())))
            .collect();
        let actuation = &self.source.profile.actuation;
        let rules = conditions.behaviour.rules();
        let wanted = rules.of(rules.wanted).next();
        let bounds: Vec<_> = wanted
            .into_iter()
            .flat_map(|rule| &rule.conditions)
            .map(|condition| {
                serde_json::json!({
                    "key": condition.parameter.key(),
                    "bound": condition.bound,
                    "needs": condition.needs.key(),
                    "in_words": condition.to_string(),
                })
            })
            .collect();
        let entry = |phase: &Phase| {
            let colour = &phase.entry().colour;
            serde_json::json!({ "key": phase, "title": phase.title(), "colour": colour })
        };
        let axes: Vec<_> = self.axes().0.into_iter().map(|(axis, it)| (axis.key(), it.0)).collect();
        Ok(serde_json::json!({
            "name": self.source.profile.name,
            "conditions": conditions,
            "digest": format!("{:016x}", conditions.digest()),
            "values": values,
            "limits": {
                "speed_m_s": actuation.speed.limits_m_s,
                "turn_rate_rad_s": actuation.turn.limits_rad_s,
            },
            "axes": axes,
            "bounds": bounds,
            "behaviour": conditions.behaviour.key(),
            "phases": conditions.behaviour.phases(),
            "phase_entries": conditions.behaviour.phases().iter().map(entry).collect::<Vec<_>>(),
            "noun": conditions.behaviour.noun(),
            "seed": self.seed().to_string(),
            "duration_s": self.duration_s(),
            "walls_m": conditions.arena.walls_m(),
        }))
    }

    /// The sweep as a file that `rsrs sweep` reads, with its robot in it: the diagram, and the shown cell.
    pub fn sweep_file(&self) -> Result<String, Refusal> {
        #[derive(Serialize)]
        struct Resolved<'a> {
            sweep: &'a SweepFile,
            profile: &'a RobotProfile,
            provenance: Provenance,
        }
        #[derive(Serialize)]
        struct Provenance {
            version: &'static str,
            commit: &'static str,
            profile_digest: String,
            schema_version: u32,
        }
        let mut with_cell = self.clone();
        let mut axes = self.axes();
        for (axis, values) in &mut axes.0 {
            if let Some(value) = self.cell.get(*axis).filter(|value| !values.0.contains(value)) {
                values.0.push(value);
                values.0.sort_by(f64::total_cmp);
            }
        }
        with_cell.axes = Some(axes);
        let profile = &self.source.profile;
        let sweep = self.possible(with_cell.sweep()?)?;
        let text = yaml::to_string(&Resolved {
            sweep: &sweep,
            profile,
            provenance: Provenance {
                version: program::VERSION,
                commit: program::commit(),
                profile_digest: profile.digest(),
                schema_version: 1,
            },
        });
        text.map_err(|error| error.to_string())
    }

    /// The sweep without the cells that cannot be simulated; if there are any, its cells are a list.
    fn possible(&self, sweep: SweepFile) -> Result<SweepFile, Refusal> {
        let fits = |conditions: &Conditions| {
            let seed = |replicate| Seed { seed: sweep.seed, replicate };
            (0..N_PLACED).all(|replicate| World::new(conditions, seed(replicate)).is_ok())
        };
        let is_possible = |cell: &Cell| {
            let alone = SweepFile {
                axes: Axes::default(),
                cells: Some(vec![cell.clone()]),
                ..sweep.clone()
            };
            let resolved = alone.resolve(FILE, &self.source.profile);
            resolved.is_ok_and(|cells| cells.iter().all(|(_, conditions)| fits(conditions)))
        };
        let all = sweep.all_cells();
        let possible: Vec<Cell> = all.iter().filter(|cell| is_possible(cell)).cloned().collect();
        if possible.len() == all.len() {
            return Ok(sweep);
        }
        if possible.is_empty() {
            return Err("no cell of the diagram can be simulated".to_owned());
        }
        Ok(SweepFile { axes: Axes::default(), cells: Some(possible), ..sweep })
    }
}

/// The values of a list of cells, axis by axis.
fn of_list(cells: &[Cell]) -> Vec<(Axis, AxisValues)> {
    let axes = cells.first().map(Cell::axes).unwrap_or_default();
    let values = |axis: Axis| {
        let mut values: Vec<f64> = cells.iter().filter_map(|cell| cell.get(axis)).collect();
        values.sort_by(f64::total_cmp);
        values.dedup();
        (axis, AxisValues(values))
    };
    axes.into_iter().map(values).collect()
}
