//! The judge: from a trajectory to the phase of a swarm, how sure that is, and who agrees.

pub mod agreement;
pub mod behaviour;
pub mod certainty;
pub mod columns;
pub mod counts;
pub mod number;
pub mod order;
pub mod phase;
pub mod plausibility;
pub mod reason;
pub mod trajectory;
pub mod window;
