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
