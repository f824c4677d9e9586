//! A bag back on the network, or into today's controller or judge.

mod into_controller;
mod into_judge;
mod selection;

pub use into_controller::{ControllerReplay, Difference, RobotReplay, replay_into_controller};
pub use into_judge::{JudgeReplay, JudgedPhase, replay_into_judge};
pub use selection::{Selected, Selection, select};
