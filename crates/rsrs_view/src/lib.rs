//! Pictures, pure: data to SVG and PNG.
//!
//! [`diagram`] draws a phase diagram and [`trajectory`] one run, as SVG text that is the same on
//! every machine; [`raster`] turns either into a PNG with a font that it carries along. Nothing here
//! opens a file or asks the machine for its fonts.

pub mod diagram;
pub mod trajectory;

pub mod palette;
pub mod raster;

mod axes;
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
