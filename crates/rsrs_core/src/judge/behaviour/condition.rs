//! A bound on one order parameter.

use std::fmt;

use crate::judge::order::{OrderParameters, Parameter};

/// On which side of a bound a phase is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Needs {
    /// At the bound or above.
    AtLeast,
    /// Below it.
    Below,
    /// At the bound or below.
    AtMost,
}

impl Needs {
    /// The name in files.
    pub fn key(self) -> &'static str {
        match self {
            Self::AtLeast => "at_least",
            Self::Below => "below",
            Self::AtMost => "at_most",
        }
    }
}

/// One bound of a rule.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Condition {
    /// The order parameter.
    pub parameter: Parameter,
    /// On which side of the bound it must be.
    pub needs: Needs,
    /// The bound, in the unit of the order parameter.
    pub bound: f64,
}

impl Condition {
    /// An order parameter must be at least this.
    pub const fn at_least(parameter: Parameter, bound: f64) -> Self {
        Self { parameter, needs: Needs::AtLeast, bound }
    }

    /// An order parameter must be less than this.
    pub const fn below(parameter: Parameter, bound: f64) -> Self {
        Self { parameter, needs: Needs::Below, bound }
    }

    /// An order parameter must be this or less.
    pub const fn at_most(parameter: Parameter, bound: f64) -> Self {
        Self { parameter, needs: Needs::AtMost, bound }
    }

    /// Whether it holds.
    pub fn holds(&self, evidence: &OrderParameters) -> bool {
        let found = self.parameter.of(evidence);
        match self.needs {
            Needs::AtLeast => found >= self.bound,
            Needs::Below => found < self.bound,
            Needs::AtMost => found <= self.bound,
        }
    }

    /// Whether it holds of every swarm, or of none; `None` if it decides.
    pub fn foregone(&self) -> Option<bool> {
        match self.needs {
            Needs::AtLeast => (self.bound <= 0.0).then_some(true),
            Needs::Below if self.bound <= 0.0 => Some(false),
            Needs::Below => (self.bound > self.parameter.most()).then_some(true),
            Needs::AtMost => (self.bound >= self.parameter.most()).then_some(true),
        }
    }
}

/// `0.50 or more`, `less than 0.02`, `0.02 or less` or `none at all`.
impl fmt::Display for Condition {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let bound = self.parameter.with_unit(self.bound);
        match self.needs {
            Needs::AtLeast => write!(formatter, "{bound} or more"),
            Needs::AtMost if self.bound == 0.0 => formatter.write_str("none at all"),
            Needs::AtMost => write!(formatter, "{bound} or less"),
            Needs::Below => write!(formatter, "less than {bound}"),
        }
    }
}
