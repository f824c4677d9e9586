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

/// What a person is to do before a trial of a robot.
pub fn words(robot: &str, trial: &Trial) -> String {
    let neighbour = match trial {
        Trial::Stand { neighbour: Some(neighbour), .. } => neighbour,
        Trial::Stand { neighbour: None, .. } => {
            return format!("{robot} alone: take away all that it could detect");
        }
        Trial::Drive { command, duration_s } => {
            return format!(
                "clear the floor around {robot}: it drives at {} m/s and {} rad/s for {duration_s} s",
                command.speed_m_s, command.turn_rate_rad_s
            );
        }
    };
    let Neighbour { distance_m, bearing_rad } = *neighbour;
    let side = if bearing_rad > 0.0 { "to the left" } else { "to the right" };
    let bearing = if bearing_rad == 0.0 {
        "straight ahead of it".to_owned()
    } else {
        let degrees = bearing_rad.abs().to_degrees();
        format!("{:.3} rad ({degrees:.1}°) {side}", bearing_rad.abs())
    };
    format!("put another robot {distance_m:.3} m from {robot}, {bearing}, centre to centre")
}

/// What a robot does in a trial.
pub fn description(robot: &str, trial: &Trial) -> String {
    match trial {
        Trial::Drive { command, duration_s } => format!(
            "{robot} drives at {} m/s and {} rad/s for {duration_s} s",
            command.speed_m_s, command.turn_rate_rad_s
        ),
        Trial::Stand { neighbour: None, samples } => {
            format!("{robot} stands alone for {samples} readings")
        }
        Trial::Stand { neighbour: Some(Neighbour { distance_m, bearing_rad }), samples } => {
            format!(
                "{robot} stands with another {distance_m:.3} m away at {bearing_rad:.3} rad, for \
                 {samples} readings"
            )
        }
    }
}

#[cfg(test)]
mod tests {
    use rsrs_core::robot::controller::ControllerParameters;

    use super::*;

    fn stand(distance_m: f64, bearing_rad: f64) -> Trial {
        Trial::Stand { neighbour: Some(Neighbour { distance_m, bearing_rad }), samples: 9 }
    }

    #[test]
    fn the_instruction_names_where_the_neighbour_stands() {
        for (trial, expected) in [
            (stand(0.3, 0.2), "0.300 m from a, 0.200 rad (11.5°) to the left, centre to centre"),
            (stand(0.3, -0.2), "0.300 m from a, 0.200 rad (11.5°) to the right, centre to centre"),
            (stand(0.5, 0.0), "0.500 m from a, straight ahead of it, centre to centre"),
            (Trial::Stand { neighbour: None, samples: 9 }, "a alone: take away all that it could"),
        ] {
            let given = words("a", &trial);
            assert!(given.contains(expected), "{given}");
        }
    }

    #[test]
    fn who_looks_on_reads_which_trial_it_is() {
        let command = ControllerParameters::mirrored(0.2, 0.5);
        let drive = Trial::Drive { command, duration_s: 4.5 };
        for (trial, expected) in [
            (drive, "a drives at 0.2 m/s and 0.5 rad/s for 4.5 s"),
            (stand(0.3, -0.2), "a stands with another 0.300 m away at -0.200 rad, for 9 readings"),
            (Trial::Stand { neighbour: None, samples: 9 }, "a stands alone for 9 readings"),
        ] {
            assert_eq!(description("a", &trial), expected);
        }
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
