//! The sweep of the page, and digests of the states of three cells after as many steps as a run of 300 s has.

use rsrs_core::diagram::sweep_file::SweepFile;
use rsrs_core::quantity::{Axis, Cell};
use rsrs_sim::controllers::Controllers;
use rsrs_sim::draw::Seed;
use rsrs_sim::world::World;
use serde_json::{Value, json};

use rsrs_testing::conditions::flockbot;
const SWEEP: &str = include_str!("../../../../launch_configs/sweeps/flockbot_speed_turn.yaml");

/// Nine Flockbots that mill; a hundred, which have a grid; and nine with all that makes a step random or late.
const CELLS: [(&str, u64); 3] = [
    ("speed_m_s=0.15,turn_rate_rad_s=0.75", 0),
    ("speed_m_s=0.2,turn_rate_rad_s=0.5,robots=100,placement_radius_m=2.75", 1),
    (
        "speed_m_s=0.125,turn_rate_rad_s=1,gain_noise=0.05,turn_bias_rad_s=0.02,heading_noise_rad=0.01,\
         gust_m_s=0.01,yaw_lag_s=0.2,latency_steps=2",
        7,
    ),
];
const N_STEPS: u64 = 2307;

/// The sweep that the page shows without a link, and its robot: JSON, as a text whose keys stay in order.
pub fn source() -> String {
    let sweep = SweepFile::parse("sweep.yaml", SWEEP).expect("the sweep is shipped");
    let profile = flockbot();
    rsrs_view::simulator::source(&sweep, &profile)
}

/// The cells, and the digest of each after its steps.
pub fn states() -> Value {
    let profile = flockbot();
    let state = |(cell, replicate): (&str, u64)| {
        let cell: Cell = cell.parse().expect("it is a cell");
        let mut sweep = SweepFile::parse("sweep.yaml", SWEEP).expect("the sweep is shipped");
        sweep.fixed.values.retain(|(axis, _)| cell.get(*axis).is_none());
        sweep.axes.0.clear();
        sweep.cells = Some(vec![cell.clone()]);
        let resolved = sweep.resolve("sweep.yaml", &profile).expect("it can be simulated");
        let conditions = &resolved[0].1;
        let seed = Seed { seed: sweep.seed, replicate };
        let mut world = World::new(conditions, seed).expect("the robots fit");
        let mut controllers = Controllers::new(conditions, seed);
        for _ in 0..N_STEPS {
            let mut commands = Vec::new();
            controllers.decide(world.sense_all(), &mut commands);
            world.advance(&commands);
        }
        let values: serde_json::Map<String, Value> = cell
            .iter()
            .map(|(axis, value): (Axis, f64)| (axis.key().to_owned(), value.into()))
            .collect();
        json!({
            "cell": values,
            "replicate": replicate,
            "n_steps": N_STEPS,
            "digest": format!("{:016x}", world.digest()),
        })
    };
    CELLS.map(state).into()
}
