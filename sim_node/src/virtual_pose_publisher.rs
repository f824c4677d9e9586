//! Poses of virtual robots, which no tracker sees: published together with the tracker's.
//!
//! So the poses of a mixed fleet have one source, one frame, one clock and one rate, as a judge of
//! the whole swarm needs them.

use std::collections::BTreeSet;
use std::time::{Duration, Instant};

use rsrs_core::robot::unicycle::Pose;
use rsrs_msgs::geometry_msgs::PoseStamped;
use rsrs_msgs::std_msgs::Header;
use rsrs_msgs::topics;
use rsrs_ros::clock::wall_time;
use rsrs_ros::session::{NodeHandle, Publisher, Session};

use crate::robots::pose_message;

/// Publishes the poses of virtual robots together with the tracker's.
pub struct VirtualPosePublisher {
    publishers: Vec<Publisher<PoseStamped>>,
    interpolator: PoseInterpolator,
    rounds: Rounds,
}

impl VirtualPosePublisher {
    /// Publishes for the virtual robots of a world with this control period.
    pub fn new(
        session: &Session,
        node: &NodeHandle,
        virtual_robots: &[String],
        period: Duration,
    ) -> anyhow::Result<Self> {
        let topic = topics::POSE;
        let publishers = virtual_robots
            .iter()
            .map(|name| session.publish_on(node, &topic.for_robot(name), topic.qos))
            .collect::<Result<_, _>>()?;
        let interpolator = PoseInterpolator::new(period);
        Ok(Self { publishers, interpolator, rounds: Rounds::default() })
    }

    /// Takes the poses of the virtual robots after a step of their world.
    pub fn step(&mut self, poses: impl Iterator<Item = Pose>) {
        self.interpolator.step(poses.collect(), Instant::now());
    }

    /// Publishes the virtual robots' poses when a round of the tracker begins. The message is on a real
    /// `robot`, by its index; its `header` tells when that was seen, and in which frame.
    pub async fn follow(&mut self, robot: usize, header: &Header) -> anyhow::Result<()> {
        let stamp = match header.stamp.to_nanos() {
            None | Some(0) => wall_time(),
            Some(_) => header.stamp,
        };
        let now = Instant::now();
        if !self.rounds.begins(robot, stamp.to_nanos().unwrap_or(0), now) {
            return Ok(());
        }
        for (publisher, pose) in self.publishers.iter().zip(self.interpolator.at(now)) {
            let header = Header { stamp, frame_id: header.frame_id.clone() };
            publisher.publish(PoseStamped { header, pose: pose_message(pose) }).await?;
        }
        Ok(())
    }
}

/// Rounds of a tracker, in each of which it publishes where every real robot is.
#[derive(Default)]
struct Rounds {
    /// Robots that were published since the last round began.
    published: BTreeSet<usize>,
    /// The stamp with which it began, in nanoseconds, and when.
    last: Option<(u64, Instant)>,
}

impl Rounds {
    /// If no round begins for so long, the tracker's clock was set back.
    const SET_BACK: Duration = Duration::from_secs(2);

    /// Whether a message on a robot begins a round: the first one of all, and each on a robot that was
    /// published in this round already. One that is not younger than the round is late and begins none, for
    /// with it the stamps of virtual robots would go back.
    fn begins(&mut self, robot: usize, stamp_ns: u64, now: Instant) -> bool {
        let begins = self.last.is_none_or(|(last_ns, at)| {
            let is_recent = now.saturating_duration_since(at) < Self::SET_BACK;
            self.published.contains(&robot) && (stamp_ns > last_ns || !is_recent)
        });
        if begins {
            self.published.clear();
            self.last = Some((stamp_ns, now));
        }
        self.published.insert(robot);
        begins
    }
}

/// Interpolates poses between the last two steps of a world, one period behind it.
struct PoseInterpolator {
    period: Duration,
    before: Vec<Pose>,
    now: Vec<Pose>,
    since: Option<Instant>,
}

impl PoseInterpolator {
    fn new(period: Duration) -> Self {
        Self { period, before: Vec::new(), now: Vec::new(), since: None }
    }

    fn step(&mut self, poses: Vec<Pose>, at: Instant) {
        self.before = std::mem::replace(&mut self.now, poses);
        self.since = Some(at);
    }

    /// Where they are; nowhere before the first step.
    fn at(&self, time: Instant) -> Vec<Pose> {
        let Some(since) = self.since else { return Vec::new() };
        let share = time.saturating_duration_since(since).as_secs_f64() / self.period.as_secs_f64();
        let share = share.min(1.0);
        let between = |(from, to): (&Pose, &Pose)| {
            let turn_rad = to.heading_rad - from.heading_rad;
            let turn_rad = libm::remainder(turn_rad, std::f64::consts::TAU);
            Pose {
                x_m: from.x_m + share * (to.x_m - from.x_m),
                y_m: from.y_m + share * (to.y_m - from.y_m),
                heading_rad: from.heading_rad + share * turn_rad,
            }
        };
        // After the first step there is nowhere to come from.
        if self.before.len() == self.now.len() {
            self.before.iter().zip(&self.now).map(between).collect()
        } else {
            self.now.clone()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(x_m: f64, heading_rad: f64) -> Vec<Pose> {
        vec![Pose { x_m, y_m: 1.0, heading_rad }]
    }

    #[test]
    fn a_round_begins_with_a_robot_that_was_published_already_and_not_with_a_late_message() {
        let (mut rounds, start) = (Rounds::default(), Instant::now());
        // Which robot, its stamp and when it comes in milliseconds, and whether a round begins.
        for (robot, stamp_ms, at_ms, begins) in [
            (0, 10_000, 0, true),
            (1, 10_000, 0, false),
            (0, 10_050, 50, true),
            (0, 10_100, 100, true),
            // The other one's messages were held up, however long.
            (1, 7_000, 120, false),
            (1, 10_050, 121, false),
            (1, 10_100, 122, false),
            (1, 10_150, 150, true),
            (0, 10_150, 150, false),
            (0, 10_150, 151, false),
            (0, 10_200, 200, true),
            // The clock is set back by eight seconds.
            (0, 2_250, 250, false),
            (0, 4_150, 2_150, false),
            (0, 4_200, 2_200, true),
            (1, 4_200, 2_200, false),
            (0, 4_250, 2_250, true),
        ] {
            let (stamp_ns, at) = (1_000_000 * stamp_ms, start + Duration::from_millis(at_ms));
            assert_eq!(rounds.begins(robot, stamp_ns, at), begins, "{robot} {stamp_ms} {at_ms}");
        }
    }

    #[test]
    fn robots_go_evenly_from_step_to_step_and_turn_the_short_way() {
        let period = Duration::from_millis(100);
        let start = Instant::now();
        let mut interpolator = PoseInterpolator::new(period);
        assert_eq!(interpolator.at(start), []);

        interpolator.step(at(0.0, 3.1), start);
        assert_eq!(interpolator.at(start + period / 2), at(0.0, 3.1));
        interpolator.step(at(0.2, -3.1), start + period);

        let half = interpolator.at(start + period + period / 2);
        assert!((half[0].x_m - 0.1).abs() < 1e-9, "{half:?}");
        assert!((half[0].heading_rad - std::f64::consts::PI).abs() < 1e-9, "{half:?}");
        let late = interpolator.at(start + 9 * period);
        assert!((late[0].x_m - 0.2).abs() < 1e-9, "a world that has stopped stands: {late:?}");
    }
}
