//! rosbag2 MCAP bags: write, read, and trajectories out of them.
//!
//! A bag is a folder with `metadata.yaml` and one or more `.mcap` files, as `ros2 bag record` makes
//! it; every tool for rosbag2 opens ours, and [`reader::Bag`] opens any laboratory's.
//!
//! * [`writer`] — records a run; what was recorded up to a second ago survives `kill -9`.
//! * [`definitions`] — definitions of message types, from the user's own folders.
//! * [`reader`] — messages in order of time, attachments, metadata; also out of a bag cut short.
//! * [`info`] — what is in a bag, at a glance.
//! * [`mod@recover`] — a new bag out of a damaged one, and what was lost.
//! * [`trajectory`] — poses and commands of the swarm, as the judge takes them.
//!
//! `cargo run --release -p rsrs_bags --example phase_of_a_bag -- BAG 0.075 0.825` names the phase of a
//! recorded swarm; `cargo run --release -p rsrs_bags --example bag_throughput -- FOLDER` measures how fast all that
//! is here.
//!
//! It does not play bags back, and it does not read `SQLite` bags.

pub mod definitions;
pub mod error;
pub mod info;
mod metadata;
mod qos;
pub mod reader;
mod records;
pub mod recover;
pub mod trajectory;
pub mod writer;

pub use error::BagError;
pub use info::BagInfo;
pub use metadata::METADATA;
pub use qos::OfferedQos;
pub use reader::{Attachment, Bag, BagMessage, Damage, TopicInfo};
pub use recover::{
    Loss, LossKind, LostMessages, Recovered, Recovery, recover, recover_into, recovered_name,
};
pub use writer::{BagOptions, BagSummary, BagWriter, ChannelId, Compression, Packing, Sample};
