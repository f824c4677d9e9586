//! What goes wrong in one run, drawn from its seed.

use std::collections::BTreeSet;

use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use rsrs_fleet::experiment::RobotLost;

use crate::network::{Faults, Node};

pub const N_ROBOTS: usize = 3;

/// Nothing begins to go wrong after this time, in milliseconds.
pub const LAST_HAPPENING_MS: u64 = 7_000;

#[derive(Clone, Debug)]
pub struct Scenario {
    pub seed: u64,
    pub faults: Faults,
    pub robot_lost: RobotLost,
    /// When the first runner dies without a word, in milliseconds.
    pub crash_ms: Option<u64>,
    /// When a second runner starts, in milliseconds.
    pub second_runner_ms: Option<u64>,
    /// When a controller restarts with its default parameters, in milliseconds.
    pub controller_reboot_ms: Option<(usize, u64)>,
    /// When a robot's gate restarts, in milliseconds.
    pub robot_reboot_ms: Option<(usize, u64)>,
    /// A controller that confirms its parameters and drives with others.
    pub liar: Option<usize>,
    /// When somebody engages the e-stop, in milliseconds.
    pub e_stop_ms: Option<u64>,
    /// When somebody types `rsrs stop`, in milliseconds.
    pub stop_ms: Option<u64>,
    /// When somebody types `rsrs stop --release`, in milliseconds.
    pub release_ms: Option<u64>,
    /// How long robots stand armed before they move, in milliseconds.
    pub countdown_ms: u64,
    /// When somebody interrupts the first runner, in milliseconds.
    pub interrupt_ms: Option<u64>,
}

impl Scenario {
    /// A network as on one desk, and nothing that goes wrong.
    pub fn calm(seed: u64) -> Self {
        Self {
            seed,
            faults: Faults { loss: 0.0, duplication: 0.0, delay_ms: 3, partition: None },
            robot_lost: RobotLost::Abort,
            crash_ms: None,
            second_runner_ms: None,
            controller_reboot_ms: None,
            robot_reboot_ms: None,
            liar: None,
            e_stop_ms: None,
            stop_ms: None,
            release_ms: None,
            countdown_ms: 0,
            interrupt_ms: None,
        }
    }

    pub fn draw(seed: u64) -> Self {
        let mut generator = ChaCha8Rng::seed_from_u64(seed);
        let mut pick = |choices: &[f64]| choices[generator.random_range(0..choices.len())];
        let loss = pick(&[0.0, 0.0, 0.05, 0.2, 0.4]);
        let duplication = pick(&[0.0, 0.1, 0.3]);
        let delays_ms = [3, 20, 100, 400, 900];
        let delay_ms = delays_ms[generator.random_range(0..delays_ms.len())];
        let mut at_ms = |probability: f64| {
            let time_ms = generator.random_range(0..LAST_HAPPENING_MS);
            (generator.random::<f64>() < probability).then_some(time_ms)
        };
        let (crash_ms, second_runner_ms) = (at_ms(0.3), at_ms(0.3));
        let (controller_reboot_ms, robot_reboot_ms) = (at_ms(0.2), at_ms(0.2));
        let (e_stop_ms, interrupt_ms, cut_ms) = (at_ms(0.1), at_ms(0.1), at_ms(0.3));
        let mut one_robot = || generator.random_range(0..N_ROBOTS);
        let (slow, forgetful, liar) = (one_robot(), one_robot(), one_robot());
        let lies = generator.random::<f64>() < 0.1;
        let robot_lost =
            if generator.random::<bool>() { RobotLost::Abort } else { RobotLost::Note };
        let length_ms = generator.random_range(200..3_000);
        let nodes = (0..N_ROBOTS)
            .flat_map(|robot| [Node::Robot(robot), Node::Controller(robot)])
            .chain([Node::Runner(0), Node::Runner(1)]);
        let side: BTreeSet<_> = nodes.filter(|_| generator.random::<bool>()).collect();
        let partition = cut_ms.map(|start_ms| (start_ms, start_ms + length_ms, side));
        Self {
            seed,
            faults: Faults { loss, duplication, delay_ms, partition },
            robot_lost,
            crash_ms,
            second_runner_ms,
            controller_reboot_ms: controller_reboot_ms.map(|at_ms| (forgetful, at_ms)),
            robot_reboot_ms: robot_reboot_ms.map(|at_ms| (slow, at_ms)),
            liar: lies.then_some(liar),
            e_stop_ms,
            stop_ms: None,
            release_ms: None,
            countdown_ms: 0,
            interrupt_ms,
        }
    }

    /// Somebody stops everything in the middle of what else goes wrong.
    pub fn draw_with_stop(seed: u64) -> Self {
        let mut generator = ChaCha8Rng::seed_from_u64(seed);
        generator.set_stream(2);
        let stop_ms = generator.random_range(1_500..LAST_HAPPENING_MS);
        Self {
            stop_ms: Some(stop_ms),
            countdown_ms: [0, 0, 500][generator.random_range(0..3)],
            e_stop_ms: None,
            ..Self::draw(seed)
        }
    }
}
