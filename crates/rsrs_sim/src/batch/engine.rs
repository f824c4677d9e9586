//! Runs and judges many replicates on one vector unit.

use rsrs_core::conditions::Conditions;
use rsrs_core::order::Evidence;
use rsrs_core::phase::{BLOCK_S, Phase, Thresholds, Verdict, WINDOW_S, lasting, samples_in};
use rsrs_core::trajectory::Bodies;

use super::Judged;
use super::approximate_judge::{Answer, ApproximateJudge, Memory};
use super::converging::{AROUND, Converging, lanes};
use super::evidence::{Commanded, Scratch, Window, gather};
use super::rows::Rows;
use super::swarms::Swarms;
use crate::draw::RunKey;
use crate::placement::PlacementError;
use crate::vector::simd::{Number, Simd};

/// One vector unit with its memory.
pub trait Engine: Send {
    /// Replicates that are run at once.
    fn lanes(&self) -> usize;

    /// Runs and judges replicates of one cell.
    ///
    /// # Arguments
    ///
    /// * `conditions` — as [`super::can_run`] asks.
    /// * `runs` — one to [`Self::lanes`] replicates.
    ///
    /// # Returns
    ///
    /// One entry for each replicate; `None` if a number did not stay finite.
    fn judge(
        &mut self,
        conditions: &Conditions,
        runs: &[RunKey],
        duration_s: f64,
    ) -> Result<Option<Vec<Judged>>, PlacementError>;

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
}

/// The engine of a vector unit.
pub struct UnitEngine<S: Simd> {
    simd: S,
    rows: Rows<S::F>,
    scratch: Scratch<S>,
    memory: Memory<S>,
    commanded: Option<(CommandKey, [Commanded; 2])>,
}

/// What the sums of commands depend on.
#[derive(Clone, Copy, PartialEq)]
struct CommandKey {
    told: (f64, f64),
    period_s: f64,
    n_robots: usize,
}

impl<S: Simd> UnitEngine<S> {
    /// The engine of this unit.
    pub fn new(simd: S) -> Self {
        Self {
            simd,
            rows: Rows::new(),
            scratch: Scratch::new(simd),
            memory: Memory::new(),
            commanded: None,
        }
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

    /// What is commanded in a window and in a block.
    fn commanded(&mut self, conditions: &Conditions) -> [Commanded; 2] {
        let controller = conditions.controller;
        let key = CommandKey {
            told: (controller.speed_m_s, controller.turn_rate_rad_s),
            period_s: conditions.period_s,
            n_robots: conditions.robots,
        };
        match self.commanded {
            Some((known, commanded)) if known == key => commanded,
            _ => {
                let commanded = [WINDOW_S, BLOCK_S].map(|time_s| {
                    let n_samples = samples_in(time_s, key.period_s);
                    Commanded::new(key.told, key.period_s, (n_samples, key.n_robots))
                });
                self.commanded = Some((key, commanded));
                commanded
            }
        }
    }

    /// Whether all places and headings in the last row are finite. What is not finite once never
    /// becomes so again, but for a place that walls hold.
    fn is_finite(&self, step: u64) -> bool {
        self.rows.at(step).iter().all(|body| {
            let sum = body.x_m + body.y_m + body.cosine + body.sine;
            (0..S::LANES).all(|lane| sum.lane(lane).is_finite())
        })
    }

    /// Which of the lanes `open` were stable mills in the block that begins at a sample, as bits.
    fn good(&mut self, start: u64, open: u32, around: &Around) -> u32 {
        let simd = self.simd;
        let window = Window {
            rows: &self.rows,
            start,
            end: start + around.n_block,
            commanded: &around.commanded[1],
            bodies: around.bodies,
        };
        let memory = &mut self.memory;
        let answers = simd.vectorize(ApproximateJudge { simd, window, open, memory });
        let mut exact: Option<Vec<Evidence>> = None;
        lanes(open).fold(0, |good, lane| {
            let is_good = match answers[lane] {
                Answer::Yes => true,
                Answer::No => false,
                Answer::Unclear => {
                    let gather = || gather(simd, window, &mut self.scratch, 0..S::LANES);
                    let evidence = &exact.get_or_insert_with(gather)[lane];
                    Thresholds::default().is_stable(evidence)
                }
            };
            good | u32::from(is_good) << lane
        })
    }
}

impl<S: Simd> UnitEngine<S> {
    /// The phases of all lanes; those of stable mills are asked of their blocks, too.
    ///
    /// # Arguments
    ///
    /// * `start`, `n_window` — the window.
    fn phases(
        &mut self,
        evidence: &[Evidence],
        (start, n_window): (u64, u64),
        around: &Around,
    ) -> Vec<Phase> {
        let thresholds = Thresholds::default();
        let mut phases: Vec<Phase> =
            evidence.iter().map(|evidence| thresholds.phase(evidence)).collect();
        let is_stable = |phase: &Phase| *phase == Phase::StableMilling;
        let stable = phases
            .iter()
            .enumerate()
            .fold(0, |bits, (lane, phase)| bits | u32::from(is_stable(phase)) << lane);
        if stable == 0 {
            return phases;
        }
        let n_block = around.n_block.min(n_window);
        let n_blocks = n_window / n_block;
        let mut n_good = vec![0; phases.len()];
        for block in 0..n_blocks {
            for lane in lanes(self.good(start + block * n_block, stable, around)) {
                n_good[lane] += 1;
            }
        }
        for lane in lanes(stable) {
            phases[lane] = lasting(phases[lane], (n_good[lane], n_blocks as usize));
        }
        phases
    }
}

/// What a run is judged by.
struct Around {
    bodies: Bodies,
    n_block: u64,
    commanded: [Commanded; 2],
}

impl<S: Simd> Engine for UnitEngine<S> {
    fn lanes(&self) -> usize {
        S::LANES
    }

    fn judge(
        &mut self,
        conditions: &Conditions,
        runs: &[RunKey],
        duration_s: f64,
    ) -> Result<Option<Vec<Judged>>, PlacementError> {
        let n_samples = conditions.steps(duration_s);
        let n_window = samples_in(WINDOW_S, conditions.period_s);
        let n_block = samples_in(BLOCK_S, conditions.period_s) as u64;
        let n_rows = n_window.max((2 * AROUND + 1) as usize * n_block as usize).max(2);
        let mut swarms = self.place(conditions, runs, n_rows)?;
        let commanded = self.commanded(conditions);
        let around = Around { bodies: conditions.bodies(), n_block, commanded };
        let mut converging = Converging::new(runs.len());
        let n_blocks = n_samples / n_block;
        for asked in Converging::asked(n_blocks) {
            let end = (asked + AROUND + 1).min(n_blocks) * n_block;
            swarms.run(&mut self.rows, end - 1 - swarms.step_index());
            let good = |block, open| self.good(block * n_block, open, &around);
            converging.search(asked, n_blocks, good);
            if converging.open() == 0 {
                break;
            }
        }
        swarms.run(&mut self.rows, n_samples - 1 - swarms.step_index());
        if !self.is_finite(n_samples - 1) {
            return Ok(None);
        }
        let window = Window {
            rows: &self.rows,
            start: n_samples - n_window as u64,
            end: n_samples,
            commanded: &around.commanded[0],
            bodies: around.bodies,
        };
        let start = window.start;
        let evidence = gather(self.simd, window, &mut self.scratch, 0..runs.len());
        let phases = self.phases(&evidence, (start, n_window as u64), &around);
        let judged = (evidence.into_iter().zip(phases).zip(converging.first_blocks())).map(
            |((evidence, phase), first_block)| {
                let duration_s = n_samples as f64 * conditions.period_s;
                let verdict = Verdict { phase, evidence, n_robots: conditions.robots, duration_s };
                let converged_s = first_block
                    .filter(|_| phase == Phase::StableMilling)
                    .map(|block| (block * n_block) as f64 * conditions.period_s);
                Judged { verdict, converged_s }
            },
        );
        Ok(Some(judged.collect()))
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
}
