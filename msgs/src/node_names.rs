//! Names of the nodes of a fleet, by which topics, keystores and preflights know them.

/// The gate in front of a robot's wheels, in the robot's namespace.
pub const GATE: &str = "robot";
/// A robot's controller, in the robot's namespace.
pub const CONTROLLER: &str = "controller";
/// The simulator; it stands for no robot, so it has no namespace.
pub const SIMULATOR: &str = SIMULATOR_FULL_NAME.split_at(1).1;
/// The simulator, as the graph and services have it.
pub const SIMULATOR_FULL_NAME: &str = "/simulator";
/// Who conducts a run.
pub const RUNNER: &str = "experiment_runner";
/// Who stops all robots.
pub const STOP: &str = "rsrs_stop";
/// Who watches.
pub const WATCH: &str = "rsrs_watch";
/// Who looks where the robots stand before a run.
pub const PLACE: &str = "rsrs_place";
/// What replays a bag with a clock of its own.
pub const REPLAY: &str = "replay";
