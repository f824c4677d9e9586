#![doc = include_str!("../README.md")]
//! # Words
//!
//! Words are spans of which some have a tone ([`words`]); how they are coloured is here, too, and whether is not.
//! What is written as JSON is the data itself, with its sentences where a program is to show them.

pub mod agreement;
pub mod answers;
pub mod axes;
pub mod bag_contents;
pub mod campaign;
pub mod choice;
pub mod columns;
pub mod comparison;
pub mod diagnosis;
pub mod difference;
pub mod driven_trials;
pub mod dry_run;
pub mod episode;
pub mod explored;
pub mod factors;
pub mod fit;
pub mod gaps;
pub mod init;
mod json;
pub mod keystore;
pub mod label;
pub mod latex;
pub mod operator_event;
pub mod own_network;
pub mod picture;
pub mod picture_file;
pub mod planned_experiments;
pub mod recorded_run;
pub mod recovered_bag;
pub mod reference;
pub mod replay;
pub mod report;
pub mod run_summary;
pub mod seen_places;
pub mod settling;
pub mod start_poses;
pub mod stop;
pub mod sweep;
pub mod validation;
mod why_a_range_ends;
pub mod wording;
pub mod words;
