//! Episodes under a controller from outside.

use std::convert::Infallible;

use rsrs_core::robot::controller::decide;
use rsrs_sim::draw::Seed;
use rsrs_sim::episode::{Observed, run_controlled, run_episode};
use rsrs_sim::world::World;

use crate::support::{HARSHER, flockbots};

const SEED: Seed = Seed { seed: 7, replicate: 3 };

#[test]
fn an_episode_under_its_own_controller_from_outside_is_the_episode() {
    let conditions = flockbots(0.15, 0.75, &HARSHER);
    let world = World::new(&conditions, SEED).unwrap();

    let observed = run_controlled(world, &conditions, 60.0, |readings, commands| {
        let parameters = conditions.controller.parameters().expect("two commands");
        commands.extend(readings.iter().map(|it| decide(it.detection(), parameters)));
        Ok::<(), Infallible>(())
    });

    let Ok(Observed { trajectory, detections }) = observed;
    assert_eq!(trajectory, run_episode(&conditions, SEED, 60.0).unwrap());
    let decided = detections
        .iter()
        .map(|it| decide(*it, conditions.controller.parameters().expect("two commands")));
    assert!(decided.eq(trajectory.commands));
}
