//! Contact between bodies, and between a body and the arena's walls.

use rsrs_core::conditions::{Arena, SimulatedRobot, Walls};
use rsrs_core::robot::contact::ContactModel;

/// When a neighbour keeps a robot from driving on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contact {
    pub(crate) diameter_squared_m2: f32,
    pub(crate) front: f32,
}

impl Contact {
    /// The contact of robots of one kind.
    pub fn new(robot: &SimulatedRobot) -> Self {
        Self::with(robot, robot)
    }

    /// The contact of a robot with one of another kind.
    pub fn with(robot: &SimulatedRobot, other: &SimulatedRobot) -> Self {
        let diameter_m = robot.radius_m + other.radius_m;
        let front = libm::cos(robot.front_half_angle_rad);
        let stops = robot.contact == ContactModel::Stop && other.contact != ContactModel::None;
        Self {
            diameter_squared_m2: (diameter_m * diameter_m) as f32,
            // In front of one that pushes or passes through others there is nobody.
            front: if stops { (front * front.abs()) as f32 } else { f32::INFINITY },
        }
    }

    /// Whether a neighbour at `forward_m` along the heading and squared distance `d2_m2` blocks.
    ///
    /// It does when the bodies overlap and it lies within the front sector: `forward > d cos φ`,
    /// written without a square root as `f |f| > cos φ |cos φ| d²`.
    ///
    /// # Source
    ///
    /// §IV step 2: "the robots would stop in place if the other robot was in front and would be
    /// generally unaffected if it was pushed from another angle".
    #[inline]
    pub fn blocks_ahead(self, forward_m: f32, d2_m2: f32) -> bool {
        (d2_m2 < self.diameter_squared_m2) & (forward_m * forward_m.abs() > self.front * d2_m2)
    }

    /// Whether it blocks a robot that drives backward: as [`Self::blocks_ahead`], mirrored.
    #[inline]
    pub fn blocks_behind(self, forward_m: f32, d2_m2: f32) -> bool {
        self.blocks_ahead(-forward_m, d2_m2)
    }
}

/// In which directions a robot cannot drive on.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Blocked {
    /// Another robot is in front of it.
    pub ahead: bool,
    /// Another robot is behind it.
    pub behind: bool,
}

impl Blocked {
    /// Whether it is blocked when it is commanded this speed.
    pub fn at(self, speed_m_s: f32) -> bool {
        if speed_m_s < 0.0 { self.behind } else { self.ahead }
    }
}

/// The border of the arena, as the centres of robots meet it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Border {
    pub(crate) walls: Walls,
    pub(crate) limit_m: f32,
}

impl Border {
    /// The border for robots of a radius: centres stay within `side / 2 - radius` on both axes.
    pub fn new(arena: &Arena, radius_m: f64) -> Self {
        Self { walls: arena.walls, limit_m: (arena.side_m / 2.0 - radius_m).max(0.0) as f32 }
    }

    /// Whether a robot can be at `(x_m, y_m)`.
    pub fn admits(self, x_m: f32, y_m: f32) -> bool {
        self.walls == Walls::None || (x_m.abs() <= self.limit_m) & (y_m.abs() <= self.limit_m)
    }

    /// Where a robot ends that drives from one point to another, in metres.
    #[inline]
    pub fn drive(self, from: (f32, f32), to: (f32, f32)) -> (f32, f32) {
        match self.walls {
            Walls::None => to,
            Walls::Stop if self.admits(to.0, to.1) => to,
            Walls::Stop => from,
            Walls::Clamp => (self.clamp(to.0), self.clamp(to.1)),
        }
    }

    /// Where a body that is pushed to a place in metres is held by the walls, if there are any.
    pub fn hold(self, to_m: [f64; 2]) -> [f64; 2] {
        let limit_m = f64::from(self.limit_m);
        if self.walls == Walls::None {
            to_m
        } else {
            to_m.map(|at_m| at_m.clamp(-limit_m, limit_m))
        }
    }

    fn clamp(self, coordinate_m: f32) -> f32 {
        let above = if coordinate_m < -self.limit_m { -self.limit_m } else { coordinate_m };
        if above > self.limit_m { self.limit_m } else { above }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rsrs_testing::conditions::flockbot_conditions;

    fn blocks_at(front_half_angle_rad: f64, bearing_rad: f64, distance_m: f64) -> bool {
        let robot = SimulatedRobot { front_half_angle_rad, ..flockbot_conditions().robot };
        let forward_m = (distance_m * libm::cos(bearing_rad)) as f32;
        Contact::new(&robot).blocks_ahead(forward_m, (distance_m * distance_m) as f32)
    }

    #[test]
    fn only_a_touching_neighbour_in_front_blocks() {
        let front_rad = 70_f64.to_radians();

        assert!(blocks_at(front_rad, 69_f64.to_radians(), 0.149));
        assert!(!blocks_at(front_rad, 71_f64.to_radians(), 0.149));
        assert!(!blocks_at(front_rad, 0.0, 0.151));
    }

    #[test]
    fn a_front_sector_may_reach_behind_the_robot() {
        let front_rad = 120_f64.to_radians();

        assert!(blocks_at(front_rad, 119_f64.to_radians(), 0.149));
        assert!(!blocks_at(front_rad, 121_f64.to_radians(), 0.149));
    }

    #[test]
    fn walls_stop_clamp_or_are_not_there() {
        let border =
            |walls| Border::new(&Arena { side_m: 2.0, walls }, 0.1).drive((0.85, 0.2), (0.95, 0.3));

        assert_eq!(border(Walls::None), (0.95, 0.3));
        assert_eq!(border(Walls::Stop), (0.85, 0.2));
        assert_eq!(border(Walls::Clamp), (0.9, 0.3));
    }
}
