//! Simulates nine Flockbots for five minutes and draws them from above.
//!
//! `cargo run --release -p rsrs_view --example draw_a_mill -- PICTURE.svg`

use rsrs_core::conditions::Conditions;
use rsrs_core::judge::phase::label;
use rsrs_sim::draw::Seed;
use rsrs_sim::episode::run_episode;
use rsrs_view::theme::Theme;
use rsrs_view::trajectory::{TrajectoryPicture, svg};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let path = std::env::args().nth(1).ok_or("PICTURE.svg")?;
    let conditions = Conditions::flockbots(9);
    let run = run_episode(&conditions, Seed { seed: 1, replicate: 0 }, 300.0)?;
    let picture = TrajectoryPicture {
        trajectory: &run,
        radius_m: conditions.robot.radius_m,
        tail_s: 60.0,
        phase: Some(label(&run, &conditions.bodies())?.phase),
        lost: &[],
        names: &[],
        walls_m: None,
        world: None,
        classes: &[],
        theme: Theme::Screen,
        title: "Nine Flockbots".to_owned(),
        subtitle: "five minutes, simulated".to_owned(),
    };
    Ok(std::fs::write(path, svg(&picture)?)?)
}
