//! A robot's controller, as all tests of parameters have it.

use rsrs_ros::parameters::{Descriptor, NodeParameters, ParameterKind, ParameterValue};

/// The node of a robot, counted from 1, and its two parameters.
pub fn controller(robot: usize, speed_m_s: f64, turn_rate_rad_s: f64) -> NodeParameters {
    let mut speed = Descriptor::new("speed", ParameterKind::Double, "Forward speed, in m/s.");
    speed.range = Some((0.0, 0.3));
    let turn_rate = Descriptor::new("turn_rate", ParameterKind::Double, "In rad/s.");
    NodeParameters {
        namespace: format!("/robot_{robot}"),
        name: "controller".into(),
        parameters: vec![
            (speed, ParameterValue::Double(speed_m_s)),
            (turn_rate, ParameterValue::Double(turn_rate_rad_s)),
        ],
    }
}
