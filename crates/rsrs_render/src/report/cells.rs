//! What is known of each cell of the diagram, and one of its runs, simulated again.

use anyhow::Context;
use rsrs_core::conditions::Conditions;
use rsrs_core::diagram::{DiagramCell, PhaseDiagram};
use rsrs_core::judge::phase::{Phase, label_with};
use rsrs_core::judge::trajectory::Trajectory;
use rsrs_core::judge::window::{WINDOW_S, samples_in};
use rsrs_core::quantity::Cell;
use rsrs_core::statistics::share::Share;
use rsrs_pipeline::sweep::result::World;
use rsrs_sim::draw::Seed;
use rsrs_sim::episode::run_episode;
use rsrs_view::replay::{Replay, Shown, bytes_per_frame};
use rsrs_view::report::{CellFacts, WorldFacts};
use rsrs_view::trajectory::ring_of;

use super::{Reported, samples_at_least};
use crate::picture::robots;
use crate::wording::quantity;

/// What the replays of all cells may take, in bytes of the page.
const BUDGET_BYTES: f64 = 340_000.0;
/// How often poses are kept, in seconds: as often as looks smooth, and as rarely as still shows turns.
const FRAMES_S: [f64; 2] = [0.4, 1.05];
/// The shortest replay that is worth watching, in seconds.
const LEAST_S: f64 = 12.0;
/// How many replicates are tried until one ends as most do.
const MOST_TRIED: u64 = 10;

/// The facts of all cells, in their order.
pub fn facts(of: &Reported) -> anyhow::Result<Vec<CellFacts>> {
    let cells = of.result.source.cells("sweep.yaml")?;
    let frame_bytes = |(_, conditions): &(_, Conditions)| {
        bytes_per_frame(conditions.robots, conditions.world.n_objects())
    };
    let frame_bytes = cells.iter().map(frame_bytes).fold(1.0, f64::max);
    let sampling = ReplaySampling::within(BUDGET_BYTES / cells.len() as f64 / frame_bytes);
    let facts = |(index, (_, conditions)): (usize, &(_, Conditions))| {
        facts_of(of, index, conditions, sampling)
    };
    cells.iter().enumerate().map(facts).collect()
}

/// How much of a run is shown, and how often its poses are kept.
#[derive(Clone, Copy, Debug, PartialEq)]
struct ReplaySampling {
    frame_s: f64,
    shown_s: f64,
}

impl ReplaySampling {
    /// What a number of frames shows, rather fewer poses than a shorter replay; `None` if that is
    /// nothing that is worth watching.
    fn within(n_frames: f64) -> Option<Self> {
        let frame_s = (WINDOW_S / n_frames).clamp(FRAMES_S[0], FRAMES_S[1]);
        let shown_s = (n_frames * frame_s).min(WINDOW_S);
        (shown_s >= LEAST_S).then_some(Self { frame_s, shown_s })
    }
}

fn facts_of(
    of: &Reported,
    index: usize,
    conditions: &Conditions,
    sampling: Option<ReplaySampling>,
) -> anyhow::Result<CellFacts> {
    let result = of.result;
    let entry = &result.diagram.cells[index];
    let runs = of.comparison.into_iter().flat_map(|comparison| comparison.bags.iter().enumerate());
    let runs = runs.filter(|(_, run)| run.cell == entry.cell);
    let is_one = result.source.as_measured().is_none();
    let mut worlds = vec![world(of, robots(result, World::Harsher), entry)];
    let measured = result.as_measured.as_ref().filter(|_| !is_one);
    worlds.extend(measured.and_then(|diagram: &PhaseDiagram| {
        Some(world(of, "robots as measured", diagram.find(&entry.cell)?))
    }));
    // The page has no tables, and one plain sensor.
    let (sweep, profile) = (&result.source.sweep, &result.source.profile);
    let is_on_page =
        sweep.controller.is_none() && sweep.world.is_none() && profile.has_one_plain_sensor();
    let of_page = |replicate| is_on_page.then(|| address(&entry.cell, replicate));
    let mut facts = CellFacts {
        name: quantity::of_cell(&entry.cell),
        is_chosen: of.choice.is_some_and(|choice| choice.cell == entry.cell),
        worlds,
        runs: runs.map(|(run, _)| run).collect(),
        replay: None,
        caption: "The sweep has too many cells for a replay of each.".to_owned(),
        address: of_page(0),
    };
    if let Some(sampling) = sampling {
        let typical = Typical::new(of, entry, conditions)?;
        facts.caption = typical.in_words(of, (entry, conditions), sampling);
        facts.address = of_page(typical.replicate);
        facts.replay = Some(typical.replay(conditions, sampling));
    }
    Ok(facts)
}

/// What the page that simulates shows of its sweep: `speed_m_s=0.15&turn_rate_rad_s=0.75&replicate=3`.
fn address(cell: &Cell, replicate: u64) -> String {
    let values = cell.iter().map(|(axis, value)| format!("{axis}={value}&"));
    format!("{}replicate={replicate}", values.collect::<String>())
}

fn world(of: &Reported, name: &str, entry: &DiagramCell) -> WorldFacts {
    let milling = Share::milling(&entry.counts);
    let kind = of.result.source.sweep.interval_kind();
    let interval = kind.interval(milling.hits, milling.n);
    WorldFacts {
        name: name.to_owned(),
        counts: entry.counts,
        interval: [interval.low, interval.high],
    }
}

/// A replicate of a cell that shows what most of them do.
struct Typical {
    replicate: u64,
    phase: Phase,
    trajectory: Trajectory,
}

impl Typical {
    /// The first replicate that ended in the most frequent phase; the first one of all if that phase
    /// is not among the first few.
    fn new(of: &Reported, entry: &DiagramCell, conditions: &Conditions) -> anyhow::Result<Self> {
        let n_tried = entry.counts.total().clamp(1, MOST_TRIED);
        let mut first = None;
        for replicate in 0..n_tried {
            let run = Self::replicate(of, conditions, replicate)
                .with_context(|| entry.cell.to_string())?;
            if Some(run.phase) == entry.counts.majority() {
                return Ok(run);
            }
            first.get_or_insert(run);
        }
        Ok(first.expect("at least one replicate was simulated"))
    }

    fn replicate(of: &Reported, conditions: &Conditions, replicate: u64) -> anyhow::Result<Self> {
        let sweep = &of.result.source.sweep;
        let seed = Seed { seed: sweep.seed, replicate };
        let trajectory = run_episode(conditions, seed, sweep.duration_s)?;
        let rules = conditions.behaviour.rules();
        let phase = label_with(&trajectory, &conditions.bodies(), &rules)?.phase;
        Ok(Self { replicate, phase, trajectory })
    }

    fn in_words(
        &self,
        of: &Reported,
        (entry, conditions): (&DiagramCell, &Conditions),
        sampling: ReplaySampling,
    ) -> String {
        let Self { replicate, phase, .. } = self;
        let which = match entry.counts.majority() {
            Some(most) if most == *phase => "the first one that ended as most did",
            Some(_) | None => "the first one",
        };
        // What was detected follows from the command alone where there are two of them.
        let lights = if conditions.controller.parameters().is_some() {
            "; a robot's sensor lights up while it detects another one"
        } else {
            ""
        };
        format!(
            "Replicate {replicate} of seed {}, {which}: {phase}. The last {:.0} s, again and again{lights}.",
            of.result.source.sweep.seed,
            sampling.shown_s.min(self.trajectory.duration_s())
        )
    }

    fn replay(&self, conditions: &Conditions, sampling: ReplaySampling) -> Replay {
        let Self { phase, trajectory, .. } = self;
        let period_s = trajectory.period_s;
        let n_samples = trajectory.n_samples();
        let first_shown = n_samples.saturating_sub(samples_in(sampling.shown_s, period_s));
        let first_judged = n_samples.saturating_sub(samples_in(WINDOW_S, period_s));
        Replay::new(&Shown {
            trajectory,
            conditions,
            robots: (1..=trajectory.n_robots).map(|robot| format!("robot_{robot}")).collect(),
            samples: first_shown..n_samples,
            every: samples_at_least(sampling.frame_s, period_s),
            ring: ring_of(*phase, trajectory, first_judged),
            lost: Vec::new(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fewer_poses_come_before_a_shorter_replay_and_nothing_last() {
        let sampling =
            |n_cells: f64| ReplaySampling::within(400_000.0 / n_cells / bytes_per_frame(9, 0));

        assert_eq!(sampling(10.0), Some(ReplaySampling { frame_s: 0.4, shown_s: WINDOW_S }));
        let coarse = sampling(70.0).unwrap();
        assert!(coarse.frame_s > 0.55 && (coarse.shown_s - WINDOW_S).abs() < 1e-9, "{coarse:?}");
        let short = sampling(200.0).unwrap();
        assert!(short.frame_s > 1.0 && short.shown_s < 40.0, "{short:?}");
        assert_eq!(sampling(5000.0), None);
    }
}
