//! What the cells of a diagram may show in the place of their phases.

use std::path::Path;

use rsrs_core::conditions::Conditions;
use rsrs_core::diagram::DiagramCell;
use rsrs_core::judge::order::Parameter;
use rsrs_core::statistics::share::Share;
use rsrs_pipeline::error::with_help;
use rsrs_pipeline::execution::n_threads;
use rsrs_pipeline::sweep::result::{SweepResult, World};
use rsrs_pipeline::sweep::share_difference::ShareDifference;
use rsrs_pipeline::sweep::{replicate_table, settling};
use rsrs_sim::draw::Seed;
use rsrs_view::diagram::ValueScale;

/// A number that a cell may show.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CellNumber {
    /// An order parameter by its column in `replicates.parquet`: its mean over the runs of the cell, of a
    /// radius over those that ended as wanted.
    Order(&'static str),
    /// When half of those runs that ended as wanted had come to it, in seconds, of the first 20.
    SettlingTime,
    /// How much more often robots as measured end as wanted than robots made worse.
    Difference,
}

/// Runs of a cell that are simulated again for their settling times, at most: enough for a median.
const RUNS: u64 = 20;
const SETTLING_TIME: &str = "settling_time_s";
const DIFFERENCE: &str = "difference";

impl CellNumber {
    /// The names of all.
    pub fn keys() -> impl Iterator<Item = &'static str> {
        Parameter::all().map(Parameter::key).chain([SETTLING_TIME, DIFFERENCE])
    }

    /// The one with a name.
    pub fn from_key(key: &str) -> Option<Self> {
        let key = Self::keys().find(|other| *other == key)?;
        Some(match key {
            SETTLING_TIME => Self::SettlingTime,
            DIFFERENCE => Self::Difference,
            key => Self::Order(key),
        })
    }

    /// Its numbers in a sweep, in the worlds that are shown.
    ///
    /// # Errors
    ///
    /// If the sweep has one world and two are compared.
    pub fn of_sweep(
        self,
        folder: &Path,
        result: &SweepResult,
        worlds: &[World],
    ) -> anyhow::Result<CellNumbers> {
        let mill = result.source.sweep.behaviour.known().verb().plain;
        match self {
            Self::Difference => of_worlds(result),
            Self::Order(key) => {
                let behaviour = result.source.sweep.behaviour.known();
                if Parameter::of_behaviour(behaviour).iter().all(|it| it.key() != key) {
                    return Err(with_help(
                        format!(
                            "the runs of this sweep have no {key}: {behaviour} does not ask for it"
                        ),
                        "name it in a rule of the behaviour, and sweep again",
                    ));
                }
                let mut of_worlds = Vec::new();
                for world in worlds {
                    of_worlds.push((*world, replicate_table::means(folder, result, *world, key)?));
                }
                let words = key.replace('_', " ");
                let (title, name) = match words.strip_suffix(" m") {
                    Some(radius) => (radius, format!("{radius} (m) of the runs that {mill}")),
                    None => (words.as_str(), format!("{words}, mean of the runs")),
                };
                Ok(CellNumbers::around(title, name, of_worlds))
            }
            Self::SettlingTime => {
                let mut of_worlds = Vec::new();
                for world in worlds {
                    of_worlds.push((*world, settling_times(result, *world)?));
                }
                let name = format!("settling time (s): median of the runs that {mill}");
                Ok(CellNumbers::around("settling time", name, of_worlds))
            }
        }
    }
}

/// A number for each cell of a sweep.
#[derive(Clone, Debug)]
pub struct CellNumbers {
    /// What it is, in few words.
    pub title: String,
    /// What it is, with its unit.
    pub name: String,
    /// How it becomes a colour.
    pub scale: ValueScale,
    /// By world, in the order of its diagram.
    pub of_worlds: Vec<(World, Vec<Option<f64>>)>,
    /// Whether each compares robots as measured with robots made worse.
    pub is_of_both_worlds: bool,
    /// Cells to be framed, in the order of the diagram, and why.
    pub framed: Option<(String, Vec<bool>)>,
}

impl CellNumbers {
    fn around(title: &str, name: String, of_worlds: Vec<(World, Vec<Option<f64>>)>) -> Self {
        let all = of_worlds.iter().flat_map(|(_, values)| values.iter().copied().flatten());
        let scale = ValueScale::around(all);
        Self {
            title: title.to_owned(),
            name,
            scale,
            of_worlds,
            is_of_both_worlds: false,
            framed: None,
        }
    }

    /// Differences of shares, with frames where their intervals do not overlap.
    pub fn differences(name: String, cells: &[ShareDifference]) -> Self {
        let most = cells.iter().map(|it| it.difference().abs()).fold(0.05, f64::max);
        let values: Vec<Option<f64>> = cells.iter().map(|it| Some(it.difference())).collect();
        Self {
            title: "difference of the shares".to_owned(),
            name,
            scale: ValueScale::Diverging { most },
            of_worlds: vec![(World::Harsher, values.clone()), (World::AsMeasured, values)],
            is_of_both_worlds: false,
            framed: Some((
                "the 95 % intervals do not overlap".to_owned(),
                cells.iter().map(ShareDifference::has_moved).collect(),
            )),
        }
    }

    /// The numbers of a world.
    pub fn of(&self, world: World) -> Vec<Option<f64>> {
        let found = self.of_worlds.iter().find(|(other, _)| *other == world);
        found.map(|(_, values)| values.clone()).unwrap_or_default()
    }
}

fn of_worlds(result: &SweepResult) -> anyhow::Result<CellNumbers> {
    let measured = result.worlds()?.as_measured.ok_or_else(|| {
        with_help("the robots of this sweep are not made worse", "a difference needs two worlds")
    })?;
    let kind = result.source.sweep.interval_kind();
    let pair = |(worse, entry): (&DiagramCell, &DiagramCell)| ShareDifference {
        from: Share::milling(&worse.counts),
        to: Share::milling(&entry.counts),
        kinds: [kind; 2],
    };
    let cells: Vec<ShareDifference> =
        result.diagram.cells.iter().zip(&measured.cells).map(pair).collect();
    let does = result.source.sweep.behaviour.known().noun();
    let name = format!("share of {does}: robots as measured less robots made worse");
    Ok(CellNumbers { is_of_both_worlds: true, ..CellNumbers::differences(name, &cells) })
}

/// When half of the runs of each cell that ended as wanted had come to it, in seconds.
fn settling_times(result: &SweepResult, world: World) -> anyhow::Result<Vec<Option<f64>>> {
    let source = &result.source;
    let measured = (world == World::AsMeasured).then(|| source.as_measured()).flatten();
    let source = measured.as_ref().unwrap_or(source);
    let cells = source.cells("sweep.yaml")?;
    let n_runs = source.sweep.replicates.min(RUNS);
    let each = cells.len().div_ceil(n_threads()).max(1);
    let of_cell = |conditions: &Conditions| -> anyhow::Result<Option<f64>> {
        let runs = (0..n_runs).map(|replicate| Seed { seed: source.sweep.seed, replicate });
        settling::median_time_s(conditions, source.sweep.duration_s, runs)
    };
    std::thread::scope(|scope| {
        let parts: Vec<_> = cells
            .chunks(each)
            .map(|part| {
                scope.spawn(move || -> anyhow::Result<Vec<Option<f64>>> {
                    part.iter().map(|(_, conditions)| of_cell(conditions)).collect()
                })
            })
            .collect();
        let mut times_s = Vec::new();
        for part in parts {
            times_s.extend(part.join().expect("no cell panics")?);
        }
        Ok(times_s)
    })
}
