//! Profiles and conditions that describe nothing that can be.

use rsrs_core::conditions::{Conditions, Settings};
use rsrs_core::quantity::Axis;
use rsrs_core::robot::contact::ContactModel;
use rsrs_core::robot::profile::RobotProfile;

use rsrs_testing::conditions::{FLOCKBOT, flockbot};

/// The Flockbot with one piece of text replaced.
fn flockbot_but(from: &str, to: &str) -> String {
    assert!(FLOCKBOT.contains(from), "{from}");
    FLOCKBOT.replace(from, to)
}

fn refusal(text: &str) -> String {
    RobotProfile::parse("robot.yaml", text).expect_err("it must be refused").to_string()
}

#[test]
fn a_profile_with_an_impossible_number_is_refused_by_the_key() {
    for (from, to, key, found) in [
        ("radius_m: 0.075", "radius_m: -0.075", "body.radius_m", "-0.075"),
        ("radius_m: 0.075", "radius_m: 0", "body.radius_m", "0"),
        ("true_positive: 0.98", "true_positive: 1.01", "sensing.true_positive", "1.01"),
        ("true_positive: 0.98", "true_positive: -0.1", "sensing.true_positive", "-0.1"),
        ("false_positive: 0.065", "false_positive: 6.5", "sensing.false_positive", "6.5"),
        ("range_m: 0.75", "range_m: -1", "sensing.cone.range_m", "-1"),
        ("half_angle_rad: 0.2", "half_angle_rad: 1.6", "sensing.cone.half_angle_rad", "1.6"),
        ("period_s: 0.13", "period_s: 0", "computation.period_s", "0"),
        ("robot_sd: 0.02", "robot_sd: -0.02", "actuation.speed.robot_sd", "-0.02"),
        ("{sd_m_s: 0.0", "{sd_m_s: -0.1", "actuation.gust.sd_m_s", "-0.1"),
        ("yaw_lag_s: 0.0", "yaw_lag_s: -1", "actuation.yaw_lag_s", "-1"),
    ] {
        let error = refusal(&flockbot_but(from, to));

        assert!(error.contains(key) && error.contains(found), "{to}: {error}");
    }
    for (wheels, expected) in [
        ("{base_m: 0, speed_max_m_s: 0.3}", "actuation.wheels.base_m is 0"),
        ("{base_m: 0.1, speed_max_m_s: -1}", "actuation.wheels.speed_max_m_s is -1"),
        ("{base_m: 0.1}", "speed_max_m_s"),
        ("{base_m: .inf, speed_max_m_s: 1}", "actuation.wheels.base_m is inf"),
    ] {
        let error =
            refusal(&flockbot_but("actuation:", &format!("actuation:\n  wheels: {wheels}")));

        assert!(error.contains(expected), "{error}");
    }
}

#[test]
fn a_polygon_that_is_no_region_is_refused() {
    let cone = "cone: {half_angle_rad: 0.2, range_m: 0.75}";
    for (what, corners) in [
        ("not convex", "[[0, -0.3], [0.7, -0.3], [0.2, 0], [0.7, 0.3], [0, 0.3]]"),
        ("a star", "[[1, 0], [-0.809, 0.588], [0.309, -0.951], [0.309, 0.951], [-0.809, -0.588]]"),
        ("self-crossing", "[[0, -0.3], [0.7, 0.3], [0.7, -0.3], [0, 0.3]]"),
        ("clockwise", "[[0, 0.3], [0.7, 0.3], [0.7, -0.3], [0, -0.3]]"),
        ("without area", "[[0, 0], [0.4, 0], [0.7, 0]]"),
        ("of two corners", "[[0, 0], [0.7, 0]]"),
        ("of nothing", "[]"),
    ] {
        let error = refusal(&flockbot_but(cone, &format!("polygon_m: {corners}")));

        assert!(error.contains("polygon"), "{what}: {error}");
    }
}

#[test]
fn a_sensor_with_two_regions_or_with_none_is_refused() {
    let cone = "cone: {half_angle_rad: 0.2, range_m: 0.75}";
    let both = flockbot_but(cone, &format!("{cone}\n  polygon_m: [[0, -1], [1, 0], [0, 1]]"));
    let none = flockbot_but(&format!("\n  {cone}"), "");

    for text in [both, none] {
        let error = refusal(&text);
        assert!(error.contains("cone") && error.contains("polygon"), "{error}");
    }
}

#[test]
fn a_cell_with_an_impossible_value_is_refused_by_the_axis() {
    let profile = flockbot();
    for (axis, value) in [
        (Axis::Robots, -1.0),
        (Axis::Robots, 2.5),
        (Axis::TruePositive, 1.5),
        (Axis::FalsePositive, -0.1),
        (Axis::Range, 0.0),
        (Axis::HalfAngle, 2.0),
        (Axis::Heterogeneity, -0.05),
        (Axis::Period, 0.0),
        (Axis::PlacementRadius, -0.5),
        (Axis::LatencySteps, 0.5),
        (Axis::Speed, f64::NAN),
    ] {
        let base = [(Axis::Speed, 0.15), (Axis::TurnRate, 0.75), (Axis::Robots, 9.0)];
        let mut values: Vec<(Axis, f64)> =
            base.into_iter().filter(|(other, _)| *other != axis).collect();
        values.push((axis, value));

        let settings = Settings { values, ..Settings::default() };
        let error = Conditions::resolve(&profile, &settings).expect_err("it must be refused");

        assert!(error.to_string().contains(axis.key()), "{axis:?} {value}: {error}");
    }
}

#[test]
fn every_capability_is_read_back_as_it_was_set() {
    let cone = "cone: {half_angle_rad: 0.2, range_m: 0.75}";
    let polygon = "polygon_m: [[0, 0], [0.6, -0.1], [0.7, 0.1], [0.5, 0.3]]";
    for text in [FLOCKBOT.to_owned(), flockbot_but(cone, polygon)] {
        let profile = RobotProfile::parse("robot.yaml", &text).expect("it is a robot");
        for (axis, value) in [
            (Axis::Range, 0.9),
            (Axis::HalfAngle, 0.35),
            (Axis::TruePositive, 0.7),
            (Axis::FalsePositive, 0.2),
            (Axis::Heterogeneity, 0.1),
            (Axis::LatencySteps, 3.0),
            (Axis::Gust, 0.02),
            (Axis::YawLag, 0.4),
            (Axis::Period, 0.2),
            (Axis::SpeedGain, 0.8),
            (Axis::TurnGain, 1.1),
            (Axis::GainNoise, 0.05),
            (Axis::TurnBias, 0.01),
            (Axis::HeadingNoise, 0.03),
        ] {
            let changed = profile.with_capabilities(&[(axis, value)]).expect("it is a robot");

            let found = changed.capability(axis).expect("it is a capability");
            assert!((found - value).abs() < 1e-12, "{axis}: {found}, expected {value}");
            assert_ne!(changed, profile, "{axis}");
        }
        let turned = profile.with_capabilities(&[(Axis::SensorBearing, 0.1)]).expect("a robot");
        assert!(turned.sensing.polygon_m.is_some() && turned.sensing.cone.is_none());
        let unturned = profile.with_capabilities(&[(Axis::SensorBearing, 0.0)]).expect("a robot");
        assert_eq!(unturned, profile);
    }
}

#[test]
fn only_robots_that_push_have_friction() {
    let stops = flockbot();
    let mut pushes = stops.clone();
    pushes.body.contact = ContactModel::Push;
    let with = |robot: &RobotProfile, friction| {
        robot.with_capabilities(&[(Axis::ContactFriction, friction)])
    };

    assert_eq!(stops.capability(Axis::ContactFriction), None);
    assert_eq!(pushes.capability(Axis::ContactFriction), Some(0.0));
    assert_eq!(with(&pushes, 0.4).unwrap().body.contact_friction, Some(0.4));
    insta::assert_snapshot!(with(&stops, 0.4).unwrap_err(), @"contact_friction does not apply to a robot whose `body.contact` is not `push`");
    insta::assert_snapshot!(with(&pushes, 3.0).unwrap_err(), @"contact_friction is 3, expected a number from 0 to 2");
}
