//! The document: what the paper says beside what was found.

mod pictures;
mod statements;

use std::fmt::Write;

use rsrs_core::diagram::PhaseCounts;
use rsrs_core::judge::phase::Phase;
use rsrs_core::statistics::comparison::{Tally, Verdict};

pub use pictures::draw;

use crate::experiments::{DURATION_S, cell};
use crate::findings::{Experiment, Findings, REPETITIONS};
use crate::reality::FAULTS;
use crate::swept::REPLICATES;

/// The whole document, in Markdown.
pub fn markdown(findings: &Findings) -> String {
    [
        preface(),
        statements::section(findings),
        diagram(findings),
        experiments(findings),
        hopeless(findings),
        varied(findings),
        limits(findings),
    ]
    .join("\n")
}

fn preface() -> String {
    let (shortest_s, longest_s) = FAULTS.slip_s;
    format!(
        "# The paper's case study, reproduced\n\n\
         This file and its pictures are written by one command; do not edit them.\n\n\
         ```\ncargo run --release --example reproduce\n```\n\n\
         It goes through the four steps of *Simulate Less, Expect More* (cited below by LaTeX label) \
         with the commands of `rsrs`: `sweep`, `validate`, `choose`, `label`, `compare`.\n\
         What it cannot have is the nine Flockbots.\n\
         They are replaced by a stand-in: robots as measured, not exaggerated, on a floor that shares \
         nothing with the simulator but how a robot decides and where it starts.\n\
         On that floor, and not in the simulator,\n\n\
         - each wheel follows its command with a time constant of {} s;\n\
         - a wheel begins to slip {} times per second and robot, keeps {:.0} % of its speed, and grips again after \
         {shortest_s} to {longest_s} s;\n\
         - every robot decides by its own clock, every 0.13 s give or take {:.0} ms, and not in step with the \
         others;\n\
         - bodies push each other apart, and time goes on in steps of 10 ms.\n\n\
         These numbers were chosen before anything was run, and were not fitted to the paper.\n\
         So agreement below shows that the method does what the paper says of it under faults that its \
         simulator does not have; it does not show what Flockbots do.\n",
        FAULTS.motor_lag_s,
        FAULTS.slips_per_s,
        100.0 * FAULTS.grip,
        1000.0 * FAULTS.jitter_s,
    )
}

fn diagram(findings: &Findings) -> String {
    let mut majorities = PhaseCounts::default();
    for entry in &findings.plane.cells {
        majorities.add(entry.counts.majority().expect("every cell was run"));
    }
    let phases: Vec<String> = Phase::ALL
        .into_iter()
        .filter(|phase| majorities.get(*phase) > 0)
        .map(|phase| format!("{} {phase}", majorities.get(phase)))
        .collect();
    let n = |name: &str| findings.choice[name].as_f64().unwrap_or(f64::NAN);
    let chosen = |name: &str| findings.choice["cell"][name].as_f64().unwrap_or(f64::NAN);
    format!(
        "## The phase diagram, `fig:phase_plot2`\n\n\
         ![Phase diagram of nine simulated Flockbots with nine experiments on it.]\
         (reproduction/diagram.png)\n\n\
         {} cells of {REPLICATES} runs each, {DURATION_S} s long; by majority: {}.\n\
         Symbols are the nine experiments below.\n\
         `rsrs choose` recommends {} m/s and {} rad/s, the cell that is deepest inside the milling region; of {} \
         fresh runs {:.1} % mill there (95 % interval {:.1} to {:.1} %).\n\n\
         ![One of the experiments from above.](reproduction/mill.png)\n",
        findings.plane.cells.len(),
        phases.join(", "),
        chosen("speed_m_s"),
        chosen("turn_rate_rad_s"),
        n("n_replicates"),
        100.0 * n("b_s"),
        100.0 * n("b_s_low"),
        100.0 * n("b_s_high"),
    )
}

fn experiments(findings: &Findings) -> String {
    let mut text = format!(
        "## Nine experiments\n\n\
         The paper does not say where its nine experiments lay.\n\
         Here they are the paper's cell and eight around it, in and outside of the milling region, fixed \
         before any was run.\n\
         Each was recorded into a bag and labelled by `rsrs label`, once, as in the paper; and repeated \
         {REPETITIONS} times on fresh seeds to see how much one run says.\n\n\
         | m/s | rad/s | simulated majority | `B_s` | experiment | beside it | `B_r` of {REPETITIONS} | |\n\
         |---|---|---|---|---|---|---|---|\n"
    );
    for (experiment, cell) in findings.experiments.iter().zip(&findings.repeated.cells) {
        writeln!(
            text,
            "| {:.2} | {:.2} | {} | {:.2} | {} | {} | {:.2} | {} |",
            experiment.setting.0,
            experiment.setting.1,
            majority(experiment),
            experiment.simulated.share(Phase::StableMilling),
            experiment.phase,
            beside(experiment),
            cell.real.value(),
            word(cell.verdict),
        )
        .expect("a string takes any text");
    }
    let tally = Tally::of(findings);
    text + &format!(
        "\nThe tally of the nine: {} as simulated, {} easier, {} harder; the paper has 5, 4 and 0.\n\
         `rsrs compare` on the nine bags, all together: {}; {} of them milled where {:.1} would if robots \
         milled as often as simulated ones, and as far as nine runs say they mill less often by at most {:.0} \
         percentage points.\n\
         Over {REPETITIONS} repetitions of all nine, a tally has {:.1} as simulated, {:.1} easier and {:.1} harder \
         on average; {} of the {REPETITIONS} have none harder, and {} are exactly 5, 4, 0.\n\
         The last column is what each cell says by itself of `eq:finalgap`, corrected for their number, by the \
         same statistics as `rsrs compare`; all {} runs together: {}.\n",
        tally.same,
        tally.easier,
        tally.harder,
        findings.comparison["verdict"].as_str().unwrap_or("nothing"),
        findings.comparison["pooled"]["n_milled"],
        findings.comparison["pooled"]["n_expected"].as_f64().unwrap_or(f64::NAN),
        100.0 * findings.comparison["pooled"]["shortfall_at_most"].as_f64().unwrap_or(1.0),
        mean(findings, |tally| tally.same),
        mean(findings, |tally| tally.easier),
        mean(findings, |tally| tally.harder),
        findings.tallies.iter().filter(|tally| tally.harder == 0).count(),
        findings.tallies.iter().filter(|tally| **tally == PAPERS).count(),
        REPETITIONS * findings.experiments.len(),
        word(findings.repeated.verdict),
    )
}

/// What the caption of `fig:phase_plot2` counts.
const PAPERS: Tally = Tally { same: 5, easier: 4, harder: 0 };

/// The tally that `rsrs compare` reported of the nine bags.
trait FromReport {
    fn of(findings: &Findings) -> Self;
}

impl FromReport for Tally {
    fn of(findings: &Findings) -> Self {
        let n = |name: &str| findings.comparison["tally"][name].as_u64().unwrap_or(0);
        Self { same: n("same"), easier: n("easier"), harder: n("harder") }
    }
}

fn mean(findings: &Findings, of: fn(&Tally) -> u64) -> f64 {
    let sum: u64 = findings.tallies.iter().map(of).sum();
    sum as f64 / findings.tallies.len() as f64
}

fn majority(experiment: &Experiment) -> Phase {
    experiment.simulated.majority().expect("every cell was run")
}

/// How an experiment went beside the simulator's majority.
fn beside(experiment: &Experiment) -> &'static str {
    let runs = rsrs_core::statistics::comparison::CellRuns {
        cell: cell(experiment.setting),
        real: PhaseCounts::of([experiment.phase]),
        simulated: experiment.simulated,
    };
    match rsrs_core::statistics::comparison::Comparison::of(&[runs]).tally {
        Tally { easier: 1, .. } => "easier",
        Tally { harder: 1, .. } => "harder",
        _ => "same",
    }
}

fn word(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::Violated => "violated",
        Verdict::Supported => "supported",
        Verdict::Undecided => "undecided",
    }
}

fn hopeless(findings: &Findings) -> String {
    let mut text = String::from(
        "## Robots that cannot mill\n\n\
         The paper gives no numbers of its SMARS and lighter-than-air robots, only what was wrong with \
         them: bad sensors, and large disturbances.\n\
         The profiles here are made up to have these faults (`launch_configs/profiles`), and are searched \
         over speed, turning rate and number of robots, made worse by the default factors, which make everything \
         worse that a profile has and take nothing to nothing.\n\n\
         | robot | made worse: best `B_s` | where | `rsrs choose` | `B_s` there, as measured |\n\
         |---|---|---|---|---|\n",
    );
    for robot in &findings.hopeless {
        let (searched, cell, [b_s, measured]) = robot.best();
        let answer = if robot.is_viable() { "a viable cell" } else { "no viable cell" };
        let (name, robots) = (robot.name, searched.robots);
        writeln!(
            text,
            "| {name} | {b_s:.2} | {robots} robots, {cell} | {answer} | {measured:.2} |"
        )
        .expect("a string takes any text");
    }
    text.push('\n');
    for robot in &findings.hopeless {
        let (searched, ..) = robot.best();
        if let Some(reason) = &searched.reason {
            writeln!(text, "`rsrs choose` of {}: {reason}.\n", robot.name)
                .expect("a string takes any text");
        }
    }
    text.trim_end().to_owned() + "\n"
}

fn varied(findings: &Findings) -> String {
    let mut text = format!(
        "## The five questions of `pr:main`\n\n\
         How many robots, how fast, how sharply turning, how good a sensor, how alike: the plane above answers \
         the second and third.\n\
         The others, one at a time at 0.15 m/s and 0.75 rad/s, {REPLICATES} simulated runs for each value:\n\n"
    );
    for varied in &findings.varied {
        let values: Vec<String> = varied
            .diagram
            .cells
            .iter()
            .map(|entry| entry.cell.get(varied.axis).map_or_else(String::new, |it| it.to_string()))
            .collect();
        let shares: Vec<String> = varied
            .diagram
            .cells
            .iter()
            .map(|entry| format!("{:.2}", entry.counts.share(Phase::StableMilling)))
            .collect();
        let columns = "---|".repeat(values.len() + 1);
        writeln!(
            text,
            "| {} | {} |\n|{columns}\n| `B_s` | {} |\n",
            varied.axis.label(),
            values.join(" | "),
            shares.join(" | ")
        )
        .expect("a string takes any text");
    }
    text
}

fn limits(findings: &Findings) -> String {
    let harder = Tally::of(findings).harder;
    let harder = if harder == 0 {
        "None of the nine was harder, but nine single runs would often show none even where reality is \
         worse in some cell; the repeated runs are what the verdicts rest on."
    } else {
        "Some were harder than simulated, as chance or the floor's faults have it: a single run per cell \
         says little, and the repeated runs are what the verdicts rest on."
    };
    format!(
        "## What this does not show\n\n\
         - The boundaries of the paper's diagram, cell by cell: its figure is not in its text, and the range and \
         angle of its sensor are not either. The angle, 0.2 rad, is that of the group's own \
         configurations; the range, 0.75 m, is ours, calibrated so that the paper's cell lies inside the milling \
         region (`launch_configs/profiles/flockbot.yaml`). The group's configurations say 3.6 m \
         (`flockbot_group_sensor.yaml`), with which {} of {} cells mill.\n\
         - The labels of the paper's authors, who judged by eye. Here a judge with fixed rules looks at the last \
         60 s.\n\
         - Flockbots. {harder}\n",
        statements::n_milling_cells(&findings.group_sensor),
        findings.group_sensor.cells.len(),
    )
}
