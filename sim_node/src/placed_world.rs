//! A placed world, and what is seen in it.

use std::sync::Arc;

use rsrs_core::conditions::Conditions;
use rsrs_core::robot::controller::Command;
use rsrs_core::robot::sensor::Readings;
use rsrs_core::robot::unicycle::Pose;
use rsrs_fleet::simulator::Placed;
use rsrs_msgs::builtin_interfaces::Time;
use rsrs_sim::controllers::Controllers;
use rsrs_sim::world::World;

use crate::display::{History, Look, Names, Scene};
use crate::mixed::Followed;
use crate::parameters::Wanted;
use crate::robots::Motion;
use crate::rows::Rows;

/// A placed world.
pub struct PlacedWorld {
    /// The world.
    pub world: World,
    /// What its pace needs.
    pub placed: Placed,
    /// The paper's `E`.
    pub conditions: Conditions,
    /// Whose rows they are.
    pub rows: Rows,
    /// The real robots among them.
    pub followed: Vec<Followed>,
    /// What its judge looks back on.
    pub history: History,
    /// What each robot of ours does; shape `[n_ours]`.
    obeyed: Vec<Command>,
    controllers: Controllers,
    names: Names,
    is_ours: Arc<[bool]>,
    look: Arc<Look>,
}

/// What is sensed in one step.
pub struct Sensed {
    /// Digest of the world's state.
    pub digest: u64,
    /// What each of our robots reports, and where it is; shape `[n_ours]`.
    pub ours: Vec<(Readings, Motion)>,
    /// What each real robot would see of ours; shape `[n_followed]`.
    pub virtual_detections: Vec<bool>,
    /// Where objects are, in metres; shape `[n_objects][2]`.
    pub objects_m: Vec<[f64; 2]>,
}

impl PlacedWorld {
    /// A world whose robots stand at their start poses.
    pub fn new(wanted: Wanted) -> Self {
        let Wanted { world, controllers, placed, conditions, rows } = wanted;
        let is_ours: Vec<bool> =
            (0..conditions.robots).map(|row| rows.ours.contains(&row)).collect();
        let followed = rows.tracked.iter().map(|row| Followed::new(*row, &conditions, &rows.ours));
        let mut placed_world = Self {
            followed: followed.collect(),
            history: History::new(&conditions),
            obeyed: vec![Command::STOP; placed.robots.len()],
            names: rows.names.clone().into(),
            is_ours: is_ours.into(),
            look: Arc::new(Look::new(&conditions)),
            world,
            controllers,
            placed,
            conditions,
            rows,
        };
        placed_world.follow();
        placed_world
    }

    /// Senses for all robots, the real ones where they were reported last.
    pub fn sense(&mut self) -> Sensed {
        self.follow();
        let step = self.world.step_index();
        let digest = self.world.digest();
        let readings = self.world.sense_all().to_vec();
        let poses: Vec<Pose> = self.world.poses().collect();
        let motions = self.rows.ours.iter().zip(&self.obeyed).map(|(row, command)| {
            (readings[*row], Motion { pose: poses[*row], command: *command })
        });
        let ours = motions.collect();
        let of_ours: Vec<Pose> = self.rows.ours.iter().map(|row| poses[*row]).collect();
        let followed = self.followed.iter_mut();
        let detects =
            |robot: &mut Followed| robot.detects(&of_ours, (step, readings[robot.row].detection()));
        let virtual_detections = followed.map(detects).collect();
        let objects_m = self.world.objects_m().collect();
        Sensed { digest, ours, virtual_detections, objects_m }
    }

    /// Moves our robots by one period, each by its command, in their order.
    pub fn advance(&mut self, commands: Vec<Command>) {
        let mut all = vec![Command::STOP; self.conditions.robots];
        for (row, command) in self.rows.ours.iter().zip(&commands) {
            all[*row] = *command;
        }
        self.history.step(&self.world, &all);
        self.world.advance(&all);
        self.obeyed = commands;
    }

    /// Moves our robots as the conditions' controller would, without commands.
    pub fn advance_freely(&mut self) {
        self.follow();
        let mut all = Vec::with_capacity(self.conditions.robots);
        self.controllers.decide(self.world.sense_all(), &mut all);
        self.advance(self.rows.ours.iter().map(|row| all[*row]).collect());
    }

    /// Our robots stand.
    pub fn stand(&mut self) {
        self.obeyed.fill(Command::STOP);
    }

    /// What each of our robots does; shape `[n_ours]`.
    pub fn obeyed(&self) -> &[Command] {
        &self.obeyed
    }

    /// What viewers see, with the judge's verdict on the run as text.
    pub fn scene(&mut self, stamp: Time, text: &str) -> Scene {
        let time_s = self.world.step_index() as f64 * self.conditions.period_s;
        let n_robots = self.conditions.robots;
        Scene {
            stamp,
            names: Arc::clone(&self.names),
            is_ours: Arc::clone(&self.is_ours),
            poses: self.world.poses().collect(),
            objects_m: self.world.objects_m().collect(),
            readings: self.world.sense_all().to_vec(),
            look: Arc::clone(&self.look),
            text: format!("{n_robots} robots, {time_s:.1} s\n{text}"),
        }
    }

    fn follow(&mut self) {
        for robot in &self.followed {
            self.world.displace(robot.row, robot.pose());
        }
    }
}
