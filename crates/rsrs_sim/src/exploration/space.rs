//! The controllers that robots can carry out, as points of a box.

use rsrs_core::robot::controller::{Command, ControllerParameters};
use rsrs_core::robot::profile::RobotProfile;
use rsrs_core::robot::wheels::Wheels;

use super::Draws;

/// Numbers of a binary controller: speed and turning rate where something is detected, and where nothing is.
pub const N_NUMBERS: usize = 4;

/// A point of the search: a coordinate from -1 to 1 for each number of a controller.
pub type Point = Vec<f64>;

/// The commands that robots can carry out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ControllerSpace {
    /// Least and greatest speed that is not 0, in metres per second.
    pub speed_m_s: [f64; 2],
    /// Least and greatest turning rate that is not 0, in radians per second.
    pub turn_rate_rad_s: [f64; 2],
    /// What their wheels can do, if that is known.
    pub wheels: Option<Wheels>,
    /// Whether robots may drive backward.
    pub directions: Directions,
}

/// In which directions robots may drive.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Directions {
    /// Forward and backward.
    Both,
    /// Forward only.
    Forward,
}

/// Numbers of controllers have this many digits after the point, so that files repeat them exactly.
pub const RESOLUTION: f64 = 1e3;

impl ControllerSpace {
    /// What a measured robot may be commanded.
    pub fn new(profile: &RobotProfile, directions: Directions) -> Self {
        Self {
            speed_m_s: profile.actuation.speed.limits_m_s,
            turn_rate_rad_s: profile.actuation.turn.limits_rad_s,
            wheels: profile.actuation.wheels,
            directions,
        }
    }

    /// The controller at a point; what lies outside the box is that on its border.
    ///
    /// # Panics
    ///
    /// If the point has not [`N_NUMBERS`] coordinates.
    pub fn controller(&self, point: &[f64]) -> ControllerParameters {
        let [speed, turn_rate, undetected_speed, undetected_turn_rate] =
            <[f64; N_NUMBERS]>::try_from(point).expect("a coordinate for each number");
        let command = |speed: f64, turn_rate: f64| {
            self.within_wheels(Command {
                speed_m_s: self.speed(speed),
                turn_rate_rad_s: amount(turn_rate, self.turn_rate_rad_s),
            })
        };
        ControllerParameters::new(
            command(speed, turn_rate),
            command(undetected_speed, undetected_turn_rate),
        )
    }

    /// The same circle, driven as fast as the wheels can; of two commands that robots are too slow for then
    /// nothing is left.
    fn within_wheels(&self, command: Command) -> Command {
        let Some(wheels) = self.wheels.filter(|wheels| !wheels.can(command)) else {
            return command;
        };
        let share = wheels.speed_max_m_s / wheels.asked_m_s(command);
        Command {
            speed_m_s: at_most(share * command.speed_m_s, self.speed_m_s[0]),
            turn_rate_rad_s: at_most(share * command.turn_rate_rad_s, self.turn_rate_rad_s[0]),
        }
    }

    fn speed(&self, coordinate: f64) -> f64 {
        match self.directions {
            Directions::Both => amount(coordinate, self.speed_m_s),
            Directions::Forward => amount(f64::midpoint(coordinate, 1.0), self.speed_m_s),
        }
    }
}

/// A coordinate in parts of the greatest value. What a robot is too slow for is either nothing or the
/// least that it does, whichever is nearer.
fn amount(coordinate: f64, [least, most]: [f64; 2]) -> f64 {
    let value = coordinate.clamp(-1.0, 1.0) * most;
    let amount = match value.abs() {
        little if little < least / 2.0 => 0.0,
        little => little.max(least),
    };
    // Rounded towards what is allowed.
    let rounded = ((amount * RESOLUTION).round() / RESOLUTION).clamp(least.min(amount), most);
    if value < 0.0 && rounded > 0.0 { -rounded } else { rounded }
}

/// A value rounded towards 0; 0 if it is less than the least that a robot does.
fn at_most(value: f64, least: f64) -> f64 {
    let rounded = (value * RESOLUTION).trunc() / RESOLUTION;
    if rounded.abs() < least { 0.0 } else { rounded }
}

/// A point anywhere in the box of so many numbers.
pub(super) fn anywhere(draws: &mut Draws, n_numbers: usize) -> Point {
    (0..n_numbers).map(|_| 2.0 * draws.uniform() - 1.0).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const SPACE: ControllerSpace = ControllerSpace {
        speed_m_s: [0.02, 0.3],
        turn_rate_rad_s: [0.1, 2.5],
        wheels: None,
        directions: Directions::Both,
    };

    #[test]
    fn every_controller_is_one_that_the_robot_may_be_given() {
        let profile = rsrs_testing::conditions::FLOCKBOT;
        let free = RobotProfile::parse("flockbot.yaml", profile).unwrap();
        let mut on_wheels = free.clone();
        on_wheels.actuation.wheels = Some(Wheels { base_m: 0.12, speed_max_m_s: 0.2 });
        let both = [Directions::Both, Directions::Forward];
        for (profile, directions) in
            [&free, &on_wheels].into_iter().flat_map(|it| both.map(|directions| (it, directions)))
        {
            let space = ControllerSpace::new(profile, directions);
            for step in 0..2000 {
                let mut draws = Draws::new(1, step);
                let controller = space.controller(&anywhere(&mut draws, N_NUMBERS));

                assert_eq!(profile.check_limits(&controller.into()), Ok(()), "{controller:?}");
                let is_forward = controller.commands().iter().all(|one| one.speed_m_s >= 0.0);
                assert!(directions == Directions::Both || is_forward);
            }
        }
    }

    #[test]
    fn what_is_too_fast_for_wheels_is_the_same_circle_driven_slower() {
        let wheels = Wheels { base_m: 0.051, speed_max_m_s: 0.128 };
        let space = ControllerSpace { wheels: Some(wheels), ..SPACE };

        let [detected, undetected] = space.controller(&[1.0, 1.0, -0.2, 0.0]).commands();

        let circle_m = detected.speed_m_s / detected.turn_rate_rad_s;
        assert!((circle_m - 0.3 / 2.5).abs() < 2e-3, "{detected:?}");
        let asked_m_s = wheels.asked_m_s(detected);
        assert!((0.126..=0.128).contains(&asked_m_s), "{asked_m_s}");
        assert_eq!(undetected, Command { speed_m_s: -0.06, turn_rate_rad_s: 0.0 });
    }

    #[test]
    fn little_is_nothing_or_the_least() {
        let controller = SPACE.controller(&[0.02, 0.035, -1.0, 2.0]);

        let [detected, undetected] = controller.commands();
        assert_eq!(detected, Command { speed_m_s: 0.0, turn_rate_rad_s: 0.1 });
        assert_eq!(undetected, Command { speed_m_s: -0.3, turn_rate_rad_s: 2.5 });
    }
}
