//! The statistics of shares and of spreads.

pub(crate) mod beta;
pub mod beta_binomial;
pub mod e_value;
pub mod interval;
pub mod interval_kind;
pub mod pooled;
pub(crate) mod posterior;
pub(crate) mod quantile;
pub mod rank_correlation;
pub mod sequence;
pub mod share;
pub mod simulated;
pub mod variance;

/// The middle one of some numbers, at least one, after they are sorted; of an even number the greater.
pub(crate) fn median(mut numbers: Vec<f64>) -> f64 {
    numbers.sort_by(f64::total_cmp);
    numbers[numbers.len() / 2]
}
