//! The steps from a measured robot to a verdict: one module for each arrow of the method, each one
//! function from files to files.

pub mod campaign;
pub mod choose;
pub mod compare;
pub mod episode;
pub mod error;
pub mod execution;
pub mod files;
pub mod label;
pub mod measure;
pub mod picture;
pub mod provenance;
pub mod recorded_run;
pub mod replay;
pub mod report;
pub mod run;
pub mod sweep;
pub mod validate;
pub mod wording;
