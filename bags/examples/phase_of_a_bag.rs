//! Reads poses and commands out of a bag and names the phase of the swarm.
//!
//! `cargo run --release -p rsrs_bags --example phase_of_a_bag -- BAG RADIUS_M REACH_M`

#![expect(clippy::print_stdout, reason = "prints its result")]

use std::path::Path;

use rsrs_bags::Bag;
use rsrs_bags::trajectory::{TrajectoryOptions, read_trajectory};
use rsrs_core::judge::phase::label;
use rsrs_core::judge::trajectory::Bodies;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [bag, radius_m, reach_m] = &arguments[..] else {
        return Err("BAG RADIUS_M REACH_M".into());
    };
    let bodies = Bodies {
        radius_m: Some(radius_m.parse()?),
        reach_m: Some(reach_m.parse()?),
        ..Bodies::UNKNOWN
    };
    let recorded = read_trajectory(&Bag::open(Path::new(bag))?, &TrajectoryOptions::default())?;
    let verdict = label(&recorded.trajectory, &bodies)?;

    println!("{}: {} for {:.0} s", recorded.robots.join(", "), verdict.phase, verdict.duration_s);
    Ok(())
}
