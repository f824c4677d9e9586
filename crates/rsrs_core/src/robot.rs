//! The robot: as measured, as made worse, and what it does with what it sees.

pub mod contact;
pub mod controller;
pub mod harsher;
pub mod other_profile;
pub mod pose_source;
pub mod profile;
pub mod pseudo_reality;
pub mod region;
pub mod sensor;
pub mod shape;
pub mod unicycle;
pub mod wheels;
