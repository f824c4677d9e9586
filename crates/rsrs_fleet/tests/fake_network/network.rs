//! A network that loses, delays, reorders, duplicates and partitions, all from one seed.

use std::collections::{BTreeMap, BTreeSet};
use std::rc::Rc;

use rand::rngs::Xoshiro256PlusPlus;
use rand::{RngExt, SeedableRng};
use rsrs_core::robot::controller::Command;
use rsrs_fleet::controller::Settings;
use rsrs_fleet::e_stop::{Locks, Source};
use rsrs_fleet::message::{Lease, Status};
use rsrs_fleet::runner::{self, Target};

use crate::scenario::Happening;

/// A place on the network.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Node {
    Robot(usize),
    Controller(usize),
    Runner(usize),
    Simulator,
    Stopper,
    /// A button on the wall: publishes on the e-stop topic all the time.
    Button(usize),
    /// A node that publishes velocity commands beside the controllers.
    Stranger,
}

/// What only the oracles read: in which incarnation a robot sent a status, and when.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Sent {
    pub incarnation: u32,
    pub at_ms: u64,
    /// Whether it reported that it stands in a run.
    pub stands: bool,
}

/// What flies.
#[derive(Clone, Debug)]
pub enum Message {
    /// A lease, with what its runner has received from each robot last.
    Lease(Rc<Lease>, Rc<[Option<Sent>]>),
    RobotStatus(Rc<Status>, Sent),
    ControllerStatus(Rc<Status>, Sent),
    /// Of which of its processes.
    SimulatorStatus(Rc<Status>, u32),
    Detection(bool),
    Clock(u64),
    Command(Command, Option<u64>),
    EStop(Source, bool),
    /// A release of these locks of the e-stop.
    Release(Rc<BTreeSet<Source>>),
    /// What the e-stop has locked on a robot.
    Locks(Rc<Locks>),
    /// The simulator has published this step.
    Sensed(u64),
    Recorded(u64),
    Set(Settings),
    SetAnswer(Target, Result<(), String>),
    Get,
    GetAnswer(Target, u64),
}

/// Whether the sender makes sure that it arrives.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Delivery {
    BestEffort,
    /// The same, and never later than it can be late: what contains neither when it was sent nor
    /// in which order comes on topics that are reliable, which hand nothing on twice.
    Once,
    /// Sent again until it arrives, once and in order.
    Reliable,
}

/// How bad the network is.
#[derive(Clone, Debug)]
pub struct Faults {
    /// Probability that a message is lost.
    pub loss: f64,
    /// Probability that a message arrives twice.
    pub duplication: f64,
    /// How late the second of two may be, in milliseconds.
    pub repeat_ms: u64,
    /// Longest delay, in milliseconds; every message draws its own, so they overtake each other.
    pub delay_ms: u64,
    /// Between which times, in milliseconds, which nodes are cut off from the others.
    pub partition: Option<(u64, u64, BTreeSet<Node>)>,
    /// What stops all traffic of a robot's computer now and then.
    pub stalls: Option<Stalls>,
    /// Where controllers are.
    pub controllers: Controllers,
}

/// Where controllers are, if each robot has a computer of its own.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Controllers {
    /// Between each and its robot happens what happens between any two nodes.
    Anywhere,
    /// On the robot's computer, to which nothing gets lost.
    OnRobots,
    /// On the computer of the runners.
    AtTheRunner,
}

/// The radio link of each robot stalls once in so many milliseconds, at any time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Stalls {
    /// How often, in milliseconds.
    pub every_ms: u64,
    /// How long, in milliseconds.
    pub length_ms: u64,
    /// What becomes of what is sent meanwhile.
    pub stalled: Stalled,
}

/// What becomes of what is sent while a link stalls.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stalled {
    /// It is lost.
    Lost,
    /// It arrives when the link works again.
    Late,
}

impl Faults {
    /// A network as on one desk.
    pub fn none() -> Self {
        Self {
            loss: 0.0,
            duplication: 0.0,
            repeat_ms: 3,
            delay_ms: 3,
            partition: None,
            stalls: None,
            controllers: Controllers::Anywhere,
        }
    }
}

/// What comes due.
#[derive(Debug)]
pub enum Item {
    Arrival {
        from: Node,
        to: Node,
        message: Message,
    },
    /// A node looks at its clock; the number is that of the node's incarnation.
    Tick(Node, u32),
    /// What the machinery on a runner's own host answers.
    Answer(usize, runner::Event),
    Happening(Happening),
}

/// Milliseconds that can be planned ahead.
const AHEAD: u64 = 16_384;
/// After so long, in milliseconds, what got lost is sent again.
const RESEND_MS: u64 = 60;

/// What is drawn, of which no two have the same numbers.
#[derive(Clone, Copy)]
pub enum Stream {
    Scenario,
    Network,
    Stop,
    Stalls,
}

/// The draws of one kind for a seed: with so many of them, quick ones.
pub fn draws(seed: u64, stream: Stream) -> Xoshiro256PlusPlus {
    Xoshiro256PlusPlus::seed_from_u64(seed.wrapping_add((stream as u64) << 60))
}

pub struct Network {
    seed: u64,
    faults: Faults,
    latest_ms: u64,
    generator: Xoshiro256PlusPlus,
    /// What comes due in each millisecond, in order; a ring.
    slots: Vec<Vec<Item>>,
    /// By pair: when the last reliable message arrives.
    last_ms: BTreeMap<(Node, Node), u64>,
}

impl Network {
    pub fn new(seed: u64, faults: Faults) -> Self {
        let generator = draws(seed, Stream::Network);
        let slots = (0..AHEAD).map(|_| Vec::new()).collect();
        let stall_ms = faults.stalls.map_or(0, |stalls| stalls.length_ms);
        let latest_ms = faults.delay_ms.max(faults.repeat_ms) + stall_ms;
        Self { seed, faults, latest_ms, generator, slots, last_ms: BTreeMap::new() }
    }

    /// From now on nothing gets lost.
    pub fn heal(&mut self) {
        self.faults = Faults { controllers: self.faults.controllers, ..Faults::none() };
    }

    /// So long after its sending, in milliseconds, a message can still arrive.
    pub fn latest_ms(&self) -> u64 {
        self.latest_ms
    }

    /// Plans something; it comes due in the future.
    pub fn plan(&mut self, due_ms: u64, item: Item) {
        self.slots[slot(due_ms)].push(item);
    }

    pub fn send(&mut self, now_ms: u64, from: Node, to: Node, message: Message) {
        if self.is_lost(now_ms, from, to) {
            return;
        }
        if self.generator.random::<f64>() < self.faults.duplication {
            let due_ms = now_ms + self.generator.random_range(1..=self.faults.repeat_ms);
            self.plan(due_ms, Item::Arrival { from, to, message: message.clone() });
        }
        let due_ms = self.passes_at(now_ms, from, to) + self.delay();
        self.plan(due_ms, Item::Arrival { from, to, message });
    }

    pub fn send_once(&mut self, now_ms: u64, from: Node, to: Node, message: Message) {
        if !self.is_lost(now_ms, from, to) {
            let due_ms = self.passes_at(now_ms, from, to) + self.delay();
            self.plan(due_ms, Item::Arrival { from, to, message });
        }
    }

    fn is_lost(&mut self, now_ms: u64, from: Node, to: Node) -> bool {
        if self.are_on_one_computer(from, to) {
            return false;
        }
        self.generator.random::<f64>() < self.faults.loss || self.is_cut(now_ms, from, to)
    }

    fn are_on_one_computer(&self, from: Node, to: Node) -> bool {
        self.faults.controllers != Controllers::Anywhere && self.link(from) == self.link(to)
    }

    /// The robot whose radio link a node is behind.
    fn link(&self, node: Node) -> Option<usize> {
        match node {
            Node::Robot(robot) => Some(robot),
            Node::Controller(robot) if self.faults.controllers == Controllers::OnRobots => {
                Some(robot)
            }
            _ => None,
        }
    }

    /// When a link works again that stalls now.
    fn stalls_until(&self, now_ms: u64, node: Node) -> Option<u64> {
        let (stalls, link) = (self.faults.stalls?, self.link(node)? as u64);
        let nth = now_ms / stalls.every_ms;
        let place = self.seed.wrapping_mul(1 << 20).wrapping_add(link << 10).wrapping_add(nth);
        let draw = draws(place, Stream::Stalls).random_range(0..stalls.every_ms);
        let start_ms = nth * stalls.every_ms + draw.min(stalls.every_ms - stalls.length_ms);
        let end_ms = start_ms + stalls.length_ms;
        (start_ms..end_ms).contains(&now_ms).then_some(end_ms)
    }

    /// When what is sent now gets onto its way.
    fn passes_at(&self, now_ms: u64, from: Node, to: Node) -> u64 {
        if self.are_on_one_computer(from, to) {
            return now_ms;
        }
        let ends = [from, to].into_iter().filter_map(|node| self.stalls_until(now_ms, node));
        ends.max().unwrap_or(now_ms)
    }

    pub fn send_reliably(&mut self, now_ms: u64, from: Node, to: Node, message: Message) {
        let mut due_ms = now_ms + self.delay();
        while self.generator.random::<f64>() < self.faults.loss || self.is_cut(due_ms, from, to) {
            due_ms += RESEND_MS;
        }
        let last_ms = self.last_ms.entry((from, to)).or_default();
        *last_ms = due_ms.max(*last_ms);
        let due_ms = *last_ms;
        self.plan(due_ms, Item::Arrival { from, to, message });
    }

    /// What comes due now, in order.
    pub fn due(&mut self, now_ms: u64) -> Vec<Item> {
        std::mem::take(&mut self.slots[slot(now_ms)])
    }

    fn delay(&mut self) -> u64 {
        self.generator.random_range(1..=self.faults.delay_ms)
    }

    fn is_cut(&self, now_ms: u64, from: Node, to: Node) -> bool {
        if self.faults.stalls.is_some_and(|stalls| stalls.stalled == Stalled::Lost)
            && self.passes_at(now_ms, from, to) > now_ms
        {
            return true;
        }
        self.faults.partition.as_ref().is_some_and(|(start_ms, end_ms, side)| {
            (*start_ms..*end_ms).contains(&now_ms) && side.contains(&from) != side.contains(&to)
        })
    }
}

/// Where a millisecond is in the ring.
fn slot(at_ms: u64) -> usize {
    usize::try_from(at_ms % AHEAD).expect("the ring is short")
}
