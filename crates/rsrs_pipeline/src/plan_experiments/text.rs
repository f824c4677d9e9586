//! A plan of experiments as a person reads it.

use std::fmt;

use rsrs_core::comparison::experiment_plan::Decided;
use rsrs_core::comparison::fixed::FixedPlan;
use rsrs_core::judge::behaviour::Behaviour;

use super::fixed::PlannedCampaign;
use super::{PlannedExperiments, PlannedRuns};
use crate::wording::{columns, count, counted, percent};

/// So many lines of the table show how the probability grows.
const LINES: usize = 8;

impl fmt::Display for PlannedExperiments {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let last = self.by_runs.last().expect("at least one run is planned");
        match self.runs {
            Some(runs) => writeln!(
                formatter,
                "{} decide {} with a probability of {}, if the robots are as measured",
                counted(runs, "run"),
                self.claim(),
                percent(last.decided)
            )?,
            None => writeln!(
                formatter,
                "not even {} decide {} with a probability of {}, if the robots are as measured: it is {}",
                counted(last.runs, "run"),
                self.claim(),
                percent(self.wanted),
                percent(last.decided)
            )?,
        }
        let cells: Vec<[String; 4]> = self.cells.iter().map(PlannedRuns::row).collect();
        writeln!(formatter, "\n{}", columns(&cells))?;
        let mut rows = vec![["runs", "decided", "supported", "violated"].map(str::to_owned)];
        rows.extend(self.shown().iter().map(row));
        writeln!(formatter, "\n{}", columns(&rows))?;
        write!(
            formatter,
            "\ncompare after every run, and stop as soon as it is decided: on average after {:.0}",
            self.mean_runs
        )?;
        for note in &self.notes {
            write!(formatter, "\nnote: {note}")?;
        }
        Ok(())
    }
}

/// What runs decide.
fn claim(behaviour: Behaviour, margin: f64) -> String {
    format!(
        "whether real robots {} as often as simulated ones, or at most {:.0} percentage points less often \
         (`B_r ≥ B_s − {margin}`),",
        behaviour.verb().plain,
        100.0 * margin
    )
}

impl PlannedExperiments {
    fn claim(&self) -> String {
        claim(self.behaviour, self.margin)
    }

    /// Some of the numbers of runs, evenly spaced, the last one among them.
    fn shown(&self) -> Vec<Decided> {
        let step = self.by_runs.len().div_ceil(LINES);
        let mut shown: Vec<Decided> = self.by_runs.iter().rev().step_by(step).copied().collect();
        shown.reverse();
        shown
    }
}

impl fmt::Display for PlannedCampaign {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let FixedPlan { test, decided, supported, violated, .. } = &self.plan;
        let (runs, claim) = (counted(self.runs, "run"), claim(self.behaviour, self.margin));
        let (not, chance) = if self.is_enough() {
            ("", percent(*decided))
        } else {
            ("not even ", format!("{}: it is {}", percent(self.wanted), percent(*decided)))
        };
        writeln!(
            formatter,
            "{not}{runs}, their number fixed before the first, decide {claim} with a probability of \
             {chance}, if the robots are as measured"
        )?;
        let cells: Vec<[String; 4]> = self.cells.iter().map(PlannedRuns::row).collect();
        writeln!(formatter, "\n{}", columns(&cells))?;
        let did = self.behaviour.verb().did;
        match test.supported_from {
            Some(least) => writeln!(
                formatter,
                "\nsupported if {least} or more {did} (probability {})",
                percent(*supported)
            )?,
            None => writeln!(formatter, "\nno number of them supports the claim")?,
        }
        match test.violated_up_to {
            Some(most) => {
                write!(
                    formatter,
                    "violated if {most} or fewer did (probability {})",
                    percent(*violated)
                )?;
            }
            None => write!(formatter, "no number of them violates it")?,
        }
        for note in &self.notes {
            write!(formatter, "\nnote: {note}")?;
        }
        Ok(())
    }
}

impl PlannedRuns {
    fn row(&self) -> [String; 4] {
        [
            format!("  {}", self.cell),
            self.runs.map_or_else(String::new, |runs| counted(runs, "run")),
            format!("B_s {} of {}", percent(self.b_s), count(self.n_simulated)),
            format!("as measured {} of {}", percent(self.b_m), count(self.n_as_measured)),
        ]
    }
}

fn row(decided: &Decided) -> [String; 4] {
    let Decided { runs, decided, supported, violated } = decided;
    [count(*runs), percent(*decided), percent(*supported), percent(*violated)]
}
