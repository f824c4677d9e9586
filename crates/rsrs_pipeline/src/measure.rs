//! Step 1: from trials to a profile of the robots.

pub mod bag_trials;
pub mod command_rhythm;
pub mod fit;
pub mod plan_folder;
pub mod sensor_readings;
pub mod sources;
pub mod trial_files;
pub mod trial_window;
