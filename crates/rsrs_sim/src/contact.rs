//! Contact between bodies, and between a body and the arena's walls.

use std::sync::Arc;

use rsrs_core::conditions::{Conditions, SimulatedRobot, Walls};
use rsrs_core::plane::{dot, minus};
use rsrs_core::robot::contact::ContactModel;
use rsrs_core::world::FreeSpace;

use crate::shaped_border::ShapedBorder;

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

/// The walls of an arena, as the centres of robots or objects of one radius meet them.
#[derive(Clone, Debug)]
pub enum Border {
    /// Those of a square.
    Square(SquareBorder),
    /// Those of an arena of another shape, or in which obstacles stand.
    Shaped(ShapedBorder),
}

/// The walls of a square around the origin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SquareBorder {
    pub(crate) walls: Walls,
    /// Centres stay within it on both axes, in metres.
    pub(crate) limit_m: f32,
}

/// The borders of a world, for bodies of any radius.
pub struct Borders {
    walls: Walls,
    side_m: f64,
    space: Option<Arc<FreeSpace>>,
}

impl Borders {
    /// Those under these conditions.
    pub fn new(conditions: &Conditions) -> Self {
        let space = conditions.free_space().map(Arc::new);
        Self { walls: conditions.arena.walls, side_m: conditions.arena.side_m, space }
    }

    /// The border for bodies of a radius: in a square, centres stay within `side / 2 - radius` on both axes.
    pub fn for_radius(&self, radius_m: f64) -> Border {
        let walls = self.walls;
        match &self.space {
            None => {
                let limit_m = (self.side_m / 2.0 - radius_m).max(0.0) as f32;
                Border::Square(SquareBorder { walls, limit_m })
            }
            Some(space) => Border::Shaped(ShapedBorder::new(walls, space.clone(), radius_m)),
        }
    }
}

impl Border {
    /// Whether a robot can be at `(x_m, y_m)`.
    pub fn admits(&self, x_m: f32, y_m: f32) -> bool {
        match self {
            Self::Square(square) => square.admits(x_m, y_m),
            Self::Shaped(shaped) => shaped.admits([x_m, y_m].map(f64::from)),
        }
    }

    /// Where a robot ends that drives from one point to another, in metres.
    #[inline]
    pub fn drive(&self, from: (f32, f32), to: (f32, f32)) -> (f32, f32) {
        match self {
            Self::Square(square) => square.drive(from, to),
            Self::Shaped(shaped) => shaped.drive(from, to),
        }
    }

    /// As [`Self::drive`], of a robot that walls hold back where it slides along them: by at most the coefficient of
    /// friction times the way that they do not let it go (Coulomb). It is in double precision, of `+ - * /` and the
    /// square root.
    pub fn drive_with_friction(
        &self,
        from: (f32, f32),
        to: (f32, f32),
        friction: f64,
    ) -> (f32, f32) {
        let held = self.drive(from, to);
        if friction == 0.0 || held == to || held == from {
            return held;
        }
        let [from_m, to_m, held_m] =
            [from, to, held].map(|(x_m, y_m)| [f64::from(x_m), f64::from(y_m)]);
        let (pressed_m, way_m) = (minus(to_m, held_m), minus(held_m, from_m));
        let pressed_m2 = dot(pressed_m, pressed_m);
        let into = dot(way_m, pressed_m) / pressed_m2;
        let slid_m = [0, 1].map(|axis| way_m[axis] - into * pressed_m[axis]);
        let slid_m2 = dot(slid_m, slid_m);
        if slid_m2 == 0.0 {
            return held;
        }
        let kept = (friction * (pressed_m2 / slid_m2).sqrt()).min(1.0);
        let at_m = [0, 1].map(|axis| held_m[axis] - kept * slid_m[axis]);
        let at = (at_m[0] as f32, at_m[1] as f32);
        // Around a corner what is behind may be in a wall.
        if self.admits(at.0, at.1) { at } else { from }
    }

    /// Where a body that is pushed from one place to another, in metres, is held by the walls, if there are any.
    pub fn hold(&self, from_m: [f64; 2], to_m: [f64; 2]) -> [f64; 2] {
        match self {
            Self::Square(square) => square.hold(to_m),
            Self::Shaped(shaped) => shaped.hold(from_m, to_m),
        }
    }
}

impl SquareBorder {
    fn admits(self, x_m: f32, y_m: f32) -> bool {
        self.walls == Walls::None || (x_m.abs() <= self.limit_m) & (y_m.abs() <= self.limit_m)
    }

    #[inline]
    fn drive(self, from: (f32, f32), to: (f32, f32)) -> (f32, f32) {
        match self.walls {
            Walls::None => to,
            Walls::Stop if self.admits(to.0, to.1) => to,
            Walls::Stop => from,
            Walls::Clamp => (self.clamp(to.0), self.clamp(to.1)),
        }
    }

    fn hold(self, to_m: [f64; 2]) -> [f64; 2] {
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
    use rsrs_core::conditions::Arena;
    use rsrs_testing::conditions::flockbot_conditions;

    fn blocks_at(front_half_angle_rad: f64, bearing_rad: f64, distance_m: f64) -> bool {
        let robot = SimulatedRobot { front_half_angle_rad, ..flockbot_conditions().robot };
        let forward_m = (distance_m * libm::cos(bearing_rad)) as f32;
        Contact::new(&robot).blocks_ahead(forward_m, (distance_m * distance_m) as f32)
    }

    #[test]
    fn only_a_touching_neighbour_in_front_blocks_and_the_front_may_reach_behind() {
        for front_deg in [70.0_f64, 120.0] {
            let front_rad = front_deg.to_radians();

            assert!(blocks_at(front_rad, (front_deg - 1.0).to_radians(), 0.149), "{front_deg}");
            assert!(!blocks_at(front_rad, (front_deg + 1.0).to_radians(), 0.149), "{front_deg}");
            assert!(!blocks_at(front_rad, 0.0, 0.151), "{front_deg}");
        }
    }

    #[test]
    fn friction_holds_back_who_slides_along_a_wall_and_nobody_else() {
        let limit_m = 1.0;
        let border = |walls| Border::Square(SquareBorder { walls, limit_m });
        // A step of 2 cm into the wall and 3 cm along it, of which friction takes 0, 1, 2 and no more than 3 cm.
        let (from, to) = ((1.0, 0.0), (1.02, 0.03));
        let along_m = |friction| {
            let (x_m, y_m) = border(Walls::Clamp).drive_with_friction(from, to, friction);
            assert!((x_m - 1.0).abs() < 1e-6, "{x_m}");
            (1000.0 * y_m).round() as i32
        };

        assert_eq!([0.0, 0.5, 1.0, 1.5, 2.0].map(along_m), [30, 20, 10, 0, 0]);
        // Who comes to the wall in this step slides there less.
        let came = border(Walls::Clamp).drive_with_friction((0.99, 0.0), (1.01, 0.02), 0.5);
        assert!((came.0 - 1.0).abs() < 1e-6 && (came.1 - 0.015).abs() < 1e-6, "{came:?}");
        for (walls, from, to, at) in [
            (Walls::None, from, to, to),
            (Walls::Stop, from, to, from),
            (Walls::Clamp, (1.0, 0.0), (0.98, 0.03), (0.98, 0.03)),
            (Walls::Clamp, (1.0, 1.0), (1.1, 1.1), (1.0, 1.0)),
        ] {
            assert_eq!(border(walls).drive_with_friction(from, to, 0.7), at, "{walls:?}");
        }
    }

    #[test]
    fn walls_stop_clamp_or_are_not_there() {
        let border = |walls| {
            let arena = Arena { side_m: 2.0, walls };
            let conditions = Conditions { arena, ..flockbot_conditions() };
            Borders::new(&conditions).for_radius(0.1).drive((0.85, 0.2), (0.95, 0.3))
        };

        assert_eq!(border(Walls::None), (0.95, 0.3));
        assert_eq!(border(Walls::Stop), (0.85, 0.2));
        assert_eq!(border(Walls::Clamp), (0.9, 0.3));
    }
}
