//! Which of the factors that make a simulated robot worse does it: each alone, and all but each.

use rsrs_core::conditions::{ClassChanges, Conditions, Settings};
use rsrs_core::diagram::DiagramCell;
use rsrs_core::diagram::sweep_file::SweepFile;
use rsrs_core::quantity::Cell;
use rsrs_core::robot::harsher::{Harsher, HarsherFactors};
use rsrs_core::statistics::share::Share;
use rsrs_sim::sweep::confirmation_seed;
use serde::Serialize;

use crate::error::helped;
use crate::execution::Execution;
use crate::sweep::result::SweepResult;
use crate::sweep::source::ResolvedSweep;

/// Most runs of each variant.
pub const REPLICATES: u64 = 200;

/// What every factor does to how often a cell mills.
#[derive(Clone, Debug, Serialize)]
pub struct Ablation {
    /// The cell.
    pub cell: Cell,
    /// Runs behind each share.
    pub n_replicates: u64,
    /// Share of stable milling with robots as measured.
    pub b_s_as_measured: f64,
    /// Share with all factors.
    pub b_s_with_all: f64,
    /// Factor by factor, of those that change a robot of the cell.
    pub factors: Vec<FactorEffect>,
}

/// What one factor does.
#[derive(Clone, Debug, Serialize)]
pub struct FactorEffect {
    /// Its key under `harsher:`.
    pub factor: &'static str,
    /// What it makes of the robots.
    #[serde(skip)]
    pub meaning: &'static str,
    /// Share of stable milling with this factor alone.
    pub b_s_alone: f64,
    /// Share with all factors but this one.
    pub b_s_without: f64,
}

/// Runs one cell of a sweep with each factor alone and with all but each, `replicates` times;
/// `None` if no factor changes a robot.
pub fn ablate(
    source: &ResolvedSweep,
    cell: &Cell,
    replicates: u64,
    execution: Execution<'_>,
) -> anyhow::Result<Option<Ablation>> {
    let is_swept = source.sweep.all_cells().contains(cell);
    anyhow::ensure!(is_swept, "the sweep has no cell {cell}");
    // What was left to the profile of the sweep is left to those of classes, too.
    let harsher = source.sweep.harsher.decided(&source.profile);
    let as_measured = conditions(source, cell, HarsherFactors::NONE.into())?;
    let mut variants = vec![as_measured.clone(), conditions(source, cell, harsher)?];
    let mut ablations = Vec::new();
    for ablation in harsher.ablations() {
        let alone = conditions(source, cell, ablation.alone)?;
        // Some factors change no robot, and what the sweep itself sets, under `fixed` or `axes`, none does.
        if (0..alone.robots).any(|robot| alone.robot_at(robot) != as_measured.robot_at(robot)) {
            variants.extend([alone, conditions(source, cell, ablation.without)?]);
            ablations.push(ablation);
        }
    }
    if ablations.is_empty() {
        return Ok(None);
    }
    let SweepFile { seed, duration_s, .. } = source.sweep;
    let runs = (confirmation_seed(confirmation_seed(seed)), replicates);
    let swept = execution.simulate("comparing factors", &variants, runs, duration_s)?;
    let counts = swept.counts(variants.len());
    let shares: Vec<f64> = counts.iter().map(|counts| Share::milling(counts).value()).collect();
    let (of_all, of_each) = shares.split_at(2);
    let effects = ablations.iter().zip(of_each.chunks(2)).map(|(ablation, shares)| FactorEffect {
        factor: ablation.key,
        meaning: ablation.meaning,
        b_s_alone: shares[0],
        b_s_without: shares[1],
    });
    Ok(Some(Ablation {
        cell: cell.clone(),
        n_replicates: replicates,
        b_s_as_measured: of_all[0],
        b_s_with_all: of_all[1],
        factors: effects.collect(),
    }))
}

/// The cell of a sweep that mills most often with the robots as measured; of equals the first.
/// `None` if the sweep's robots are those as measured.
pub fn best_as_measured(
    source: &ResolvedSweep,
    replicates: u64,
    execution: Execution<'_>,
) -> anyhow::Result<Option<Cell>> {
    let Some(measured) = source.as_measured() else {
        return Ok(None);
    };
    let (cells, conditions): (Vec<Cell>, Vec<Conditions>) =
        measured.cells("sweep.yaml")?.into_iter().unzip();
    let SweepFile { seed, duration_s, .. } = source.sweep;
    let runs = (confirmation_seed(seed), replicates);
    let swept = execution.simulate("robots as measured", &conditions, runs, duration_s)?;
    let counts = swept.counts(cells.len());
    let shares = counts.iter().map(|counts| Share::milling(counts).hits).rev();
    let best = cells.into_iter().rev().zip(shares).max_by_key(|(_, hits)| *hits);
    Ok(best.map(|(cell, _)| cell))
}

/// Of a sweep in which no cell mills in most runs, what the factors do in the cell that mills most
/// often as measured; `None` if some cell mills in most runs, or no factor changes a robot.
pub fn of_barren_sweep(
    result: &SweepResult,
    execution: Execution<'_>,
) -> anyhow::Result<Option<Ablation>> {
    let mills = |entry: &DiagramCell| entry.counts.wanted_share() >= 0.5;
    if result.diagram.cells.iter().any(mills) {
        return Ok(None);
    }
    let replicates = REPLICATES.min(result.source.sweep.replicates);
    match best_as_measured(&result.source, replicates, execution)? {
        Some(cell) => ablate(&result.source, &cell, replicates, execution),
        None => Ok(None),
    }
}

fn conditions(source: &ResolvedSweep, cell: &Cell, harsher: Harsher) -> anyhow::Result<Conditions> {
    let measured = &source.profile;
    let simulated = harsher.factors(measured).apply(measured)?;
    let class_changes = ClassChanges { capabilities: Vec::new(), harsher: Some(harsher) };
    let settings = Settings { class_changes, ..source.sweep.settings().with_cell(cell) };
    Conditions::resolve(&simulated, &settings).map_err(helped)
}

impl Ablation {
    /// The factor without which most is won, if that is more than chance.
    pub fn worst(&self) -> Option<&FactorEffect> {
        let worst = self
            .factors
            .iter()
            .max_by(|one, other| one.b_s_without.total_cmp(&other.b_s_without))?;
        // By chance, two shares differ by less than this in 99 of 100 cases.
        let chance = 2.58 * libm::sqrt(2.0 * 0.25 / self.n_replicates as f64);
        (worst.b_s_without - self.b_s_with_all > chance).then_some(worst)
    }
}

#[cfg(test)]
mod tests {
    use rsrs_core::document::source::Source;
    use rsrs_core::robot::harsher::Ablation;
    use rsrs_core::robot::profile::RobotProfile;
    use rsrs_core::world::{RobotClass, WorldFile, WorldSource};
    use rsrs_testing::conditions::flockbot;

    use super::*;
    use crate::provenance::ResultProvenance;

    const SWEEP: &str = "\
profile: flockbot.yaml
axes: {speed_m_s: [0.15], turn_rate_rad_s: [0.75]}
fixed: {robots: 4, arena_m: 3, placement_radius_m: 0.6}
replicates: 4
duration_s: 70
seed: 7
";

    fn profile(heading_noise_sd_rad: f64) -> RobotProfile {
        let mut profile = flockbot();
        profile.actuation.turn.heading_noise_sd_rad = heading_noise_sd_rad;
        profile
    }

    /// A sweep of such robots, with classes that have profiles of their own.
    fn source(profile: RobotProfile, classes: [Option<RobotProfile>; 2]) -> ResolvedSweep {
        let class = |(name, own): (&str, Option<RobotProfile>)| RobotClass {
            name: name.to_owned(),
            profile: own.map(Source::Read),
            ..RobotClass::default()
        };
        let classes = ["a", "b"].into_iter().zip(classes).map(class).collect();
        let mut sweep = SweepFile::parse("sweep.yaml", SWEEP).unwrap();
        sweep.world = Some(WorldSource::Read(WorldFile { classes, ..WorldFile::NOTHING }));
        sweep.harsher = Harsher::from(sweep.factors(&profile));
        let provenance = ResultProvenance::new(&profile);
        ResolvedSweep { sweep, profile, provenance }
    }

    fn factors(source: &ResolvedSweep) -> Vec<&'static str> {
        let cell = source.sweep.all_cells().remove(0);
        let found = ablate(source, &cell, 4, Execution::unobserved()).unwrap();
        found.unwrap().factors.iter().map(|effect| effect.factor).collect()
    }

    const PLAIN: [&str; 3] = ["gain_sd_factor", "miss_factor", "false_positive_factor"];

    #[test]
    fn a_factor_that_changes_the_robots_of_one_class_alone_is_tried() {
        let with_drift = source(profile(0.0), [None, Some(profile(0.1))]);

        assert_eq!(factors(&with_drift), [&PLAIN[..], &["drift_factor"]].concat());
        assert_eq!(factors(&source(profile(0.0), [None, Some(profile(0.0))])), PLAIN);
    }

    #[test]
    fn a_factor_that_changes_no_robot_that_is_there_is_not_tried() {
        let nobodys = source(profile(0.1), [Some(profile(0.0)), Some(profile(0.0))]);

        assert_eq!(factors(&nobodys), PLAIN);
    }

    #[test]
    fn a_factor_is_alone_in_every_class_and_left_out_of_every_class() {
        let source = source(profile(0.0), [None, Some(profile(0.1))]);
        let cell = source.sweep.all_cells().remove(0);
        let harsher = source.sweep.harsher.decided(&source.profile);
        let noise = |harsher: Harsher| {
            conditions(&source, &cell, harsher).unwrap().robot_at(1).heading_noise_sd_rad.to_bits()
        };

        let swept = source.conditions_of(0).unwrap();
        assert_eq!(conditions(&source, &cell, harsher).unwrap(), swept);
        for Ablation { key, alone, without, .. } in harsher.ablations() {
            let found = [alone, without].map(noise);
            let is_drift = key == "drift_factor";
            let expected = if is_drift { [0.15, 0.1] } else { [0.1, 0.15] };
            assert_eq!(found, expected.map(f64::to_bits), "{key}");
        }
    }
}
