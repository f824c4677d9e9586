//! Robots that stand in a run because leases did not reach them.

use rsrs_core::robot::unicycle::Pose;

use super::*;

/// A long run of which the second robot misses the leases for a while, so many beats long.
fn pausing(robot_lost: RobotLost, n_beats: usize) -> Bench {
    let mut bench =
        Bench::new(RunLength::RealTime { duration: Duration::from_secs(20) }, robot_lost);
    bench.run();
    (0..5).for_each(|_| bench.beat());
    pause(&mut bench, n_beats);
    bench
}

fn pause(bench: &mut Bench, n_beats: usize) {
    bench.stop_cause = StopCause::Lease;
    bench.stopped.insert("robot_2");
    (0..n_beats).for_each(|_| bench.beat());
    bench.stopped.remove("robot_2");
    bench.stop_cause = StopCause::None;
    bench.beat();
}

#[test]
fn a_robot_that_stood_for_a_moment_goes_on_and_is_in_the_account_of_the_run() {
    let mut bench = pausing(RobotLost::Abort, 4);

    assert_eq!(bench.end().0, Outcome::Completed);
    let [paused] = bench.runner.paused() else { panic!("{:?}", bench.runner.paused()) };
    assert_eq!(paused.robot, "robot_2");
    assert!((0.4..0.6).contains(&paused.stood_s), "{paused:?}");
    assert!((0.4..0.7).contains(&paused.after_s), "{paused:?}");
    let note = "robot_2 goes on, and stood for at most 0.5 s: its lease ran out";
    assert_eq!(bench.notes.iter().filter(|text| *text == note).count(), 1, "{:?}", bench.notes);
    let ending = bench.runner.ending().expect("it has ended");
    assert_eq!(ending.paused, bench.runner.paused());
}

#[test]
fn a_robot_whose_lapse_is_final_is_lost_at_once() {
    let mut bench = pausing(RobotLost::Abort, 2);

    bench.stop_cause = StopCause::Latched;
    bench.stopped.insert("robot_2");

    let Outcome::Aborted { reason } = bench.end().0 else { panic!("{:?}", bench.finish) };
    assert!(reason.starts_with("lost robot_2: stopped in epoch 4"), "{reason}");
}

#[test]
fn a_robot_that_stands_again_and_again_is_lost() {
    let mut bench = pausing(RobotLost::Note, 8);

    for _ in 0..4 {
        pause(&mut bench, 8);
    }

    let [lost] = bench.runner.lost() else { panic!("{:?}", bench.notes) };
    assert!(lost.reason.starts_with("stood for 3."), "{lost:?}");
    assert!(lost.reason.ends_with(" s in all, as no lease reached it"), "{lost:?}");
}

#[test]
fn a_robot_that_was_given_up_is_left_out_of_the_leases_until_all_are_stopped() {
    let mut bench = Bench::with(|options| {
        options.length = RunLength::RealTime { duration: Duration::from_secs(12) };
        options.robot_lost = RobotLost::Note;
        options.samples = [SampleKind::Pose].into();
        options.expected.simulator = false;
    });
    let pose = |robot: &str| Event::Sampled { robot: robot.to_owned(), kind: SampleKind::Pose };
    let named = |bench: &Bench| -> Vec<String> {
        let lease = bench.lease.as_ref().expect("it has published some");
        lease.robots.iter().map(|echo| echo.robot.clone()).collect()
    };
    for name in NAMES {
        let pose = Pose { x_m: 0.0, y_m: 0.0, heading_rad: 0.0 };
        bench.give(Event::Pose { robot: name.to_owned(), frame: "map".to_owned(), pose });
    }
    bench.run();
    for name in NAMES {
        bench.give(pose(name));
    }

    // The tracker does not see robot_2 any more.
    for _ in 0..60 {
        bench.give(pose("robot_1"));
        bench.beat();
    }
    assert_eq!(named(&bench), ["robot_1"]);
    let moves = "robot_2 was given up and reports that it still moves: stop it by hand";
    while !bench.notes.iter().any(|text| text == moves) {
        bench.give(pose("robot_1"));
        bench.beat();
    }
    bench.stopped.insert("robot_2");
    while bench.finish.is_none() {
        bench.give(pose("robot_1"));
        bench.beat();
    }

    assert_eq!(bench.end().0, Outcome::Completed);
    let stands = "robot_2 stands until the next run";
    assert_eq!(bench.notes.iter().filter(|text| *text == stands).count(), 1, "{:?}", bench.notes);
    assert_eq!(named(&bench), NAMES, "it is stopped as all others are");
}

#[test]
fn the_lease_of_a_large_fleet_comes_in_parts_twenty_times_a_second() {
    let robots: Vec<String> = (0..100).map(|robot| format!("robot_{robot}")).collect();
    let mut runner = Bench::with(|options| options.expected.robots.clone_from(&robots)).runner;
    let mut leases = Vec::new();

    for now_ms in (0..1_000).step_by(20) {
        for action in runner.on_event(Event::Tick, Duration::from_millis(now_ms)) {
            if let Action::PublishLease(lease) = action {
                leases.push(lease);
            }
        }
    }

    assert_eq!(leases.len(), 20 * 2);
    let named: Vec<_> = leases[..2].iter().flat_map(|lease| &lease.robots).collect();
    assert_eq!(named.len(), 100);
}
