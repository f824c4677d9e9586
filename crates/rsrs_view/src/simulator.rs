//! The page that simulates in a browser, and what it has of this source.
//!
//! `page/build` makes it: the simulator and the judge as WebAssembly, and what moves sliders. It is one file
//! that asks for nothing from elsewhere, and the same as `docs/simulator.html`.

use rsrs_core::diagram::sweep_file::SweepFile;
use rsrs_core::judge::order::Parameter;
use rsrs_core::judge::phase::Phase;
use rsrs_core::quantity::Axis;
use rsrs_core::robot::profile::RobotProfile;
use serde::Serialize;
use serde_json::{Value, json};

use crate::order_over_time::colour;
use crate::palette::{LEAST_SHARE, hue, least_hue};
use crate::symbol::{Filling, MARK_PX, mark};

/// The page. Behind `#` in its address is what it shows: `speed_m_s=0.15&robots=12`, with the sweep and the
/// robot under `source` as JSON if they are not the Flockbots'.
pub const PAGE: &str = include_str!("../assets/simulator.html");

/// What the page simulates cells of, as JSON whose keys stay in order.
///
/// # Panics
///
/// Never: both are plain data.
pub fn source(sweep: &SweepFile, profile: &RobotProfile) -> String {
    #[derive(Serialize)]
    struct Source<'a> {
        sweep: &'a SweepFile,
        profile: &'a RobotProfile,
    }
    serde_json::to_string(&Source { sweep, profile }).expect("both are plain data")
}

/// Names, colours and symbols that the page has of the source.
pub fn keys() -> Value {
    let axis = |axis: Axis| {
        json!({
            "key": axis.key(),
            "name": axis.name(),
            "unit": axis.unit(),
            "is_count": axis.is_count(),
        })
    };
    let phase = |phase: Phase| {
        let symbol = mark(phase, Filling::Full, ((0.0, 0.0), MARK_PX));
        json!({
            "key": phase.key(),
            "title": phase.title(),
            "colour": hue(phase).hex(),
            "least_hue": least_hue(phase),
            "symbol": symbol.to_string(),
        })
    };
    let parameter =
        |parameter: Parameter| json!({ "key": parameter.key(), "colour": colour(parameter) });
    json!({
        "axes": Axis::ALL.map(axis),
        "phases": Phase::BUILT_IN.map(phase),
        "least_share": LEAST_SHARE,
        "parameters": Parameter::all().map(parameter).collect::<Vec<_>>(),
    })
}
