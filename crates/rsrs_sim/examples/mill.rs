//! Simulates nine Flockbots for five minutes and names the phase that they settle into.
//!
//! `cargo run --release -p rsrs_sim --example mill -- [SPEED_M_S TURN_RATE_RAD_S]`

#![expect(clippy::print_stdout, reason = "prints its result")]

use rsrs_core::conditions::Conditions;
use rsrs_core::judge::phase::label;
use rsrs_core::robot::controller::ControllerParameters;
use rsrs_sim::draw::Seed;
use rsrs_sim::episode::run_episode;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut conditions = Conditions::flockbots(9);
    let numbers: Vec<f64> =
        std::env::args().skip(1).map(|text| text.parse()).collect::<Result<_, _>>()?;
    if let [speed_m_s, turn_rate_rad_s] = numbers[..] {
        conditions.controller = ControllerParameters::mirrored(speed_m_s, turn_rate_rad_s).into();
    }
    for replicate in 0..5 {
        let run = run_episode(&conditions, Seed { seed: 1, replicate }, 300.0)?;
        let verdict = label(&run, &conditions.bodies())?;
        println!(
            "{}: circliness {:.2}, radius {:.2} m",
            verdict.phase, verdict.evidence.circliness, verdict.evidence.mean_radius_m
        );
    }
    Ok(())
}
