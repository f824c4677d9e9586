//! A fleet that is watched while it runs, or out of a bag.
//!
//! What is seen is a [`rsrs_fleet::observation::Observation`]; here messages become its events.
//! [`live`] receives them and [`recording`] reads them; what they mean is the same for both.
//! [`stop`] stops the robots.

pub mod live;
pub mod recording;
pub mod stop;
mod watched_topic;
