//! The statistics of shares, of spreads, and of reality against the simulator.

pub(crate) mod beta;
pub mod comparison;
pub mod e_value;
pub mod experiment_plan;
pub mod interval;
pub mod interval_kind;
pub mod left_out;
pub mod next_experiment;
pub mod pooled;
pub(crate) mod posterior;
pub(crate) mod quantile;
pub mod sequence;
pub mod share;
pub mod simulated;
pub mod variance;
