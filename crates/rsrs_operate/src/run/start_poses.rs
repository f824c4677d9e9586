//! Where robots start, for people who put them there.

use std::fmt;

use rsrs_core::conditions::{Conditions, Placement};
use rsrs_core::robot::unicycle::Pose;
use rsrs_core::world::WorldFile;
use rsrs_experiment_runner::plan::Plan;
use rsrs_fleet::placement::WantedStart;
use rsrs_pipeline::error::helped;
use rsrs_sim::draw::{RunKey, Seed};
use rsrs_sim::placement;
use rsrs_sim::world::World;
use rsrs_view::placement::Area;
use serde::Serialize;

use crate::run::place_command::{PlacedRobot, WantedPlacement};

/// Start poses.
#[derive(Debug, Serialize)]
pub struct StartPoses {
    /// Of the poses.
    pub seed: u64,
    /// Radius of the disc around the origin that holds the robots' centres, in metres.
    pub disc_radius_m: f64,
    /// Where they start: `disc_facing_out`, `box_facing_out`, `box_facing_any_way` or `file`.
    pub placement: &'static str,
    /// Where the centres lie, in words.
    #[serde(skip)]
    pub area: String,
    /// Where the centres lie, on the picture.
    #[serde(skip)]
    pub drawn_area: Area,
    /// Least distance between two centres, in metres.
    pub clearance_m: f64,
    /// Radius of a robot's body, in metres.
    pub body_radius_m: f64,
    /// In the order of the fleet file.
    pub robots: Vec<StartPose>,
    /// What robots push, of a world that has some.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub objects: Vec<StartPlace>,
    /// What is there besides robots.
    #[serde(skip)]
    pub world: WorldFile,
    /// Distance of the walls of a square from the centre, in metres, where there are walls.
    #[serde(skip)]
    pub walls_m: Option<f64>,
}

/// Where an object is at the start, from the centre.
#[derive(Debug, Serialize)]
pub struct StartPlace {
    /// Its name, as in its topic.
    pub object: String,
    /// In metres.
    pub x_m: f64,
    /// In metres.
    pub y_m: f64,
}

/// Where one robot starts, from the centre of the disc.
#[derive(Debug, Serialize)]
pub struct StartPose {
    /// Its name.
    pub robot: String,
    /// In metres.
    pub x_m: f64,
    /// In metres.
    pub y_m: f64,
    /// In (-π, π].
    pub heading_rad: f64,
    /// In (-180, 180].
    pub heading_deg: f64,
}

impl StartPoses {
    /// Where the robots of a plan start.
    pub fn new(plan: &Plan) -> anyhow::Result<Self> {
        let record = &plan.record;
        let seed = Seed { seed: record.seed, replicate: record.replicate };
        let poses = poses(&record.conditions, seed)?;
        let robots = record.robots.iter().zip(poses).map(|(robot, pose)| StartPose {
            robot: robot.clone(),
            x_m: pose.x_m,
            y_m: pose.y_m,
            heading_rad: wrapped(pose.heading_rad),
            heading_deg: wrapped(pose.heading_rad).to_degrees(),
        });
        let reach_m = record.conditions.placement.radius_m();
        let (placement, area, drawn_area) = match &record.conditions.placement {
            Placement::BoxFacingOut(sides) => (
                "box_facing_out",
                format!("in a box of {} m by {} m, facing out", sides.width_m, sides.height_m),
                Area::Box(*sides),
            ),
            Placement::BoxFacingAnyWay(sides) => (
                "box_facing_any_way",
                format!("in a box of {} m by {} m, heading any way", sides.width_m, sides.height_m),
                Area::Box(*sides),
            ),
            Placement::Given { .. } => {
                ("file", "where the table puts them".to_owned(), Area::Table { reach_m })
            }
            _ => (
                "disc_facing_out",
                format!("in a disc of radius {reach_m} m, facing out"),
                Area::Disc { radius_m: reach_m },
            ),
        };
        Ok(Self {
            placement,
            area,
            drawn_area,
            seed: record.seed,
            disc_radius_m: reach_m,
            clearance_m: WantedStart::new(&record.conditions, record.replicate).clearance_m,
            body_radius_m: record.conditions.largest_radius_m(),
            robots: robots.collect(),
            objects: objects(&record.conditions, seed)?,
            world: record.conditions.world.clone(),
            walls_m: record.conditions.arena.walls_m(),
        })
    }

    /// The same for a program that places the robots for a purpose.
    pub fn wanted(&self, purpose: String) -> WantedPlacement {
        let robots = self.robots.iter().map(|start| PlacedRobot {
            name: start.robot.clone(),
            x_m: start.x_m,
            y_m: start.y_m,
            heading_rad: start.heading_rad,
        });
        WantedPlacement { purpose, robots: robots.collect() }
    }
}

impl fmt::Display for StartPoses {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let width = self.robots.iter().map(|pose| pose.robot.len()).max().unwrap_or(0).max(5);
        write!(
            out,
            "{} robots {}, centres at least {:.3} m apart, seed {}\n\
             x and y from the centre; heading counterclockwise from x\n\n\
             {:width$}   x (m)   y (m)  heading (°)  heading (rad)",
            self.robots.len(),
            self.area,
            self.clearance_m,
            self.seed,
            "robot",
        )?;
        for StartPose { robot, x_m, y_m, heading_rad, heading_deg } in &self.robots {
            write!(
                out,
                "\n{robot:width$}  {x_m:>6.3}  {y_m:>6.3}  {heading_deg:>11.0}  {heading_rad:>13.3}"
            )?;
        }
        let width = self.objects.iter().map(|it| it.object.len()).max().unwrap_or(0);
        if width > 0 {
            write!(out, "\n\n{:width$}   x (m)   y (m)", "object")?;
        }
        for StartPlace { object, x_m, y_m } in &self.objects {
            write!(out, "\n{object:width$}  {x_m:>6.3}  {y_m:>6.3}")?;
        }
        Ok(())
    }
}

/// Where objects are in a replicate of these conditions.
fn objects(conditions: &Conditions, seed: Seed) -> anyhow::Result<Vec<StartPlace>> {
    if conditions.world.n_objects() == 0 {
        return Ok(Vec::new());
    }
    let world = World::new(conditions, seed).map_err(helped)?;
    let place = |(index, [x_m, y_m]): (usize, [f64; 2])| StartPlace {
        object: WorldFile::object_name(index),
        x_m,
        y_m,
    };
    Ok(world.objects_m().enumerate().map(place).collect())
}

/// Where the simulator starts a replicate of these conditions.
fn poses(conditions: &Conditions, seed: Seed) -> anyhow::Result<Vec<Pose>> {
    let run = RunKey::new(seed, conditions.digest());
    placement::place(conditions, run).map_err(helped)
}

/// An angle in (-π, π].
fn wrapped(angle_rad: f64) -> f64 {
    let turns = (angle_rad / std::f64::consts::TAU).round();
    let wrapped = angle_rad - turns * std::f64::consts::TAU;
    if wrapped <= -std::f64::consts::PI { std::f64::consts::PI } else { wrapped }
}

#[cfg(test)]
mod tests {
    use rsrs_core::conditions::Settings;
    use rsrs_core::quantity::Cell;
    use rsrs_fleet::placement::deviations;

    use super::*;

    fn flockbots() -> Conditions {
        let profile = rsrs_testing::conditions::flockbot();
        let cell: Cell = "speed_m_s=0.15,turn_rate_rad_s=0.75,robots=9".parse().unwrap();
        let mut settings = Settings::default().with_cell(&cell);
        settings.values.push((rsrs_core::quantity::Axis::PlacementRadius, 0.825));
        Conditions::resolve(&profile, &settings).unwrap()
    }

    #[test]
    fn what_the_runner_checks_is_what_the_simulator_places() {
        let conditions = flockbots();
        let wanted = WantedStart::new(&conditions, 0);

        for seed in 0..200 {
            let poses = poses(&conditions, Seed { seed, replicate: 0 }).unwrap();
            let named: Vec<_> = poses
                .into_iter()
                .enumerate()
                .map(|(robot, pose)| (robot, robot.to_string(), pose))
                .collect();

            assert_eq!(deviations(&wanted, &named), [], "seed {seed}");
        }
    }

    #[test]
    fn angles_are_given_between_minus_and_plus_a_half_turn() {
        use std::f64::consts::PI;

        for (angle_rad, expected_rad) in
            [(0.0, 0.0), (1.5 * PI, -0.5 * PI), (-PI, PI), (PI, PI), (2.0 * PI, 0.0)]
        {
            assert!((wrapped(angle_rad) - expected_rad).abs() < 1e-12, "{angle_rad}");
        }
    }
}
