//! Trajectories out of bags: good ones, and the reasons why others give none.

use rsrs_bags::Bag;
use rsrs_bags::trajectory::{
    Finding, TrajectoryError, TrajectoryOptions, WindowSource, read_trajectory,
};
use rsrs_core::help::Help;
use rsrs_core::robot::pose_source::PoseSource;
use rsrs_msgs::builtin_interfaces::Time;
use rsrs_msgs::geometry_msgs::{PoseStamped, TransformStamped};
use rsrs_msgs::rsrs::{LeaseState, RunLease};
use rsrs_msgs::tf2_msgs::TFMessage;

use crate::recording::damage::temporary;
use crate::recording::outcome::{Foreign, read, recorded};
use crate::recording::{PERIOD_NS, Recording, SPEED_M_S, odometry};

fn body(robot: &str, parent: &str, step: u64) -> TransformStamped {
    let mut transform = TransformStamped::default();
    transform.header.stamp = Time::from_nanos(step * PERIOD_NS);
    parent.clone_into(&mut transform.header.frame_id);
    transform.child_frame_id = format!("{robot}/base_link");
    transform.transform.translation.x = step as f64;
    transform
}

#[test]
fn rows_are_robots_in_the_order_people_count_with_the_command_that_answered() {
    let read = recorded(|recording| (0..20).for_each(|step| recording.step(step))).unwrap();

    let trajectory = &read.trajectory;
    assert_eq!(read.robots, ["robot_2", "robot_10"]);
    assert_eq!(read.poses, PoseSource::Odom);
    assert_eq!((trajectory.n_robots, trajectory.n_samples(), read.start_ns), (2, 20, 0));
    assert_eq!(trajectory.period_s.to_bits(), 0.13_f64.to_bits());
    // The recording numbers robot_10 first, and its robots are at y = 0 and y = 1.
    let y_m: Vec<f64> = trajectory.poses_at(7).iter().map(|pose| pose.y_m).collect();
    assert_eq!(y_m, [1.0, 0.0]);
    assert!((trajectory.poses_at(7)[0].x_m - SPEED_M_S * 0.91).abs() < 1e-12);
    // The turning rate counts the steps, so that a shift by one would show.
    let commands = trajectory.commands_at(7);
    let turns: Vec<f64> = commands.iter().map(|command| command.turn_rate_rad_s).collect();
    assert_eq!(turns, [7.0, 7.0]);
}

#[test]
fn only_the_time_in_which_the_lease_was_running_counts() {
    let read = recorded(|recording| {
        recording.lease(0, LeaseState::Armed);
        for step in 0..50 {
            if step == 10 {
                recording.lease(step, LeaseState::Running);
            }
            recording.step(step);
        }
        recording.lease(39, LeaseState::Stopped);
    })
    .unwrap();

    assert_eq!(read.window.source, WindowSource::Lease);
    assert_eq!((read.trajectory.n_samples(), read.start_ns), (30, 10 * PERIOD_NS));
    assert_eq!(read.trajectory.commands_at(0)[0].turn_rate_rad_s.to_bits(), 10_f64.to_bits());
}

#[test]
fn a_lease_that_never_ran_gives_no_trajectory() {
    let folder = temporary();
    let path = folder.path().join("run");
    let mut recording = Recording::new(&path, &["robot_1"]);
    recording.lease(0, LeaseState::Armed);
    (0..20).for_each(|step| recording.step(step));
    recording.writer.finish().unwrap();

    let outcome = read(&Bag::open(&path).unwrap());

    assert!(matches!(outcome, Err(TrajectoryError::NeverRunning)));
}

#[test]
fn a_trackers_bag_with_unstamped_commands_counts_from_the_first_to_the_last_command() {
    let mut foreign = Foreign::new();
    for step in 0..40 {
        // The tracker has a clock of its own, and the commands come a little later.
        let mut pose = PoseStamped::default();
        pose.header.stamp = Time::from_nanos(5_000_000_000 + step * PERIOD_NS);
        pose.pose.position.x = step as f64;
        foreign.put("/r1/pose", step * PERIOD_NS, &pose);
        let speed_m_s = if (10..30).contains(&step) { step as f64 } else { 0.0 };
        foreign.command("r1", step * PERIOD_NS + 20_000_000, speed_m_s);
    }

    let read = foreign.read().unwrap();

    assert_eq!((read.poses, read.window.source), (PoseSource::Pose, WindowSource::Commands));
    assert_eq!(read.trajectory.n_samples(), 20);
    for sample in 0..20 {
        let (pose, command) = (read.trajectory.poses[sample], read.trajectory.commands[sample]);
        assert_eq!(pose.x_m.to_bits(), command.speed_m_s.to_bits());
    }
}

#[test]
fn what_a_gate_lets_through_to_a_base_is_no_command_of_another_robot() {
    let mut foreign = Foreign::new();
    for step in 0..40 {
        let mut pose = PoseStamped::default();
        pose.header.stamp = Time::from_nanos(step * PERIOD_NS);
        pose.pose.position.x = 0.01 * step as f64;
        foreign.put("/robot_1/pose", step * PERIOD_NS, &pose);
        foreign.command("robot_1", step * PERIOD_NS, 0.1);
        foreign.command("robot_1/hardware", step * PERIOD_NS, 0.3);
    }

    let read = foreign.read().unwrap();

    assert_eq!(read.robots, ["robot_1"]);
    assert!(
        read.trajectory
            .commands
            .iter()
            .all(|command| command.speed_m_s.to_bits() == 0.1_f64.to_bits())
    );
}

/// A transform that turns by a quarter and then moves.
fn quarter_turn(child: &str, parent: &str, step: u64) -> TransformStamped {
    let mut edge = body("", parent, step);
    child.clone_into(&mut edge.child_frame_id);
    let transform = &mut edge.transform;
    (transform.translation.x, transform.translation.y) = (1.0, 2.0);
    (transform.rotation.z, transform.rotation.w) = (0.5_f64.sqrt(), 0.5_f64.sqrt());
    edge
}

#[test]
fn chains_of_transforms_are_followed_up_to_the_map_that_all_robots_share() {
    let mut foreign = Foreign::new();
    let mount = TransformStamped {
        child_frame_id: "r1/base_footprint".into(),
        ..body("", "r1/base_link", 0)
    };
    for step in 0..20 {
        let mut localised = quarter_turn("r2/odom", "map", step);
        localised.transform.translation.x = 2.0;
        let transforms = vec![body("r1", "/r1/odom", step), localised, body("r2", "r2/odom", step)];
        foreign.put("/tf", step * PERIOD_NS, &TFMessage { transforms });
        foreign.command("r1", step * PERIOD_NS, 0.1);
        foreign.command("r2", step * PERIOD_NS, 0.1);
    }
    // Received last, and true from the beginning.
    let transforms = vec![quarter_turn("r1/odom", "map", 0), mount];
    foreign.put("/tf_static", 20 * PERIOD_NS, &TFMessage { transforms });

    let read = foreign.read().unwrap();

    assert_eq!((read.poses, read.robots.len()), (PoseSource::Tf, 2));
    assert_eq!(read.trajectory.n_samples(), 20);
    for step in 0..20 {
        for (pose, x_m) in read.trajectory.poses_at(step).iter().zip([1.0, 2.0]) {
            assert!((pose.x_m - x_m).abs() < 1e-6, "{pose:?}");
            assert!((pose.y_m - 2.0 - step as f64).abs() < 1e-6, "{pose:?}");
            assert!((pose.heading_rad - std::f64::consts::FRAC_PI_2).abs() < 1e-6, "{pose:?}");
        }
    }
}

#[test]
fn a_bag_without_poses_names_the_topics_it_has() {
    let mut foreign = Foreign::new();
    foreign.command("r1", 0, 0.1);

    let error = foreign.read().unwrap_err();

    assert_eq!(
        error.to_string(),
        "the bag has no poses: expected /<robot>/odom, /<robot>/pose, /poses or /tf among its topics: \
         /r1/cmd_vel (geometry_msgs/msg/Twist)"
    );
    assert!(error.help().unwrap().contains("record /<robot>/odom"));
}

#[test]
fn a_robot_without_commands_is_named() {
    let mut foreign = Foreign::new();
    foreign.put("/r1/pose", 0, &PoseStamped::default());
    foreign.put("/r1/pose", PERIOD_NS, &PoseStamped::default());

    let error = foreign.read().unwrap_err();

    assert_eq!(
        error.to_string(),
        "robot r1 has poses and no commands: expected /r1/cmd_vel among the topics: /r1/pose \
         (geometry_msgs/msg/PoseStamped)"
    );
}

#[test]
fn robots_that_never_moved_give_no_trajectory() {
    let mut foreign = Foreign::new();
    for step in 0..20 {
        foreign.put("/r1/pose", step * PERIOD_NS, &PoseStamped::default());
        foreign.command("r1", step * PERIOD_NS, 0.0);
    }

    assert!(matches!(foreign.read(), Err(TrajectoryError::NeverCommanded)));
}

#[test]
fn a_pose_that_is_not_a_number_names_robot_and_time() {
    let error = recorded(|recording| {
        (0..10).for_each(|step| recording.step(step));
        let mut message = odometry(1, 10);
        message.pose.pose.position.y = f64::NAN;
        recording.odom(1, 10, &message);
    })
    .unwrap_err();

    assert_eq!(error.to_string(), "pose of robot robot_2 at 1.300 s is not a number");
}

#[test]
fn the_first_sample_is_dropped_where_the_window_opened_between_two_robots() {
    let read = recorded(|recording| {
        (0..2).for_each(|robot| recording.cmd_vel(robot, 0, SPEED_M_S));
        recording.odom(0, 0, &odometry(0, 0));
        (1..20).for_each(|step| recording.step(step));
    })
    .unwrap();

    assert_eq!((read.trajectory.n_samples(), read.start_ns), (19, PERIOD_NS));
}

#[test]
fn the_source_that_was_asked_for_is_the_only_one() {
    let folder = temporary();
    let path = folder.path().join("run");
    let mut recording = Recording::new(&path, &["robot_1"]);
    (0..20).for_each(|step| recording.step(step));
    recording.writer.finish().unwrap();

    let options =
        TrajectoryOptions { poses: Some(PoseSource::Pose), ..TrajectoryOptions::default() };
    let error = read_trajectory(&Bag::open(&path).unwrap(), &options).unwrap_err();

    assert!(matches!(error, TrajectoryError::NoPoses { asked: Some(PoseSource::Pose), .. }));
}

/// A lease of some run.
fn lease_of(run_id: &str, state: LeaseState) -> RunLease {
    RunLease { state: state.into(), epoch: 1, run_id: run_id.to_owned(), ..RunLease::default() }
}

#[test]
fn leases_of_other_runs_neither_begin_nor_end_a_run() {
    let folder = temporary();
    let path = folder.path().join("run");
    let mut recording = Recording::new(&path, &["robot_1", "robot_2"]);
    let channel = recording.lease;
    let mut robots = lease_of("ours", LeaseState::Running);
    robots.robots = vec!["robot_1".to_owned(), "robot_2".to_owned()];
    recording.put(channel, 0, &robots);
    for step in 0..60 {
        if step % 8 == 3 {
            recording.put(channel, step * PERIOD_NS, &lease_of("theirs", LeaseState::Idle));
        }
        if (20..30).contains(&step) {
            let mut theirs = lease_of("theirs", LeaseState::Running);
            theirs.robots = vec!["robot_9".to_owned()];
            recording.put(channel, step * PERIOD_NS, &theirs);
        }
        recording.step(step);
    }
    recording.put(channel, 49 * PERIOD_NS, &lease_of("ours", LeaseState::Stopped));
    recording.writer.finish().unwrap();
    let bag = Bag::open(&path).unwrap();
    let of_run = |run_id: Option<&str>| {
        let run_id = run_id.map(str::to_owned);
        read_trajectory(&bag, &TrajectoryOptions { run_id, ..TrajectoryOptions::default() })
    };

    let first = of_run(None).unwrap();
    let named = of_run(Some("ours")).unwrap();
    let theirs = of_run(Some("theirs")).unwrap_err();

    assert_eq!(first.trajectory.n_samples(), 50);
    assert_eq!(named, first);
    assert!(
        matches!(&theirs, TrajectoryError::MissingRobots { robots } if robots == &["robot_9"]),
        "{theirs}"
    );
}

#[test]
fn robots_whose_odometry_begins_at_zero_are_refused() {
    let mut foreign = Foreign::new();
    for step in 0..40 {
        for robot in ["r1", "r2", "r3"] {
            let mut odometry = odometry(0, step);
            odometry.header.frame_id = "odom".into();
            foreign.put(&format!("/{robot}/odom"), step * PERIOD_NS, &odometry);
            foreign.command(robot, step * PERIOD_NS, SPEED_M_S);
        }
    }

    let error = foreign.read().unwrap_err();

    assert_eq!(
        error.to_string(),
        "robots r1, r2, r3 start on one spot, (0.00 m, 0.00 m): each has poses in a frame of its own?"
    );
    assert!(
        error.help().is_some_and(|help| help.contains("poses must be in one frame, with z up"))
    );
}

/// Two robots side by side, each with poses in the frame that it had then.
fn in_frames(topic: &str, frame_of: impl Fn(&str, u64) -> String) -> Foreign {
    let mut foreign = Foreign::new();
    for step in 0..40 {
        for (number, robot) in ["r1", "r2"].into_iter().enumerate() {
            let mut odometry = odometry(number, step);
            odometry.header.frame_id = frame_of(robot, step);
            let (name, time_ns) = (format!("/{robot}/{topic}"), step * PERIOD_NS);
            if topic == "odom" {
                foreign.put(&name, time_ns, &odometry);
            } else {
                let pose = PoseStamped { header: odometry.header, pose: odometry.pose.pose };
                foreign.put(&name, time_ns, &pose);
            }
            // It stands, then it runs.
            foreign.command(robot, time_ns, if step < 10 { 0.0 } else { SPEED_M_S });
        }
    }
    foreign
}

#[test]
fn odometry_and_poses_in_different_frames_are_refused_as_transforms_are() {
    let mut transforms = Foreign::new();
    let of_each = vec![body("r1", "r1/odom", 0), body("r2", "r2/odom", 0)];
    transforms.put("/tf", 0, &TFMessage { transforms: of_each });
    let own = |robot: &str, _| format!("{robot}/odom");
    for foreign in [in_frames("odom", own), in_frames("pose", own), transforms] {
        let error = foreign.read().unwrap_err();

        let text = "poses of robot r2 are in frame \"r2/odom\", others in \"r1/odom\"";
        assert_eq!(error.to_string(), text);
        assert!(error.help().is_some_and(|help| help.contains("`--poses tf`")));
    }
    // As tf2 compares them, and as long as the swarm was running.
    let moves_on = |robot: &str, step| if step < 5 { robot.to_owned() } else { "/map".to_owned() };
    assert!(in_frames("odom", moves_on).read().is_ok());
    let is_set = |_: &str, step| if step < 20 { "/map".to_owned() } else { "map".to_owned() };
    assert!(in_frames("pose", is_set).read().is_ok());
    let leaves = |_: &str, step| if step < 20 { "map".to_owned() } else { "other".to_owned() };
    let error = in_frames("odom", leaves).read().unwrap_err();
    assert!(matches!(error, TrajectoryError::Frames { .. }), "{error}");
}

#[test]
fn a_tracker_goes_before_odometry_unless_it_sees_too_few_and_what_was_passed_over_is_named() {
    let with_tracker_of = |robots: &[&str]| {
        let mut foreign = in_frames("odom", |_, _| "odom".to_owned());
        for step in 0..40 {
            for (number, robot) in robots.iter().enumerate() {
                let odometry = odometry(number, step);
                let pose = PoseStamped { header: odometry.header, pose: odometry.pose.pose };
                foreign.put(&format!("/{robot}/pose"), step * PERIOD_NS, &pose);
            }
        }
        foreign.read().unwrap()
    };

    let of_both = with_tracker_of(&["r1", "r2"]);
    let of_one = with_tracker_of(&["r1"]);

    assert_eq!(of_both.poses, PoseSource::Pose);
    let unstated = Finding::Unstated { taken: PoseSource::Pose, others: vec![PoseSource::Odom] };
    assert_eq!(of_both.findings, [unstated]);
    assert_eq!((of_one.poses, &of_one.findings[..]), (PoseSource::Odom, &[][..]));
}
