//! Poses and commands that were stamped by several clocks.

use rsrs_bags::trajectory::{Finding, RecordedTrajectory};
use rsrs_msgs::builtin_interfaces::Time;
use rsrs_msgs::geometry_msgs::{PoseStamped, TwistStamped};

use crate::recording::PERIOD_NS;
use crate::recording::outcome::Foreign;

/// A bag of a robot with a stamped pose and a stamped command in each step, given its number and the
/// time that its recorder's clock shows.
struct Clocks {
    foreign: Foreign,
}

/// When the recorder starts, in nanoseconds since 1970.
const START_NS: u64 = 1_700_000_000_000_000_000;

impl Clocks {
    fn new() -> Self {
        Self { foreign: Foreign::new() }
    }

    fn step(&mut self, robot: u64, step: u64, (pose_ns, command_ns): (u64, u64)) {
        let log_ns = START_NS + step * PERIOD_NS;
        let mut pose = PoseStamped::default();
        pose.header.stamp = Time::from_nanos(pose_ns);
        (pose.pose.position.x, pose.pose.position.y) = (0.01 * step as f64, robot as f64);
        self.foreign.put(&format!("/r{robot}/pose"), log_ns + 4_000_000, &pose);
        let mut command = TwistStamped::default();
        command.header.stamp = Time::from_nanos(command_ns);
        command.twist.linear.x = 0.01 * step as f64 + 0.001;
        self.foreign.put(&format!("/r{robot}/cmd_vel"), log_ns + 9_000_000, &command);
    }
}

/// How far commands are from those that belong to their poses.
fn worst_command(read: &RecordedTrajectory) -> f64 {
    let both = read.trajectory.poses.iter().zip(&read.trajectory.commands);
    both.map(|(pose, command)| (command.speed_m_s - 0.001 - pose.x_m).abs()).fold(0.0, f64::max)
}

#[test]
fn a_tracker_with_another_clock_is_aligned_by_log_time_and_reported() {
    // A minute behind, and seconds since the tracker was switched on.
    for behind_ns in [60_000_000_000, START_NS - 5_000_000_000] {
        let mut clocks = Clocks::new();
        for step in 0..60 {
            let now_ns = START_NS + step * PERIOD_NS;
            clocks.step(1, step, (now_ns - behind_ns, now_ns));
        }

        let read = clocks.foreign.read().unwrap();

        assert!(worst_command(&read) < 1e-9, "{} m/s off", worst_command(&read));
        let [Finding::Clocks { least_s, most_s }] = read.findings[..] else {
            panic!("{:?}", read.findings)
        };
        assert!((most_s - least_s - behind_ns as f64 / 1e9).abs() < 0.01, "{least_s} {most_s}");
    }
}

#[test]
fn stamps_of_one_clock_are_left_as_they_are_however_late_the_recorder_is() {
    let mut clocks = Clocks::new();
    for step in 0..60 {
        let stamp_ns = START_NS + step * PERIOD_NS - 3_600_000_000_000;
        clocks.step(1, step, (stamp_ns, stamp_ns));
    }

    let read = clocks.foreign.read().unwrap();

    assert_eq!((read.findings.len(), read.start_ns), (0, START_NS - 3_600_000_000_000));
    assert!(worst_command(&read) < 1e-9);
}

#[test]
fn robots_whose_own_clocks_differ_are_put_side_by_side() {
    let mut clocks = Clocks::new();
    for step in 0..60 {
        let now_ns = START_NS + step * PERIOD_NS;
        clocks.step(1, step, (now_ns, now_ns));
        clocks.step(2, step, (now_ns + 3_000_000_000, now_ns + 3_000_000_000));
    }

    let read = clocks.foreign.read().unwrap();

    assert_eq!(read.trajectory.n_samples(), 60);
    for sample in 0..60 {
        let poses = read.trajectory.poses_at(sample);
        assert_eq!(poses[0].x_m.to_bits(), poses[1].x_m.to_bits());
    }
    assert!(matches!(read.findings[..], [Finding::Clocks { .. }]), "{:?}", read.findings);
}

#[test]
fn commands_whose_clock_was_set_in_the_middle_are_taken_by_log_time() {
    let mut clocks = Clocks::new();
    for step in 0..60 {
        let now_ns = START_NS + step * PERIOD_NS;
        let ahead_ns = if step < 30 { 0 } else { 60_000_000_000 };
        clocks.step(1, step, (now_ns, now_ns + ahead_ns));
    }

    let read = clocks.foreign.read().unwrap();

    assert!(worst_command(&read) < 1e-9, "{} m/s off", worst_command(&read));
}
