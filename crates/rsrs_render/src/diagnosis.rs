//! A diagnosis for people.

use rsrs_core::judge::behaviour::Verb;
use rsrs_core::numerals::{count, counted, percent};
use rsrs_core::quantity::{Axis, Cell};
use rsrs_core::statistics::share::Share;
use rsrs_pipeline::diagnose::{AsMeasured, Diagnosis, Hopeless, NeededChange, Spare};
use serde::Serialize;

use crate::choice::{alternatives, indented};
use crate::columns::columns;
use crate::json::with;
use crate::wording::quantity::{of_cell, quantity};
use crate::words::{Tone, Words};

/// A diagnosis as JSON.
pub fn json(diagnosis: &Diagnosis) -> impl Serialize {
    let changed = with(diagnosis, "causes", causes(diagnosis));
    with(with(changed, "hopeless", &diagnosis.hopeless), "spare", spare(diagnosis))
}

/// Changes after which robots mill as JSON, each with its sentence.
pub fn causes(diagnosis: &Diagnosis) -> Vec<impl Serialize> {
    diagnosis.causes.iter().map(|cause| with(cause, "change", change(cause))).collect()
}

/// What may be worse as JSON, each with its sentence.
pub fn spare(diagnosis: &Diagnosis) -> Vec<impl Serialize> {
    diagnosis.spare.iter().map(|spare| with(spare, "text", saved(spare))).collect()
}

/// All of it.
pub fn text(diagnosis: &Diagnosis) -> Words {
    let of = Text(diagnosis);
    let mut lines = indented(alternatives(&diagnosis.best.choice, diagnosis.best.wanted));
    if diagnosis.best.viable {
        lines.extend(of.surplus());
    } else {
        let best = &diagnosis.best;
        let Verb { plain: mill, does, .. } = best.behaviour.verb();
        lines.extend(of.changes());
        lines.extend(helpful(
            &diagnosis.hopeless,
            Share::from_value(best.b_s, best.n_replicates),
            does,
        ));
        lines.extend(next_steps(
            diagnosis.as_measured.as_ref(),
            &diagnosis.causes,
            (mill, best.b_s, best.wanted),
        ));
    }
    lines.into_iter().fold(of.headline(), Words::below)
}

struct Text<'a>(&'a Diagnosis);

impl Text<'_> {
    fn headline(&self) -> Words {
        let mill = self.0.best.behaviour.verb().plain;
        let (found, verdict) = if self.0.best.viable {
            (mill.to_owned(), "nothing is wrong")
        } else if self.0.best.b_s >= self.0.best.wanted {
            (format!("seem to {mill} often enough"), "more fresh runs would show whether they do")
        } else {
            (format!("do not {mill} often enough"), "something must change")
        };
        let words = Words::from(format!("{}: these robots {found}; ", self.0.best.robot));
        words.then_toned(Tone::good_if(self.0.best.viable), verdict).then(format!(
            "\n  best of {}: {}\n  there they {mill} in {} of {} fresh \
             runs, lower bound {}; wanted {}",
            counted(self.0.n_settings as u64, "setting"),
            self.0.best.cell,
            percent(self.0.best.b_s),
            count(self.0.best.n_replicates),
            percent(self.0.best.b_s_low),
            percent(self.0.best.wanted)
        ))
    }

    fn surplus(&self) -> Vec<String> {
        if self.0.spare.is_empty() {
            return vec!["no capability may be noticeably worse".to_owned()];
        }
        let rows: Vec<[String; 2]> = (self.0.spare.iter())
            .map(|spare| {
                [
                    format!("  {}", saved(spare)),
                    self.after(spare.b_s, spare.b_s_low) + &self.elsewhere(&spare.cell),
                ]
            })
            .collect();
        vec!["what could be saved, one at a time:".to_owned(), columns(&rows)]
    }

    fn changes(&self) -> Vec<String> {
        if self.0.causes.is_empty() {
            return vec![
                "no change was found that suffices: not of one capability, and not of all noise with up \
                 to three properties of the sensor, the period and the limits"
                    .to_owned(),
            ];
        }
        let alone: Vec<&NeededChange> = self.0.causes.iter().filter(|cause| cause.alone).collect();
        let mut lines = Vec::new();
        if !alone.is_empty() {
            lines.push("any one of these suffices, with all else as it is:".to_owned());
            let row = |cause: &&NeededChange| {
                [
                    format!("  {}{}", change(cause), cost(cause)),
                    self.after(cause.b_s, cause.b_s_low) + &self.elsewhere(&cause.cell),
                ]
            };
            let rows: Vec<[String; 2]> = alone.iter().map(row).collect();
            lines.push(columns(&rows));
        }
        for set in self.sets() {
            lines.push(format!(
                "these suffice together ({}):",
                self.after(set[0].b_s, set[0].b_s_low) + &self.elsewhere(&set[0].cell)
            ));
            lines.extend(set.iter().map(|cause| format!("  {}{}", change(cause), cost(cause))));
        }
        let mut necessary: Vec<&str> = Vec::new();
        // A capability is in several sets.
        for cause in self.0.causes.iter().filter(|cause| cause.necessary) {
            if !necessary.contains(&cause.capability.name()) {
                necessary.push(cause.capability.name());
            }
        }
        if !necessary.is_empty() {
            lines.push(format!(
                "robots that are perfect in all else would not {} either without a change of: {}",
                self.0.best.behaviour.verb().plain,
                necessary.join(", ")
            ));
        }
        lines
    }

    /// Changes that need each other.
    fn sets(&self) -> Vec<&[NeededChange]> {
        let mut sets = Vec::new();
        let mut rest = &self.0.causes[..];
        while let Some(first) = rest.first() {
            let (set, others) = rest.split_at((first.with.len() + 1).min(rest.len()));
            if !first.alone {
                sets.push(set);
            }
            rest = others;
        }
        sets
    }

    /// `mills in 92.1 %, lower bound 90.2 %`.
    fn after(&self, b_s: f64, b_s_low: f64) -> String {
        let mills = self.0.best.behaviour.verb().does;
        format!("{mills} in {}, lower bound {}", percent(b_s), percent(b_s_low))
    }

    /// The setting in which something holds, if that is not the one that is named above.
    fn elsewhere(&self, cell: &Cell) -> String {
        if *cell == self.0.best.cell { String::new() } else { format!(", at {}", of_cell(cell)) }
    }
}

/// The best value of each capability that helps without being enough, and what does not help. One
/// helps where the intervals of the shares with it and as it is `now` do not overlap.
fn helpful(hopeless: &[Hopeless], now: Share, does: &str) -> Vec<String> {
    // What is as good as perfect has nothing to gain.
    let can_change = |hopeless: &&Hopeless| {
        let [now, best] =
            [hopeless.now, hopeless.best].map(|value| quantity(hopeless.capability, value));
        now != best
    };
    let helps = |hopeless: &&Hopeless| {
        Share::from_value(hopeless.b_s, hopeless.n_replicates).interval().low > now.interval().high
    };
    let (helpful, useless): (Vec<&Hopeless>, Vec<&Hopeless>) =
        hopeless.iter().filter(can_change).partition(helps);
    let row = |hopeless: &&Hopeless| {
        let Hopeless { capability, now, best, b_s, .. } = hopeless;
        let [now, best] = [now, best].map(|value| quantity(*capability, *value));
        let share = format!("{does} in {}", percent(*b_s));
        [format!("  {}", capability.name()), format!("{now} → {best}"), share]
    };
    let mut lines = Vec::new();
    if !helpful.is_empty() {
        lines.push("these help, but not enough by themselves, the best value of each:".to_owned());
        lines.push(columns(&helpful.iter().map(row).collect::<Vec<[String; 3]>>()));
    }
    if !useless.is_empty() {
        let names: Vec<&str> = useless.iter().map(|it| it.capability.name()).collect();
        lines.push(format!(
            "by itself, no better value of these surely helps: {}",
            names.join(", ")
        ));
    }
    lines
}

/// The paper's order of remedies (§III step 3): less noise first, then an upgrade, then step 1 again; robots
/// `mill` in a share of `wanted`.
fn next_steps(
    as_measured: Option<&AsMeasured>,
    causes: &[NeededChange],
    (mill, share, wanted): (&str, f64, f64),
) -> Vec<String> {
    let of_measured = as_measured.map(|measured| {
        let text = format!(
            "as measured they {mill} in {} (lower bound {}) at {}",
            percent(measured.b_s),
            percent(measured.b_s_low),
            measured.cell
        );
        (measured.b_s_low >= wanted, text)
    });
    let mut steps = Vec::new();
    if let Some((true, measured)) = &of_measured {
        steps.push(format!(
            "make the simulated robots less worse (`harsher:` in a sweep file; `rsrs choose` names the \
             factor that matters): {measured}"
        ));
    }
    if let Some(cause) = causes.first() {
        let all: Vec<String> = causes[..=cause.with.len()].iter().map(change).collect();
        steps.push(format!("upgrade the robots: {}", all.join(", and ")));
    }
    if !steps.is_empty() {
        steps.push("then measure them again: `rsrs measure plan`".to_owned());
    }
    if share >= wanted {
        steps.insert(0, "simulate more fresh runs: `--confirm`".to_owned());
    }
    let mut lines = if steps.is_empty() {
        vec![
            "what to do: no better robot helps here, so try another controller, other settings \
             (`--sweep SWEEP`), or longer runs (`duration_s` of the sweep)"
                .to_owned(),
        ]
    } else {
        let numbered = (1..).zip(steps).map(|(number, step)| format!("  {number}. {step}"));
        std::iter::once("what to do, in this order:".to_owned()).chain(numbered).collect()
    };
    if let Some((false, measured)) = of_measured {
        lines.push(format!("less noise in the simulation alone would not suffice: {measured}"));
    }
    lines
}

fn cost(cause: &NeededChange) -> String {
    cause.cost.map_or_else(String::new, |cost| format!(" (costs {cost})"))
}

/// What is to be changed: `range 0.45 m → at least 0.66 m`.
pub fn change(cause: &NeededChange) -> String {
    changed(cause.capability, cause.now, cause.needed)
}

fn changed(axis: Axis, now: f64, needed: f64) -> String {
    match axis {
        Axis::SensorBearing => format!("aim the sensor {}", turn(needed)),
        Axis::Speed | Axis::TurnRate => format!(
            "allow a {} of {} (the limit is {})",
            axis.name(),
            quantity(axis, needed),
            quantity(axis, now)
        ),
        Axis::SpeedGain | Axis::TurnGain => {
            format!("{} {} → {}", axis.name(), quantity(axis, now), quantity(axis, needed))
        }
        _ => format!(
            "{} {} → {} {}",
            axis.name(),
            quantity(axis, now),
            if needed > now { "at least" } else { "at most" },
            quantity(axis, needed)
        ),
    }
}

/// What would do as well: `range 0.75 m, 0.52 m would do`.
fn saved(spare: &Spare) -> String {
    let Spare { capability: axis, now, enough, .. } = spare;
    format!("{} {}, {} would do", axis.name(), quantity(*axis, *now), quantity(*axis, *enough))
}

fn turn(by_rad: f64) -> String {
    let side = if by_rad < 0.0 { "right" } else { "left" };
    format!("{:.1}° to the {side}", by_rad.abs().to_degrees())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn changes_are_what_a_laboratory_would_do() {
        let sentences = [
            changed(Axis::SensorBearing, 0.0, -0.0698),
            changed(Axis::Range, 0.45, 0.66),
            changed(Axis::FalsePositive, 0.145, 0.062),
            changed(Axis::LatencySteps, 6.0, 1.0),
            changed(Axis::HalfAngle, 0.6, 0.35),
            changed(Axis::Speed, 0.05, 0.12),
        ];

        assert_eq!(
            sentences,
            [
                "aim the sensor 4.0° to the right",
                "range of the sensor 0.45 m → at least 0.66 m",
                "false positive rate 0.145 → at most 0.062",
                "latency of the sensor 6 steps → at most 1 step",
                "half-angle of the sensor 0.6 rad (34.4°) → at most 0.35 rad (20.1°)",
                "allow a speed of 0.12 m/s (the limit is 0.05 m/s)",
            ]
        );
    }

    #[test]
    fn what_does_not_surely_help_is_not_offered() {
        let hopeless =
            |capability, best, b_s| Hopeless { capability, now: 0.5, best, b_s, n_replicates: 200 };
        let now = Share::from_value(0.035, 200);
        let range = hopeless(Axis::Range, 0.9, 0.2);
        let speed = hopeless(Axis::Speed, 0.0125, 0.005);
        let period = hopeless(Axis::Period, 0.1, 0.05);
        let perfect = hopeless(Axis::TruePositive, 0.5, 0.03);

        assert_eq!(
            helpful(&[range, period.clone(), speed, perfect], now, "mills"),
            [
                "these help, but not enough by themselves, the best value of each:",
                "  range of the sensor  0.5 m → 0.9 m  mills in 20.0 %",
                "by itself, no better value of these surely helps: control period, speed",
            ]
        );
        assert_eq!(helpful(&[period], now, "mills").len(), 1);
        assert!(helpful(&[], now, "mills").is_empty());
    }

    #[test]
    fn what_to_do_begins_with_what_can_be_done() {
        let cell = Cell::new([(Axis::Speed, 0.15)]).unwrap();
        let measured = AsMeasured { cell: cell.clone(), b_s: 0.4, b_s_low: 0.33 };
        let cause = NeededChange {
            capability: Axis::Range,
            now: 0.45,
            needed: 0.66,
            b_s: 0.9,
            b_s_low: 0.85,
            n_replicates: 200,
            alone: true,
            with: Vec::new(),
            necessary: false,
            cost: None,
            cell,
        };
        let less_noise = "less noise in the simulation alone would not suffice: as measured they mill in 40.0 % \
                          (lower bound 33.0 %) at speed_m_s=0.15";

        assert_eq!(
            next_steps(Some(&measured), &[cause], ("mill", 0.4, 0.8)),
            [
                "what to do, in this order:",
                "  1. upgrade the robots: range of the sensor 0.45 m → at least 0.66 m",
                "  2. then measure them again: `rsrs measure plan`",
                less_noise,
            ]
        );
        let likely = next_steps(None, &[], ("mill", 0.85, 0.8));
        let fresh_runs = "  1. simulate more fresh runs: `--confirm`";
        assert_eq!(likely, ["what to do, in this order:", fresh_runs]);
        let nothing = next_steps(Some(&measured), &[], ("mill", 0.4, 0.8));
        assert!(nothing[0].starts_with("what to do: no better robot helps here"), "{nothing:?}");
        assert_eq!(nothing[1..], [less_noise]);
    }
}
