//! A comparison as a person reads it.

use std::fmt::{Display, Formatter, Result};

use rsrs_core::comparison::{MARGIN, SIGNIFICANCE, SUPPORT, Tally, Verdict};
use rsrs_core::diagram::PhaseCounts;
use rsrs_core::next_experiment::{DECIDES, MOST_RUNS, NextStep};
use rsrs_core::phase::Phase;

use super::{ComparedCell, Report, counted};
use crate::human_labels::JUDGE;

impl Display for Report {
    fn fmt(&self, formatter: &mut Formatter<'_>) -> Result {
        writeln!(formatter, "claim: real robots mill at least as often as simulated ones")?;
        if self.labels != JUDGE {
            writeln!(
                formatter,
                "labels: {}, against simulated runs labelled by the judge",
                self.labels
            )?;
        }
        for cell in &self.cells {
            self.write_cell(cell, formatter)?;
        }
        if !self.cells.is_empty() {
            let Tally { same, easier, harder } = self.tally;
            writeln!(
                formatter,
                "run by run: {same} ended as most simulated runs did, {easier} closer to stable \
                 milling, {harder} further from it"
            )?;
        }
        for run in &self.not_counted {
            let bag = run.bag.display();
            writeln!(formatter, "not counted: {bag} ({}: {})", run.ending, run.reason)?;
        }
        for note in &self.notes {
            writeln!(formatter, "note: {note}")?;
        }
        writeln!(formatter, "{}", self.verdict_in_words())?;
        write!(formatter, "next: {}", self.next_in_words())
    }
}

impl ComparedCell {
    /// What follows from its runs, in a word.
    pub fn verdict_in_a_word(&self) -> &'static str {
        word(self.verdict)
    }
}

impl Report {
    /// What follows from all runs.
    pub fn verdict_in_words(&self) -> String {
        format!("verdict: {} ({})", word(self.verdict), self.summary)
    }

    /// What to do next.
    pub fn next_in_words(&self) -> String {
        match &self.next {
            NextStep::ReturnToStep1 { cell, b_r, b_s, .. } => format!(
                "return to step 1 (`rsrs measure plan`): at {cell} {:.1} % of real and {:.1} % of simulated \
                 runs mill, so the simulated robots are not worse than the real ones",
                100.0 * b_r,
                100.0 * b_s
            ),
            NextStep::Run(experiment) => {
                let cell = &experiment.cell;
                let runs = match experiment.runs {
                    Some(n) => format!(
                        "{} there decide with a probability of {DECIDES}",
                        counted(n, "further real run")
                    ),
                    None => format!("not even {MOST_RUNS} there would be sure to decide"),
                };
                format!(
                    "`rsrs run EXPERIMENT --from SWEEP --cell {cell}`, where one run tells most ({:.3} bit); {runs}",
                    experiment.information_bits
                )
            }
            NextStep::Nothing => "no further run in a swept cell would tell more".to_owned(),
        }
    }

    fn write_cell(&self, cell: &ComparedCell, formatter: &mut Formatter<'_>) -> Result {
        writeln!(formatter, "{}", cell.cell)?;
        let real = share([cell.b_r, cell.b_r_low, cell.b_r_high], (&cell.real, "run"));
        writeln!(formatter, "  real       {real}")?;
        for bag in self.bags.iter().filter(|bag| bag.cell == cell.cell) {
            writeln!(formatter, "    {}: {}", bag.labelled.bag.display(), bag.labelled.phase)?;
        }
        let which = if cell.is_confirmed { "fresh run" } else { "run" };
        let simulated = share([cell.b_s, cell.b_s_low, cell.b_s_high], (&cell.simulated, which));
        writeln!(formatter, "  simulated  {simulated}")?;
        write_chances(cell, formatter)?;
        write!(formatter, "  {}", word(cell.verdict))?;
        if let Some(n) = cell.further_runs {
            let runs = counted(n, "further real run");
            write!(formatter, ": {runs} would support the claim if every one of them mills")?;
        }
        writeln!(formatter)
    }
}

fn write_chances(cell: &ComparedCell, formatter: &mut Formatter<'_>) -> Result {
    let corrected = if cell.p_corrected > cell.p_value {
        format!(", {} corrected for the number of cells", chance(cell.p_corrected))
    } else {
        String::new()
    };
    writeln!(
        formatter,
        "  chance of so few real mills if both mill equally often: {}{corrected} (below \
         {SIGNIFICANCE} violates the claim)",
        chance(cell.p_value)
    )?;
    writeln!(
        formatter,
        "  chance that real robots mill as often, or at most {:.0} percentage points less often: {} ({SUPPORT} \
         supports it)",
        100.0 * MARGIN,
        chance(cell.p_supported)
    )
}

/// How often a cell mills, and what else came of it.
fn share(percents: [f64; 3], (phases, run): (&PhaseCounts, &str)) -> String {
    let [share, low, high] = percents.map(|share| 100.0 * share);
    let others: Vec<String> = Phase::ALL
        .into_iter()
        .filter(|phase| *phase != Phase::StableMilling && phases.get(*phase) > 0)
        .map(|phase| format!("{} {phase}", phases.get(phase)))
        .collect();
    let others = if others.is_empty() {
        String::new()
    } else {
        format!("; otherwise {}", others.join(", "))
    };
    format!(
        "{} of {} milled: {share:.1} % (95 % interval {low:.1} to {high:.1} %){others}",
        phases.get(Phase::StableMilling),
        counted(phases.total(), run)
    )
}

fn chance(probability: f64) -> String {
    if probability < 0.001 { "under 0.001".to_owned() } else { format!("{probability:.3}") }
}

fn word(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::Violated => "violated",
        Verdict::Supported => "supported",
        Verdict::Undecided => "undecided",
    }
}
