//! Each statement of the paper beside what was found.

use rsrs_core::diagram::PhaseDiagram;
use rsrs_core::diagram::axis::Axis;
use rsrs_core::judge::phase::Phase;
use rsrs_core::statistics::comparison::Tally;
use rsrs_core::trials::gain::speed_gain;

use super::{FromReport, mean};
use crate::findings::{CONTINUOUSLY_PER_S, Findings, REPETITIONS};
use crate::swept::{b_s, counts};

/// One statement.
struct Statement {
    /// Where the paper makes it.
    place: &'static str,
    /// What it says.
    says: &'static str,
    /// What was found.
    found: String,
    /// Whether they agree.
    agrees: Agreement,
    /// Why not, or what to know; may be empty.
    why: String,
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Agreement {
    Yes,
    Partly,
    No,
}

impl From<bool> for Agreement {
    fn from(is_so: bool) -> Self {
        if is_so { Self::Yes } else { Self::No }
    }
}

impl Agreement {
    fn word(self) -> &'static str {
        match self {
            Self::Yes => "yes",
            Self::Partly => "in part",
            Self::No => "**no**",
        }
    }
}

/// The section with all of them.
pub fn section(findings: &Findings) -> String {
    let rows: Vec<String> = [
        gains(),
        reach(findings),
        only_in_some_cells(findings),
        four_phases(findings),
        recommended(findings),
        first_experiment(findings),
        tally(findings),
        gap(findings),
        placement(findings),
        more_is_not_better(findings),
        semi_stable(findings),
        cannot_mill(findings, ("smars", &SENSOR_FACTORS), "SMARS: the sensors are so bad that, made worse in simulation, the robots are not capable of anything"),
        cannot_mill(findings, ("lta", &DISTURBANCE_FACTORS), "LTA: the disturbances are so large that the harsher simulation shows no desirable behaviour"),
    ]
    .iter()
    .map(|row| {
        let Statement { place, says, found, agrees, why } = row;
        let why = if why.is_empty() { String::new() } else { format!(" {why}") };
        format!("| {place} | {says} | {found}{why} | {} |", agrees.word())
    })
    .collect();
    format!(
        "## Statement by statement\n\n\
         | where | the paper | here | agrees |\n|---|---|---|---|\n{}\n",
        rows.join("\n")
    )
}

fn gains() -> Statement {
    let rows = [
        (25.0, 22.15, "0.89"),
        (25.0, 21.48, "0.86"),
        (25.0, 22.32, "0.89"),
        (50.0, 48.47, "0.97"),
        (50.0, 48.66, "0.97"),
        (50.0, 48.54, "0.97"),
    ];
    let gains: Vec<String> = rows
        .iter()
        .map(|(desired, measured, _)| {
            let gain = speed_gain(desired / 1000.0, &[measured / 1000.0]);
            format!("{:.2}", gain.expect("the table's speeds are positive"))
        })
        .collect();
    let is_so = rows.iter().zip(&gains).all(|((_, _, paper), found)| paper == found);
    Statement {
        place: "`tab:speed1`, `eq:theta^a1`",
        says: "`θᵃ₁` is 0.89, 0.86, 0.89 at 25 mm/s and 0.97, 0.97, 0.97 at 50 mm/s",
        found: gains.join(", "),
        agrees: Agreement::from(is_so),
        why: String::new(),
    }
}

fn reach(findings: &Findings) -> Statement {
    let told = &findings.validation;
    let n = |name: &str| told[name].as_u64().unwrap_or(0);
    let is_contained = told["is_contained"].as_bool() == Some(true);
    let p_value = match told["p_value"].as_f64().unwrap_or(f64::NAN) {
        small if small < 0.001 => "below 0.001".to_owned(),
        other => format!("= {other:.3}"),
    };
    let why = if is_contained {
        ""
    } else {
        "The stand-in slips and lags, and the default factors exaggerate neither; §III sends such a robot back \
         to step 1. The steps below go on all the same, to see what the inequality does then."
    };
    Statement {
        place: "`eq:simulatorreq`, end of step 2",
        says: "real trajectories lie within what the simulated robots can reach",
        found: format!(
            "of {} drives of single robots, 10 s each, {} stay within the simulated 99 % region at all times \
             (`rsrs validate`: p {p_value}).",
            n("n_trials"),
            n("n_inside"),
        ),
        agrees: Agreement::from(is_contained),
        why: why.to_owned(),
    }
}

pub fn n_milling_cells(plane: &PhaseDiagram) -> usize {
    let mills = |entry: &&rsrs_core::diagram::DiagramCell| {
        entry.counts.majority() == Some(Phase::StableMilling)
    };
    plane.cells.iter().filter(mills).count()
}

fn only_in_some_cells(findings: &Findings) -> Statement {
    let (n, all) = (n_milling_cells(&findings.plane), findings.plane.cells.len());
    let of_group = n_milling_cells(&findings.group_sensor);
    let is_so = n > 0 && n < all;
    Statement {
        place: "§IV step 3",
        says: "milling is produced only for certain parameters",
        found: format!(
            "stable milling is the most frequent phase in {n} of {all} cells with a sensor of 0.75 m, and in \
             {of_group} with the 3.6 m of the group's own configurations."
        ),
        agrees: match (is_so, of_group < all) {
            (true, true) => Agreement::Yes,
            (true, false) => Agreement::Partly,
            (false, _) => Agreement::No,
        },
        why: "0.75 m was chosen so that the plane has other regions: this is calibration, and no evidence."
            .to_owned(),
    }
}

fn four_phases(findings: &Findings) -> Statement {
    let is_there = |phase: Phase| {
        findings.plane.cells.iter().filter(|entry| entry.counts.majority() == Some(phase)).count()
    };
    let n_dispersing = |plane: &PhaseDiagram| {
        let of = |entry: &&rsrs_core::diagram::DiagramCell| {
            entry.counts.majority() == Some(Phase::Dispersion)
        };
        plane.cells.iter().filter(of).count()
    };
    let four = [
        Phase::Dispersion,
        Phase::StableMilling,
        Phase::SemiStableMilling,
        Phase::CollidingUnstable,
    ];
    let regions: Vec<String> =
        four.iter().map(|phase| format!("{phase} {}", is_there(*phase))).collect();
    let runs: u64 = findings.plane.cells.iter().map(|entry| entry.counts.total()).sum();
    let unformed: u64 =
        findings.plane.cells.iter().map(|entry| entry.counts.get(Phase::Unformed)).sum();
    Statement {
        place: "§IV step 3, `fig:phase_plot2`",
        says: "the diagram for N = 9 has four regions",
        found: format!("cells by majority after 300 s: {}.", regions.join(", ")),
        // Which regions there are follows from a range that was chosen so that there are some.
        agrees: Agreement::Partly,
        why: format!(
            "Dispersion is a transient: it is the majority in {} cells after 300 s and in {} after 900 s. With the \
             sensor of the group's own configurations it is in {}. Which regions there are is calibration: see \
             the line above. {:.1} % of the runs are none of the four, mostly split mills; they are called \
             unformed.",
            n_dispersing(&findings.plane),
            n_dispersing(&findings.long),
            n_dispersing(&findings.group_sensor),
            100.0 * unformed as f64 / runs as f64
        ),
    }
}

fn recommended(findings: &Findings) -> Statement {
    let is_papers =
        |(speed, rate): &(f64, f64)| (speed - 0.15).abs() < 1e-9 && (rate - 0.75).abs() < 1e-9;
    let found: Vec<(f64, f64)> = findings.recommended.iter().flatten().copied().collect();
    let n_papers = found.iter().filter(|cell| is_papers(cell)).count();
    let mut cells: Vec<String> =
        found.iter().map(|(speed, rate)| format!("({speed} m/s, {rate} rad/s)")).collect();
    cells.sort_unstable();
    cells.dedup();
    let at_papers = b_s(&findings.plane, &[(Axis::Speed, 0.15), (Axis::TurnRate, 0.75)]);
    let n = findings.recommended.len();
    Statement {
        place: "§IV step 3",
        says: "best chances with 9 robots at 0.15 m/s and 0.75 rad/s, the middle of the milling region",
        found: format!(
            "over {n} sweeps with other seeds `rsrs choose` recommends a cell {} times, this one {n_papers} \
             times; in all {}.",
            found.len(),
            cells.join(", ")
        ),
        agrees: if n_papers == n { Agreement::Yes } else { Agreement::Partly },
        why: format!(
            "The paper's cell mills with `B_s` {at_papers:.2}. The sensor's range is calibrated so that it lies \
             inside the region; where the middle of the region is depends on it."
        ),
    }
}

fn first_experiment(findings: &Findings) -> Statement {
    let first = &findings.experiments[0];
    let (_, evidence) = &findings.mill;
    let n_mills = first.repeated.iter().filter(|phase| **phase == Phase::StableMilling).count();
    Statement {
        place: "§IV step 4",
        says: "nine robots mill at 0.15 m/s and 0.75 rad/s the first time",
        found: format!(
            "the first experiment is {}; of {REPETITIONS} repetitions {n_mills} mill.",
            first.phase
        ),
        agrees: Agreement::from(first.phase == Phase::StableMilling),
        why: format!(
            "The ring has a radius of {:.2} m, circliness {:.2}.",
            evidence.mean_radius_m, evidence.circliness
        ),
    }
}

fn tally(findings: &Findings) -> Statement {
    let Tally { same, easier, harder } = Tally::of(findings);
    Statement {
        place: "caption of `fig:phase_plot2`",
        says: "of nine experiments 5 match the simulation, and in 4 the real robots have an easier time",
        found: format!("{same} match, {easier} are easier, {harder} harder."),
        agrees: match (harder, easier) {
            (0, 0) => Agreement::Partly,
            (0, _) => Agreement::Yes,
            (harder, easier) if harder > easier => Agreement::No,
            _ => Agreement::Partly,
        },
        why: format!(
            "The counts depend on which cells are run, and the paper does not say which it ran. One run in a cell \
             can miss the mill by chance: over {REPETITIONS} repetitions a tally has {:.1} harder on average.",
            mean(findings, |tally| tally.harder)
        ),
    }
}

fn gap(findings: &Findings) -> Statement {
    let below: Vec<String> = findings
        .repeated
        .cells
        .iter()
        .filter(|cell| cell.verdict == rsrs_core::statistics::comparison::Verdict::Violated)
        .map(|cell| {
            format!(
                "{} (`B_r` {:.2}, `B_s` {:.2})",
                cell.cell,
                cell.real.value(),
                cell.simulated.value()
            )
        })
        .collect();
    let n = findings.repeated.cells.len();
    let (found, why) = if below.is_empty() {
        (format!("violated in none of {n} cells, {REPETITIONS} runs each."), String::new())
    } else {
        (
            format!("violated in {} of {n} cells: {}.", below.len(), below.join(", ")),
            "Being better in every capability does not make a robot mill more often in every cell: noise \
             also helps, by breaking up split groups. The inequality is tested and not assumed."
                .to_owned(),
        )
    };
    Statement {
        place: "`eq:finalgap`, §IV step 4",
        says: "`B_r(E) >= B_s(E)` seems to hold",
        found,
        agrees: if below.is_empty() { Agreement::Yes } else { Agreement::Partly },
        why,
    }
}

fn diagram_of(findings: &Findings, axis: Axis) -> &PhaseDiagram {
    let varied = findings.varied.iter().find(|varied| varied.axis == axis);
    &varied.expect("every setting that is asked for was varied").diagram
}

fn placement(findings: &Findings) -> Statement {
    let diagram = diagram_of(findings, Axis::PlacementRadius);
    let at = |radius: f64| counts(diagram, &[(Axis::PlacementRadius, radius)]);
    let (near, usual, far) = (at(0.40), at(0.825), at(2.5));
    let collides = |it: rsrs_core::diagram::PhaseCounts| it.share(Phase::CollidingUnstable);
    let is_lost = far.share(Phase::StableMilling) < 0.5 * usual.share(Phase::StableMilling);
    let more_collisions = collides(near) > collides(usual);
    Statement {
        place: "§IV step 3",
        says: "the start matters much: too close, and collisions increase dramatically; anywhere, and some never see \
               another",
        found: format!(
            "within 0.40 m `B_s` is {:.2} and {:.0} % collide; within 0.825 m {:.2} and {:.0} %; within 2.5 m {:.2}.",
            near.share(Phase::StableMilling),
            100.0 * collides(near),
            usual.share(Phase::StableMilling),
            100.0 * collides(usual),
            far.share(Phase::StableMilling)
        ),
        agrees: match (is_lost, more_collisions) {
            (true, true) => Agreement::Yes,
            (true, false) => Agreement::Partly,
            (false, _) => Agreement::No,
        },
        why: if more_collisions {
            String::new()
        } else {
            "A close start that faces outward does not collide here: robots drive apart before they turn. \
             How the paper's start was when it collided is not said."
                .to_owned()
        },
    }
}

fn more_is_not_better(findings: &Findings) -> Statement {
    let diagram = diagram_of(findings, Axis::Robots);
    let at = |n: f64| b_s(diagram, &[(Axis::Robots, n)]);
    Statement {
        place: "`pr:main`",
        says: "more robots are not always better",
        found: format!(
            "`B_s` is {:.2} with 4 robots, {:.2} with 6, {:.2} with 9, {:.2} with 12.",
            at(4.0),
            at(6.0),
            at(9.0),
            at(12.0)
        ),
        agrees: Agreement::from(at(12.0) < at(9.0)),
        why: "A larger ring puts the robot ahead out of reach.".to_owned(),
    }
}

fn semi_stable(findings: &Findings) -> Statement {
    let (n_bumping, n) = findings.bumping;
    Statement {
        place: "§IV step 3",
        says: "semi-stable mills continuously collide while they rotate",
        found: format!(
            "of {n} semi-stable runs at 0.75 rad/s, in {n_bumping} robots come into contact {CONTINUOUSLY_PER_S} times \
             a second or more."
        ),
        agrees: if n_bumping == n { Agreement::Yes } else { Agreement::Partly },
        why: "The judge calls semi-stable what rotates and is not a clean ring, with contacts or without; they \
              are in its evidence."
            .to_owned(),
    }
}

const SENSOR_FACTORS: [&str; 3] = ["miss_factor", "false_positive_factor", "polygon_scale"];

const DISTURBANCE_FACTORS: [&str; 2] = ["gust_factor", "drift_factor"];

fn cannot_mill(
    findings: &Findings,
    (name, of_fault): (&str, &[&str]),
    says: &'static str,
) -> Statement {
    let robot = findings.hopeless.iter().find(|robot| robot.name == name);
    let robot = robot.expect("both robots were tried");
    let (searched, _, [b_s, measured]) = robot.best();
    let found = if robot.is_viable() { "finds" } else { "does not find" };
    // The fault does it if one of its factors alone leaves less than half, and another one more.
    let leaves_half = |effect: &serde_json::Value| {
        effect["b_s_alone"].as_f64().is_some_and(|alone| alone >= measured / 2.0)
    };
    let is_of_fault =
        |effect: &serde_json::Value| of_fault.contains(&effect["factor"].as_str().unwrap_or("?"));
    let mills = effects(&searched.factors).any(leaves_half);
    let does_it = mills
        && effects(&searched.factors).any(|effect| is_of_fault(effect) && !leaves_half(effect));
    // A robot that could not mill as measured either was not stopped by being made worse.
    let agrees = match (robot.is_viable(), measured >= 0.5 && does_it) {
        (true, _) => Agreement::No,
        (false, true) => Agreement::Yes,
        (false, false) => Agreement::Partly,
    };
    let cause = match (mills, does_it) {
        (_, true) => "",
        (true, false) => {
            " No factor of that fault does it alone: the cause in that cell is another one."
        }
        (false, false) => {
            " That cell does not mill with any factor alone, so that none of them is singled out."
        }
    };
    Statement {
        place: "end of §IV",
        says,
        found: format!(
            "in {} cells `rsrs choose` {found} a viable one; the best has `B_s` {b_s:.2}, and as measured \
             {measured:.2}. {}",
            robot.n_cells(),
            factor_by_factor(&searched.factors)
        ),
        agrees,
        why: format!("The profile is made up, with that fault.{cause}"),
    }
}

/// What each factor does, as `rsrs choose` reports it.
fn effects(factors: &serde_json::Value) -> impl Iterator<Item = &serde_json::Value> {
    factors["factors"].as_array().into_iter().flatten()
}

/// What each factor does in the best cell.
fn factor_by_factor(factors: &serde_json::Value) -> String {
    let share = |value: &serde_json::Value| format!("{:.2}", value.as_f64().unwrap_or(f64::NAN));
    let effects: Vec<String> = effects(factors)
        .map(|effect| {
            format!(
                "`{}` {} alone and {} without it",
                effect["factor"].as_str().unwrap_or("?"),
                share(&effect["b_s_alone"]),
                share(&effect["b_s_without"])
            )
        })
        .collect();
    format!("Factor by factor in that cell: {}.", effects.join(", "))
}
