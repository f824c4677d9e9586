//! The widest conditions that are taken still make worlds of finite numbers.

use rsrs_core::conditions::{Conditions, Impossible};
use rsrs_core::robot::controller::Command;
use rsrs_fleet::simulator::MAX_COMMAND;
use rsrs_sim::draw::Seed;
use rsrs_sim::world::World;
use rsrs_testing::conditions::measured_flockbots;
use serde_json::{Value, json};

fn document() -> Value {
    let conditions = measured_flockbots(3);
    let mut document = serde_json::to_value(conditions).expect("conditions are plain data");
    // Every disturbance is at work, and nothing keeps the robots in.
    for (path, value) in [
        ("/robot/gust_sd_m_s", json!(0.1)),
        ("/robot/yaw_lag_s", json!(0.1)),
        ("/robot/heading_noise_sd_rad", json!(0.1)),
        ("/robot/speed_gain/step_sd", json!(0.1)),
        ("/arena/walls", json!("none")),
    ] {
        *document.pointer_mut(path).expect("it is a key of the conditions") = value;
    }
    document
}

/// Every path to a number whose limits are to be tried.
fn numbers(value: &Value, path: &str) -> Vec<String> {
    match value {
        Value::Number(_) if path != "/robots" => vec![path.to_owned()],
        Value::Object(map) => {
            map.iter().flat_map(|(key, inner)| numbers(inner, &format!("{path}/{key}"))).collect()
        }
        _ => Vec::new(),
    }
}

/// The least and greatest value that the check lets through.
fn limits(document: &Value, path: &str) -> [f64; 2] {
    let mut document = document.clone();
    *document.pointer_mut(path).expect("it is a key") = json!(4_000_000_000_u64);
    let conditions: Conditions = serde_json::from_value(document).expect("its shape is right");
    match conditions.check() {
        Err(Impossible::Number { least, most, .. }) => [least, most],
        other => panic!("{path} is not checked: {other:?}"),
    }
}

fn set(document: &mut Value, path: &str, value: f64) {
    // A whole number is written without a point, as counts must be.
    let value = value.to_string().parse().expect("a finite number is JSON");
    *document.pointer_mut(path).expect("it is a key") = value;
}

/// Runs a world with the greatest commands, and returns whether its robots are still somewhere;
/// `None` if they do not fit where they are to start.
fn stays_finite(document: &Value) -> Option<bool> {
    let conditions: Conditions =
        serde_json::from_value(document.clone()).expect("its shape is right");
    conditions.check().expect("limits are within themselves");
    let mut world = World::new(&conditions, Seed { seed: 1, replicate: 0 }).ok()?;
    for step in 0..200 {
        world.sense();
        let sign = if step % 3 == 0 { -1.0 } else { 1.0 };
        let greatest = Command { speed_m_s: MAX_COMMAND, turn_rate_rad_s: sign * MAX_COMMAND };
        world.advance(&[greatest, Command::STOP, greatest]);
    }
    Some(
        world.poses().all(|pose| {
            pose.x_m.is_finite() && pose.y_m.is_finite() && pose.heading_rad.is_finite()
        }),
    )
}

#[test]
fn a_world_at_any_limit_of_its_conditions_stays_finite() {
    for document in [document(), pushing(document())] {
        at_any_limit(&document);
    }
}

/// Robots that push each other, with friction.
fn pushing(mut document: Value) -> Value {
    let robot = document["robot"].as_object_mut().expect("it has keys");
    robot.insert("contact".to_owned(), json!("push"));
    robot.insert("contact_friction".to_owned(), json!(0.2));
    document
}

fn at_any_limit(document: &Value) {
    for path in numbers(document, "") {
        for limit in limits(document, &path) {
            let mut document = document.clone();
            set(&mut document, &path, limit);

            let too_tight = (path == "/robot/radius_m" && limit > 1.0)
                || (path == "/placement/radius_m" && limit < 1.0);
            let expected = if too_tight { None } else { Some(true) };
            assert_eq!(stays_finite(&document), expected, "{path} = {limit}");
        }
    }
}

#[test]
fn a_world_at_all_limits_of_its_conditions_stays_finite() {
    for (end, mut document) in
        [(0, document()), (1, document()), (0, pushing(document())), (1, pushing(document()))]
    {
        for path in numbers(&document.clone(), "") {
            // At their limits, robots do not fit.
            if path != "/robot/radius_m" && path != "/placement/radius_m" {
                let limit = limits(&document, &path)[end];
                set(&mut document, &path, limit);
            }
        }

        assert_eq!(stays_finite(&document), Some(true), "{document}");
    }
}
