//! What floors that share nothing with the simulator are made of: motors with inertia, sensors that
//! cast rays, and bodies that push each other.
//!
//! A pose is x and y in metres, and a heading in radians.

use std::f64::consts::TAU;

use rand::RngExt;
use rand::rngs::ChaCha8Rng;

/// The most that a motor changes the speed of its wheel, in m/s².
pub const MOTOR_MOST_M_S2: f64 = 0.8;

/// Rays of a sensor, evenly over its angle.
pub const N_RAYS: usize = 15;

/// A motor that turns a wheel.
pub struct Motor {
    /// It approaches what it is asked for with this time constant, in seconds.
    pub lag_s: f64,
    /// What friction takes of its acceleration, in m/s².
    pub friction_m_s2: f64,
}

impl Motor {
    /// The speed of its wheel `step_s` later, in m/s.
    pub fn turned_m_s(&self, speed_m_s: f64, asked_m_s: f64, step_s: f64) -> f64 {
        let wanted_m_s2 = (asked_m_s - speed_m_s) / self.lag_s;
        // Friction resists the wheel, and holds one that stands.
        let given_m_s2 = wanted_m_s2.clamp(-MOTOR_MOST_M_S2, MOTOR_MOST_M_S2);
        let friction_m_s2 = self.friction_m_s2 * speed_m_s.clamp(-0.01, 0.01) / 0.01;
        speed_m_s + (given_m_s2 - friction_m_s2) * step_s
    }
}

/// Where a robot comes to that moves by `way_m` and turns by `turn_rad`.
pub fn moved([x_m, y_m, heading_rad]: [f64; 3], way_m: f64, turn_rad: f64) -> [f64; 3] {
    let (sine, cosine) = libm::sincos(heading_rad + turn_rad / 2.0);
    [x_m + way_m * cosine, y_m + way_m * sine, libm::remainder(heading_rad + turn_rad, TAU)]
}

/// How far the nearest body is along any ray of a robot's sensor, in metres. Rays leave `eye_m` ahead of its centre;
/// each ends at the first body.
pub fn nearest_m(
    poses: &[[f64; 3]],
    robot: usize,
    radius_m: f64,
    eye_m: f64,
    half_angle_rad: f64,
) -> f64 {
    let [x_m, y_m, heading_rad] = poses[robot];
    let (sine, cosine) = libm::sincos(heading_rad);
    let eye_m = [x_m + eye_m * cosine, y_m + eye_m * sine];
    let along = |ray: usize| {
        let aside = 2.0 * ray as f64 / (N_RAYS - 1) as f64 - 1.0;
        let (sine, cosine) = libm::sincos(heading_rad + half_angle_rad * aside);
        let others = poses.iter().enumerate().filter(|(other, _)| *other != robot);
        let met = others.filter_map(|(_, other)| {
            let [dx_m, dy_m] = [other[0] - eye_m[0], other[1] - eye_m[1]];
            let (ahead_m, aside_m) = (dx_m * cosine + dy_m * sine, dy_m * cosine - dx_m * sine);
            let half_chord_m2 = radius_m * radius_m - aside_m * aside_m;
            (half_chord_m2 >= 0.0 && ahead_m >= 0.0)
                .then(|| (ahead_m - libm::sqrt(half_chord_m2)).max(0.0))
        });
        met.fold(f64::INFINITY, f64::min)
    };
    (0..N_RAYS).map(along).fold(f64::INFINITY, f64::min)
}

/// No two bodies are in one place: each gives way by half, pair after pair, until none overlap.
pub fn push_apart(poses: &mut [[f64; 3]], radius_m: f64) {
    let apart_m = 2.0 * radius_m;
    for _ in 0..20 {
        let mut is_apart = true;
        for other in 1..poses.len() {
            let (before, from_other) = poses.split_at_mut(other);
            let two = &mut from_other[0];
            for one in before {
                let [dx_m, dy_m] = [two[0] - one[0], two[1] - one[1]];
                let distance_m = libm::hypot(dx_m, dy_m);
                if distance_m >= apart_m - 1e-6 || distance_m == 0.0 {
                    continue;
                }
                is_apart = false;
                let give_way = (apart_m - distance_m) / 2.0 / distance_m;
                one[0] -= dx_m * give_way;
                one[1] -= dy_m * give_way;
                two[0] += dx_m * give_way;
                two[1] += dy_m * give_way;
            }
        }
        if is_apart {
            return;
        }
    }
}

/// A normal draw.
pub fn normal(random: &mut ChaCha8Rng) -> f64 {
    let radius = libm::sqrt(-2.0 * libm::log(1.0 - random.random::<f64>()));
    radius * libm::cos(TAU * random.random::<f64>())
}
