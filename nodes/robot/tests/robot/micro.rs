//! A simulated microcontroller on a pseudo-terminal, that misbehaves on request.
//!
//! It is written from `docs/serial_protocol.md` and shares no code with the driver.

use std::fs::File;
use std::io::{Read, Write};
use std::os::unix::fs::symlink;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use rustix::fs::{OFlags, fcntl_setfl};
use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};

const TIMEOUT: Duration = Duration::from_millis(250);
const STATE_EVERY: Duration = Duration::from_millis(50);
const POLL_PERIOD: Duration = Duration::from_millis(2);

/// How the microcontroller behaves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mood {
    /// As the protocol states.
    Well,
    /// It sends nothing.
    Silent,
    /// It does not read its line.
    Deaf,
    /// It sends noise between its lines.
    Garbling,
    /// Every other line that it sends lacks its end.
    Halving,
    /// Characters of what it receives are damaged on the way.
    Mishearing,
    /// It reports a fault of its hardware.
    Broken,
}

/// What the wheels were set to, in mm/s and mrad/s.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Wheels {
    pub at: Instant,
    pub speed_mm_s: i32,
    pub turn_rate_mrad_s: i32,
}

#[derive(Debug)]
pub struct Inside {
    pub mood: Mood,
    /// What its sensor reports, as the protocol writes it: `1`, `0` or `-`.
    pub seen: &'static str,
    pub range: &'static str,
    /// What its further sensors report, such as `,wall=1`.
    pub further: &'static str,
    /// Every change of what the wheels are set to.
    pub wheels: Vec<Wheels>,
    /// When the last valid command came.
    pub commanded: Option<Instant>,
    /// When it last looked whether its wheels must stand: they were as they are now.
    pub looked: Instant,
    is_to_end: bool,
    is_to_restart: bool,
}

/// The microcontroller, plugged in at a path until it is dropped.
pub struct Micro {
    inside: Arc<Mutex<Inside>>,
    thread: Option<JoinHandle<()>>,
}

impl Micro {
    /// Plugs a microcontroller in; the path is a link to its device.
    pub fn plug_in(path: &Path) -> Self {
        let master = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY | OpenptFlags::CLOEXEC)
            .expect("there are terminals");
        grantpt(&master).expect("the terminal is ours");
        unlockpt(&master).expect("the terminal is ours");
        fcntl_setfl(&master, OFlags::NONBLOCK).expect("flags can be set");
        let device = ptsname(&master, Vec::new()).expect("a terminal has a name");
        std::fs::remove_file(path).ok();
        symlink(device.to_str().expect("it is ASCII"), path).expect("the folder is writable");

        let inside = Arc::new(Mutex::new(Inside {
            mood: Mood::Well,
            seen: "0",
            range: "-",
            further: "",
            wheels: Vec::new(),
            commanded: None,
            looked: Instant::now(),
            is_to_end: false,
            is_to_restart: false,
        }));
        let program = Program::new(File::from(master), Arc::clone(&inside));
        Self { inside, thread: Some(std::thread::spawn(move || program.run())) }
    }

    /// What it does, and how it is to behave.
    pub fn inside(&self) -> MutexGuard<'_, Inside> {
        self.inside.lock().unwrap_or_else(PoisonError::into_inner)
    }

    pub fn set_mood(&self, mood: Mood) {
        self.inside().mood = mood;
    }

    /// Switches it off and on.
    pub fn restart(&self) {
        self.inside().is_to_restart = true;
    }

    /// What the wheels are set to now, in mm/s and mrad/s.
    pub fn wheels(&self) -> (i32, i32) {
        self.inside().wheels.last().map_or((0, 0), |last| (last.speed_mm_s, last.turn_rate_mrad_s))
    }
}

impl Drop for Micro {
    fn drop(&mut self) {
        self.inside().is_to_end = true;
        if let Some(thread) = self.thread.take() {
            drop(thread.join());
        }
    }
}

/// A folder with a place for the device.
pub struct Socket {
    folder: tempfile::TempDir,
}

impl Socket {
    pub fn new() -> Self {
        Self { folder: tempfile::tempdir().expect("there is room for a temporary folder") }
    }

    pub fn path(&self) -> PathBuf {
        self.folder.path().join("ttyTEST")
    }
}

struct Program {
    line: File,
    inside: Arc<Mutex<Inside>>,
    received: Vec<u8>,
    is_greeted: bool,
    command: Option<(u16, Instant)>,
    wheels: (i32, i32),
    sent: Instant,
    n_states: u64,
    n_bytes_received: u64,
    born: Instant,
}

impl Program {
    fn new(line: File, inside: Arc<Mutex<Inside>>) -> Self {
        let sent = Instant::now();
        Self {
            line,
            inside,
            received: Vec::new(),
            is_greeted: false,
            command: None,
            wheels: (0, 0),
            sent,
            n_states: 0,
            n_bytes_received: 0,
            born: sent,
        }
    }

    fn inside(&self) -> MutexGuard<'_, Inside> {
        self.inside.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn run(mut self) {
        loop {
            let (mood, is_to_restart) = {
                let mut inside = self.inside();
                if inside.is_to_end {
                    return;
                }
                (inside.mood, std::mem::take(&mut inside.is_to_restart))
            };
            if is_to_restart {
                self.turn_wheels((0, 0));
                (self.is_greeted, self.command) = (false, None);
            }
            let looked = Instant::now();
            if mood != Mood::Deaf {
                self.read(mood);
            }
            if self.command.is_some_and(|(_, at)| at.elapsed() >= TIMEOUT) {
                self.turn_wheels((0, 0));
            }
            self.inside().looked = looked;
            if self.sent.elapsed() >= STATE_EVERY {
                self.sent = Instant::now();
                self.send_state(mood);
            }
            std::thread::sleep(POLL_PERIOD);
        }
    }

    fn read(&mut self, mood: Mood) {
        let mut bytes = [0; 512];
        // An error is a line that nobody has opened, or that has nothing.
        let Ok(n_bytes) = self.line.read(&mut bytes) else { return };
        for byte in &mut bytes[..n_bytes] {
            self.n_bytes_received += 1;
            if mood == Mood::Mishearing && self.n_bytes_received.is_multiple_of(89) {
                *byte ^= 0x04;
            }
        }
        self.received.extend(&bytes[..n_bytes]);
        while let Some(end) = self.received.iter().position(|byte| *byte == b'\n') {
            let line: Vec<u8> = self.received.drain(..=end).collect();
            let text = String::from_utf8_lossy(&line).trim_end().to_owned();
            if let Some(body) = body_of(&text) {
                self.obey(body, mood);
            }
        }
    }

    fn obey(&mut self, body: &str, mood: Mood) {
        let fields: Vec<&str> = body.split(',').collect();
        match fields[..] {
            ["H", version, nonce] => {
                self.turn_wheels((0, 0));
                (self.is_greeted, self.command) = (version == "1", None);
                if mood != Mood::Silent {
                    self.send(&sealed(&format!("I,1,{nonce},simulated,250,400,20,750")));
                }
            }
            ["V", number, time, speed, turn] if self.is_greeted => {
                let (Ok(number), Ok(time), Ok(speed), Ok(turn)) =
                    (number.parse(), time.parse::<u32>(), speed.parse(), turn.parse())
                else {
                    return;
                };
                let age_ms = self.time_ms().wrapping_sub(time);
                if u128::from(age_ms) > TIMEOUT.as_millis() {
                    return;
                }
                if self.command.is_none_or(|(last, _)| last != number) {
                    self.command = Some((number, Instant::now()));
                    self.inside().commanded = Some(Instant::now());
                    self.turn_wheels((speed, turn));
                }
            }
            _ => {}
        }
    }

    /// Its own clock, which soon starts again.
    fn time_ms(&self) -> u32 {
        let since_ms = u32::try_from(self.born.elapsed().as_millis()).expect("tests are short");
        since_ms.wrapping_sub(1000)
    }

    fn turn_wheels(&mut self, wheels: (i32, i32)) {
        if wheels != self.wheels {
            self.wheels = wheels;
            let (speed_mm_s, turn_rate_mrad_s) = wheels;
            let given = Wheels { at: Instant::now(), speed_mm_s, turn_rate_mrad_s };
            self.inside().wheels.push(given);
        }
    }

    fn send_state(&mut self, mood: Mood) {
        if mood == Mood::Silent {
            return;
        }
        let (seen, range, further) = {
            let inside = self.inside();
            (inside.seen, inside.range, inside.further)
        };
        if mood == Mood::Broken {
            self.turn_wheels((0, 0));
        }
        let mode = match self.command {
            _ if mood == Mood::Broken => "F",
            _ if !self.is_greeted => "N",
            Some((_, at)) if at.elapsed() < TIMEOUT => "R",
            _ => "T",
        };
        let number = self.command.map_or_else(|| "-".to_owned(), |(number, _)| number.to_string());
        let (time, (speed, turn)) = (self.time_ms(), self.wheels);
        let sensed = format!("{seen},{range},7400{further}");
        let mut line = sealed(&format!("S,{time},{number},{speed},{turn},{mode},{sensed}"));
        self.n_states += 1;
        match mood {
            Mood::Garbling => line.insert_str(0, "\u{7f}$S,1,2*\0\u{1}V,9,900,900\n$*"),
            Mood::Halving if self.n_states.is_multiple_of(2) => line.truncate(line.len() / 2),
            _ => {}
        }
        self.send(&line);
    }

    /// Nobody may listen, and then nothing is sent.
    fn send(&mut self, line: &str) {
        drop(self.line.write(line.as_bytes()));
    }
}

fn sum(text: &str) -> u16 {
    let mut sum = 0xFFFF_u16;
    for byte in text.bytes() {
        sum ^= u16::from(byte) << 8;
        for _ in 0..8 {
            sum = if sum >= 0x8000 { (sum << 1) ^ 0x1021 } else { sum << 1 };
        }
    }
    sum
}

fn sealed(body: &str) -> String {
    format!("${body}*{:04X}\r\n", sum(body))
}

fn body_of(line: &str) -> Option<&str> {
    let (_, rest) = line.rsplit_once('$')?;
    let (body, seal) = rest.split_once('*')?;
    (seal == format!("{:04X}", sum(body))).then_some(body)
}
