//! The serial driver against a simulated microcontroller that misbehaves, over a pseudo-terminal.

use std::collections::BTreeSet;
use std::time::{Duration, Instant};

use super::micro::{Micro, Mood, Socket};
use rsrs_core::robot::controller::Command;
use rsrs_robot_node::driver::serial::SerialDriver;
use rsrs_robot_node::driver::{Driver, Report, Sensed};
use rsrs_testing::network::TIMEOUT;

const BEAT: Duration = Duration::from_millis(50);
const FORWARD: Command = Command { speed_m_s: 0.15, turn_rate_rad_s: -0.75 };

/// A driver that is given the same command again and again, as by the node.
struct Drive {
    driver: SerialDriver,
    is_up: bool,
    downs: Vec<String>,
    sensed: Option<Sensed>,
}

impl Drive {
    fn new(socket: &Socket) -> Self {
        let path = socket.path().display().to_string();
        let driver = SerialDriver::at(&path, 115_200);
        Self { driver, is_up: false, downs: Vec::new(), sensed: None }
    }

    /// Drives until `is_done`, which is looked at with every beat; the command may change with it.
    async fn until(
        &mut self,
        what: &str,
        mut command: impl FnMut() -> Command,
        mut is_done: impl FnMut(&Self) -> bool,
    ) {
        let start = Instant::now();
        let mut beat = tokio::time::interval(BEAT);
        while !is_done(self) {
            assert!(start.elapsed() < TIMEOUT, "it never came true that {what}: {:?}", self.downs);
            tokio::select! {
                report = self.driver.report() => match report {
                    Report::Up => self.is_up = true,
                    Report::Down(reason) => {
                        self.is_up = false;
                        self.downs.push(reason);
                    }
                    Report::Sensed(sensed) => self.sensed = Some(sensed),
                    Report::Battery(_) | Report::Refused(_) => {}
                },
                _ = beat.tick() => if self.is_up {
                    // A failure is reported as well.
                    drop(self.driver.drive(command()).await);
                },
            }
        }
    }

    async fn up(&mut self) {
        self.until("the driver is up", || Command::STOP, |drive| drive.is_up).await;
    }

    async fn for_a_while(&mut self, duration: Duration, command: Command) {
        let start = Instant::now();
        self.until("time passes", || command, |_| start.elapsed() >= duration).await;
    }
}

/// A microcontroller with a driver that is up.
async fn plugged_in() -> (Socket, Micro, Drive) {
    let socket = Socket::new();
    let micro = Micro::plug_in(&socket.path());
    let mut drive = Drive::new(&socket);
    drive.up().await;
    (socket, micro, drive)
}

fn run(body: impl Future<Output = ()>) {
    tokio::runtime::Builder::new_current_thread()
        .enable_all()
        .build()
        .expect("a runtime needs no rights")
        .block_on(body);
}

/// Every pair that the wheels were set to, in mm/s and mrad/s.
fn given(micro: &Micro) -> BTreeSet<(i32, i32)> {
    micro.inside().wheels.iter().map(|given| (given.speed_mm_s, given.turn_rate_mrad_s)).collect()
}

#[test]
fn wheels_follow_commands_and_stop_when_none_comes() {
    run(async {
        let (_socket, micro, mut drive) = plugged_in().await;

        drive.until("wheels turn", || FORWARD, |_| micro.wheels() == (150, -750)).await;
        drive.for_a_while(Duration::from_secs(1), FORWARD).await;
        assert_eq!(drive.downs, [""; 0]);
        assert_eq!(given(&micro), BTreeSet::from([(150, -750)]), "the wheels never stood");

        tokio::time::sleep(Duration::from_millis(600)).await;
        let inside = micro.inside();
        let last = inside.wheels.last().expect("the wheels turned");
        assert_eq!((last.speed_mm_s, last.turn_rate_mrad_s), (0, 0));
        let silent = last.at.duration_since(inside.commanded.expect("commands came"));
        assert!(silent < Duration::from_millis(400), "the wheels ran on for {silent:?}");
    });
}

#[test]
fn what_the_sensor_measures_is_reported() {
    run(async {
        let socket = Socket::new();
        let micro = Micro::plug_in(&socket.path());
        (micro.inside().seen, micro.inside().range) = ("-", "i");
        let mut drive = Drive::new(&socket);

        let is_far = |drive: &Drive| {
            let range = drive.sensed.as_ref().and_then(|sensed| sensed.range.as_ref());
            range.is_some_and(|range| range.range.is_infinite() && range.max_range > 0.7)
        };
        drive.until("nothing is in range", || Command::STOP, is_far).await;
        (micro.inside().seen, micro.inside().range) = ("1", "312");
        let is_seen =
            |drive: &Drive| drive.sensed.as_ref().is_some_and(|sensed| sensed.seen == Some(true));
        drive.until("something is seen", || Command::STOP, is_seen).await;
    });
}

#[test]
fn noise_and_half_lines_neither_stop_the_robot_nor_move_it_otherwise() {
    run(async {
        let (_socket, micro, mut drive) = plugged_in().await;

        for mood in [Mood::Garbling, Mood::Halving, Mood::Mishearing] {
            micro.set_mood(mood);
            drive.for_a_while(Duration::from_millis(1500), FORWARD).await;
        }

        assert_eq!(drive.downs, [""; 0]);
        let allowed = BTreeSet::from([(150, -750), (0, 0)]);
        assert!(given(&micro).is_subset(&allowed), "{:?}", given(&micro));
        let garbled = drive.driver.health().into_iter().find(|(key, _)| *key == "lines_garbled");
        assert_ne!(garbled.expect("it is counted").1, "0");
    });
}

#[test]
fn silence_a_restart_and_a_fault_are_reported_and_recovered_from() {
    run(async {
        let (_socket, micro, mut drive) = plugged_in().await;

        for (misbehave, expected) in [
            (Mood::Silent, "no state of the microcontroller for 500 ms"),
            (Mood::Broken, "microcontroller reports a fault"),
        ] {
            micro.set_mood(misbehave);
            drive.until("it is down", || FORWARD, |drive| !drive.is_up).await;
            assert_eq!(drive.downs.last().map(String::as_str), Some(expected));
            micro.set_mood(Mood::Well);
            drive.up().await;
        }
        micro.restart();
        drive.until("it is down", || FORWARD, |drive| !drive.is_up).await;
        assert_eq!(drive.downs.last().map(String::as_str), Some("microcontroller restarted"));
        drive.up().await;
        drive.until("wheels turn", || FORWARD, |_| micro.wheels() == (150, -750)).await;
    });
}

#[test]
fn a_microcontroller_that_is_unplugged_is_found_again() {
    run(async {
        let (socket, micro, mut drive) = plugged_in().await;

        drop(micro);
        drive.until("it is down", || FORWARD, |drive| !drive.is_up).await;
        assert!(drive.downs[0].contains("the other end has gone"), "{:?}", drive.downs);
        let micro = Micro::plug_in(&socket.path());
        drive.up().await;

        drive.until("wheels turn", || FORWARD, |_| micro.wheels() == (150, -750)).await;
    });
}

#[test]
fn a_port_that_is_not_there_is_named_and_one_in_use_is_left_alone() {
    run(async {
        let socket = Socket::new();
        let mut early = Drive::new(&socket);
        early.until("it is down", || FORWARD, |drive| !drive.downs.is_empty()).await;
        assert!(early.downs[0].contains("cannot be opened"), "{:?}", early.downs);

        let _micro = Micro::plug_in(&socket.path());
        early.up().await;
        let mut late = Drive::new(&socket);
        late.until("it is down", || FORWARD, |drive| !drive.downs.is_empty()).await;
        assert!(late.downs[0].contains("in use by another process"), "{:?}", late.downs);
    });
}

#[test]
fn a_microcontroller_that_was_deaf_obeys_no_old_command() {
    run(async {
        let (_socket, micro, mut drive) = plugged_in().await;
        let start = Instant::now();
        // The speed encodes the age of its command, in units of 10 ms.
        let encoding = || Command {
            speed_m_s: (start.elapsed().as_secs_f64() * 100.0).floor() / 1000.0,
            turn_rate_rad_s: 0.0,
        };
        drive.until("wheels turn", encoding, |_| micro.wheels().0 > 0).await;

        for _ in 0..3 {
            micro.set_mood(Mood::Deaf);
            let deaf = Instant::now();
            let is_late = |_: &Drive| deaf.elapsed() > Duration::from_secs(2);
            drive.until("it was deaf for long", encoding, is_late).await;
            micro.set_mood(Mood::Well);
            let before = micro.inside().wheels.len();
            drive
                .until("it obeys again", encoding, |drive| {
                    drive.is_up && micro.inside().wheels.len() > before + 3
                })
                .await;
        }

        assert!(drive.downs.iter().any(|reason| reason.contains("not acknowledged")));
        for given in &micro.inside().wheels {
            if given.speed_mm_s > 0 {
                let sent_s = f64::from(given.speed_mm_s) / 100.0;
                let age_s = given.at.duration_since(start).as_secs_f64() - sent_s;
                assert!(age_s < 0.4, "a command of {age_s} s ago was obeyed");
            }
        }
    });
}
