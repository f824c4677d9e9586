//! A fleet that is watched while it runs, or out of a bag.
//!
//! What is seen is a [`rsrs_fleet::observation::Observation`]; here messages become its events.
//! [`live`] receives them, [`recording`] reads them, and [`meaning`] is the same for both.

pub mod foxglove;
pub mod live;
mod meaning;
pub mod recording;
pub mod stop;
