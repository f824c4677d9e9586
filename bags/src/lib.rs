#![doc = include_str!("../README.md")]
//! # Modules
//!
//! * [`writer`] — records a run; what was recorded up to a second ago survives `kill -9`.
//! * [`definitions`] — definitions of message types, from the user's own folders.
//! * [`reader`] — messages in order of time, attachments, metadata; also out of a bag cut short.
//! * [`info`] — what is in a bag, at a glance.
//! * [`mod@recover`] — a new bag out of a damaged one, and what was lost.
//! * [`trajectory`] — poses and commands of the swarm, as the judge takes them.

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
