//! A value of a quantity that was tried.

use rsrs_core::conditions::Conditions;
use rsrs_core::judge::counts::PhaseCounts;

/// A value, and how runs with it end in the world in which mills are rarer.
pub struct TriedValue {
    /// The value.
    pub value: f64,
    /// How its runs end.
    pub phases: PhaseCounts,
    /// Its conditions in the world of robots made worse.
    pub harsher: Conditions,
    /// Mean radius of the mills in that world, in metres; `None` if there were none.
    pub ring_m: Option<f64>,
}
