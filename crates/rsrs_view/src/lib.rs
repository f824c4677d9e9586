//! Pictures, pure: data to SVG and PNG.
//!
//! [`diagram`] draws a phase diagram and [`trajectory`] one run; of the measured robots,
//! [`distribution`] draws their speeds, [`sensor`] what they detect, and [`reach`] real trajectories
//! over simulated ones. All give SVG text that is the same on every machine; [`raster`] turns it into
//! a PNG with a font that it carries along. Nothing here opens a file or asks the machine for its
//! fonts.

pub mod diagram;
pub mod distribution;
pub mod reach;
pub mod sensor;
pub mod trajectory;

pub mod palette;
pub mod raster;

mod axes;
mod chart;
mod header;
mod legend;
mod overlay;
mod plot;
mod scale;
mod slice;
mod svg;
mod symbol;
mod text;
mod track;
