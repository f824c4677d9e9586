//! What the tests, benchmarks and examples of several crates share; nothing that is installed uses it.

#![expect(clippy::missing_panics_doc, reason = "what tests share fails by panics")]

pub mod chromium;
pub mod conditions;
pub mod draw;
pub mod environment;
pub mod fuzz;
#[cfg(feature = "network")]
pub mod network;
pub mod processor;
pub mod python;
#[cfg(feature = "records")]
pub mod record;
