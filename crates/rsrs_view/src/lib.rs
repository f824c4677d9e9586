#![doc = include_str!("../README.md")]
//! # Modules
//!
//! [`diagram`] draws a phase diagram, [`curves`] shares along one quantity, [`trajectory`] one run,
//! [`order_over_time`] the same beside its order parameters, and [`placement`] its start; of the measured
//! robots, [`distribution`] draws their speeds, [`sensor`] what they detect, and [`reachable_set`] real
//! trajectories over simulated ones. [`film`] moves a run, and [`gallery`] shows some side by side. All
//! others give SVG text, coloured by a [`theme`]; [`raster`] turns it into a PNG, [`pdf`] into a PDF, [`page`]
//! puts pictures and tables into one HTML file, and [`report`] is one whose cells and runs, packed by
//! [`replay`], respond and move; [`simulator`] is one that simulates.

#![expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "casts from floats saturate, and sides, times and shares are not negative"
)]

pub mod curves;
pub mod diagram;
pub mod distribution;
pub mod film;
pub mod gallery;
pub mod order_over_time;
pub mod placement;
pub mod reachable_set;
pub mod sensor;
pub mod trajectory;

pub mod page;
pub mod palette;
pub mod pdf;
pub mod quantity;
pub mod raster;
pub mod replay;
pub mod report;
pub mod simulator;
pub mod theme;

mod arrangement;
mod axes;
mod boundary;
mod cell_values;
mod chart;
mod floor;
mod header;
mod layout;
mod legend;
mod marks;
mod overlay;
mod panel;
mod picture;
mod plot;
mod scale;
mod slice;
mod svg;
mod symbol;
mod text;
mod track;

pub use svg::resized;
