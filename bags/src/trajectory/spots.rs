//! Robots that stand on one spot: poses in frames of their own, whose relation is unknown.

use rsrs_core::robot::unicycle::Pose;

use super::TrajectoryError;

/// Centres of robots are further apart than this, in metres: bodies are wider.
const MIN_APART_M: f64 = 0.02;

/// Refuses robots that start on one spot.
pub fn check(starts: &[Pose], robots: &[String]) -> Result<(), TrajectoryError> {
    let is_near = |one: &Pose, other: &Pose| {
        libm::hypot(one.x_m - other.x_m, one.y_m - other.y_m) < MIN_APART_M
    };
    for (first, start) in starts.iter().enumerate() {
        let others = (first + 1..starts.len()).filter(|other| is_near(start, &starts[*other]));
        let together: Vec<String> =
            std::iter::once(first).chain(others).map(|robot| robots[robot].clone()).collect();
        if together.len() > 1 {
            let (x_m, y_m) = (start.x_m, start.y_m);
            return Err(TrajectoryError::OneSpot { robots: together, x_m, y_m });
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(x_m: f64, y_m: f64) -> Pose {
        Pose { x_m, y_m, heading_rad: 0.0 }
    }

    #[test]
    fn robots_side_by_side_are_distinguished_from_robots_on_one_spot() {
        let robots: Vec<String> = (1..=3).map(|robot| format!("robot_{robot}")).collect();

        assert!(check(&[at(0.0, 0.0), at(0.05, 0.0), at(0.0, 0.05)], &robots).is_ok());
        let error = check(&[at(0.0, 0.0), at(1.0, 0.0), at(0.001, 0.0)], &robots).unwrap_err();
        assert_eq!(
            error.to_string(),
            "robots robot_1, robot_3 start on one spot, (0.00 m, 0.00 m): each has poses in a frame \
             of its own?"
        );
    }
}
