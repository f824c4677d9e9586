//! What a person gets of a result: every sentence, table, report and picture.
//!
//! The steps of `rsrs_pipeline` return plain data, and the command line and the Python package print and
//! show them by this crate. Words are spans of which some have a tone ([`words`]); how they are coloured is
//! here, too, and whether is not. What is written as JSON is the data itself, with its sentences where a
//! program is to show them.
//!
//! An error has its sentence at its type, where it comes from.
//!
//! # Examples
//!
//! ```
//! use rsrs_core::quantity::Axis;
//! use rsrs_render::wording::quantity::named;
//!
//! assert_eq!(named(Axis::Speed, 0.15), "speed 0.15 m/s");
//! ```

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
mod json;
pub mod label;
pub mod latex;
pub mod picture;
pub mod picture_file;
pub mod planned_experiments;
pub mod recorded_run;
pub mod recovered_bag;
pub mod reference;
pub mod replay;
pub mod report;
pub mod seen_places;
pub mod settling;
pub mod start_poses;
pub mod sweep;
pub mod validation;
mod why_a_range_ends;
pub mod wording;
pub mod words;
