//! What goes wrong in one run, drawn from its seed.

use std::collections::BTreeSet;

use rand::RngExt;
use rand::rngs::Xoshiro256PlusPlus;
use rsrs_fleet::experiment::RobotLost;

use crate::network::{Faults, Node, Stream, draws};

/// Robots of the fleets to which the worst happens.
const N_ROBOTS: usize = 3;

/// Buttons that may be on the wall.
pub const N_BUTTONS: usize = 2;

/// Nothing begins to go wrong after this time, in milliseconds.
pub const LAST_HAPPENING_MS: u64 = 4_500;

/// What the robots are made of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Body {
    /// Each has a process and wheels of its own.
    Real,
    /// The simulator stands in for all of them, at the pace of the wall clock.
    Simulated,
    /// The simulator stands in for all of them, in lockstep with controllers and recorder.
    Lockstep,
}

/// What happens to a fleet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Happening {
    /// A process dies without a word.
    Crash(Node),
    /// A process that died is started again.
    Restart(Node),
    /// A process gets no time from its machine for so long, in milliseconds.
    Stall(Node, u64),
    /// A runner starts.
    Start(usize),
    /// The operator presses Ctrl-C.
    Interrupt,
    /// A person types `rsrs stop`.
    Stop,
    /// A person types `rsrs stop --release`.
    Release,
    /// A button publishes engaged from now on.
    Press(usize),
    /// A button publishes from now on that it is not engaged.
    Unpress(usize),
    /// A button's node dies.
    ButtonFallsSilent(usize),
    /// A person sets the parameters of a controller.
    Meddle(usize),
    /// A person sets another world in the simulator, if there is one.
    PlaceAnother,
    /// A stranger sends a robot a command that is beyond its limits.
    Beyond(usize),
    /// The disk of the runner's host is full.
    DiskFull,
    /// Whatever is wrong is put right, and the operator ends what still runs.
    Heal,
}

#[derive(Clone, Debug)]
pub struct Scenario {
    pub seed: u64,
    pub n_robots: usize,
    pub body: Body,
    pub faults: Faults,
    pub robot_lost: RobotLost,
    /// What happens, and when, in milliseconds.
    pub happenings: Vec<(u64, Happening)>,
    /// Which buttons there are; each publishes that it is not engaged until something happens to
    /// it.
    pub has_button: [bool; N_BUTTONS],
    /// Robots without a gate of ours: their controllers hold the lease.
    pub controller_only: Vec<bool>,
    /// By runner: which robots it wants; those that are not listed want all.
    pub teams: Vec<Vec<usize>>,
    /// Whether runners receive the robots, and never each other.
    pub are_runners_apart: bool,
    /// A controller that confirms its parameters and drives with others.
    pub liar: Option<usize>,
    /// How far each robot's wall clock is ahead of the runners', in milliseconds.
    pub ahead_ms: Vec<i64>,
    /// How much too fast each robot's clock goes, in millionths.
    pub too_fast_ppm: Vec<i64>,
    /// How long robots stand armed before they move, in milliseconds.
    pub countdown_ms: u64,
    /// How long runs last, in milliseconds.
    pub run_ms: u64,
}

impl Scenario {
    /// A network as on one desk, and nothing that goes wrong.
    pub fn calm(seed: u64) -> Self {
        Self {
            seed,
            n_robots: N_ROBOTS,
            body: Body::Real,
            faults: Faults::none(),
            robot_lost: RobotLost::Abort,
            happenings: Vec::new(),
            has_button: [false; N_BUTTONS],
            controller_only: vec![false; N_ROBOTS],
            teams: Vec::new(),
            are_runners_apart: false,
            liar: None,
            ahead_ms: vec![0; N_ROBOTS],
            too_fast_ppm: vec![0; N_ROBOTS],
            countdown_ms: 0,
            run_ms: 3_000,
        }
    }

    /// So many robots behind radio links, in a long run to which nothing else happens.
    pub fn on_a_floor(seed: u64, n_robots: usize, faults: Faults) -> Self {
        Self {
            n_robots,
            faults,
            controller_only: vec![false; n_robots],
            ahead_ms: vec![0; n_robots],
            too_fast_ppm: vec![0; n_robots],
            countdown_ms: 3_000,
            run_ms: 300_000,
            ..Self::calm(seed)
        }
    }

    /// Which robots a runner wants.
    pub fn robots_of(&self, runner: usize) -> Vec<usize> {
        self.teams.get(runner).cloned().unwrap_or_else(|| (0..self.n_robots).collect())
    }

    /// The same with this happening at that time.
    pub fn with(mut self, at_ms: u64, happening: Happening) -> Self {
        self.happenings.push((at_ms, happening));
        self
    }

    /// Anything may go wrong; at the end it is put right, and another run is made.
    pub fn draw(seed: u64) -> Self {
        let mut draw = Draw { generator: draws(seed, Stream::Scenario) };
        let body = draw.of(&[Body::Real, Body::Real, Body::Simulated, Body::Lockstep]);
        let mut scenario = Self {
            body,
            faults: draw.faults(),
            robot_lost: draw.of(&[RobotLost::Abort, RobotLost::Note]),
            has_button: [draw.chance(0.2), false],
            liar: draw.chance(0.05).then(|| draw.robot()),
            ahead_ms: draw.clocks(&[0, 0, 0, 300, -300, 6_000]),
            too_fast_ppm: draw.clocks(&[0, 2_000, -2_000]),
            countdown_ms: draw.of(&[0, 0, 300]),
            run_ms: draw.of(&[600, 1_500, 3_000]),
            happenings: draw.happenings(body),
            ..Self::calm(seed)
        };
        if !scenario.has_button[0] {
            let needs_button = [Happening::Press(0), Happening::ButtonFallsSilent(0)];
            scenario.happenings.retain(|(_, happening)| !needs_button.contains(happening));
        }
        if body != Body::Real {
            // One machine has one clock.
            scenario.ahead_ms = vec![scenario.ahead_ms[0]; N_ROBOTS];
            scenario.too_fast_ppm = vec![scenario.too_fast_ppm[0]; N_ROBOTS];
        }
        if body == Body::Real && draw.chance(0.3) {
            scenario.controller_only = (0..N_ROBOTS).map(|_| draw.chance(0.5)).collect();
        }
        if draw.chance(0.5) {
            // What is not awaited any more comes again.
            scenario.faults.repeat_ms = draw.of(&[1_000, 3_000, 5_000]);
        }
        scenario.are_runners_apart = draw.chance(0.2);
        if scenario.are_runners_apart && draw.chance(0.5) {
            let is_start = |happening: &Happening| *happening == Happening::Start(1);
            scenario.happenings.retain(|(_, happening)| !is_start(happening));
            scenario.happenings.push((draw.of(&[1, 30, 100, 300]), Happening::Start(1)));
        }
        scenario.has_button[1] = draw.chance(0.3);
        for (button, is_there) in scenario.has_button.into_iter().enumerate() {
            for (probability, happening) in [
                (0.3, Happening::Press(button)),
                (0.3, Happening::Unpress(button)),
                (0.1, Happening::ButtonFallsSilent(button)),
            ] {
                if is_there && draw.chance(probability) {
                    scenario.happenings.push((draw.time(), happening));
                }
            }
        }
        scenario.with(LAST_HAPPENING_MS, Happening::Heal)
    }

    /// A person stops everything in the middle of what else goes wrong.
    pub fn draw_with_stop(seed: u64) -> Self {
        let mut scenario = Self::draw(seed);
        let mut generator = draws(seed, Stream::Stop);
        let stop_ms = generator.random_range(1_000..LAST_HAPPENING_MS);
        let is_other = |happening: &Happening| *happening == Happening::Stop;
        scenario.happenings.retain(|(_, happening)| !is_other(happening));
        scenario.with(stop_ms, Happening::Stop)
    }
}

struct Draw {
    generator: Xoshiro256PlusPlus,
}

impl Draw {
    fn chance(&mut self, probability: f64) -> bool {
        self.generator.random::<f64>() < probability
    }

    fn of<T: Copy>(&mut self, choices: &[T]) -> T {
        choices[self.generator.random_range(0..choices.len())]
    }

    fn robot(&mut self) -> usize {
        self.generator.random_range(0..N_ROBOTS)
    }

    fn time(&mut self) -> u64 {
        self.generator.random_range(0..LAST_HAPPENING_MS)
    }

    /// Half of all fleets have good clocks.
    fn clocks(&mut self, choices: &[i64]) -> Vec<i64> {
        if self.chance(0.5) {
            return vec![0; N_ROBOTS];
        }
        (0..N_ROBOTS).map(|_| self.of(choices)).collect()
    }

    fn faults(&mut self) -> Faults {
        let loss = self.of(&[0.0, 0.0, 0.05, 0.2, 0.4]);
        let duplication = self.of(&[0.0, 0.1, 0.3]);
        let delay_ms = self.of(&[3, 3, 20, 100, 400, 900]);
        let nodes = (0..N_ROBOTS).flat_map(|robot| [Node::Robot(robot), Node::Controller(robot)]);
        let others = [Node::Runner(0), Node::Runner(1), Node::Simulator, Node::Stopper];
        let side: BTreeSet<_> = nodes.chain(others).filter(|_| self.chance(0.5)).collect();
        let start_ms = self.time();
        let length_ms = self.generator.random_range(200..3_000);
        let end_ms = (start_ms + length_ms).min(LAST_HAPPENING_MS);
        let partition = self.chance(0.3).then_some((start_ms, end_ms, side));
        Faults { loss, duplication, repeat_ms: delay_ms, delay_ms, partition, ..Faults::none() }
    }

    fn happenings(&mut self, body: Body) -> Vec<(u64, Happening)> {
        let (one, other) = (self.robot(), self.robot());
        let robot = if body == Body::Real { Node::Robot(one) } else { Node::Simulator };
        let mut happenings = Vec::new();
        for (probability, node) in
            [(0.25, robot), (0.2, Node::Controller(other)), (0.3, Node::Runner(0))]
        {
            if self.chance(probability) {
                let crash_ms = self.time();
                let down_ms = self.of(&[10, 100, 600, 2_000]);
                happenings.push((crash_ms, Happening::Crash(node)));
                if !matches!(node, Node::Runner(_)) {
                    happenings.push((crash_ms + down_ms, Happening::Restart(node)));
                }
            }
            // The world of a lockstep run does not move while its simulator hangs.
            if self.chance(0.1) && (body, node) != (Body::Lockstep, Node::Simulator) {
                let stall = Happening::Stall(node, self.of(&[150, 400, 900]));
                happenings.push((self.time(), stall));
            }
        }
        for (probability, happening) in [
            (0.3, Happening::Start(1)),
            (0.1, Happening::Interrupt),
            (0.1, Happening::Stop),
            (0.3, Happening::Press(0)),
            (0.3, Happening::ButtonFallsSilent(0)),
            (0.15, Happening::Meddle(other)),
            (0.15, Happening::PlaceAnother),
            (0.15, Happening::Beyond(one)),
            (0.05, Happening::DiskFull),
        ] {
            if self.chance(probability) {
                happenings.push((self.time(), happening));
            }
        }
        happenings
    }
}
