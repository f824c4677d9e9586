//! Verdicts that no result of the runs that were left out could undo.
//!
//! A run may be left out, or repeated, for a cause after its start: a robot or its poses were lost, or
//! somebody stopped it. That may be what the swarm did: one that disperses leaves the tracker's view.
//! What such a run would have come to is unknown, so a verdict stands only if it stands whatever that
//! was.

use crate::comparison::{CellRuns, Comparison, Verdict};
use crate::judge::behaviour::Behaviour;
use crate::judge::phase::Phase;
use crate::quantity::Cell;

/// A cell with its runs, and how many more were left out after their start.
#[derive(Clone, Debug, PartialEq)]
pub struct CellAttempts {
    /// The cell, with the runs that count.
    pub runs: CellRuns,
    /// Runs that were left out for a cause after their start.
    pub n_left_out: u64,
}

/// What follows from the runs that count, and from all that were begun.
#[derive(Clone, Debug, PartialEq)]
pub struct Attempts {
    /// The runs that count alone.
    pub counted: Comparison,
    /// All, as if none of those that were left out had ended in the wanted phase.
    pub if_none: Comparison,
    /// All, as if every one of them had.
    pub if_all: Comparison,
    /// The cells behind each of the three, in that order.
    pub cells: [Vec<CellRuns>; 3],
}

impl Attempts {
    /// Compares real runs with simulated ones, as [`Comparison::with_margin`] does.
    pub fn with_margin(cells: &[CellAttempts], margin: f64) -> Self {
        let counted = cells.iter().map(|cell| cell.runs.clone());
        let counted: Vec<CellRuns> = counted.filter(|runs| runs.real.total() > 0).collect();
        let all = |ended_in: fn(Behaviour) -> Phase| -> Vec<CellRuns> {
            let filled = cells.iter().map(|cell| cell.with_left_out(ended_in));
            filled.filter(|runs| runs.real.total() > 0).collect()
        };
        let cells = [counted, all(furthest), all(Behaviour::wanted)];
        let [counted, if_none, if_all] =
            cells.each_ref().map(|cells| Comparison::with_margin(cells, margin));
        Self { counted, if_none, if_all, cells }
    }

    /// What follows whatever the runs that were left out would have come to.
    pub fn verdict(&self) -> Verdict {
        self.unless_undone(|comparison| Some(comparison.verdict))
    }

    /// The same for one cell by itself.
    pub fn verdict_of(&self, cell: &Cell) -> Verdict {
        self.unless_undone(|comparison| {
            let found = comparison.cells.iter().find(|compared| compared.cell == *cell)?;
            Some(found.verdict)
        })
    }

    /// The comparison from which it follows what to do next, with its cells: the one that holds a verdict
    /// back, where one does.
    pub fn deciding(&self) -> (&Comparison, &[CellRuns]) {
        let is_undone = self.verdict() != self.counted.verdict;
        match self.counted.verdict {
            Verdict::Supported if is_undone => (&self.if_none, &self.cells[1]),
            Verdict::Violated if is_undone => (&self.if_all, &self.cells[2]),
            _ => (&self.counted, &self.cells[0]),
        }
    }

    fn unless_undone(&self, verdict: impl Fn(&Comparison) -> Option<Verdict>) -> Verdict {
        let of_counted = verdict(&self.counted).unwrap_or(Verdict::Undecided);
        let worst = match of_counted {
            Verdict::Supported => verdict(&self.if_none),
            Verdict::Violated => verdict(&self.if_all),
            Verdict::Undecided | Verdict::NoClaim => return of_counted,
        };
        worst.filter(|worst| *worst == of_counted).unwrap_or(Verdict::Undecided)
    }
}

impl CellAttempts {
    /// The runs, as if all that were left out had ended in one phase of the behaviour.
    fn with_left_out(&self, ended_in: fn(Behaviour) -> Phase) -> CellRuns {
        let mut real = self.runs.real;
        real.add_many(ended_in(self.runs.simulated.behaviour()), self.n_left_out);
        CellRuns { real, ..self.runs.clone() }
    }
}

/// The phase furthest from the wanted one.
fn furthest(behaviour: Behaviour) -> Phase {
    let phases = behaviour.phases();
    phases[phases.len() - 1]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::judge::counts::PhaseCounts;
    use crate::quantity::Axis;

    fn cell(speed_m_s: f64, [mills, others]: [u64; 2], n_left_out: u64) -> CellAttempts {
        let counts = |mills, others| {
            let mut counts = PhaseCounts::default();
            counts.add_many(Phase::STABLE_MILLING, mills);
            counts.add_many(Phase::DISPERSION, others);
            counts
        };
        let cell = Cell::new([(Axis::Speed, speed_m_s)]).unwrap();
        let (real, simulated) = (counts(mills, others), counts(950, 50));
        let runs = CellRuns { cell, real, simulated, part: 0.5 };
        CellAttempts { runs, n_left_out }
    }

    fn attempts(cells: &[CellAttempts]) -> Attempts {
        Attempts::with_margin(cells, 0.1)
    }

    #[test]
    fn without_runs_that_were_left_out_the_verdict_is_that_of_the_runs() {
        for counted in [[40, 0], [3, 0], [0, 4]] {
            let attempts = attempts(&[cell(0.1, counted, 0)]);

            assert_eq!(attempts.verdict(), attempts.counted.verdict);
            assert_eq!(attempts.if_none, attempts.counted);
            assert_eq!(attempts.if_all, attempts.counted);
        }
    }

    #[test]
    fn support_stands_only_if_it_does_with_every_run_that_was_left_out_counted_as_not_milling() {
        let one = attempts(&[cell(0.1, [60, 0], 1)]);
        let ten = attempts(&[cell(0.1, [60, 0], 10)]);

        assert_eq!((one.counted.verdict, one.verdict()), (Verdict::Supported, Verdict::Supported));
        assert_eq!((ten.counted.verdict, ten.verdict()), (Verdict::Supported, Verdict::Undecided));
        assert_eq!(ten.if_none.verdict, Verdict::Undecided);
        assert_eq!(ten.deciding().0, &ten.if_none);
        assert_eq!(ten.verdict_of(&ten.counted.cells[0].cell), Verdict::Undecided);
    }

    #[test]
    fn a_violation_stands_only_if_it_does_with_every_run_that_was_left_out_counted_as_milling() {
        let few = attempts(&[cell(0.1, [0, 6], 1)]);
        let many = attempts(&[cell(0.1, [0, 2], 30)]);

        assert_eq!((few.counted.verdict, few.verdict()), (Verdict::Violated, Verdict::Violated));
        assert_eq!((many.counted.verdict, many.verdict()), (Verdict::Violated, Verdict::Undecided));
        assert_eq!(many.deciding().0, &many.if_all);
    }

    #[test]
    fn runs_that_were_left_out_never_decide_by_themselves() {
        let attempts = attempts(&[cell(0.1, [2, 0], 0), cell(0.2, [0, 0], 40)]);

        assert_eq!(attempts.verdict(), Verdict::Undecided);
        assert_eq!(attempts.counted.cells.len(), 1, "a cell without a run that counts is none");
        assert_eq!(attempts.if_none.cells.len(), 2);
    }
}
