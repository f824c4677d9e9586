//! A comparison as a person reads it.

use std::fmt::{Display, Formatter, Result};

use rsrs_core::comparison::fixed::FixedTest;
use rsrs_core::comparison::next_experiment::{Experiment, NextStep};
use rsrs_core::comparison::{MOST_RUNS, SIGNIFICANCE, Tally, Verdict};
use rsrs_core::judge::behaviour::Verb;
use rsrs_core::judge::counts::PhaseCounts;
use rsrs_core::statistics::pooled::Pooled;

use super::{
    ComparedCell, LeftOut, Report, as_often, counted, less_often, runs_that_claim, supported_share,
};
use crate::compare::fixed::FixedCampaign;
use crate::label::human_labels::JUDGE;

impl Display for Report {
    fn fmt(&self, formatter: &mut Formatter<'_>) -> Result {
        let mill = self.verb().plain;
        writeln!(formatter, "claim: real robots {mill} at least as often as simulated ones")?;
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
            self.write_pooled(formatter)?;
            let Tally { same, easier, harder } = self.tally;
            let wanted = self.behaviour().wanted();
            writeln!(
                formatter,
                "run by run: {same} ended as most simulated runs did, {easier} closer to {wanted}, \
                 {harder} further from it"
            )?;
        }
        for run in &self.not_counted {
            let bag = run.bag.display();
            writeln!(formatter, "not counted: {bag} ({}: {})", run.cause, run.reason)?;
        }
        for note in &self.notes {
            writeln!(formatter, "note: {note}")?;
        }
        if let Some(left_out) = &self.left_out {
            writeln!(formatter, "{}", self.left_out_in_words(left_out))?;
        }
        writeln!(formatter, "{}", self.verdict_in_words())?;
        let [what, why] = self.next_in_words();
        write!(formatter, "next: {what}\n  {why}")
    }
}

impl ComparedCell {
    /// What follows from its runs, in a word.
    pub fn verdict_in_a_word(&self) -> &'static str {
        word(self.verdict)
    }
}

impl Report {
    /// What follows from all runs, in a word.
    pub fn verdict_in_a_word(&self) -> &'static str {
        word(self.verdict)
    }

    /// What follows from all runs.
    pub fn verdict_in_words(&self) -> String {
        format!("verdict: {} ({})", word(self.verdict), self.reason_in_words())
    }

    /// What the verdict would be with the runs that were left out after their start.
    fn left_out_in_words(&self, left_out: &LeftOut) -> String {
        let LeftOut { bags, verdict_without, verdict_if_none_milled, verdict_if_all_milled } =
            left_out;
        let bags: Vec<String> = bags.iter().map(|bag| bag.display().to_string()).collect();
        let (count, did) = (counted(bags.len() as u64, "run"), self.verb().did);
        format!(
            "left out after their start, and so perhaps for what the swarm did: {count} ({})\n  without \
             them: {}; if none of them {did}: {}; if every one {did}: {}",
            bags.join(", "),
            word(*verdict_without),
            word(*verdict_if_none_milled),
            word(*verdict_if_all_milled)
        )
    }

    /// What the verdict means or rests on, and how sure it is.
    pub fn reason_in_words(&self) -> String {
        let error = match self.verdict {
            Verdict::Undecided | Verdict::NoClaim => String::new(),
            Verdict::Violated | Verdict::Supported => {
                let when = if self.fixed.is_some() {
                    "at the number of runs that was fixed"
                } else {
                    "however often one looks"
                };
                format!("; reached wrongly with a probability of at most {SIGNIFICANCE}, {when}")
            }
        };
        format!("{}{error}", self.summary)
    }

    /// What to do next, and why.
    pub fn next_in_words(&self) -> [String; 2] {
        let mill = self.verb().plain;
        if let (NextStep::Nothing, Some(fixed)) = (&self.next, &self.fixed) {
            return next_of(fixed);
        }
        match &self.next {
            NextStep::ReturnToStep1 { cell, b_r, b_s, .. } => [
                "rsrs measure plan".to_owned(),
                format!(
                    "back to step 1: at {cell} {:.1} % of real and {:.1} % of simulated runs {mill}, so \
                     the simulated robots are not worse than the real ones",
                    100.0 * b_r,
                    100.0 * b_s
                ),
            ],
            NextStep::Run(experiment) => [
                format!(
                    "rsrs run {} --from {} --cell {} {}",
                    self.at_hand.experiment,
                    self.at_hand.sweep,
                    experiment.cell,
                    self.at_hand.options
                ),
                format!("{}; {}", self.why_there(experiment), runs_that_decide(experiment, mill)),
            ],
            NextStep::Nothing if self.verdict == Verdict::NoClaim => [
                "nothing".to_owned(),
                format!(
                    "in no other swept cell do simulated robots surely {mill} more often than the margin; \
                     sweep where they do"
                ),
            ],
            NextStep::Nothing => [
                "nothing".to_owned(),
                "no further run in a swept cell would add information".to_owned(),
            ],
        }
    }

    /// Why the next run is in its cell.
    fn why_there(&self, experiment: &Experiment) -> String {
        if self.verdict == Verdict::NoClaim {
            let mill = self.verb().plain;
            return format!("there simulated robots {mill} so often that real ones can fall short");
        }
        format!("there one run is most informative ({:.3} bit)", experiment.information_bits)
    }

    fn write_cell(&self, cell: &ComparedCell, formatter: &mut Formatter<'_>) -> Result {
        writeln!(formatter, "{}", cell.cell)?;
        let real = share([cell.b_r, cell.b_r_low, cell.b_r_high], &cell.real, "run");
        writeln!(formatter, "  real       {real}")?;
        for bag in self.bags.iter().filter(|bag| bag.cell == cell.cell) {
            let labelled = &bag.labelled;
            writeln!(formatter, "    {}: {}", labelled.bag.display(), labelled.phase_in_words())?;
        }
        let which = if cell.is_confirmed { "fresh run" } else { "run" };
        let simulated = share([cell.b_s, cell.b_s_low, cell.b_s_high], &cell.simulated, which);
        writeln!(formatter, "  simulated  {simulated}")?;
        writeln!(formatter, "  by itself  {}", by_itself(cell))
    }

    fn write_pooled(&self, formatter: &mut Formatter<'_>) -> Result {
        let pooled = &self.pooled;
        let percentage_points = format!("{:.0} percentage points", 100.0 * pooled.margin);
        let decides = 1.0 / SIGNIFICANCE;
        let Verb { plain: mill, did: milled, .. } = self.verb();
        writeln!(
            formatter,
            "all runs: {} of {} {milled}, {:.1} expected if real robots {mill} as often as simulated ones",
            pooled.n_milled,
            counted(pooled.n_real, "run"),
            pooled.n_expected
        )?;
        if let Some(fixed) = &self.fixed {
            return writeln!(formatter, "  {}", that_decides(fixed, pooled.margin, milled));
        }
        writeln!(
            formatter,
            "  evidence that they {mill} less often: {} (from {decides} on the claim is violated)",
            evidence(pooled.e_violated)
        )?;
        let Some(e_supported) = pooled.e_supported else {
            return writeln!(
                formatter,
                "  nothing is claimed that they could fall short of by {percentage_points}"
            );
        };
        writeln!(
            formatter,
            "  evidence that they {mill} as often, or at most {percentage_points} less often, in {}: {} (from \
             {decides} on the claim is supported)",
            runs_that_claim(pooled),
            evidence(e_supported)
        )?;
        let short = pooled.shortfall_at_most.map_or_else(
            || format!("how much less often they may {mill} is not bounded"),
            |short| {
                format!("they {mill} less often by at most {:.0} percentage points", 100.0 * short)
            },
        );
        writeln!(formatter, "  as far as these show, {short}; {}", supported_share(pooled))
    }
}

/// What a campaign shows whose number of runs was fixed.
pub(super) fn of_fixed(fixed: &FixedCampaign, verb: Verb, pooled: &Pooled) -> String {
    let (mill, margin) = (verb.plain, 100.0 * pooled.margin);
    match fixed.verdict {
        _ if fixed.made < fixed.runs => format!(
            "{} of the {} runs are made that were fixed before the first, and there is no verdict before \
             the last",
            fixed.made, fixed.runs
        ),
        Verdict::Violated => less_often(mill),
        Verdict::Supported => as_often(pooled, mill),
        Verdict::NoClaim => format!(
            "simulated robots {mill} too rarely for real ones to {mill} less often by {margin:.0} \
             percentage points"
        ),
        Verdict::Undecided => {
            "the runs that were fixed before the first do not decide, and no further ones will"
                .to_owned()
        }
    }
}

/// Which numbers decide a campaign whose number of runs was fixed.
fn that_decides(fixed: &FixedCampaign, margin: f64, milled: &str) -> String {
    let FixedCampaign { runs, left_out, .. } = fixed;
    let design = format!("fixed before the first run: {runs} runs, a margin of {margin}");
    let Some(FixedTest { supported_from, violated_up_to, n_claimed }) = fixed.test else {
        return design;
    };
    let supported = supported_from.map_or_else(
        || "no number supports the claim".to_owned(),
        |least| format!("the claim is supported if {least} or more of {n_claimed} {milled}"),
    );
    let violated = violated_up_to.map_or_else(
        || "none violates it".to_owned(),
        |most| format!("violated if {most} or fewer of {runs} did"),
    );
    let left_out = match left_out {
        0 => String::new(),
        1 => "; one was left out after its start, and is held against either".to_owned(),
        n => format!("; {n} were left out after their start, and are held against either"),
    };
    format!("{design}; {supported}, and {violated}{left_out}")
}

/// What comes after the runs that there are.
fn next_of(fixed: &FixedCampaign) -> [String; 2] {
    if fixed.made < fixed.runs {
        let left = counted(fixed.runs - fixed.made, "run");
        return ["go on with the campaign".to_owned(), format!("{left} of {} left", fixed.runs)];
    }
    let why = "the number of runs was fixed; another campaign is planned and judged by itself";
    ["nothing".to_owned(), why.to_owned()]
}

/// One cell by itself.
fn by_itself(cell: &ComparedCell) -> String {
    let word = word(cell.verdict);
    let verb = cell.simulated.behaviour().verb();
    let mill = verb.plain;
    let less =
        format!("{:.1} % of real and {:.1} % of simulated", 100.0 * cell.b_r, 100.0 * cell.b_s);
    match (cell.verdict, cell.further_runs) {
        (Verdict::Violated, _) => format!("{word}: {less} runs {mill}"),
        (Verdict::Undecided, Some(n)) => format!(
            "{word}: {} would support the claim here if every one of them {}",
            counted(n, "further real run"),
            verb.does
        ),
        (Verdict::NoClaim, _) => {
            format!(
                "{word}: simulated robots {mill} too rarely here for real ones to fall short by the margin"
            )
        }
        (Verdict::Undecided, None) | (Verdict::Supported, _) => word.to_owned(),
    }
}

/// How many runs decide, and how surely.
fn runs_that_decide(experiment: &Experiment, mill: &str) -> String {
    let assumed = match experiment.b_m {
        Some(b_m) => format!(
            "if real robots {mill} as those so far and as simulated ones as measured ({:.1} % of {})",
            100.0 * b_m,
            counted(experiment.n_as_measured, "run")
        ),
        None => format!("if real robots {mill} as those so far"),
    };
    match experiment.runs {
        Some(n) => format!(
            "{} there decide with a probability of {:.2}, {assumed}",
            counted(n, "further real run"),
            experiment.chance
        ),
        None => format!(
            "even {MOST_RUNS} there decide with a probability of {:.2} only, {assumed}: real robots may \
             {mill} less often by about as much as the margin, or too few simulated runs show how often \
             theirs do",
            experiment.chance
        ),
    }
}

/// An e-value as people read it: `25.69`.
pub fn evidence(e_value: f64) -> String {
    match e_value {
        great if great >= 1e4 => "over 10000".to_owned(),
        small if small < 0.01 => "under 0.01".to_owned(),
        e_value => format!("{e_value:.2}"),
    }
}

/// How often a cell mills, and what else came of it.
fn share(percents: [f64; 3], phases: &PhaseCounts, run: &str) -> String {
    let [share, low, high] = percents.map(|share| 100.0 * share);
    let behaviour = phases.behaviour();
    let others: Vec<String> = behaviour.phases()[1..]
        .iter()
        .copied()
        .filter(|phase| phases.get(*phase) > 0)
        .map(|phase| format!("{} {phase}", phases.get(phase)))
        .collect();
    let others = if others.is_empty() {
        String::new()
    } else {
        format!("; otherwise {}", others.join(", "))
    };
    format!(
        "{} of {} {}: {share:.1} % (95 % interval {low:.1} to {high:.1} %){others}",
        phases.wanted(),
        counted(phases.total(), run),
        behaviour.verb().did
    )
}

pub(super) fn word(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::Violated => "violated",
        Verdict::Supported => "supported",
        Verdict::Undecided => "undecided",
        Verdict::NoClaim => "no claim",
    }
}
