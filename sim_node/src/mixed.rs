//! Real robots among virtual ones: where they are, and what they would see of the virtual ones.

use std::collections::VecDeque;
use std::time::{Duration, Instant};

use rsrs_core::conditions::Conditions;
use rsrs_core::robot::pose_source::PoseSource;
use rsrs_core::robot::unicycle::Pose;
use rsrs_msgs::geometry_msgs::{self, PoseStamped};
use rsrs_msgs::nav_msgs::Odometry;
use rsrs_msgs::std_msgs::{Bool, Header};
use rsrs_msgs::topics;
use rsrs_ros::logging::Level;
use rsrs_ros::session::{NodeHandle, Publisher, Session, Subscription};
use rsrs_sim::field_of_view::FieldOfView;
use tokio::sync::mpsc::UnboundedSender;

use crate::subscriptions::Input;

/// A real robot of which nothing is received for so long may be anywhere.
const SILENCE: Duration = Duration::from_secs(1);

/// Where a robot stands until it is first reported: out of everybody's sight, in metres.
const NOWHERE_M: f64 = 1e6;

/// A real robot, as the world follows it.
#[derive(Clone, Debug)]
pub struct Followed {
    /// Its row in the world.
    pub row: usize,
    /// Upon each of our robots, whose bodies may differ; shape `[n_ours]`.
    views: Vec<FieldOfView>,
    latency_steps: usize,
    /// Where it was last.
    received: Option<Pose>,
    /// When that was received; at first, when it was begun to listen.
    at: Instant,
    is_missed: bool,
    /// Whether it saw one of ours, with the step; the newest last.
    seen: VecDeque<(u64, bool)>,
}

impl Followed {
    /// A robot of which nothing has been received yet, beside our robots in these rows.
    pub fn new(row: usize, conditions: &Conditions, ours: &[usize]) -> Self {
        let robot = conditions.robot_at(row);
        let latency_steps =
            usize::try_from(robot.latency_steps).expect("32 bits fit the address space");
        let upon = |other: &usize| FieldOfView::upon(robot, conditions.robot_at(*other).radius_m);
        Self {
            row,
            views: ours.iter().map(upon).collect(),
            latency_steps,
            received: None,
            at: Instant::now(),
            is_missed: false,
            seen: VecDeque::new(),
        }
    }

    /// Takes its pose.
    pub fn receive(&mut self, pose: Pose) {
        (self.received, self.at, self.is_missed) = (Some(pose), Instant::now(), false);
    }

    /// Whether it has just fallen silent: once for each silence.
    pub fn falls_silent(&mut self) -> bool {
        let is_news = !self.is_missed && self.at.elapsed() >= SILENCE;
        self.is_missed |= is_news;
        is_news
    }

    /// Where it is, as far as is known.
    pub fn pose(&self) -> Pose {
        let nowhere =
            Pose { x_m: NOWHERE_M, y_m: NOWHERE_M + 1e3 * self.row as f64, heading_rad: 0.0 };
        self.received.unwrap_or(nowhere)
    }

    /// Whether its sensor would report one of our robots at a step of the world.
    ///
    /// What it reports of other real robots, and what it reports by mistake, comes from the real
    /// sensor; ours are missed as often as the conditions define: what the world's sensor reports
    /// for this row (`detection`) decides whether what is seen is also detected.
    pub fn detects(&mut self, ours: &[Pose], (step, detection): (u64, bool)) -> bool {
        let from = self.pose();
        let mut ours = ours.iter().zip(&self.views);
        let sees = ours.any(|(other, view)| sees(view, &from, other));
        self.seen.retain(|(at, _)| *at < step);
        self.seen.push_back((step, sees));
        while self.seen.len() > self.latency_steps + 1 {
            self.seen.pop_front();
        }
        let is_delivered = self.seen.len() == self.latency_steps + 1 && self.seen[0].1;
        is_delivered && detection
    }
}

/// Whether one robot has another in view.
#[expect(clippy::cast_possible_truncation, reason = "the world's sensors are single precision")]
fn sees(view: &FieldOfView, from: &Pose, to: &Pose) -> bool {
    let (dx_m, dy_m) = (to.x_m - from.x_m, to.y_m - from.y_m);
    let seen = to.relative_to(*from);
    view.sees(seen.x_m as f32, seen.y_m as f32, (dx_m * dx_m + dy_m * dy_m) as f32)
}

/// The topics of the real robots of a world, until it is dropped.
#[derive(Default)]
pub struct RealRobots {
    detections: Vec<Publisher<Bool>>,
    poses: Vec<Subscription>,
}

impl RealRobots {
    /// Receives the poses of real robots, from their own odometry in the frame of the world or from a
    /// tracker, and publishes to their controllers.
    pub fn follow(
        session: &Session,
        node: &NodeHandle,
        names: &[String],
        by: PoseSource,
        received: &UnboundedSender<Input>,
    ) -> anyhow::Result<Self> {
        let mut all = Self::default();
        for (index, name) in names.iter().enumerate() {
            let topic = topics::VIRTUAL_DETECTION;
            all.detections.push(session.publish_on(node, &topic.for_robot(name), topic.qos)?);
            let (received, speaker) = (received.clone(), node.clone());
            let name_of = name.clone();
            // The receiver is gone only while the node shuts down.
            let receive = move |header: Header, pose: &geometry_msgs::Pose| match on_the_floor(pose)
            {
                Some(pose) => drop(received.send(Input::Pose { robot: index, header, pose })),
                None => speaker.log(Level::Warn, &format!("{name_of}: a pose is no pose")),
            };
            // The parameter allows these two.
            all.poses.push(if by == PoseSource::Odom {
                let (name, qos) = (topics::ODOM.for_robot(name), topics::ODOM.qos);
                session.subscribe(node, &name, qos, move |sample| {
                    let odometry: Odometry = sample.message;
                    receive(odometry.header, &odometry.pose.pose);
                })?
            } else {
                let (name, qos) = (topics::POSE.for_robot(name), topics::POSE.qos);
                session.subscribe(node, &name, qos, move |sample| {
                    let tracked: PoseStamped = sample.message;
                    receive(tracked.header, &tracked.pose);
                })?
            });
        }
        Ok(all)
    }

    /// Publishes to the controllers of the real robots what they would see.
    pub async fn publish(&self, detections: &[bool]) -> anyhow::Result<()> {
        for (publisher, data) in self.detections.iter().zip(detections) {
            publisher.publish(Bool { data: *data }).await?;
        }
        Ok(())
    }
}

/// A pose on the floor; `None` if it is not finite, has no orientation, or is so far away that it is
/// none.
pub fn on_the_floor(pose: &geometry_msgs::Pose) -> Option<Pose> {
    let position = pose.position;
    let heading_rad = pose.orientation.heading_rad().ok()?;
    let is_near = position.x.abs() < NOWHERE_M && position.y.abs() < NOWHERE_M;
    is_near.then_some(Pose { x_m: position.x, y_m: position.y, heading_rad })
}

#[cfg(test)]
mod tests {
    use rsrs_testing::conditions::measured_flockbots;

    use super::*;
    use crate::robots::pose_message;

    fn followed(latency_steps: u32) -> Followed {
        let mut conditions = measured_flockbots(4);
        conditions.robot.latency_steps = latency_steps;
        Followed::new(1, &conditions, &[0])
    }

    fn at(x_m: f64, y_m: f64, heading_rad: f64) -> Pose {
        Pose { x_m, y_m, heading_rad }
    }

    #[test]
    fn a_real_robot_sees_a_virtual_one_in_its_cone_and_none_beside_it() {
        let mut robot = followed(0);
        let ours = [at(3.0, 2.5, 0.0)];
        assert!(!robot.detects(&ours, (1, true)), "its pose was never received");

        // Looking north at the one half a metre away; then east.
        robot.receive(at(3.0, 2.0, std::f64::consts::FRAC_PI_2));
        assert!(robot.detects(&ours, (2, true)));
        assert!(!robot.detects(&ours, (2, false)), "the draw misses it");
        robot.receive(at(3.0, 2.0, 0.0));
        assert!(!robot.detects(&ours, (3, true)));
    }

    #[test]
    fn what_is_seen_is_delivered_as_late_as_the_conditions_state() {
        let mut robot = followed(2);
        robot.receive(at(0.0, 0.0, 0.0));
        let (ahead, behind) = ([at(0.5, 0.0, 0.0)], [at(-0.5, 0.0, 0.0)]);

        let delivered: Vec<bool> = [&ahead, &behind, &behind, &behind]
            .into_iter()
            .enumerate()
            // Sensing twice in a step is sensing once.
            .flat_map(|(step, ours)| [(step as u64, ours); 2])
            .map(|(step, ours)| robot.detects(ours, (step, true)))
            .collect();

        assert_eq!(delivered, [false, false, false, false, true, true, false, false]);
    }

    #[test]
    fn a_pose_that_is_none_is_not_followed() {
        let good = at(0.3, -0.4, 2.0);
        let there = on_the_floor(&pose_message(good)).expect("it is a pose");
        assert!(
            (there.heading_rad - 2.0).abs() < 1e-12 && there.x_m.to_bits() == good.x_m.to_bits()
        );

        for spoil in [
            |pose: &mut geometry_msgs::Pose| pose.position.x = f64::NAN,
            |pose: &mut geometry_msgs::Pose| pose.position.y = f64::INFINITY,
            |pose: &mut geometry_msgs::Pose| pose.orientation.w = f64::NAN,
            |pose: &mut geometry_msgs::Pose| pose.orientation.w = 3.0,
        ] {
            let mut pose = pose_message(good);
            spoil(&mut pose);
            assert_eq!(on_the_floor(&pose), None, "{pose:?}");
        }
    }
}
