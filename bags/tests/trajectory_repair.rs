//! Poses that are missing, jump, or come at other times: what is repaired, and what is refused.

use rsrs_bags::trajectory::{Finding, TrajectoryError};
use rsrs_msgs::builtin_interfaces::Time;
use rsrs_msgs::geometry_msgs::PoseStamped;

use crate::recording::outcome::{Foreign, Outcome, recorded};
use crate::recording::{PERIOD_NS, SPEED_M_S, odometry};

#[test]
fn two_publishers_on_one_topic_are_found_out() {
    let error = recorded(|recording| {
        for step in 0..20 {
            recording.step(step);
            recording.odom(0, step, &odometry(0, step));
        }
    })
    .unwrap_err();

    assert!(matches!(&error, TrajectoryError::TooClose { robot, .. } if robot == "robot_10"));
    assert!(error.to_string().ends_with("two publishers on one topic?"), "{error}");
}

/// Two robots of which the second one has only some of its poses.
fn with_poses_of_robot_2(n_steps: u64, has_pose: impl Fn(u64) -> bool) -> Outcome {
    recorded(|recording| {
        for step in 0..n_steps {
            recording.cmd_vel(0, step, SPEED_M_S);
            recording.cmd_vel(1, step, SPEED_M_S);
            recording.odom(0, step, &odometry(0, step));
            if has_pose(step) {
                recording.odom(1, step, &odometry(1, step));
            }
        }
    })
}

#[test]
fn a_long_gap_is_named_with_robot_time_and_length() {
    let error = with_poses_of_robot_2(40, |step| !(8..16).contains(&step)).unwrap_err();

    assert_eq!(
        error.to_string(),
        "robot robot_2 has no pose for 1.170 s before 2.080 s, expected one every 0.1300 s"
    );
}

#[test]
fn single_missing_poses_are_interpolated_and_reported() {
    let read = with_poses_of_robot_2(100, |step| step % 20 != 7).unwrap();

    assert_eq!(read.trajectory.n_samples(), 100);
    for (sample, expected) in (0..100).map(|step| (step, odometry(1, step as u64))) {
        let pose = read.trajectory.poses_at(sample)[0];
        let expected = expected.pose.pose.position;
        assert!((pose.x_m - expected.x).abs() < 1e-9 && (pose.y_m - 1.0).abs() < 1e-12);
    }
    let share = match &read.findings[0] {
        Finding::Missing { robot, share, .. } if robot == "robot_2" => *share,
        other => panic!("{other}"),
    };
    assert!((share - 0.05).abs() < 0.005, "{share}");
}

#[test]
fn too_many_missing_poses_are_refused() {
    let error = with_poses_of_robot_2(100, |step| step % 3 != 1).unwrap_err();

    assert!(matches!(&error, TrajectoryError::TooManyMissing { robot, .. } if robot == "robot_2"));
}

#[test]
fn a_robot_that_came_a_little_late_shortens_the_run() {
    let read = with_poses_of_robot_2(100, |step| step >= 8).unwrap();

    assert_eq!((read.trajectory.n_samples(), read.start_ns), (92, 8 * PERIOD_NS));
    let by_s = 8.0 * 0.13;
    assert_eq!(read.findings[0], Finding::LateStart { robot: "robot_2".into(), by_s });
}

#[test]
fn a_robot_that_left_in_the_middle_is_refused() {
    let error = with_poses_of_robot_2(100, |step| step < 60).unwrap_err();

    assert_eq!(
        error.to_string(),
        "robot robot_2 has no pose after 7.7 s of 12.9 s: a run is judged by its end"
    );
}

#[test]
fn a_robot_without_any_pose_is_missed() {
    let error = with_poses_of_robot_2(50, |_| false).unwrap_err();

    assert_eq!(error.to_string(), "robots of the run without poses: robot_2");
}

#[test]
fn a_single_pose_out_of_reach_is_left_out() {
    let read = recorded(|recording| {
        for step in 0..60 {
            let mut message = odometry(1, step);
            if step == 30 {
                message.pose.pose.position.x += 2.0;
            }
            (0..2).for_each(|robot| recording.cmd_vel(robot, step, SPEED_M_S));
            recording.odom(0, step, &odometry(0, step));
            recording.odom(1, step, &message);
        }
    })
    .unwrap();

    let outliers = Finding::Outliers { robot: "robot_2".into(), n_poses: 1 };
    assert!(read.findings.contains(&outliers), "{:?}", read.findings);
    let pose = read.trajectory.poses_at(30)[0];
    assert!((pose.x_m - odometry(1, 30).pose.pose.position.x).abs() < 1e-9);
}

#[test]
fn robots_that_the_tracker_exchanged_are_set_right() {
    let read = recorded(|recording| {
        for step in 0..60 {
            let exchanged = (20..45).contains(&step);
            for robot in 0..2 {
                let seen = if exchanged { 1 - robot } else { robot };
                recording.cmd_vel(robot, step, SPEED_M_S);
                recording.odom(robot, step, &odometry(seen, step));
            }
        }
    })
    .unwrap();

    let swaps: Vec<&Finding> =
        read.findings.iter().filter(|finding| matches!(finding, Finding::Swap { .. })).collect();
    assert_eq!(swaps.len(), 2, "{:?}", read.findings);
    for sample in 0..60 {
        let y_m: Vec<f64> = read.trajectory.poses_at(sample).iter().map(|pose| pose.y_m).collect();
        assert_eq!(y_m, [1.0, 0.0], "sample {sample}");
    }
}

#[test]
fn a_robot_that_was_carried_is_refused() {
    let error = recorded(|recording| {
        for step in 0..60 {
            let mut message = odometry(1, step);
            if step >= 30 {
                message.pose.pose.position.x += 1.0;
            }
            (0..2).for_each(|robot| recording.cmd_vel(robot, step, SPEED_M_S));
            recording.odom(0, step, &odometry(0, step));
            recording.odom(1, step, &message);
        }
    })
    .unwrap_err();

    assert_eq!(
        error.to_string(),
        "robot robot_2 jumped by 1.02 m at 3.900 s, expected at most 0.12 m, and no exchange of \
         robots explains it"
    );
}

#[test]
fn stamps_that_go_back_are_refused() {
    let error = recorded(|recording| {
        for step in 0..40 {
            let mut message = odometry(1, step);
            let stamp_ns = if step < 20 { step + 100 } else { step } * PERIOD_NS;
            message.header.stamp = Time::from_nanos(stamp_ns);
            (0..2).for_each(|robot| recording.cmd_vel(robot, step, SPEED_M_S));
            recording.odom(0, step, &odometry(0, step));
            recording.odom(1, step, &message);
        }
    })
    .unwrap_err();

    assert!(matches!(&error, TrajectoryError::ClockBackwards { robot, .. } if robot == "robot_2"));
}

#[test]
fn poses_of_a_fast_tracker_are_resampled_to_the_commands_period() {
    let mut foreign = Foreign::new();
    for step in 0..400_u64 {
        // 30 Hz, each stamp off by up to 20 ms.
        let time_ns = step * 33_333_333;
        let off_ns = (step * 7919 % 41) * 1_000_000;
        let mut pose = PoseStamped::default();
        pose.header.stamp = Time::from_nanos(1_000_000_000 + time_ns + off_ns - 20_000_000);
        pose.pose.position.x = SPEED_M_S * time_ns as f64 / 1e9;
        foreign.put("/r1/pose", 1_000_000_000 + time_ns, &pose);
        if step < 100 {
            foreign.command("r1", 1_000_000_000 + step * PERIOD_NS, SPEED_M_S);
        }
    }

    let read = foreign.read().unwrap();

    assert_eq!(read.trajectory.period_s.to_bits(), 0.13_f64.to_bits());
    assert!((98..=100).contains(&read.trajectory.n_samples()), "{}", read.trajectory.n_samples());
    for sample in 0..read.trajectory.n_samples() {
        let time_s = read.start_ns as f64 / 1e9 - 1.0 + sample as f64 * 0.13;
        let off_m = read.trajectory.poses_at(sample)[0].x_m - SPEED_M_S * time_s;
        // A stamp that is off by 20 ms moves a robot of 0.15 m/s by 3 mm.
        assert!(off_m.abs() < 0.0061, "{off_m} m at sample {sample}");
    }
}

#[test]
fn a_robot_that_drifts_away_from_the_others_is_brought_back_into_step() {
    let drifting = |drift_ns: u64| {
        recorded(move |recording| {
            for step in 0..50 {
                let mut late = odometry(1, step);
                late.header.stamp = Time::from_nanos(step * (PERIOD_NS + drift_ns));
                (0..2).for_each(|robot| recording.cmd_vel(robot, step, SPEED_M_S));
                recording.odom(0, step, &odometry(0, step));
                recording.odom(1, step, &late);
            }
        })
        .unwrap()
    };

    // Over 49 steps, 1 ms each is less than half a period of 130 ms, and 2 ms are more.
    let (little, much) = (drifting(1_000_000), drifting(2_000_000));

    assert!(little.findings.is_empty());
    assert!(matches!(much.findings[..], [Finding::Resampled { .. }]), "{:?}", much.findings);
    let last = much.trajectory.n_samples() - 1;
    let time_s = last as f64 * much.trajectory.period_s;
    let x_m = much.trajectory.poses_at(last)[0].x_m;
    assert!((x_m - SPEED_M_S * time_s * 130.0 / 132.0).abs() < 1e-6, "{x_m} m");
}
