//! How the files in the folder of a search are called.

/// Name of the profile in the folder.
pub const PROFILE: &str = "profile.yaml";
/// Name of the controller's table in the folder, where its numbers are searched.
pub const CONTROLLER: &str = "controller.yaml";
/// Name of the world in the folder, where there is one.
pub const WORLD: &str = "world.yaml";
/// Name of the table of start poses in the folder, where there is one.
pub const STARTS: &str = "starts.csv";
/// Name of what the search follows from, besides the robot.
pub const SETTINGS: &str = "exploration.yaml";
