//! The line protocol against bytes that nobody sent, in both directions, without a terminal.
//!
//! A link talks with a microcontroller over a line that flips, cuts, inserts, repeats and replays
//! what it carries; most of what arrives is nearly right, because it is made from what was sent.
//! Nobody panics; the wheels are set only to what was commanded at most 250 ms before, they stand
//! 250 ms after the last command that was taken, and they stand as soon as a new conversation
//! begins. Damaged lines that have the right checksum by chance are counted and left out: sixteen
//! bits cannot distinguish them from others.
//!
//! `RSRS_FUZZ_S` sets for how many seconds they talk, and `RSRS_SEED` plays one conversation.

use std::collections::{BTreeMap, VecDeque};
use std::io::Write;
use std::time::{Duration, Instant};

use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use rsrs_core::robot::controller::Command;
use rsrs_robot_node::driver::Report;
use rsrs_robot_node::driver::serial::line::{crc, encode};
use rsrs_robot_node::driver::serial::link::Link;
use rsrs_testing::environment::number;
use rsrs_testing::fuzz::{self, Harness};

/// Length of one conversation, in steps of 10 ms.
const STEPS: u64 = 400;
const STEP_MS: u64 = 10;
const TIMEOUT_MS: u64 = 250;
const BEAT_MS: u64 = 50;
/// What damage likes to look like.
const SPECIAL: &[u8] = b"$*,\n\r-0123456789HVISRTNFix\0\xff";

/// How a conversation went.
#[derive(Clone, Copy, Debug, Default)]
struct Tally {
    deliveries: u64,
    damaged: u64,
    /// Damaged lines whose checksum was right by chance.
    collisions: u64,
    obeyed: u64,
    ended: u64,
}

/// The microcontroller of `docs/serial_protocol.md`, without its wires.
#[derive(Default)]
struct Micro {
    line: Option<Vec<u8>>,
    is_greeted: bool,
    command: Option<(u16, u64)>,
    wheels: i64,
    reported_ms: u64,
    /// Its clock starts again early in the conversation.
    clock_ahead: u32,
}

impl Micro {
    fn clock(&self, now_ms: u64) -> u32 {
        self.clock_ahead.wrapping_add(u32::try_from(now_ms).expect("conversations are short"))
    }

    /// Takes a byte; whole lines with the right checksum come out.
    fn receive(&mut self, byte: u8) -> Option<String> {
        match (byte, &mut self.line) {
            (b'$', line) => *line = Some(Vec::new()),
            (b'\n', line) => return body_of(&line.take()?),
            (_, Some(line)) if line.len() < 80 => line.push(byte),
            (_, line) => *line = None,
        }
        None
    }

    /// Does what a line requests, and answers; `true` if the wheels took a new command.
    fn obey(&mut self, body: &str, now_ms: u64) -> (Option<String>, bool) {
        let fields: Vec<_> = body.split(',').collect();
        match fields[..] {
            ["H", version, nonce] => {
                (self.is_greeted, self.command, self.wheels) = (version == "1", None, 0);
                return (Some(encode(&format!("I,1,{nonce},fuzzed,250,400,20,750"))), false);
            }
            ["V", number, time, speed, turn] if self.is_greeted => {
                let (Ok(number), Ok(time), Ok(speed), Ok(_)) =
                    (number.parse(), time.parse::<u32>(), speed.parse(), turn.parse::<i64>())
                else {
                    return (None, false);
                };
                let is_old = u64::from(self.clock(now_ms).wrapping_sub(time)) > TIMEOUT_MS;
                if !is_old && self.command.is_none_or(|(last, _)| last != number) {
                    (self.command, self.wheels) = (Some((number, now_ms)), speed);
                    return (None, true);
                }
            }
            _ => {}
        }
        (None, false)
    }

    /// Lets its own timeout stop the wheels, and reports its state when that is due.
    fn look(&mut self, now_ms: u64) -> Option<String> {
        let is_fresh = self.command.is_some_and(|(_, at_ms)| now_ms < at_ms + TIMEOUT_MS);
        if !is_fresh {
            self.wheels = 0;
        }
        if now_ms < self.reported_ms + BEAT_MS {
            return None;
        }
        self.reported_ms = now_ms;
        let mode = match (self.is_greeted, is_fresh) {
            (false, _) => "N",
            (true, true) => "R",
            (true, false) => "T",
        };
        let number = self.command.map_or_else(|| "-".to_owned(), |(number, _)| number.to_string());
        let (time, wheels) = (self.clock(now_ms), self.wheels);
        Some(encode(&format!("S,{time},{number},{wheels},0,{mode},1,312,7400")))
    }
}

fn body_of(line: &[u8]) -> Option<String> {
    let text = std::str::from_utf8(line).ok()?.trim_end_matches('\r');
    let (body, sum) = text.split_once('*')?;
    (sum == format!("{:04X}", crc(body.as_bytes()))).then(|| body.to_owned())
}

/// A line that damages what it carries.
struct Wire {
    /// What was sent lately, to be received again.
    sent: VecDeque<Vec<u8>>,
    probability: f64,
}

impl Wire {
    /// What arrives; `true` if that is something else.
    fn carry(&mut self, bytes: &[u8], generator: &mut ChaCha8Rng) -> (Vec<u8>, bool) {
        self.sent.push_back(bytes.to_vec());
        if self.sent.len() > 16 {
            self.sent.pop_front();
        }
        let mut arrives = bytes.to_vec();
        if generator.random::<f64>() >= self.probability {
            return (arrives, false);
        }
        for _ in 0..generator.random_range(1..5) {
            self.damage(&mut arrives, generator);
        }
        (arrives, true)
    }

    fn damage(&self, bytes: &mut Vec<u8>, generator: &mut ChaCha8Rng) {
        let place = generator.random_range(0..=bytes.len());
        let some = |generator: &mut ChaCha8Rng| SPECIAL[generator.random_range(0..SPECIAL.len())];
        match generator.random_range(0..8) {
            0 | 1 if place < bytes.len() => bytes[place] ^= 1 << generator.random_range(0..8),
            2 if place < bytes.len() => bytes[place] = some(generator),
            3 => bytes.insert(place, some(generator)),
            4 => bytes.truncate(place),
            5 => drop(bytes.drain(..place)),
            6 => {
                let old = &self.sent[generator.random_range(0..self.sent.len())];
                bytes.splice(place..place, old.iter().copied());
            }
            _ => {
                let n_bytes = generator.random_range(0..300);
                let noise: Vec<_> = (0..n_bytes).map(|_| generator.random::<u8>()).collect();
                bytes.splice(place..place, noise);
            }
        }
    }
}

/// Both ends of a line, and the books on what was commanded.
struct Conversation {
    generator: ChaCha8Rng,
    link: Link,
    nonce: u16,
    is_up: bool,
    /// When the port is opened again.
    reopen_ms: Option<u64>,
    micro: Micro,
    wires: [Wire; 2],
    /// By speed: when it was commanded last.
    commanded: BTreeMap<i64, u64>,
    /// Bodies that the link has sent.
    bodies: VecDeque<String>,
    n_commands: i64,
    now_ms: u64,
    tally: Tally,
}

impl Conversation {
    fn new(seed: u64) -> Self {
        let mut generator = ChaCha8Rng::seed_from_u64(seed);
        let mut wire = || Wire {
            sent: VecDeque::new(),
            probability: [0.0, 0.02, 0.1, 0.5, 1.0][generator.random_range(0..5)],
        };
        let wires = [wire(), wire()];
        Self {
            generator,
            link: Link::new(1, Duration::ZERO),
            nonce: 1,
            is_up: false,
            reopen_ms: None,
            micro: Micro { clock_ahead: u32::MAX - 1_500, ..Micro::default() },
            wires,
            commanded: BTreeMap::new(),
            bodies: VecDeque::new(),
            n_commands: 0,
            now_ms: 0,
            tally: Tally::default(),
        }
    }

    fn now(&self) -> Duration {
        Duration::from_millis(self.now_ms)
    }

    fn step(&mut self) {
        self.now_ms += STEP_MS;
        if self.reopen_ms.is_some_and(|at_ms| self.now_ms >= at_ms) {
            self.reopen_ms = None;
            self.nonce += 1;
            self.link = Link::new(self.nonce, self.now());
        }
        if self.generator.random::<f64>() < 0.001 {
            let clock_ahead = self.generator.random();
            self.micro = Micro { clock_ahead, reported_ms: self.now_ms, ..Micro::default() };
        }
        if self.reopen_ms.is_none() {
            match self.link.on_tick(self.now()) {
                Ok(Some(line)) => self.carry_to_micro(&line),
                Ok(None) => {}
                Err(_end) => self.end(),
            }
        }
        if self.is_up && self.now_ms.is_multiple_of(BEAT_MS) {
            self.command();
        }
        if let Some(state) = self.micro.look(self.now_ms) {
            self.carry_to_link(&state);
        }
        self.judge();
    }

    /// The speed encodes when it was commanded.
    fn command(&mut self) {
        self.n_commands += 1;
        let speed_mm_s = 1 + self.n_commands % 200;
        let command = Command { speed_m_s: speed_mm_s as f64 / 1000.0, turn_rate_rad_s: 0.0 };
        if let Some(line) = self.link.drive(command, self.now()) {
            self.commanded.insert(speed_mm_s, self.now_ms);
            self.carry_to_micro(&line);
        }
    }

    fn carry_to_micro(&mut self, line: &str) {
        self.bodies.push_back(line[1..line.len() - 6].to_owned());
        if self.bodies.len() > 256 {
            self.bodies.pop_front();
        }
        let (bytes, is_damaged) = self.wires[0].carry(line.as_bytes(), &mut self.generator);
        self.tally.deliveries += 1;
        self.tally.damaged += u64::from(is_damaged);
        for byte in bytes {
            let Some(body) = self.micro.receive(byte) else { continue };
            if !self.bodies.contains(&body) {
                self.tally.collisions += 1;
                continue;
            }
            let (answer, has_obeyed) = self.micro.obey(&body, self.now_ms);
            self.tally.obeyed += u64::from(has_obeyed);
            if has_obeyed {
                let at_ms = self.commanded[&self.micro.wheels];
                assert!(self.now_ms <= at_ms + TIMEOUT_MS, "a command of {at_ms} ms was obeyed");
            }
            if let Some(answer) = answer {
                self.carry_to_link(&answer);
            }
        }
    }

    fn carry_to_link(&mut self, line: &str) {
        let (bytes, is_damaged) = self.wires[1].carry(line.as_bytes(), &mut self.generator);
        self.tally.deliveries += 1;
        self.tally.damaged += u64::from(is_damaged);
        if self.reopen_ms.is_some() {
            return;
        }
        match self.link.on_bytes(&bytes, self.now()) {
            Ok(reports) => self.is_up |= reports.contains(&Report::Up),
            Err(_end) => self.end(),
        }
    }

    /// The driver gives the port up for a while; nothing is sent meanwhile.
    fn end(&mut self) {
        self.tally.ended += 1;
        self.is_up = false;
        self.reopen_ms = Some(self.now_ms + 500);
    }

    fn judge(&self) {
        if self.micro.wheels == 0 {
            return;
        }
        let at_ms = self.commanded.get(&self.micro.wheels);
        let is_right = at_ms.is_some_and(|at_ms| self.now_ms <= at_ms + 2 * TIMEOUT_MS);
        assert!(is_right, "wheels at {} mm/s, commanded at {at_ms:?} ms", self.micro.wheels);
        if let Some(reopen_ms) = self.reopen_ms {
            let ended_ms = reopen_ms - 500;
            assert!(self.now_ms <= ended_ms + TIMEOUT_MS, "wheels outlive their conversation");
        }
    }
}

fn talk(seed: u64) -> Tally {
    let mut conversation = Conversation::new(seed);
    for _ in 0..STEPS {
        conversation.step();
    }
    conversation.tally
}

#[test]
fn whatever_the_line_does_the_wheels_get_no_stale_or_wrong_command() {
    if let Some(seed) = number("RSRS_SEED") {
        panic!("seed {seed}: {:?}", talk(seed));
    }
    let end = Instant::now() + fuzz::duration();
    let mut sum = Tally::default();
    let mut seed = 0;

    while Instant::now() < end {
        let tally = std::panic::catch_unwind(|| talk(seed));
        let tally = tally.unwrap_or_else(|_| panic!("see above, and `RSRS_SEED={seed}`"));
        sum.deliveries += tally.deliveries;
        sum.damaged += tally.damaged;
        sum.collisions += tally.collisions;
        sum.obeyed += tally.obeyed;
        sum.ended += tally.ended;
        seed += 1;
    }

    writeln!(std::io::stdout(), "{seed} conversations: {sum:?}").expect("somebody reads");
    // A line that nothing passes would prove nothing.
    assert!(sum.obeyed > sum.deliveries / 20 && sum.damaged > sum.deliveries / 5, "{sum:?}");
    assert!(sum.ended > sum.deliveries / 1_000, "{sum:?}");
}

#[test]
fn fuzzed_lines_with_the_right_checksum_are_understood_or_refused() {
    let bodies =
        ["I,1,1,rsrs_base,250,400,20,750", "S,81300,-,0,0,T,-,312,7400", "S,81350,0,0,0,R,1,i,-"];
    let harness = Harness {
        corpus: concat!(env!("CARGO_MANIFEST_DIR"), "/tests/corpus/lines"),
        seeds: vec![bodies.join("\n").into_bytes()],
        mutation: &fuzz::text,
    };

    let n_outcomes = harness.run(|input| {
        let mut link = Link::new(1, Duration::ZERO);
        let mut outcomes = Vec::new();
        for (step, body) in (1..).zip(input.split(|byte| *byte == b'\n')) {
            let now = Duration::from_millis(BEAT_MS) * step;
            let line = [b"$", body, format!("*{:04X}\n", crc(body)).as_bytes()].concat();
            let reports = link.on_bytes(&line, now);
            let command = link.drive(Command { speed_m_s: 0.1, turn_rate_rad_s: 0.0 }, now);
            let is_end = reports.is_err();
            outcomes.push((reports, command.is_some(), link.on_tick(now)));
            if is_end {
                break;
            }
        }
        format!("{outcomes:?}")
    });

    assert!(n_outcomes > 5, "{n_outcomes} outcomes");
}
