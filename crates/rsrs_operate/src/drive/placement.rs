//! Where robots are to stand for a trial.

use anyhow::Context;
use rsrs_core::trials::trial::{Neighbour, Trial};

use crate::run::place_command::{PlacedRobot, WantedPlacement};

/// The robot in the middle of the floor, and where another is to be sensed, the next one of the fleet.
pub fn wanted(robot: &str, robots: &[String], trial: &Trial) -> anyhow::Result<WantedPlacement> {
    let at = |name: &str, x_m: f64, y_m: f64| PlacedRobot {
        name: name.to_owned(),
        x_m,
        y_m,
        heading_rad: 0.0,
    };
    let mut placed = vec![at(robot, 0.0, 0.0)];
    if let Trial::Stand { neighbour: Some(Neighbour { distance_m, bearing_rad }), .. } = trial {
        let other = robots.iter().find(|other| *other != robot).with_context(|| {
            format!("the fleet has no other robot that could stand beside {robot}")
        })?;
        let (sine, cosine) = libm::sincos(*bearing_rad);
        placed.push(at(other, distance_m * cosine, distance_m * sine));
    }
    Ok(WantedPlacement { purpose: format!("trial of {robot}"), robots: placed })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn stand(distance_m: f64, bearing_rad: f64) -> Trial {
        Trial::Stand { neighbour: Some(Neighbour { distance_m, bearing_rad }), samples: 9 }
    }

    #[test]
    fn a_program_gets_the_robot_in_the_middle_and_the_other_where_it_is_sensed() {
        let robots = ["a".to_owned(), "b".to_owned()];

        let wanted = wanted("b", &robots, &stand(0.5, std::f64::consts::FRAC_PI_2)).unwrap();

        let places: Vec<(&str, String)> = wanted
            .robots
            .iter()
            .map(|robot| (robot.name.as_str(), format!("{:.3} {:.3}", robot.x_m, robot.y_m)))
            .collect();
        assert_eq!(places, [("b", "0.000 0.000".to_owned()), ("a", "0.000 0.500".to_owned())]);
        let alone = super::wanted("a", &robots[..1], &stand(0.5, 0.0)).unwrap_err();
        assert!(alone.to_string().contains("no other robot"), "{alone}");
    }
}
