//! Poses that are missing, jump, or come at other times: what is repaired, and what is refused.

use rsrs_bags::trajectory::{Finding, RecordedTrajectory, TrajectoryError};
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

/// The gaps of robot 2 that were bridged.
fn gaps(read: &RecordedTrajectory) -> Vec<(f64, f64, bool)> {
    let gap = |finding: &Finding| match finding {
        Finding::Gap { robot, from_s, to_s, is_judged } if robot == "robot_2" => {
            Some((*from_s, *to_s, *is_judged))
        }
        _ => None,
    };
    read.findings.iter().filter_map(gap).collect()
}

#[test]
fn poses_that_are_missing_where_a_run_is_judged_are_named_with_robot_and_time() {
    let cases = [
        (
            200,
            8..24,
            "robot robot_2 has no pose from 0.91 s to 3.12 s within the last 60 s, which are judged, \
             expected gaps of at most 2 s there",
        ),
        (
            100,
            60..100,
            "robot robot_2 has no pose after 7.7 s of 12.9 s: a run is judged by its end",
        ),
        (50, 0..50, "robots of the run without poses: robot_2"),
    ];
    for (n_steps, missing, expected) in cases {
        let error = with_poses_of_robot_2(n_steps, |step| !missing.contains(&step)).unwrap_err();

        assert_eq!(error.to_string(), expected);
    }
}

#[test]
fn a_gap_of_up_to_two_seconds_in_the_judged_time_is_bridged_and_named() {
    let read = with_poses_of_robot_2(200, |step| !(100..114).contains(&step)).unwrap();

    let from_s = 99.0 * 0.13;
    let [(found_s, to_s, true)] = gaps(&read)[..] else { panic!("{:?}", read.findings) };
    assert!((found_s - from_s).abs() < 1e-9 && (to_s - from_s - 1.95).abs() < 1e-9);
    assert_eq!(read.trajectory.n_samples(), 200);
    let named = read.findings.iter().map(ToString::to_string).find(|text| text.contains("no pose"));
    assert_eq!(
        named.as_deref(),
        Some(
            "robot_2: no pose from 12.87 s to 14.82 s, in the time that is judged: interpolated \
             on a straight line"
        )
    );
}

#[test]
fn gaps_of_any_length_before_the_judged_time_are_named_and_no_reason_to_refuse() {
    // 130 s, of which the last 60 s are judged: 40 s without a pose, and 3 s.
    let is_gone = |step: u64| (100..408).contains(&step) || (450..473).contains(&step);
    let read = with_poses_of_robot_2(1000, |step| !is_gone(step)).unwrap();

    let [(first_s, back_s, false), (_, last_s, false)] = gaps(&read)[..] else {
        panic!("{:?}", read.findings)
    };
    assert!((first_s - 99.0 * 0.13).abs() < 1e-9 && (back_s - 408.0 * 0.13).abs() < 1e-9);
    assert!(last_s < 70.0);
    assert_eq!(read.trajectory.n_samples(), 1000);
    // One that ends within it is too long for it.
    let error = with_poses_of_robot_2(1000, |step| !(530..550).contains(&step)).unwrap_err();
    assert!(matches!(error, TrajectoryError::Gap { .. }), "{error}");
    // Nor are many missing poses before it.
    let read = with_poses_of_robot_2(1000, |step| step > 500 || step % 3 != 1).unwrap();
    assert!(matches!(&read.findings[..1], [Finding::Missing { share, .. }] if *share > 0.1));
}

#[test]
fn a_robot_that_is_seen_late_but_for_all_that_is_judged_shortens_the_run() {
    let read = with_poses_of_robot_2(700, |step| step >= 200).unwrap();
    assert_eq!((read.trajectory.n_samples(), read.start_ns), (500, 200 * PERIOD_NS));
    let late = Finding::LateStart { robot: "robot_2".into(), by_s: 26.0 };
    assert!(read.findings.contains(&late), "{:?}", read.findings);

    let error = with_poses_of_robot_2(700, |step| step >= 300).unwrap_err();
    assert!(matches!(&error, TrajectoryError::Span { robot, .. } if robot == "robot_2"), "{error}");
    // Of a run shorter than what is judged, a tenth.
    let read = with_poses_of_robot_2(100, |step| step >= 8).unwrap();
    assert_eq!((read.trajectory.n_samples(), read.start_ns), (92, 8 * PERIOD_NS));
    let error = with_poses_of_robot_2(100, |step| step >= 11).unwrap_err();
    assert!(matches!(error, TrajectoryError::Span { .. }), "{error}");
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
