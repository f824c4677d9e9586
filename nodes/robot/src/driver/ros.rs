//! Somebody else's base driver: any node that takes velocity commands, and any that measures
//! distances or detects.
//!
//! Readings come as `sensor_msgs/Range`, `sensor_msgs/LaserScan` or `std_msgs/Bool`; gated commands go out on
//! `hardware/cmd_vel`. The base driver must have a timeout of its own: if this process dies, nobody
//! else stops its wheels.

use std::time::Duration;

use anyhow::{Context, Result, bail};
use rsrs_core::robot::controller::Command;
use rsrs_fleet::fleet_file::CmdVel;
use rsrs_msgs::sensor_msgs::{LaserScan, Range};
use rsrs_msgs::{RosMessage, std_msgs, topics};
use rsrs_ros::clock::wall_time;
use rsrs_ros::cmd_vel::CmdVelPublisher;
use rsrs_ros::parameters::{Descriptor, ParameterValue};
use rsrs_ros::session::{Received, Subscription};
use tokio::sync::mpsc::{UnboundedReceiver, unbounded_channel};

use super::{Driver, DriverContext, Report, Sensed, next_of};
use crate::declared::{choice, cmd_vel, cmd_vel_type, number};
use rsrs_fleet::parameters::gate::{
    ROS_CMD_VEL_TYPE as CMD_VEL_TYPE, ROS_SENSOR_TOPIC as SENSOR_TOPIC,
    ROS_SENSOR_TYPE as SENSOR_TYPE, SECTOR,
};

/// A command that a subscriber does not take within this time is late.
const LATE: Duration = Duration::from_millis(100);

/// The driver.
pub struct RosDriver {
    cmd_vel: CmdVelPublisher,
    reports: UnboundedReceiver<Report>,
    sensor_topic: String,
    subscription: Subscription,
}

impl RosDriver {
    /// Follows a sensor, on the topic that was given or, where that is empty, on the `usual` one; a
    /// `reading` is what a message says.
    pub(super) fn follow<M: RosMessage>(
        place: DriverContext<'_>,
        cmd_vel: CmdVel,
        (given, usual): (&str, topics::Topic),
        reading: impl Fn(M) -> Sensed + Send + 'static,
    ) -> Result<Self> {
        let (to_node, reports) = unbounded_channel();
        // A base or simulator that does not run is a sensor that is silent, which the node notices.
        drop(to_node.send(Report::Up));
        let sensor_topic = full_name(place.robot, given, &usual);
        let follow = move |sample: Received<M>| {
            // The receiver is gone only while the node shuts down.
            drop(to_node.send(Report::Sensed(reading(sample.message))));
        };
        let subscription = place.session.subscribe(place.node, &sensor_topic, usual.qos, follow)?;
        let DriverContext { session, node, robot, .. } = place;
        let cmd_vel = CmdVelPublisher::new(session, node, robot, cmd_vel.hardware_topic())?;
        Ok(Self { cmd_vel, reports, sensor_topic, subscription })
    }

    /// Messages that could be read so far.
    pub(super) fn n_readings(&self) -> u64 {
        self.subscription.counts().taken
    }
}

impl Driver for RosDriver {
    fn parameters() -> Vec<(Descriptor, ParameterValue)> {
        let sensor_type = "Type of the sensor's messages.";
        let sensor_topic =
            "Topic of the sensor; hardware/range, hardware/scan or hardware/detection if empty.";
        let topics = "absolute, or relative to the robot's namespace";
        vec![
            choice(SENSOR_TYPE, sensor_type, "range, laser_scan or bool", "range"),
            choice(SENSOR_TOPIC, sensor_topic, topics, ""),
            number(SECTOR),
            cmd_vel(CMD_VEL_TYPE, "Type of hardware/cmd_vel.", CmdVel::Twist),
        ]
    }

    fn open(place: DriverContext<'_>) -> Result<Self> {
        let value = |name| place.server.text(place.node.full_name(), name);
        let cmd_vel = cmd_vel_type(place.server, place.node.full_name(), CMD_VEL_TYPE)?;
        let given = value(SENSOR_TOPIC);
        match value(SENSOR_TYPE).as_str() {
            "range" => {
                let reading =
                    |message| Sensed { range: Some(usable(message)), ..Sensed::default() };
                Self::follow(place, cmd_vel, (&given, topics::HARDWARE_RANGE), reading)
            }
            "laser_scan" => {
                let half_angle_rad = place.server.double(place.node.full_name(), SECTOR.name);
                let reading = move |scan: LaserScan| Sensed {
                    range: Some(nearest(&scan, half_angle_rad)),
                    ..Sensed::default()
                };
                Self::follow(place, cmd_vel, (&given, topics::HARDWARE_SCAN), reading)
            }
            "bool" => {
                let topic = (given.as_str(), topics::HARDWARE_DETECTION);
                Self::follow(place, cmd_vel, topic, seen)
            }
            other => bail!("`{SENSOR_TYPE}` is `{other}`, expected range, laser_scan or bool"),
        }
        .with_context(|| format!("`{SENSOR_TOPIC}`"))
    }

    async fn report(&mut self) -> Report {
        next_of(&mut self.reports).await
    }

    async fn drive(&mut self, command: Command) -> Result<()> {
        match tokio::time::timeout(LATE, self.cmd_vel.publish(command, wall_time())).await {
            Ok(sent) => Ok(sent?),
            Err(_late) => bail!("no command was taken for {} ms", LATE.as_millis()),
        }
    }

    fn sensor(&self) -> String {
        self.sensor_topic.clone()
    }

    fn health(&self) -> Vec<(&'static str, String)> {
        let counts = self.subscription.counts();
        vec![
            ("sensor_topic", self.sensor_topic.clone()),
            ("readings", counts.taken.to_string()),
            ("undecodable", counts.undecodable.to_string()),
        ]
    }
}

/// The full name of a topic that was given, or of the usual one if none was.
fn full_name(robot: &str, given: &str, usual: &topics::Topic) -> String {
    match given {
        "" => usual.for_robot(robot),
        absolute if absolute.starts_with('/') => absolute.to_owned(),
        relative => format!("/{robot}/{relative}"),
    }
}

/// What a detection says.
pub(super) fn seen(detection: std_msgs::Bool) -> Sensed {
    Sensed { seen: Some(detection.data), ..Sensed::default() }
}

/// A reading outside its own limits is not to be used; beyond the farthest there is nothing.
fn usable(mut message: Range) -> Range {
    // Sensors that only distinguish near and far have equal limits and publish an infinity.
    if message.range.is_finite() {
        if message.range > message.max_range {
            message.range = f32::INFINITY;
        } else if message.range < message.min_range {
            message.range = f32::NAN;
        }
    }
    message
}

/// The nearest thing in the sector of a scan.
///
/// Rays that are not numbers or below the scanner's least distance met nothing, by the convention
/// of scanners in both ways. A scan without a ray in the sector is a failed measurement.
fn nearest(scan: &LaserScan, half_angle_rad: f64) -> Range {
    let mut range = f32::NAN;
    for (ray, distance) in scan.ranges.iter().enumerate() {
        let angle_rad = f64::from(scan.angle_min) + ray as f64 * f64::from(scan.angle_increment);
        if from_ahead_rad(angle_rad) > half_angle_rad {
            continue;
        }
        let is_met =
            *distance == f32::NEG_INFINITY || (scan.range_min..=scan.range_max).contains(distance);
        // The minimum of a number and what is not one is the number.
        range = range.min(if is_met { *distance } else { f32::INFINITY });
    }
    Range {
        header: scan.header.clone(),
        radiation_type: Range::INFRARED,
        #[expect(clippy::cast_possible_truncation, reason = "the message has 32 bits")]
        field_of_view: (2.0 * half_angle_rad) as f32,
        min_range: scan.range_min,
        max_range: scan.range_max,
        range,
        variance: 0.0,
    }
}

/// How far a direction is from straight ahead, 0 to π.
fn from_ahead_rad(angle_rad: f64) -> f64 {
    let turn = std::f64::consts::TAU;
    let wrapped = angle_rad.rem_euclid(turn);
    wrapped.min(turn - wrapped)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Eight rays, 45° apart, the first straight ahead.
    fn scan(ranges: [f32; 8]) -> LaserScan {
        LaserScan {
            angle_increment: std::f32::consts::FRAC_PI_4,
            range_min: 0.1,
            range_max: 4.0,
            ranges: ranges.to_vec(),
            ..LaserScan::default()
        }
    }

    #[test]
    fn the_sector_of_a_scan_reaches_over_its_seam() {
        let scan = scan([3.0, 2.0, 0.2, 0.2, 0.2, 0.2, 0.2, 1.0]);

        let ranges = [0.1, 0.8, 2.0].map(|half_angle_rad| nearest(&scan, half_angle_rad).range);
        assert_eq!(ranges.map(f32::to_bits), [3.0, 1.0, 0.2].map(f32::to_bits));
    }

    #[test]
    fn rays_that_met_nothing_are_far_away() {
        let scan = scan([0.0, f32::NAN, 9.0, f32::INFINITY, 9.0, 9.0, 9.0, 9.0]);

        assert!(nearest(&scan, 3.0).range.is_infinite());
    }

    #[test]
    fn a_scan_without_a_ray_in_the_sector_is_a_failed_measurement() {
        let mut scan = scan([1.0; 8]);
        scan.angle_min = 0.3;

        assert!(nearest(&scan, 0.1).range.is_nan());
    }

    #[test]
    fn readings_beyond_the_limits_of_a_sensor_are_not_used() {
        let reading = |range| {
            usable(Range { min_range: 0.1, max_range: 2.0, range, ..Range::default() }).range
        };

        let readings = [1.0, 2.5, f32::NEG_INFINITY].map(reading);
        let expected = [1.0, f32::INFINITY, f32::NEG_INFINITY];
        assert_eq!(readings.map(f32::to_bits), expected.map(f32::to_bits));
        assert!(reading(0.05).is_nan());
    }
}
