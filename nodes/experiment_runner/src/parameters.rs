//! What is set before a run, and what is read back.

use std::time::{Duration, Instant};

use rsrs_core::draw::Seed;
use rsrs_core::robot::controller::state_machine;
use rsrs_core::robot::controller::{Command, Controller, ControllerParameters, Reaction};
use rsrs_fleet::experiment::Time;
use rsrs_fleet::fleet_file::LeaseHolder;
use rsrs_fleet::parameters::controller::{
    self, CLASS, CONSTANT, LEASE, MIRRORED, SPEED, SPEED_MAX, STAMP_FROM_CLOCK, TABLE,
    TRANSITION_KEY, TURN_RATE, TURN_RATE_MAX, UNDETECTED_SPEED, UNDETECTED_TURN_RATE,
};
use rsrs_fleet::parameters::{GateSettings, Value, gate, simulator};
use rsrs_fleet::runner::Target;
use rsrs_fleet::timing::NODE_TIMEOUT;
use rsrs_ros::parameters::{ParameterClient, ParameterValue};

use crate::plan::Plan;

/// Sets all parameters of a target at once.
///
/// # Errors
///
/// What the target answered, or that it did not, in words.
pub async fn configure(
    client: &ParameterClient<'_>,
    plan: &Plan,
    target: &Target,
) -> Result<(), String> {
    let (node, values) = match target {
        Target::Robot(name) => (controller(name), of_controller(plan, name)),
        Target::Simulator => (simulator::FULL_NAME.to_owned(), of_simulator(plan)),
    };
    client.set_atomically(&node, &values).await.map_err(|error| error.to_string())
}

/// Reads a controller's parameters back, and digests them.
///
/// # Errors
///
/// What is wrong with the answer, that there is none, or that the robot's lease is held otherwise
/// than the fleet file states.
pub async fn read_back(
    client: &ParameterClient<'_>,
    plan: &Plan,
    robot: &str,
) -> Result<u64, String> {
    let lease = plan.lease_of(robot);
    let class = class(plan, robot);
    let mut names = vec![
        SPEED,
        TURN_RATE,
        MIRRORED,
        UNDETECTED_SPEED,
        UNDETECTED_TURN_RATE,
        CONSTANT,
        LEASE,
        SPEED_MAX,
        TURN_RATE_MAX,
        TABLE,
        TRANSITION_KEY,
    ];
    names.extend(class.as_ref().map(|_| CLASS));
    let values = client.get(&controller(robot), &names).await;
    match values.map_err(|error| error.to_string())?.as_slice() {
        [
            ParameterValue::Double(speed_m_s),
            ParameterValue::Double(turn_rate_rad_s),
            ParameterValue::Bool(is_mirrored),
            ParameterValue::Double(undetected_m_s),
            ParameterValue::Double(undetected_rad_s),
            ParameterValue::Bool(is_constant),
            ParameterValue::String(holder),
            ParameterValue::Double(speed_max_m_s),
            ParameterValue::Double(turn_rate_max_rad_s),
            ParameterValue::String(table),
            key @ ParameterValue::Integer(_),
            found_class @ ..,
        ] => {
            check_lease(holder, lease)?;
            if lease == LeaseHolder::Controller {
                check_limits([*speed_max_m_s, *turn_rate_max_rad_s], plan.limits_of(robot))?;
            }
            let command = |speed_m_s, turn_rate_rad_s| Command { speed_m_s, turn_rate_rad_s };
            let detected = command(*speed_m_s, *turn_rate_rad_s);
            let undetected = command(*undetected_m_s, *undetected_rad_s);
            let undetected = (!is_mirrored).then_some(undetected);
            let controller = controller::of_values(table, detected, undetected)?;
            if *key != transition_key(plan, robot) {
                return Err(format!("`{TRANSITION_KEY}` is not the one that was set"));
            }
            if !found_class.iter().eq(class.as_ref()) {
                return Err(format!("`{CLASS}` is not the one that was set"));
            }
            let reaction = if *is_constant { Reaction::Constant } else { Reaction::ToDetections };
            Ok(controller.digest_with(reaction))
        }
        other => Err(format!(
            "{} are {other:?}, expected doubles, `{MIRRORED}` and `{CONSTANT}` as bools, `{LEASE}` and \
             `{TABLE}` as strings, and `{TRANSITION_KEY}` as an integer",
            names.join(", ")
        )),
    }
}

/// Reads what a robot's gate is set to; `None` if its node is not ours: nothing offers it
/// parameters, it does not answer, or it does not have those of a gate.
pub async fn read_gate(client: &ParameterClient<'_>, robot: &str) -> Option<GateSettings> {
    let node = format!("/{robot}/{}", gate::NODE);
    // A gate that publishes its status was discovered, and its services are discovered with it.
    let start = Instant::now();
    while !client.is_offered_by(&node) {
        if start.elapsed() >= NODE_TIMEOUT {
            return None;
        }
        tokio::time::sleep(POLL_PERIOD).await;
    }
    let names = gate::names();
    let values = client.get_known(&node, &names).await.ok()?;
    let known = names.into_iter().zip(values);
    let settings: GateSettings =
        known.filter_map(|(name, found)| Some((name.to_owned(), value(found?)))).collect();
    settings.contains_key(gate::DETECTION_THRESHOLD).then_some(settings)
}

/// How often the services of a gate are looked for.
const POLL_PERIOD: Duration = Duration::from_millis(20);

/// A value as records keep it; what a gate of ours has none of, as text.
fn value(found: ParameterValue) -> Value {
    match found {
        ParameterValue::Bool(value) => Value::Bool(value),
        ParameterValue::Integer(value) => Value::Integer(value),
        ParameterValue::Double(value) if value.is_finite() => Value::Double(value),
        ParameterValue::String(value) => Value::Text(value),
        other => Value::Text(other.to_string()),
    }
}

fn check_lease(found: &str, expected: LeaseHolder) -> Result<(), String> {
    let expected = expected.key();
    if found == expected {
        return Ok(());
    }
    Err(format!(
        "`{LEASE}` is `{found}`, expected `{expected}` as in the fleet file: start its controller with \
         `-p {LEASE}:={expected}`"
    ))
}

/// Where nothing of ours is in front of the wheels, its controller alone keeps to a robot's limits.
fn check_limits(found: [f64; 2], limits: [f64; 2]) -> Result<(), String> {
    for ((name, unit), (found, limit)) in [(SPEED_MAX, "m/s"), (TURN_RATE_MAX, "rad/s")]
        .into_iter()
        .zip(found.into_iter().zip(limits))
    {
        if found > limit {
            return Err(format!(
                "`{name}` is {found} {unit}, expected at most {limit} {unit}, the limit of the robot's \
                 profile, because no gate of ours keeps to it: start its controller with \
                 `-p {name}:={limit:?}`"
            ));
        }
    }
    Ok(())
}

fn controller(robot: &str) -> String {
    format!("/{robot}/{}", controller::NODE)
}

/// Key of the draws of a robot's transitions in the run, as a parameter.
fn transition_key(plan: &Plan, robot: &str) -> ParameterValue {
    let record = &plan.record;
    let place = record.robots.iter().position(|name| name == robot).unwrap_or_default();
    let seed = Seed { seed: record.seed, replicate: record.replicate };
    let key = state_machine::transition_key(seed, record.conditions.controller.digest(), place);
    ParameterValue::Integer(key.bits().cast_signed())
}

/// The class of a robot in a world that has some, as a parameter.
fn class(plan: &Plan, robot: &str) -> Option<ParameterValue> {
    let record = &plan.record;
    let place = record.robots.iter().position(|name| name == robot)?;
    let class = record.conditions.world.class_names_of(record.robots.len())[place]?;
    Some(ParameterValue::String(class.to_owned()))
}

/// The table of a controller with states; empty for any other.
fn table(controller: &Controller) -> ParameterValue {
    ParameterValue::String(match controller {
        Controller::Parameters(_) => String::new(),
        Controller::Machine(machine) => machine.to_json(),
    })
}

fn of_controller(plan: &Plan, robot: &str) -> Vec<(String, ParameterValue)> {
    let set = &plan.record.conditions.controller;
    // Beside a table, speeds and turning rates are nobody's.
    let standing = ControllerParameters::mirrored(0.0, 0.0);
    let controller = set.parameters().unwrap_or(standing);
    let [detected, undetected] = controller.commands();
    let lockstep = plan.record.time == Time::Lockstep;
    let double = |name: &str, value| (name.to_owned(), ParameterValue::Double(value));
    let mut values = vec![
        double(SPEED, detected.speed_m_s),
        double(TURN_RATE, detected.turn_rate_rad_s),
        (MIRRORED.to_owned(), ParameterValue::Bool(controller.undetected.is_none())),
        double(UNDETECTED_SPEED, undetected.speed_m_s),
        double(UNDETECTED_TURN_RATE, undetected.turn_rate_rad_s),
        (STAMP_FROM_CLOCK.to_owned(), ParameterValue::Bool(lockstep)),
        (TABLE.to_owned(), table(set)),
        (TRANSITION_KEY.to_owned(), transition_key(plan, robot)),
    ];
    values.extend(class(plan, robot).map(|class| (CLASS.to_owned(), class)));
    values
}

fn of_simulator(plan: &Plan) -> Vec<(String, ParameterValue)> {
    let record = &plan.record;
    let conditions = serde_json::to_string(&record.conditions).expect("conditions are plain data");
    let integer = |value: u64| ParameterValue::Integer(value.cast_signed());
    vec![
        (simulator::CONDITIONS.to_owned(), ParameterValue::String(conditions)),
        (simulator::SEED.to_owned(), integer(record.seed)),
        (simulator::REPLICATE.to_owned(), integer(record.replicate)),
        (simulator::STEPS.to_owned(), integer(plan.steps())),
        (simulator::TIME.to_owned(), ParameterValue::String(record.time.key().to_owned())),
        (simulator::ROBOTS.to_owned(), ParameterValue::StringArray(record.robots.clone())),
        (
            simulator::TRACKED_BY.to_owned(),
            ParameterValue::String(plan.tracked_by().key().to_owned()),
        ),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_controller_without_a_gate_keeps_to_the_limits_of_the_profile() {
        assert_eq!(check_limits([0.1, 2.5], [0.1, 2.5]), Ok(()));

        let refused = check_limits([0.3, 2.5], [0.1, 2.5]).unwrap_err();

        assert!(
            refused.starts_with("`speed_max` is 0.3 m/s, expected at most 0.1 m/s"),
            "{refused}"
        );
        assert!(refused.ends_with("`-p speed_max:=0.1`"), "{refused}");
        assert!(
            check_limits([0.1, 3.0], [0.1, 2.0]).unwrap_err().ends_with("`-p turn_rate_max:=2.0`")
        );
    }
}
