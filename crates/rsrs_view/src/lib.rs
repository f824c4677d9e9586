//! Pictures, pure: data to SVG and PNG.
//!
//! [`diagram`] draws a phase diagram, [`curves`] shares along one quantity, [`trajectory`] one run,
//! [`order_over_time`] the same beside its order parameters, and [`placement`] its start; of the measured
//! robots, [`distribution`] draws their speeds, [`sensor`] what they detect, and [`reach`] real
//! trajectories over simulated ones. [`film`] moves a run, and [`gallery`] shows some side by side. All others give SVG text that is the same on every machine; [`raster`] turns it into
//! a PNG with a font that it carries along, and [`page`] puts pictures and tables into one HTML file.
//! Nothing here opens a file or asks the machine for its fonts.

pub mod curves;
pub mod diagram;
pub mod distribution;
pub mod film;
pub mod gallery;
pub mod order_over_time;
pub mod placement;
pub mod reach;
pub mod sensor;
pub mod trajectory;

pub mod page;
pub mod palette;
pub mod raster;

mod axes;
mod chart;
mod floor;
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
