//! A comparison as a person reads it.

use rsrs_core::comparison::fixed::FixedTest;
use rsrs_core::comparison::left_out::Attempts;
use rsrs_core::comparison::next_experiment::{Experiment, NextStep};
use rsrs_core::comparison::{CellComparison, MOST_RUNS, SIGNIFICANCE, Tally, Verdict};
use rsrs_core::judge::behaviour::Verb;
use rsrs_core::judge::counts::PhaseCounts;
use rsrs_core::natural_order::natural_key;
use rsrs_core::numerals::{counted, percent, percentage_points, percents};
use rsrs_core::statistics::pooled::Pooled;

use rsrs_files::quoted;
use rsrs_pipeline::compare::at_hand::AtHand;
use rsrs_pipeline::compare::fixed::FixedCampaign;
use rsrs_pipeline::label::human_labels::JUDGE;

use super::notes::cause_in_words;
use super::{ComparedBag, ComparedCell, LeftOut, Report};
use crate::label::phase_of;
use crate::wording::shell::ANY_EXPERIMENT;
use crate::words::{Tone, Words};

/// All of a comparison.
pub fn text(report: &Report) -> Words {
    let mill = report.verb().plain;
    let mut lines: Vec<Words> =
        vec![format!("claim: real robots {mill} at least as often as simulated ones").into()];
    if report.labels != JUDGE {
        let labels = &report.labels;
        lines
            .push(format!("labels: {labels}, against simulated runs labelled by the judge").into());
    }
    lines.extend(report.cells.iter().flat_map(|cell| of_cell(report, cell)));
    if !report.cells.is_empty() {
        lines.extend(of_all(report).into_iter().map(Words::from));
        let Tally { same, easier, harder } = report.tally;
        let wanted = report.behaviour().wanted();
        let tally = format!(
            "run by run: {same} ended as most simulated runs did, {easier} closer to {wanted}, \
             {harder} further from it"
        );
        lines.push(tally.into());
    }
    for run in &report.not_counted {
        let (bag, cause) = (run.bag.display(), cause_in_words(run.cause));
        lines.push(format!("not counted: {bag} ({cause}: {})", run.reason).into());
    }
    lines.extend(report.notes.iter().map(|note| format!("note: {note}").into()));
    lines.extend(report.left_out.iter().map(|left_out| left_out_in_words(report, left_out).into()));
    let verdict = Words::from("verdict: ").then(toned(report.verdict));
    lines.push(verdict.then(format!(" ({})", reason_in_words(report))));
    let [what, why] = next_in_words(report);
    lines.push(format!("next: {what}\n  {why}").into());
    Words::lines(lines)
}

fn toned(verdict: Verdict) -> Words {
    let tone = match verdict {
        Verdict::Supported => Tone::Good,
        Verdict::Undecided | Verdict::NoClaim => Tone::Unclear,
        Verdict::Violated => Tone::Bad,
    };
    Words::toned(tone, verdict_name(verdict))
}

/// What the verdict would be with the runs that were left out after their start.
fn left_out_in_words(report: &Report, left_out: &LeftOut) -> String {
    let LeftOut { bags, verdict_without, verdict_if_none_milled, verdict_if_all_milled } = left_out;
    let bags: Vec<String> = bags.iter().map(|bag| bag.display().to_string()).collect();
    let (count, did) = (counted(bags.len() as u64, "run"), report.verb().did);
    format!(
        "left out after their start, and so perhaps for what the swarm did: {count} ({})\n  without \
         them: {}; if none of them {did}: {}; if every one {did}: {}",
        bags.join(", "),
        verdict_name(*verdict_without),
        verdict_name(*verdict_if_none_milled),
        verdict_name(*verdict_if_all_milled)
    )
}

/// What the verdict means or rests on, and how sure it is.
pub fn reason_in_words(report: &Report) -> String {
    let error = match report.verdict {
        Verdict::Undecided | Verdict::NoClaim => String::new(),
        Verdict::Violated | Verdict::Supported => {
            let when = if report.fixed.is_some() {
                "at the number of runs that was fixed"
            } else {
                "however often one looks"
            };
            format!("; reached wrongly with a probability of at most {SIGNIFICANCE}, {when}")
        }
    };
    format!("{}{error}", report.summary)
}

/// What to do next, and why.
pub fn next_in_words(report: &Report) -> [String; 2] {
    let mill = report.verb().plain;
    if let (NextStep::Nothing, Some(fixed)) = (&report.next, &report.fixed) {
        return next_of(fixed);
    }
    match &report.next {
        NextStep::ReturnToStep1 { cell, b_r, b_s, .. } => [
            "rsrs measure plan".to_owned(),
            format!(
                "back to step 1: at {cell} {} of real and {} of simulated runs {mill}, so \
                 the simulated robots are not worse than the real ones",
                percent(*b_r),
                percent(*b_s)
            ),
        ],
        NextStep::Run(experiment) => [
            command(&report.at_hand, experiment),
            format!("{}; {}", why_there(report, experiment), runs_that_decide(experiment, mill)),
        ],
        NextStep::Nothing if report.verdict == Verdict::NoClaim || report.cells.is_empty() => [
            "nothing".to_owned(),
            format!(
                "in no {}swept cell do simulated robots surely {mill} more often than the margin; \
                 sweep where they do",
                if report.cells.is_empty() { "" } else { "other " }
            ),
        ],
        NextStep::Nothing => [
            "nothing".to_owned(),
            "no further run in a swept cell would add information".to_owned(),
        ],
    }
}

fn why_there(report: &Report, experiment: &Experiment) -> String {
    if report.verdict == Verdict::NoClaim {
        let mill = report.verb().plain;
        return format!("there simulated robots {mill} so often that real ones can fall short");
    }
    if report.cells.is_empty() {
        return "there the fewest runs decide".to_owned();
    }
    format!("there one run is most informative ({:.3} bit)", experiment.information_bits)
}

fn command(at_hand: &AtHand, experiment: &Experiment) -> String {
    let AtHand { experiment: file, sweep, is_on_floor, seed, bag } = at_hand;
    let file = file.as_ref().map_or_else(|| ANY_EXPERIMENT.to_owned(), quoted);
    let options = match (is_on_floor, seed) {
        (true, _) => "--backend fleet --interface NAME ".to_owned(),
        (false, Some(seed)) => format!("--seed {seed} "),
        (false, None) => String::new(),
    };
    format!(
        "rsrs run {file} --from {} --cell {} {options}-o {}",
        quoted(sweep),
        experiment.cell,
        quoted(bag)
    )
}

fn of_cell(report: &Report, cell: &ComparedCell) -> Vec<Words> {
    let real = share([cell.b_r, cell.b_r_low, cell.b_r_high], &cell.real, "run");
    let mut lines: Vec<Words> = vec![cell.cell.to_string().into()];
    lines.push(format!("  real       {real}").into());
    let mut of_cell: Vec<&ComparedBag> =
        report.bags.iter().filter(|bag| bag.cell == cell.cell).collect();
    of_cell.sort_by_cached_key(|bag| natural_key(&bag.labelled.bag.to_string_lossy()));
    for bag in of_cell {
        let name = format!("    {}: ", bag.labelled.bag.display());
        lines.push(Words::from(name).then(phase_of(&bag.labelled)));
    }
    let which = if cell.is_confirmed { "fresh run" } else { "run" };
    let simulated = share([cell.b_s, cell.b_s_low, cell.b_s_high], &cell.simulated, which);
    lines.push(format!("  simulated  {simulated}").into());
    lines.push(Words::from("  by itself  ").then(by_itself(cell)));
    lines
}

fn of_all(report: &Report) -> Vec<String> {
    let pooled = &report.pooled;
    let decides = 1.0 / SIGNIFICANCE;
    let Verb { plain: mill, did: milled, .. } = report.verb();
    let mut lines = vec![format!(
        "all runs: {} of {} {milled}, {:.1} expected if real robots {mill} as often as simulated ones",
        pooled.n_milled,
        counted(pooled.n_real, "run"),
        pooled.n_expected
    )];
    if let Some(fixed) = &report.fixed {
        lines.push(format!("  {}", that_decides(fixed, pooled.margin, milled)));
        return lines;
    }
    lines.push(format!(
        "  evidence that they {mill} less often: {} (from {decides} on the claim is violated)",
        evidence(pooled.e_violated)
    ));
    let Some(e_supported) = pooled.e_supported else {
        let by = by_margin(pooled.margin);
        lines.push(format!("  nothing is claimed that they could fall short of{by}"));
        return lines;
    };
    lines.push(format!(
        "  evidence that they {mill} as often{}, in {}: {} (from {decides} on the claim is supported)",
        or_less_often(pooled.margin),
        runs_that_claim(pooled),
        evidence(e_supported)
    ));
    let short = pooled.shortfall_at_most.map_or_else(
        || format!("how much less often they may {mill} is not bounded"),
        |short| format!("they {mill} less often by at most {}", percentage_points(short)),
    );
    lines.push(format!("  as far as these show, {short}; {}", supported_share(pooled)));
    lines
}

/// What a campaign shows whose number of runs was fixed.
pub fn of_fixed(fixed: &FixedCampaign, verb: Verb, pooled: &Pooled) -> String {
    let (mill, by) = (verb.plain, by_margin(pooled.margin));
    match fixed.verdict {
        _ if fixed.made < fixed.runs => format!(
            "{} of the {} runs are made that were fixed before the first, and there is no verdict before \
             the last",
            fixed.made, fixed.runs
        ),
        Verdict::Violated => less_often(mill),
        Verdict::Supported => as_often(pooled, mill),
        Verdict::NoClaim => {
            format!("simulated robots {mill} too rarely for real ones to {mill} less often{by}")
        }
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
        |least| format!("the claim is supported if {} {milled}", or_more(least, n_claimed)),
    );
    let violated = violated_up_to.map_or_else(
        || "none violates it".to_owned(),
        |most| format!("violated if {} did", or_fewer(most, *runs)),
    );
    let left_out = match left_out {
        0 => String::new(),
        1 => "; one was left out after its start, and is held against either".to_owned(),
        n => format!("; {n} were left out after their start, and are held against either"),
    };
    format!("{design}; {supported}, and {violated}{left_out}")
}

/// `34 or more of 40`.
pub fn or_more(least: u64, of: u64) -> String {
    if least == of { format!("{least} of {of}") } else { format!("{least} or more of {of}") }
}

/// `29 or fewer of 40`.
pub fn or_fewer(most: u64, of: u64) -> String {
    if most == 0 { format!("none of {of}") } else { format!("{most} or fewer of {of}") }
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

fn by_itself(cell: &ComparedCell) -> Words {
    let verb = cell.simulated.behaviour().verb();
    let mill = verb.plain;
    let why = match (cell.verdict, cell.further_runs) {
        (Verdict::Violated, _) => {
            let [b_r, b_s] = [cell.b_r, cell.b_s].map(percent);
            format!(": {b_r} of real and {b_s} of simulated runs {mill}")
        }
        (Verdict::Undecided, Some(n)) => format!(
            ": {} would support the claim here if every one of them {}",
            counted(n, "further real run"),
            verb.does
        ),
        (Verdict::NoClaim, _) => {
            format!(
                ": simulated robots {mill} too rarely here for real ones to fall short by the margin"
            )
        }
        (Verdict::Undecided, None) | (Verdict::Supported, _) => String::new(),
    };
    toned(cell.verdict).then(why)
}

/// How many runs decide, and how surely.
fn runs_that_decide(experiment: &Experiment, mill: &str) -> String {
    let Experiment { n_real, runs, chance, b_m, n_as_measured, .. } = experiment;
    let measured = b_m.map(|b_m| {
        let (share, runs) = (percent(b_m), counted(*n_as_measured, "run"));
        format!("as simulated ones as measured ({share} of {runs})")
    });
    let assumed = match (*n_real > 0, measured) {
        (true, Some(measured)) => format!("if real robots {mill} as those so far and {measured}"),
        (true, None) => format!("if real robots {mill} as those so far"),
        (false, Some(measured)) => format!("if real robots {mill} {measured}"),
        (false, None) => format!("as nothing is known of how often real robots {mill} there"),
    };
    let run = if *n_real > 0 { "further real run" } else { "real run" };
    match runs {
        Some(n) => {
            let runs = counted(*n, run);
            format!("{runs} there decide with a probability of {chance:.2}, {assumed}")
        }
        None => format!(
            "even {} there decide with a probability of {chance:.2} only, {assumed}: real robots may {mill} \
             less often by about as much as the margin, or too few simulated runs show how often theirs do",
            counted(MOST_RUNS, run)
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
fn share([share, low, high]: [f64; 3], phases: &PhaseCounts, run: &str) -> String {
    let behaviour = phases.behaviour();
    let others = behaviour.phases()[1..].iter().map(|phase| (*phase, phases.get(*phase)));
    let others = others.filter(|(_, n)| *n > 0).map(|(phase, n)| format!("{n} {phase}"));
    let others = others.collect::<Vec<String>>().join(", ");
    let others = if others.is_empty() { others } else { format!("; otherwise {others}") };
    format!(
        "{} of {} {}: {} (95 % interval {}){others}",
        phases.wanted(),
        counted(phases.total(), run),
        behaviour.verb().did,
        percent(share),
        percents(low, high)
    )
}

/// A verdict in a word.
pub fn verdict_name(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::Violated => "violated",
        Verdict::Supported => "supported",
        Verdict::Undecided => "undecided",
        Verdict::NoClaim => "no claim",
    }
}

/// Over how many runs and cells a claim is.
fn runs_that_claim(pooled: &Pooled) -> String {
    let Pooled { n_real_claimed, n_cells_claimed, .. } = pooled;
    format!("{} in {}", counted(*n_real_claimed, "run"), counted(*n_cells_claimed as u64, "cell"))
}

/// What is violated.
fn less_often(mill: &str) -> String {
    format!("real robots {mill} less often than simulated ones")
}

/// `mill as often as simulated ones, or at most 10 percentage points less often`.
pub fn as_often_as_simulated(mill: &str, margin: f64) -> String {
    format!("{mill} as often as simulated ones{}", or_less_often(margin))
}

fn or_less_often(margin: f64) -> String {
    if margin > 0.0 {
        format!(", or at most {} less often", percentage_points(margin))
    } else {
        String::new()
    }
}

/// By how much they may, after a verb.
fn by_margin(margin: f64) -> String {
    if margin > 0.0 { format!(" by {}", percentage_points(margin)) } else { String::new() }
}

/// What is supported.
fn as_often(pooled: &Pooled, mill: &str) -> String {
    format!(
        "averaged over {}, real robots {}",
        runs_that_claim(pooled),
        as_often_as_simulated(mill, pooled.margin)
    )
}

/// Why nothing is claimed in some cells.
pub fn too_rarely(mill: &str, cells: &str, margin: f64) -> String {
    let perhaps = if margin > 0.0 {
        format!("{:.0} % of their runs or fewer", 100.0 * margin)
    } else {
        "none of their runs".to_owned()
    };
    format!(
        "simulated robots {mill} too rarely in {cells}: perhaps in {perhaps}, so that real ones cannot {mill} \
         less often{}",
        by_margin(margin)
    )
}

fn supported_share(pooled: &Pooled) -> String {
    let share = pooled.b_r_at_least.unwrap_or_default();
    format!("B_r >= {share:.2}, at 95 %")
}

/// What follows from runs that were looked at as they came.
pub fn summary(attempts: &Attempts, verb: Verb) -> String {
    let mill = verb.plain;
    let comparison = &attempts.counted;
    if attempts.verdict() != comparison.verdict {
        let word = verdict_name(comparison.verdict);
        return format!(
            "{word} by the runs that count alone, which does not stand whatever those came to that \
             were left out after their start"
        );
    }
    let n_cells = comparison.cells.len();
    match comparison.verdict {
        Verdict::Violated if n_cells > 1 => {
            let is_named = |cell: &&CellComparison| cell.verdict == Verdict::Violated;
            let named = comparison.cells.iter().filter(is_named).count();
            let where_ = match named {
                0 => "no single one of which shows it alone".to_owned(),
                n => format!("and {n} of them by themselves"),
            };
            format!(
                "real robots {mill} less often than simulated ones in these {n_cells} cells together, \
                 {where_}"
            )
        }
        Verdict::Violated => less_often(mill),
        Verdict::Supported => {
            let share = supported_share(&comparison.pooled);
            format!("{}: {share}", as_often(&comparison.pooled, mill))
        }
        Verdict::NoClaim => {
            let cells = if n_cells == 1 { "the cell" } else { "all of the cells" };
            let cells = format!("{cells} that {} run", if n_cells == 1 { "was" } else { "were" });
            format!(
                "{}, and further runs there would not show whether they do as well",
                too_rarely(mill, &cells, comparison.pooled.margin)
            )
        }
        Verdict::Undecided if n_cells == 0 => "no run counts".to_owned(),
        Verdict::Undecided => match comparison.further_runs {
            Some(n) => format!(
                "the runs do not decide yet; {} would support the claim if every one of them {}",
                counted(n, "further real run"),
                verb.does
            ),
            None => "the runs do not decide yet".to_owned(),
        },
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_margin_of_nothing_is_not_named() {
        assert_eq!(as_often_as_simulated("mill", 0.0), "mill as often as simulated ones");
        assert_eq!(
            as_often_as_simulated("mill", 0.1),
            "mill as often as simulated ones, or at most 10 percentage points less often"
        );
        assert_eq!(
            too_rarely("mill", "this cell", 0.0),
            "simulated robots mill too rarely in this cell: perhaps in none of their runs, so that real ones \
             cannot mill less often"
        );
    }

    #[test]
    fn numbers_that_decide_are_bounds_only_where_they_bound_something() {
        assert_eq!([or_more(34, 40), or_more(12, 12)], ["34 or more of 40", "12 of 12"]);
        assert_eq!([or_fewer(29, 40), or_fewer(0, 3)], ["29 or fewer of 40", "none of 3"]);
    }
}
