//! rosbag2 MCAP bags: write, read, and trajectories out of them.
//!
//! A bag is a folder with `metadata.yaml` and one or more `.mcap` files, as `ros2 bag record` makes
//! it; every tool that knows rosbag2 opens ours, and [`reader::Bag`] opens any laboratory's.
//!
//! * [`writer`] — records a run; what was recorded up to a second ago survives `kill -9`.
//! * [`reader`] — messages in order of time, attachments, metadata; also out of a bag cut short.
//! * [`trajectory`] — poses and commands of the swarm, as the judge takes them.
//!
//! It does not play bags back, and it neither splits nor compresses whole files.

pub mod error;
mod metadata;
mod qos;
pub mod reader;
pub mod trajectory;
pub mod writer;

pub use error::BagError;
pub use reader::{Attachment, Bag, BagMessage, Damage, TopicInfo};
pub use writer::{BagOptions, BagSummary, BagWriter, ChannelId, Sample};
