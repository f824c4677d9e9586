//! The five answers as a person reads them.

use std::fmt;

use rsrs_core::judge::behaviour::Verb;
use rsrs_core::quantity::Axis;

use super::{Answer, Answers, Quantity, Range};
use crate::wording::quantity::{named, of_cell, quantity, span};
use crate::wording::{count, percent};

impl fmt::Display for Answers {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let verb = self.behaviour.verb();
        writeln!(
            formatter,
            "{}: {} {},\nin {} of {} fresh runs of {} s (lower bound {}; wanted {}){}",
            self.robot,
            if self.viable {
                format!("they {} with", verb.plain)
            } else {
                format!("they do not {}; most often with", verb.plain)
            },
            self.settings_text(),
            percent(self.b_s),
            count(self.n_replicates),
            self.duration_s,
            percent(self.b_s_low),
            percent(self.wanted),
            if self.viable { "" } else { "; `rsrs diagnose` names what to change" }
        )?;
        if let Some(differ) = &self.other_profile {
            writeln!(formatter, "note: the settings are those of another sweep: {differ}")?;
        }
        for line in &self.alternatives {
            writeln!(formatter, "{line}")?;
        }
        for (number, answer) in (1..).zip(&self.questions) {
            writeln!(formatter, "\n{number}. {}", answer.question)?;
            for line in answer.lines(verb) {
                writeln!(formatter, "   {line}")?;
            }
        }
        write!(
            formatter,
            "\nA range ends before the first value with which fewer than {} of the runs {}, made worse or \
             as measured, all else as recommended{}; what chance has put out of order is pooled. \
             A margin is from what is recommended to the end of its range, by runs of its own; how far a value \
             may drift by `rsrs choose` goes from swept value to swept value.",
            percent(self.wanted),
            verb.plain,
            self.fixed_text()
        )?;
        if self.decided_factors.is_empty() {
            return Ok(());
        }
        write!(
            formatter,
            "\nRobots with each value are made worse by {} of the sweep, whatever the value is; all other \
             factors follow from it.",
            self.decided_factors.join(", ")
        )
    }
}

impl Answers {
    /// The recommendation in words: `9 robots, speed 0.15 m/s`.
    pub fn settings_text(&self) -> String {
        of_cell(&self.cell)
    }

    fn fixed_text(&self) -> String {
        let fixed = of_cell(&self.fixed);
        if fixed.is_empty() { fixed } else { format!(" ({fixed})") }
    }
}

impl Answer {
    fn lines(&self, verb: Verb) -> Vec<String> {
        self.quantities.iter().flat_map(|quantity| quantity.lines(verb)).collect()
    }
}

impl Quantity {
    /// The range in words, and why it ends.
    fn lines(&self, verb: Verb) -> [String; 2] {
        let has = named(self.axis, self.recommended);
        let range = match &self.range {
            None => format!("{} too rarely", verb.does),
            Some(range) => range.text(self.axis, verb),
        };
        [format!("{has}: {range}"), format!("  {}", self.reason)]
    }
}

impl Range {
    /// `mills from 5 to 9 robots (margin 3 below, 1 above)`.
    fn text(&self, axis: Axis, verb: Verb) -> String {
        let Self { low, high, margin, .. } = self;
        let end = |is_end: bool, margin: f64, side: &str| {
            is_end.then(|| format!("{} {side}", quantity(axis, margin)))
        };
        let below = end(self.ends_below, margin.low, "below");
        let above = end(self.ends_above, margin.high, "above");
        let margins: Vec<String> = below.into_iter().chain(above).collect();
        let tried = match (self.ends_below, self.ends_above) {
            (true, true) => String::new(),
            (true, false) => format!("; more than {} was not tried", quantity(axis, *high)),
            (false, true) => format!("; less than {} was not tried", quantity(axis, *low)),
            (false, false) => "; nothing else was tried".to_owned(),
        };
        let margin = if margins.is_empty() {
            String::new()
        } else {
            format!(" (margin {})", margins.join(", "))
        };
        format!("{} from {}{margin}{tried}", verb.does, span(axis, *low, *high))
    }
}
