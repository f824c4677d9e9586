//! A diagnosis for people.

use std::fmt;

use rsrs_core::quantity::Cell;

use super::{Cause, Diagnosis, Hopeless};
use crate::wording::quantity::{of_cell, quantity};
use crate::wording::{columns, count, counted, percent};

impl fmt::Display for Diagnosis {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut lines = vec![self.headline()];
        lines.extend(self.alternatives.iter().map(|line| format!("  {line}")));
        if self.viable {
            lines.extend(self.surplus());
        } else {
            lines.extend(self.changes());
            lines.extend(self.hopeless_ones());
            lines.extend(self.next_steps());
        }
        formatter.write_str(&lines.join("\n"))
    }
}

impl Diagnosis {
    fn headline(&self) -> String {
        let mill = self.behaviour.verb().plain;
        let (found, verdict) = if self.viable {
            (mill.to_owned(), "nothing is wrong")
        } else {
            (format!("do not {mill} often enough"), "something must change")
        };
        format!(
            "{}: these robots {found}; {verdict}\n  best of {}: {}\n  there they {mill} in {} of {} fresh \
             runs, lower bound {}; wanted {}",
            self.robot,
            counted(self.n_settings as u64, "setting"),
            self.cell,
            percent(self.b_s),
            count(self.n_replicates),
            percent(self.b_s_low),
            percent(self.wanted)
        )
    }

    fn surplus(&self) -> Vec<String> {
        if self.spare.is_empty() {
            return vec!["no capability may be noticeably worse".to_owned()];
        }
        let rows: Vec<[String; 2]> = (self.spare.iter())
            .map(|spare| {
                [
                    format!("  {}", spare.text),
                    self.after(spare.b_s, spare.b_s_low) + &self.elsewhere(&spare.cell),
                ]
            })
            .collect();
        vec!["what could be saved, one at a time:".to_owned(), columns(&rows)]
    }

    fn changes(&self) -> Vec<String> {
        if self.causes.is_empty() {
            return vec![
                "no change was found that helps: not of one capability, and not of all noise with up \
                 to three properties of the sensor, the period and the limits"
                    .to_owned(),
            ];
        }
        let alone: Vec<&Cause> = self.causes.iter().filter(|cause| cause.alone).collect();
        let mut lines = Vec::new();
        if !alone.is_empty() {
            lines.push("any one of these suffices, with all else as it is:".to_owned());
            let row = |cause: &&Cause| {
                [
                    format!("  {}{}", cause.change, cost(cause)),
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
            lines.extend(set.iter().map(|cause| format!("  {}{}", cause.change, cost(cause))));
        }
        let necessary: Vec<&str> = (self.causes.iter())
            .filter(|cause| cause.necessary)
            .map(|cause| cause.capability.name())
            .collect();
        if !necessary.is_empty() {
            lines.push(format!(
                "robots that are perfect in all else would not {} either without a change of: {}",
                self.behaviour.verb().plain,
                necessary.join(", ")
            ));
        }
        lines
    }

    /// Changes that need each other.
    fn sets(&self) -> Vec<&[Cause]> {
        let mut sets = Vec::new();
        let mut rest = &self.causes[..];
        while let Some(first) = rest.first() {
            let (set, others) = rest.split_at((first.with.len() + 1).min(rest.len()));
            if !first.alone {
                sets.push(set);
            }
            rest = others;
        }
        sets
    }

    fn hopeless_ones(&self) -> Vec<String> {
        if self.hopeless.is_empty() {
            return Vec::new();
        }
        let row = |hopeless: &Hopeless| {
            let Hopeless { capability, now, best, b_s } = hopeless;
            let values =
                format!("{} → {}", quantity(*capability, *now), quantity(*capability, *best));
            let share = format!("{} in {}", self.behaviour.verb().does, percent(*b_s));
            [format!("  {}", capability.name()), values, share]
        };
        let rows: Vec<[String; 3]> = self.hopeless.iter().map(row).collect();
        vec!["not enough by itself, the best value of each:".to_owned(), columns(&rows)]
    }

    /// `mills in 92.1 %, lower bound 90.2 %`.
    fn after(&self, b_s: f64, b_s_low: f64) -> String {
        let mills = self.behaviour.verb().does;
        format!("{mills} in {}, lower bound {}", percent(b_s), percent(b_s_low))
    }

    /// The setting in which something holds, if that is not the one that is named above.
    fn elsewhere(&self, cell: &Cell) -> String {
        if *cell == self.cell { String::new() } else { format!(", at {}", of_cell(cell)) }
    }

    /// The paper's order of remedies (§III step 3): less noise first, then an upgrade, then step 1 again.
    fn next_steps(&self) -> Vec<String> {
        let mut steps = Vec::new();
        if let Some(measured) = &self.as_measured {
            let share = format!(
                "as measured they {} in {} (lower bound {}) at {}",
                self.behaviour.verb().plain,
                percent(measured.b_s),
                percent(measured.b_s_low),
                measured.cell
            );
            steps.push(if measured.b_s_low >= self.wanted {
                format!(
                    "make the simulated robots less worse (`harsher:` in a sweep file; `rsrs choose` \
                     names the factor that matters): {share}"
                )
            } else {
                format!("less noise in the simulation does not suffice: {share}")
            });
        }
        if let Some(cause) = self.causes.first() {
            let all: Vec<&str> =
                self.causes[..=cause.with.len()].iter().map(|cause| &*cause.change).collect();
            steps.push(format!("upgrade the robots: {}", all.join(", and ")));
        }
        steps.push("then measure them again, from step 1: `rsrs measure plan`".to_owned());
        let numbered = (1..).zip(steps).map(|(number, step)| format!("  {number}. {step}"));
        std::iter::once("what to do, in this order:".to_owned()).chain(numbered).collect()
    }
}

fn cost(cause: &Cause) -> String {
    cause.cost.map_or_else(String::new, |cost| format!(" (costs {cost})"))
}
