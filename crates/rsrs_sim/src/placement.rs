//! Where the robots start.

use rsrs_core::conditions::{Conditions, Placement};
use rsrs_core::unicycle::Pose;

use crate::contact::Border;
use crate::draw::{Purpose, RunKey};

/// Robots that do not find room where they are to start.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error(
    "{robots} robots do not fit into a disc of radius {radius_m:.3} m, {spacing_m:.3} m apart and \
     within the walls: {placed} found a place, and no more than {at_most} ever do"
)]
pub struct PlacementError {
    /// Robots asked for.
    pub robots: usize,
    /// Radius of the disc of their centres, in metres.
    pub radius_m: f64,
    /// Least distance between two centres, in metres.
    pub spacing_m: f64,
    /// Robots that found a place before the tries ran out.
    pub placed: usize,
    /// An upper bound on how many fit, by the density of the closest packing.
    pub at_most: usize,
}

impl PlacementError {
    /// What to do next.
    pub fn help(&self) -> String {
        "widen `placement_radius_m` (and `arena_m`), or take fewer `robots`".to_owned()
    }
}

/// Least distance between two centres at the start, in robot radii: a tenth more than touching.
const SPACING_RADII: f64 = 2.2;

/// Places tried for one robot before giving up.
const MAX_TRIES: usize = 20_000;

/// Places every robot, each from its own stream of draws.
///
/// # Returns
///
/// One pose for each robot; shape `[robots]`.
///
/// # Errors
///
/// [`PlacementError`] if they do not fit.
pub fn place(conditions: &Conditions, run: RunKey) -> Result<Vec<Pose>, PlacementError> {
    let Placement::DiscFacingOut { radius_m } = conditions.placement;
    let spacing_m = SPACING_RADII * conditions.robot.radius_m;
    let at_most = most_that_fit(radius_m, spacing_m);
    let refuse =
        |placed| PlacementError { robots: conditions.robots, radius_m, spacing_m, placed, at_most };
    if conditions.robots > at_most {
        return Err(refuse(0));
    }
    let border = Border::new(&conditions.arena, conditions.robot.radius_m);
    let mut poses: Vec<Pose> = Vec::with_capacity(conditions.robots);
    for robot in 0..conditions.robots {
        let mut stream = run.stream(robot, Purpose::Placement);
        let place = (0..MAX_TRIES)
            .map(|_| facing_out(radius_m, stream.uniform(), stream.uniform()))
            .find(|pose| {
                border.admits(pose.x_m as f32, pose.y_m as f32)
                    && poses.iter().all(|other| {
                        libm::hypot(pose.x_m - other.x_m, pose.y_m - other.y_m) >= spacing_m
                    })
            });
        poses.push(place.ok_or_else(|| refuse(poses.len()))?);
    }
    Ok(poses)
}

/// A pose in a disc, facing away from its centre; uniform in the disc for uniform numbers.
fn facing_out(radius_m: f64, first: f64, second: f64) -> Pose {
    let distance_m = radius_m * first.sqrt();
    let bearing_rad = std::f64::consts::TAU * second;
    let (sine, cosine) = libm::sincos(bearing_rad);
    Pose { x_m: distance_m * cosine, y_m: distance_m * sine, heading_rad: bearing_rad }
}

/// Centres at least `spacing_m` apart in a disc are discs of half that radius in a disc that is
/// wider by it; no packing is denser than the hexagonal one.
fn most_that_fit(radius_m: f64, spacing_m: f64) -> usize {
    let hexagonal = std::f64::consts::PI / 12_f64.sqrt();
    let ratio = (radius_m + spacing_m / 2.0) / (spacing_m / 2.0);
    (hexagonal * ratio * ratio).floor().max(1.0) as usize
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::draw::Seed;
    use crate::example::flockbot_conditions;

    fn run(replicate: u64) -> RunKey {
        RunKey::new(Seed { seed: 1, replicate }, 0)
    }

    #[test]
    fn robots_start_apart_in_the_disc_and_face_away_from_its_centre() {
        for replicate in 0..100 {
            let poses = place(&flockbot_conditions(), run(replicate)).unwrap();

            assert_eq!(poses.len(), 9);
            for (robot, pose) in poses.iter().enumerate() {
                assert!(libm::hypot(pose.x_m, pose.y_m) <= 0.825);
                let away = libm::atan2(pose.y_m, pose.x_m) - pose.heading_rad;
                assert!(libm::sin(away).abs() < 1e-9 && libm::cos(away) > 0.0);
                for other in &poses[..robot] {
                    assert!(libm::hypot(pose.x_m - other.x_m, pose.y_m - other.y_m) >= 0.165);
                }
            }
        }
    }

    #[test]
    fn a_start_in_the_disc_is_uniform() {
        let conditions = Conditions { robots: 1, ..flockbot_conditions() };

        let inner = (0..10_000)
            .filter(|replicate| {
                let pose = place(&conditions, run(*replicate)).unwrap()[0];
                libm::hypot(pose.x_m, pose.y_m) < 0.825 / 2.0
            })
            .count();

        // A quarter of the area, within four standard errors.
        assert!((inner as f64 / 10_000.0 - 0.25).abs() < 0.018, "{inner}");
    }

    #[test]
    fn too_many_robots_are_refused_with_how_many_fit() {
        let conditions = Conditions { robots: 200, ..flockbot_conditions() };

        let error = place(&conditions, run(0)).unwrap_err();

        assert_eq!(
            error.to_string(),
            "200 robots do not fit into a disc of radius 0.825 m, 0.165 m apart and within the \
             walls: 0 found a place, and no more than 109 ever do"
        );
    }

    #[test]
    fn robots_that_could_only_fit_by_design_are_refused_after_bounded_tries() {
        let conditions = Conditions { robots: 90, ..flockbot_conditions() };

        let error = place(&conditions, run(0)).unwrap_err();

        assert!((40..90).contains(&error.placed), "{error}");
    }

    #[test]
    fn robots_start_within_the_walls() {
        let mut conditions = flockbot_conditions();
        conditions.arena.side_m = 1.2;

        let poses = place(&conditions, run(0)).unwrap();

        assert!(poses.iter().all(|pose| pose.x_m.abs() <= 0.525 && pose.y_m.abs() <= 0.525));
    }
}
