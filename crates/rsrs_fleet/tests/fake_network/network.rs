//! A network that loses, delays, reorders, duplicates and partitions, all from one seed.

use std::collections::BTreeSet;

use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use rsrs_core::controller::Command;
use rsrs_fleet::message::{Lease, Status};

/// A place on the network.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Node {
    Robot(usize),
    Controller(usize),
    Runner(usize),
    Stopper,
}

/// What flies.
#[derive(Clone, Debug)]
pub enum Message {
    Lease(Lease),
    RobotStatus(Status),
    ControllerStatus(Status),
    Command(Command),
    EStop(bool),
}

/// How bad the network is.
#[derive(Clone, Debug)]
pub struct Faults {
    /// Probability that a message is lost.
    pub loss: f64,
    /// Probability that a message arrives twice.
    pub duplication: f64,
    /// Longest delay, in milliseconds; every message draws its own, so they overtake each other.
    pub delay_ms: u64,
    /// Between which times, in milliseconds, which nodes are cut off from the others.
    pub partition: Option<(u64, u64, BTreeSet<Node>)>,
}

struct Flight {
    due_ms: u64,
    from: Node,
    to: Node,
    message: Message,
}

pub struct Network {
    faults: Faults,
    generator: ChaCha8Rng,
    flying: Vec<Flight>,
}

impl Network {
    pub fn new(seed: u64, faults: Faults) -> Self {
        let mut generator = ChaCha8Rng::seed_from_u64(seed);
        generator.set_stream(1);
        Self { faults, generator, flying: Vec::new() }
    }

    pub fn send(&mut self, now_ms: u64, from: Node, to: Node, message: &Message) {
        if self.generator.random::<f64>() < self.faults.loss || self.is_cut(now_ms, from, to) {
            return;
        }
        let copies = 1 + usize::from(self.generator.random::<f64>() < self.faults.duplication);
        for _ in 0..copies {
            let due_ms = now_ms + self.generator.random_range(1..=self.faults.delay_ms);
            self.flying.push(Flight { due_ms, from, to, message: message.clone() });
        }
    }

    /// Messages that arrive now, in the order of their arrival.
    pub fn arrivals(&mut self, now_ms: u64) -> Vec<(Node, Node, Message)> {
        let (mut due, flying): (Vec<_>, Vec<_>) =
            self.flying.drain(..).partition(|flight| flight.due_ms <= now_ms);
        self.flying = flying;
        due.sort_by_key(|flight| flight.due_ms);
        due.into_iter().map(|flight| (flight.from, flight.to, flight.message)).collect()
    }

    fn is_cut(&self, now_ms: u64, from: Node, to: Node) -> bool {
        self.faults.partition.as_ref().is_some_and(|(start_ms, end_ms, side)| {
            (*start_ms..*end_ms).contains(&now_ms) && side.contains(&from) != side.contains(&to)
        })
    }
}
