//! Worlds that are placed, and robots that are in none.

use std::time::{Duration, Instant};

use rsrs_core::robot::pose_source::PoseSource;
use rsrs_core::robot::sensor::{ReadingNames, Readings};
use rsrs_core::world::WorldFile;
use rsrs_fleet::robot;
use rsrs_fleet::simulator::{Event, Gates};
use rsrs_msgs::topics;
use rsrs_ros::logging::Level;

use super::{Simulation, Step, step_response};
use crate::mixed::RealRobots;
use crate::parameters;
use crate::placed_world::PlacedWorld;
use crate::rows::Rows;
use crate::virtual_pose_publisher::VirtualPosePublisher;

/// How often a sensor without a world reports that it sees nothing.
const SENSES_NOTHING: Duration = Duration::from_millis(100);

impl Simulation<'_> {
    /// Places the world that the parameters ask for; a run that is under way ends with it.
    pub(crate) async fn place(&mut self) -> anyhow::Result<()> {
        self.placed_world = None;
        if let Some(Step { asked, responder }) = self.steps.take() {
            responder.send(step_response(asked, asked));
        }
        self.stamp_ns = None;
        (self.real, self.virtual_pose_publisher) = (RealRobots::default(), None);
        self.objects.clear();
        let taken = parameters::take_cell(&self.server, &self.profile);
        let wanted = taken
            .map_err(parameters::WorldError::from)
            .and_then(|()| parameters::wanted(&self.server, &self.hosted));
        let n_placed = match &wanted {
            Ok(Some(wanted)) => wanted.placed.robots.len(),
            Ok(None) | Err(_) => 0,
        };
        let now = self.start.elapsed();
        for (index, robot) in self.robots.iter_mut().enumerate() {
            robot.on_event(robot::Event::WithoutWorld(index >= n_placed), now).await?;
            robot.report(self.session, &ReadingNames::default())?;
        }
        match wanted {
            Ok(Some(wanted)) => {
                let placed = wanted.placed.clone();
                for robot in &mut self.robots[..placed.robots.len()] {
                    robot.join(placed.time, Duration::from_nanos(placed.period_ns));
                    robot.report(self.session, &wanted.conditions.robot.reading_names())?;
                }
                for object in 0..wanted.conditions.world.n_objects() {
                    let name = topics::object_pose(&WorldFile::object_name(object));
                    let qos = topics::OBJECT_POSE.qos;
                    self.objects.push(self.session.publish_on(&self.node, &name, qos)?);
                }
                self.subscriptions.follow_types(self.session, &self.robots, placed.time)?;
                self.follow(&wanted.rows, Duration::from_nanos(placed.period_ns))?;
                self.placed_world = Some(PlacedWorld::new(wanted));
                self.display.wipe();
                self.advance(Event::Placed(placed)).await
            }
            Ok(None) => {
                self.display.wipe();
                self.advance(Event::Removed).await
            }
            Err(error) => {
                self.display.wipe();
                self.node.log(Level::Error, &format!("no world is placed: {error}"));
                self.advance(Event::NotPlaced { reason: error.to_string() }).await
            }
        }
    }

    /// Follows the real robots of a world.
    fn follow(&mut self, rows: &Rows, period: Duration) -> anyhow::Result<()> {
        let names: Vec<String> = rows.tracked.iter().map(|row| rows.names[*row].clone()).collect();
        if !names.is_empty() {
            let by = parameters::tracked_by(&self.server)?;
            self.real = RealRobots::follow(self.session, &self.node, &names, by, &self.to_me)?;
            if by == PoseSource::Pose {
                let virtual_robots = &self.hosted[..rows.ours.len()];
                self.virtual_pose_publisher = Some(VirtualPosePublisher::new(
                    self.session,
                    &self.node,
                    virtual_robots,
                    period,
                )?);
            }
            let text = format!("mixed fleet: {} are real and followed", names.join(", "));
            self.node.log(Level::Info, &text);
        }
        Ok(())
    }

    /// The sensors of robot nodes work, and see nothing, where there is no world yet.
    pub(super) async fn sense_nothing(&mut self) -> anyhow::Result<()> {
        let is_due = self.sensed_nothing.elapsed() >= SENSES_NOTHING;
        if parameters::gates(&self.server) == Gates::Here || !is_due {
            return Ok(());
        }
        self.sensed_nothing = Instant::now();
        for robot in &self.robots[self.placed_robots().len()..] {
            robot.publish_readings(Readings::default()).await?;
        }
        Ok(())
    }
}
