//! Runs and judges many replicates on one vector unit.

use rsrs_core::conditions::Conditions;
use rsrs_core::judge::behaviour::rule::Rules;
use rsrs_core::judge::number::Number;
use rsrs_core::judge::phase::{JudgedWindow, Verdict};

use super::judge::{Commands, LookAtEnd, Past};
use super::outside::{Lanes, UnitLanes};
use super::rows::Rows;
use super::swarms::Swarms;
use crate::draw::RunKey;
use crate::placement::PlacementError;
use crate::vector::simd::Simd;

/// One vector unit with its memory.
pub trait Engine: Send {
    /// Replicates that are run at once.
    fn lanes(&self) -> usize;

    /// Runs and judges one to [`Self::lanes`] replicates of one cell, with conditions as
    /// [`super::runs_in_lanes`] asks; `None` if a number did not stay finite.
    fn judge(
        &mut self,
        of: (&Conditions, &Rules),
        runs: &[RunKey],
        duration_s: f64,
    ) -> Result<Option<Vec<Verdict>>, PlacementError>;

    /// The digests of all states before each of so many steps; shape `[n_runs][n_steps]`.
    fn digests(
        &mut self,
        conditions: &Conditions,
        runs: &[RunKey],
        n_steps: u64,
    ) -> Result<Vec<Vec<u64>>, PlacementError>;

    /// Makes steps and looks at nothing.
    fn step_only(
        &mut self,
        conditions: &Conditions,
        runs: &[RunKey],
        n_steps: u64,
    ) -> Result<(), PlacementError>;

    /// Worlds of one to [`Self::lanes`] replicates that take commands from outside.
    fn commanded(
        &self,
        conditions: &Conditions,
        runs: &[RunKey],
    ) -> Result<Box<dyn Lanes>, PlacementError>;
}

/// The engine of a vector unit.
pub struct UnitEngine<S: Simd> {
    simd: S,
    rows: Rows<S::F>,
    /// Those of the cell that was judged last.
    commands: Option<Commands>,
}

impl<S: Simd> UnitEngine<S> {
    /// The engine of this unit.
    pub fn new(simd: S) -> Self {
        Self { simd, rows: Rows::new(), commands: None }
    }

    fn place(
        &mut self,
        conditions: &Conditions,
        runs: &[RunKey],
        n_rows: usize,
    ) -> Result<Swarms<S>, PlacementError> {
        assert!((1..=S::LANES).contains(&runs.len()), "a lane for each run");
        self.rows.resize(conditions.robots, n_rows, self.simd.single(0.0));
        Swarms::new(self.simd, conditions, runs, &mut self.rows)
    }

    /// Whether all places and headings in the last row are finite. What is not finite once never
    /// becomes so again, but for a place that walls hold.
    fn is_finite(&self, step: u64) -> bool {
        self.rows.at(step).iter().all(|body| {
            let sum = body.x_m + body.y_m + body.cosine + body.sine;
            (0..S::LANES).all(|lane| sum.lane(lane).is_finite())
        })
    }
}

impl<S: Simd> Engine for UnitEngine<S> {
    fn lanes(&self) -> usize {
        S::LANES
    }

    fn judge(
        &mut self,
        (conditions, rules): (&Conditions, &Rules),
        runs: &[RunKey],
        duration_s: f64,
    ) -> Result<Option<Vec<Verdict>>, PlacementError> {
        let n_samples = conditions.steps(duration_s);
        let (n_all, period_s) = (n_samples as usize, conditions.period_s);
        let n_window = rules.window.n_samples(n_all, period_s);
        let known = self.commands.take().filter(|commands| commands.are_of(conditions, n_window));
        let commands = known.unwrap_or_else(|| Commands::new(conditions, n_window));
        // What the last sample detects is part of it, and found out by one more step.
        let n_more = usize::from(commands.vary);
        let mut swarms =
            self.place(conditions, runs, rules.window.n_needed(n_all, period_s).max(2) + n_more)?;
        if commands.vary {
            self.rows.keep_detections(self.simd.no());
        }
        swarms.run(&mut self.rows, n_samples - 1 + n_more as u64);
        if !self.is_finite(n_samples - 1) {
            return Ok(None);
        }
        let commands = &*self.commands.insert(commands);
        let (simd, bodies) = (self.simd, conditions.bodies());
        let past = Past { simd, rows: &self.rows, commands, bodies: &bodies };
        let look = LookAtEnd { past, n_samples: n_all, rules, n_lanes: runs.len() };
        let verdict = |window: JudgedWindow| Verdict {
            phase: window.phase,
            evidence: window.whole,
            blocks: window.blocks,
            n_robots: conditions.robots,
            duration_s: n_samples as f64 * conditions.period_s,
        };
        Ok(Some(simd.vectorize(look).into_iter().map(verdict).collect()))
    }

    fn digests(
        &mut self,
        conditions: &Conditions,
        runs: &[RunKey],
        n_steps: u64,
    ) -> Result<Vec<Vec<u64>>, PlacementError> {
        let mut swarms = self.place(conditions, runs, 2)?;
        let mut digests = vec![Vec::with_capacity(n_steps as usize); runs.len()];
        for _ in 0..n_steps {
            for (lane, digests) in digests.iter_mut().enumerate() {
                digests.push(swarms.digest(&self.rows, lane));
            }
            swarms.run(&mut self.rows, 1);
        }
        Ok(digests)
    }

    fn step_only(
        &mut self,
        conditions: &Conditions,
        runs: &[RunKey],
        n_steps: u64,
    ) -> Result<(), PlacementError> {
        self.place(conditions, runs, 2)?.run(&mut self.rows, n_steps);
        Ok(())
    }

    fn commanded(
        &self,
        conditions: &Conditions,
        runs: &[RunKey],
    ) -> Result<Box<dyn Lanes>, PlacementError> {
        Ok(Box::new(UnitLanes::new(self.simd, conditions, runs)?))
    }
}
