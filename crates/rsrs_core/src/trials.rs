//! Trials on the floor: which are worth running, what they measure, and whether the simulator agrees.

pub mod fit;
pub mod plan;
pub mod trial;
pub mod validation;
