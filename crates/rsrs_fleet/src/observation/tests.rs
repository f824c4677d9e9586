use std::collections::BTreeMap;

use rsrs_core::judge::behaviour::Behaviour;
use rsrs_core::judge::phase::Phase;
use rsrs_core::world::WorldFile;

use super::*;
use crate::e_stop::LockCause;
use crate::experiment::Time;
use crate::message::{self, Echo, RobotState, StopCause};
use crate::record::tests::record;

const RUN: &str = "run_1";

fn at(seconds: f64) -> Duration {
    Duration::from_secs_f64(seconds)
}

fn status(counter: u64, state: RobotState, stop_cause: StopCause) -> Status {
    let run_id = RUN.to_owned();
    Status { counter, epoch: 7, run_id, ..message::tests::status(state, stop_cause) }
}

fn lease(state: LeaseState, robots: &[&str]) -> Event {
    let echoes = robots.iter().map(|robot| Echo { robot: (*robot).to_owned(), counter: 1 });
    Event::Lease(Lease {
        run_id: RUN.to_owned(),
        epoch: 7,
        state,
        parameter_digest: 1,
        robots: echoes.collect(),
    })
}

fn of_robot_1(observation: &Observation) -> &ObservedRobot {
    observation.robots().find(|(name, _)| *name == "robot_1").expect("it was received").1
}

fn detection() -> Event {
    Event::Detection { robot: "robot_1".to_owned(), detected: true }
}

fn robot_status(status: Status) -> Event {
    Event::Status { robot: "robot_1".to_owned(), status }
}

/// Robots on a circle around the origin, which drive along it.
fn mill(n_robots: usize, time_s: f64) -> Vec<Event> {
    let (radius_m, turn_rate_rad_s) = (0.5, 0.3);
    (0..n_robots)
        .flat_map(|index| {
            let angle_rad =
                std::f64::consts::TAU * index as f64 / n_robots as f64 + turn_rate_rad_s * time_s;
            let (sine, cosine) = libm::sincos(angle_rad);
            let pose = Pose {
                x_m: radius_m * cosine,
                y_m: radius_m * sine,
                heading_rad: angle_rad + std::f64::consts::FRAC_PI_2,
            };
            let command = Command { speed_m_s: radius_m * turn_rate_rad_s, turn_rate_rad_s };
            let robot = format!("robot_{}", index + 1);
            [
                Event::Pose { robot: robot.clone(), source: PoseSource::Odom, pose },
                Event::Command { robot, command },
            ]
        })
        .collect()
}

/// Nine robots that mill under a lease.
fn milling(duration_s: u32) -> Vec<(Duration, Event)> {
    (0..duration_s * 10)
        .flat_map(|step| {
            let time_s = f64::from(step) * 0.1;
            let events = mill(9, time_s).into_iter().chain([lease(LeaseState::Running, &[])]);
            events.map(move |event| (at(time_s), event)).collect::<Vec<_>>()
        })
        .collect()
}

#[test]
fn a_rate_is_that_of_the_samples_and_falls_when_they_stay_away() {
    let mut observation = Observation::default();
    for sample in 0..50 {
        observation.on_event(detection(), at(0.13 * f64::from(sample)));
    }

    let last_s = 0.13 * 49.0;
    let hz =
        |after_s: f64| of_robot_1(&observation).detection_rate.hz(at(last_s + after_s)).unwrap();

    assert!((hz(0.1) - 1.0 / 0.13).abs() < 0.01, "{}", hz(0.1));
    assert!(hz(1.5) < 0.7 / 0.13, "{}", hz(1.5));
    assert!(hz(3.1).abs() < 1e-9, "{}", hz(3.1));
}

#[test]
fn a_robot_whose_statuses_stay_away_is_silent() {
    let mut observation = Observation::default();
    observation.on_event(robot_status(status(1, RobotState::Moving, StopCause::None)), at(1.0));

    let condition = |after_s| of_robot_1(&observation).condition(at(1.0 + after_s));

    assert_eq!(condition(0.9), Condition::Moving);
    assert_eq!(condition(1.1), Condition::Silent);
}

#[test]
fn a_status_that_comes_late_changes_nothing() {
    let mut observation = Observation::default();
    observation.on_event(robot_status(status(5, RobotState::Stopped, StopCause::EStop)), at(1.0));
    observation.on_event(robot_status(status(4, RobotState::Moving, StopCause::None)), at(1.1));

    assert_eq!(of_robot_1(&observation).condition(at(1.2)), Condition::EStop);
    assert_eq!(observation.n_held_by_e_stop(), 1);
}

#[test]
fn a_tracker_goes_before_the_robots_own_estimate_for_as_long_as_it_sees_it() {
    let pose = |x_m, source| Event::Pose {
        robot: "robot_1".to_owned(),
        source,
        pose: Pose { x_m, y_m: 0.0, heading_rad: 0.0 },
    };
    let mut observation = Observation::default();
    observation.on_event(pose(1.0, PoseSource::Pose), at(0.0));
    observation.on_event(pose(2.0, PoseSource::Odom), at(0.1));

    let x_m = |now_s| of_robot_1(&observation).pose(at(now_s)).unwrap().value.x_m;

    assert!((x_m(0.2) - 1.0).abs() < 1e-12);
    assert!((x_m(6.0) - 2.0).abs() < 1e-12);
}

#[test]
fn the_lease_is_that_of_the_robots_epoch() {
    let mut observation = Observation::default();
    observation.on_event(lease(LeaseState::Armed, &["robot_1", "robot_2"]), at(1.0));
    observation.on_event(robot_status(status(1, RobotState::Armed, StopCause::Waiting)), at(1.0));

    let views = |now_s| -> Vec<LeaseView> {
        let robots = observation.robots();
        robots.map(|(_, robot)| observation.lease_of(robot, at(now_s))).collect()
    };

    assert_eq!(views(1.5), [LeaseView::Holds(LeaseState::Armed), LeaseView::OtherEpoch]);
    assert_eq!(views(2.5), [LeaseView::None, LeaseView::None]);
}

#[test]
fn a_lease_in_parts_holds_each_robot_that_a_part_names_and_a_run_beside_changes_nothing() {
    let mut observation = Observation::default();
    observation.on_event(lease(LeaseState::Running, &["robot_1"]), at(1.0));
    observation.on_event(lease(LeaseState::Running, &["robot_2"]), at(1.0));
    observation.on_event(robot_status(status(1, RobotState::Moving, StopCause::None)), at(1.0));
    let Event::Lease(mut beside) = lease(LeaseState::Armed, &["robot_9"]) else { unreachable!() };
    beside.run_id = "of another bench".to_owned();

    observation.on_event(Event::Lease(beside), at(1.1));

    assert_eq!(
        observation.lease_of(of_robot_1(&observation), at(1.2)),
        LeaseView::Holds(LeaseState::Running)
    );
    let run = observation.run(at(1.2)).unwrap();
    assert_eq!((run.run_id, run.state), (RUN, LeaseState::Running));
}

#[test]
fn the_clock_of_a_run_starts_with_its_movement_and_stops_with_it() {
    let mut observation = Observation::default();
    observation.on_event(lease(LeaseState::Armed, &[]), at(1.0));
    let before = observation.run(at(1.5)).unwrap().running_for;
    observation.on_event(lease(LeaseState::Running, &[]), at(2.0));
    let during = observation.run(at(2.5)).unwrap().running_for;
    observation.on_event(lease(LeaseState::Stopped, &[]), at(4.0));
    let after = observation.run(at(9.0)).unwrap();

    assert_eq!((before, during), (None, Some(at(0.5))));
    assert_eq!((after.running_for, after.is_fresh), (Some(at(2.0)), false));
}

#[test]
fn who_holds_the_e_stop_is_known_from_itself_and_from_the_robots() {
    let (button, gone) = (Source([1; 16]), Source([2; 16]));
    let mut observation = Observation::default();
    observation.on_event(Event::EStop(Message::State { source: button, engaged: true }), at(0.0));
    let locks = Locks(BTreeMap::from([(gone, LockCause::Silent)]));
    observation
        .on_event(Event::EStop(Message::Locks { reporter: Source([3; 16]), locks }), at(0.1));

    assert_eq!(observation.e_stop(), BTreeSet::from([button, gone]));

    observation.on_event(Event::EStop(Message::State { source: button, engaged: false }), at(1.0));
    let none = Event::EStop(Message::Locks { reporter: Source([3; 16]), locks: Locks::default() });
    observation.on_event(none, at(1.1));

    assert_eq!(observation.e_stop(), BTreeSet::new());
}

#[test]
fn a_mill_is_one_from_the_beginning_and_for_good_after_a_minute() {
    let mut observation = Observation::default();
    let mut orders = Vec::new();
    for (time, event) in milling(75) {
        observation.on_event(event, time);
        if time == at(20.0) || time == at(74.0) {
            orders.push(observation.order().expect("it moves"));
        }
    }

    let [early, .., late] = orders[..] else { panic!("both times are there") };
    assert!(!early.is_whole() && late.is_whole(), "{} s, {} s", early.over_s, late.over_s);
    for order in [early, late] {
        assert_eq!(order.phase, Phase::STABLE_MILLING, "{order:?}");
        assert!(order.evidence.circliness > 0.95, "{order:?}");
    }
}

#[test]
fn what_a_lockstep_run_does_is_measured_by_its_own_clock() {
    let mut slow = Observation::default();
    for (time, event) in milling(70) {
        slow.on_event(event, time);
    }
    let mut fast = Observation::default();
    for (time, event) in milling(70) {
        let wall = time / 50;
        fast.on_event(Event::Clock(time), wall);
        fast.on_event(event, wall);
    }

    let (slow, fast) = (slow.order().unwrap(), fast.order().unwrap());

    assert!((slow.evidence.orbit - fast.evidence.orbit).abs() < 0.02, "{slow:?}\n{fast:?}");
    assert!((slow.evidence.circliness - fast.evidence.circliness).abs() < 0.02);
}

#[test]
fn a_new_run_is_judged_from_its_own_beginning() {
    let mut observation = Observation::default();
    for (time, event) in milling(30) {
        observation.on_event(event, time);
    }
    let Event::Lease(mut of_next) = lease(LeaseState::Running, &[]) else { unreachable!() };
    of_next.run_id = "run_2".to_owned();

    observation.on_event(Event::Lease(of_next), at(30.0));
    for event in mill(9, 30.1) {
        observation.on_event(event, at(30.1));
    }

    assert!(observation.order().is_none_or(|order| order.over_s < 1.0));
}

#[test]
fn a_sender_of_any_number_of_names_fills_no_memory() {
    let mut observation = Observation::default();
    for number in 0..2 * MOST_ROBOTS {
        observation.on_event(Event::Found { robot: format!("robot_{number}") }, at(0.0));
    }

    assert_eq!(observation.n_robots(), MOST_ROBOTS);
}

#[test]
fn a_recording_plays_at_its_pace_pauses_and_ends() {
    let mut playback = Playback::new(milling(20), None, at(20.0));

    playback.advance(at(3.0));
    assert_eq!(playback.at(), at(3.0));
    playback.toggle_pause();
    playback.advance(at(3.0));
    assert_eq!(playback.at(), at(3.0));
    playback.toggle_pause();
    playback.play_faster();
    playback.advance(at(3.0));
    assert_eq!(playback.at(), at(9.0));
    playback.advance(at(60.0));

    assert!(playback.is_over() && playback.at() == at(20.0));
    playback.toggle_pause();
    assert_eq!(playback.at(), Duration::ZERO);
}

#[test]
fn whoever_goes_back_sees_what_was_seen_there() {
    let mut events = milling(100);
    events.push((at(0.5), Event::EStop(Message::State { source: Source([1; 16]), engaged: true })));
    let mut straight = Playback::new(events.clone(), None, at(100.0));
    straight.seek(at(80.0));
    let mut back = Playback::new(events, None, at(100.0));
    back.seek(at(100.0));
    back.skip(-20.0);

    let seen = |playback: &Playback| {
        let now = playback.at();
        let robots = playback.observation().robots();
        let robots: Vec<_> = robots
            .map(|(name, robot)| (name.to_owned(), robot.pose(now), robot.pose_hz(now)))
            .collect();
        let running_for = playback.observation().run(now).and_then(|run| run.running_for);
        let phase = playback.order().map(|order| order.phase);
        (robots, playback.observation().e_stop(), running_for, phase)
    };

    assert_eq!(seen(&back), seen(&straight));
    assert_eq!(back.observation().e_stop().len(), 1);
}

#[test]
fn a_recorded_run_in_lockstep_has_no_silent_robots_and_one_in_real_time_has() {
    // Statuses come by the wall clock, some simulated seconds apart.
    let played = |time: Time| {
        let record = ExperimentRecord { time, ..record() };
        let events = [
            Event::Experiment(Box::new(record)),
            lease(LeaseState::Running, &["robot_1"]),
            robot_status(status(1, RobotState::Moving, StopCause::None)),
        ];
        let mut playback = Playback::new(events.map(|it| (at(1.0), it)).into(), None, at(20.0));
        playback.seek(at(15.0));
        playback.skip(-5.0);
        let observation = playback.observation();
        let is_fresh = observation.run(playback.at()).map(|run| run.is_fresh);
        (of_robot_1(observation).condition(playback.at()), is_fresh)
    };

    assert_eq!(played(Time::Lockstep), (Condition::Moving, Some(true)));
    assert_eq!(played(Time::RealTime), (Condition::Silent, Some(false)));
}

#[test]
fn objects_decide_on_a_phase_once_all_of_them_are_seen() {
    let mut record = record();
    let world = "objects: [{count: 3, radius_m: 0.05}]";
    record.conditions.world =
        WorldFile::parse("world.yaml", world, &[15.0], &[]).expect("it is one");
    let heap = "name: heap\nwords: {noun: a heap, swarm: a heaping swarm, verb: [heap, heaps, heaped]}\n\
                phases: [{key: in_a_heap}, {key: not_in_a_heap}]\n\
                rules: [{phase: in_a_heap, when: {objects_clustered: {at_least: 0.5}}}]\n\
                otherwise: not_in_a_heap\n";
    record.conditions.behaviour = Behaviour::parse("heap.yaml", heap).expect("it is one");
    let mut observation = Observation::default();
    assert!(!observation.lacks_objects());

    observation.on_event(Event::Experiment(Box::new(record)), at(0.0));
    let object = |number: u32| Event::Object {
        object: format!("object_{number}"),
        place_m: [0.1 * f64::from(number), 0.0],
    };
    for (time, event) in milling(20) {
        observation.on_event(event, time);
        observation.on_event(object(1), time);
        observation.on_event(object(2), time);
    }
    assert_eq!(observation.order(), None);
    assert!(observation.lacks_objects());

    for (time, event) in milling(20) {
        let time = time + at(30.0);
        observation.on_event(object(3), time);
        observation.on_event(event, time);
    }
    assert!(!observation.lacks_objects());
    let order = observation.order().expect("all are seen");
    assert_eq!(order.phase.key(), "in_a_heap");
    assert_eq!(observation.objects_m().count(), 3);
}
