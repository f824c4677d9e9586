//! What geometry predicts of a mill, without any simulation.
//!
//! In a mill each robot drives along a ring and keeps the body of the robot ahead on the edge of its
//! cone: it turns one way while it sees it and the other way while it does not. That fixes the
//! radius of the ring, the number of robots that can form one, and how fast they may drive. These
//! are oracles for the world, and lines upon the phase diagram and reasons in answers ([`Condition`])
//! where simulated rings are this one; they are not used to decide anything. Rings of another kind
//! exist: such as that on which each robot just reaches the one ahead.
//!
//! # Source
//!
//! The ring of a cone of zero width is the tangent polygon of F. Berlinger, M. Gauci, R. Nagpal,
//! Science Robotics 6, 2021, supplement S3, Theorem 1. That of a wider cone, its existence, reach and
//! turn balance are derived here from `eq:output` and `eq:disc_kine`, and hold as `Δt → 0`: steering
//! once per period acts like a cone that is wider by about a third of `ωΔt`.

use std::f64::consts::{PI, TAU};

use crate::conditions::Conditions;
use crate::judge::behaviour::Behaviour;
use crate::robot::region::Region;
use crate::robot::sensor::Sees;

/// The ring that robots with a cone can form.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ring {
    /// Number of robots `N`; between whole numbers it is a point on a line in a diagram.
    pub n_robots: f64,
    /// Radius of one robot's body `r`, in metres.
    pub body_radius_m: f64,
    /// Half of the cone's opening angle `a`, in radians.
    pub half_angle_rad: f64,
    /// Reach of the cone, in metres.
    pub range_m: f64,
    /// Probability of a detection when a neighbour is in the cone.
    pub true_positive: f64,
    /// Probability of a detection when none is.
    pub false_positive: f64,
}

/// What must hold for robots to form this ring and stay on it; robots may mill on another one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Condition {
    /// The cone is narrow enough for so many robots: `a < π/N`.
    Existence,
    /// The edge of the cone is long enough to touch the robot ahead: `chord² <= range² + r²`.
    Reach,
    /// Bodies on the ring do not touch: `chord > 2r`.
    Room,
    /// Robots turn inward more often than by false positives: `P* > p_fp`.
    FastTurnBalance,
    /// Robots turn inward less often than they detect the one ahead: `P* < p_tp`.
    SlowTurnBalance,
}

impl Condition {
    /// All of them, those of geometry first.
    pub const ALL: [Self; 5] =
        [Self::Existence, Self::Reach, Self::Room, Self::FastTurnBalance, Self::SlowTurnBalance];

    /// What the line on a diagram is called on which it only just holds.
    pub fn title(self) -> &'static str {
        match self {
            Self::Existence => "the cone is narrow enough for one",
            Self::Reach => "the robot ahead is in reach",
            Self::Room => "bodies do not touch",
            Self::FastTurnBalance => "turns inward more often than by false detections alone",
            Self::SlowTurnBalance => "turns inward less often than the robot ahead is detected",
        }
    }

    /// By how much the condition holds for robots that deliver this speed and this turning rate,
    /// which is positive: above zero where it does, and zero on its line.
    ///
    /// An angle in radians for [`Self::Existence`], a length in metres for [`Self::Reach`] and
    /// [`Self::Room`], else a share; `None` where the condition has no meaning because another one
    /// does not hold: without a ring there is no chord, and a ring that is out of reach is not
    /// balanced on.
    ///
    /// # Example
    ///
    /// Nine Flockbots see far enough for their ring, by 0.25 m.
    ///
    /// ```
    /// use rsrs_core::diagram::theory::{Condition, Ring};
    ///
    /// let flockbots = Ring {
    ///     n_robots: 9.0,
    ///     body_radius_m: 0.075,
    ///     half_angle_rad: 0.2,
    ///     range_m: 0.75,
    ///     true_positive: 0.8,
    ///     false_positive: 0.08,
    /// };
    /// let margin_m = Condition::Reach.margin(&flockbots, 0.15, 0.75).unwrap();
    /// assert_eq!(format!("{margin_m:.2}"), "0.25");
    /// ```
    pub fn margin(self, ring: &Ring, speed_m_s: f64, turn_rate_rad_s: f64) -> Option<f64> {
        let balance = || {
            let balance = ring.turn_balance(speed_m_s, turn_rate_rad_s);
            balance.filter(|_| ring.exists())
        };
        match self {
            Self::Existence => {
                (ring.n_robots >= 2.0).then(|| PI / ring.n_robots - ring.half_angle_rad)
            }
            Self::Reach => ring.chord_m().map(|chord_m| ring.longest_chord_m() - chord_m),
            Self::Room => ring.chord_m().map(|chord_m| chord_m - 2.0 * ring.body_radius_m),
            Self::FastTurnBalance => balance().map(|share| share - ring.false_positive),
            Self::SlowTurnBalance => balance().map(|share| ring.true_positive - share),
        }
    }
}

impl Ring {
    /// The ring of robots under these conditions; `None` if they are not alike, see with a polygon, by centres or with more
    /// than one plain sensor or among objects, for which this geometry does not hold, have another controller than that of
    /// the paper, or are to do something else than mill.
    pub fn new(conditions: &Conditions) -> Option<Self> {
        let robot = &conditions.robot;
        let is_mirrored =
            conditions.controller.parameters().is_some_and(|it| it.undetected.is_none());
        let sees_plainly = robot.has_one_plain_sensor() && conditions.world.n_objects() == 0;
        if !conditions.are_robots_alike()
            || !is_mirrored
            || !sees_plainly
            || conditions.behaviour != Behaviour::MILLING
        {
            return None;
        }
        let Region::Cone { half_angle_rad, range_m } = robot.region else {
            return None;
        };
        (robot.sees == Sees::Body).then_some(Self {
            n_robots: conditions.robots as f64,
            body_radius_m: robot.radius_m,
            half_angle_rad,
            range_m,
            true_positive: robot.true_positive,
            false_positive: robot.false_positive,
        })
    }

    /// Radius of the ring, `R* = r / (cos a - cos(2π/N - a))`, in metres. `None` if there is no
    /// such ring: its robots would see the one ahead at any distance, which is so unless `a < π/N`.
    ///
    /// # Example
    ///
    /// ```
    /// use rsrs_core::diagram::theory::Ring;
    ///
    /// let flockbots = Ring {
    ///     n_robots: 9.0,
    ///     body_radius_m: 0.075,
    ///     half_angle_rad: 0.2,
    ///     range_m: 0.75,
    ///     true_positive: 0.8,
    ///     false_positive: 0.08,
    /// };
    /// assert_eq!(format!("{:.3}", flockbots.radius_m().unwrap()), "0.738");
    /// ```
    pub fn radius_m(&self) -> Option<f64> {
        if self.n_robots < 2.0 || self.half_angle_rad >= PI / self.n_robots {
            return None;
        }
        let ahead_rad = TAU / self.n_robots;
        let gap = libm::cos(self.half_angle_rad) - libm::cos(ahead_rad - self.half_angle_rad);
        Some(self.body_radius_m / gap)
    }

    /// Distance to the robot ahead, centre to centre, in metres; `None` if there is no ring.
    pub fn chord_m(&self) -> Option<f64> {
        self.radius_m().map(|radius_m| 2.0 * radius_m * libm::sin(PI / self.n_robots))
    }

    /// The greatest distance to a robot that touches an edge of the cone with its side, in metres.
    /// Up to a radius beyond the range it still touches the end of the edge, but at bearings that become
    /// smaller quickly.
    pub fn longest_chord_m(&self) -> f64 {
        libm::hypot(self.range_m, self.body_radius_m)
    }

    /// Whether there is such a ring for these bodies and their reach: `a < π/N`, `2r < chord` and
    /// `chord² <= range² + r²`.
    pub fn exists(&self) -> bool {
        self.chord_m().is_some_and(|chord_m| {
            chord_m > 2.0 * self.body_radius_m && chord_m <= self.longest_chord_m()
        })
    }

    /// Share of the time in which robots on the ring turn towards its inside, from 0 to 1/2:
    /// `P* = (1 - v / (ω R)) / 2`, with the speed `v` and the turning rate `ω > 0` that they
    /// deliver, and `R = max(R*, v/ω)`. `None` if there is no ring.
    pub fn turn_balance(&self, speed_m_s: f64, turn_rate_rad_s: f64) -> Option<f64> {
        let circle_m = speed_m_s / turn_rate_rad_s;
        self.radius_m().map(|radius_m| (1.0 - circle_m / circle_m.max(radius_m)) / 2.0)
    }

    /// Whether robots that deliver this speed and this turning rate, which is positive, hold the
    /// ring: it exists, and its turn balance lies strictly between the two probabilities of a
    /// detection.
    pub fn holds(&self, speed_m_s: f64, turn_rate_rad_s: f64) -> bool {
        let is_between =
            |balance: f64| balance > self.false_positive && balance < self.true_positive;
        self.exists() && self.turn_balance(speed_m_s, turn_rate_rad_s).is_some_and(is_between)
    }
}

/// Tangentness of a perfect mill that steers once per period: its heading swings by `ωΔt` between
/// left and right, so on average it is `ωΔt/2` off the tangent.
pub fn tangentness(turn_rate_rad_s: f64, period_s: f64) -> f64 {
    turn_rate_rad_s * period_s / 2.0
}

#[cfg(test)]
mod tests {
    use super::*;

    const FLOCKBOTS: Ring = Ring {
        n_robots: 9.0,
        body_radius_m: 0.075,
        half_angle_rad: 0.2,
        range_m: 0.75,
        true_positive: 0.8,
        false_positive: 0.08,
    };

    #[test]
    fn the_robot_ahead_lies_on_the_edge_of_the_cone() {
        let radius_m = FLOCKBOTS.radius_m().unwrap();
        let chord_m = FLOCKBOTS.chord_m().unwrap();

        // Seen from a robot, the one ahead is at pi/N off the heading; its body spans asin(r/d).
        let edge_rad = PI / 9.0 - libm::asin(0.075 / chord_m);
        assert!((edge_rad - 0.2).abs() < 1e-12);
        assert!((radius_m - 0.738).abs() < 5e-4 && (chord_m - 0.505).abs() < 5e-4);
    }

    #[test]
    fn too_many_robots_or_too_wide_a_cone_form_no_ring() {
        assert!(FLOCKBOTS.exists());
        assert_eq!(Ring { n_robots: 16.0, ..FLOCKBOTS }.radius_m(), None);
        assert_eq!(Ring { half_angle_rad: 0.36, ..FLOCKBOTS }.radius_m(), None);
        assert_eq!(Ring { n_robots: 1.0, ..FLOCKBOTS }.radius_m(), None);
        // Twelve robots have a ring, but the one ahead is 1.2 m away.
        assert!(Ring { n_robots: 12.0, ..FLOCKBOTS }.radius_m().is_some());
        assert!(!Ring { n_robots: 12.0, ..FLOCKBOTS }.exists());
    }

    #[test]
    fn the_balance_at_the_best_cell_is_between_the_probabilities_of_detection() {
        let balance = FLOCKBOTS.turn_balance(0.15, 0.75).unwrap();

        assert!((balance - 0.3645).abs() < 1e-3, "{balance}");
        assert!(FLOCKBOTS.holds(0.15, 0.75));
    }

    #[test]
    fn robots_hold_a_ring_where_all_conditions_do() {
        let rings = [0.05, 0.2, 0.3, 0.5].into_iter().flat_map(|half_angle_rad| {
            (2..20).map(move |robots| Ring {
                n_robots: f64::from(robots),
                half_angle_rad,
                ..FLOCKBOTS
            })
        });
        let mut n_held = 0;

        for ring in rings {
            for (speed_m_s, turn_rate_rad_s) in [(0.05, 2.0), (0.15, 0.75), (0.3, 0.25)] {
                let margin =
                    |condition: &Condition| condition.margin(&ring, speed_m_s, turn_rate_rad_s);
                let all_hold = Condition::ALL.iter().all(|condition| margin(condition) > Some(0.0));

                let holds = ring.holds(speed_m_s, turn_rate_rad_s);

                assert_eq!(holds, all_hold, "{ring:?} {speed_m_s} {turn_rate_rad_s}");
                n_held += usize::from(holds);
            }
        }
        assert!(n_held > 10, "{n_held}");
    }
}
