//! Where robots start, for people who put them there.

use rsrs_core::conditions::{Conditions, Placement};
use rsrs_core::robot::unicycle::Pose;
use rsrs_core::world::WorldFile;
use rsrs_experiment_runner::plan::Plan;
use rsrs_fleet::placement::WantedStart;
use rsrs_pipeline::error::helped;
use rsrs_sim::draw::{RunKey, Seed};
use rsrs_sim::placement;
use rsrs_sim::world::World;

use crate::run::place_command::{PlacedRobot, WantedPlacement};
use rsrs_render::start_poses::{StartPlace, StartPose, StartPoses};

/// Where the robots of a plan start.
pub fn start_poses(plan: &Plan) -> anyhow::Result<StartPoses> {
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
    let placement = &record.conditions.placement;
    Ok(StartPoses {
        seed: record.seed,
        disc_radius_m: placement.radius_m(),
        placement: match placement {
            Placement::BoxFacingOut(_) => "box_facing_out",
            Placement::BoxFacingAnyWay(_) => "box_facing_any_way",
            Placement::Given { .. } => "file",
            _ => "disc_facing_out",
        },
        area: placement.clone(),
        clearance_m: WantedStart::new(&record.conditions, record.replicate).clearance_m,
        body_radius_m: record.conditions.largest_radius_m(),
        robots: robots.collect(),
        objects: objects(&record.conditions, seed)?,
        world: record.conditions.world.clone(),
        walls_m: record.conditions.arena.walls_m(),
    })
}

/// The same for a program that places the robots for a purpose.
pub fn wanted(starts: &StartPoses, purpose: String) -> WantedPlacement {
    let robots = starts.robots.iter().map(|start| PlacedRobot {
        name: start.robot.clone(),
        x_m: start.x_m,
        y_m: start.y_m,
        heading_rad: start.heading_rad,
    });
    WantedPlacement { purpose, robots: robots.collect() }
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
