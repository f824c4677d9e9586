//! The parameters of a controller: ROS names, with unit and range in their descriptors.

use std::collections::BTreeMap;

use rsrs_core::draw::Key;
use rsrs_core::robot::controller::state_machine::StateMachine;
use rsrs_core::robot::controller::{Command, Controller, ControllerParameters, Reaction};
use rsrs_core::robot::profile::PERIOD_BOUNDS_S;
use rsrs_fleet::controller::{Controller as Node, Settings, Stamp};
use rsrs_fleet::parameters::controller::{
    CLASS, CMD_VEL_TYPE, CONSTANT, LEASE, LEASE_CONTROLLER, LEASE_GATE, MIRRORED, NODE, PERIOD,
    SPEED, SPEED_MAX, STAMP_FROM_CLOCK, TABLE, TRANSITION_KEY, TURN_RATE, TURN_RATE_MAX,
    UNDETECTED_SPEED, UNDETECTED_TURN_RATE,
};
use rsrs_fleet::timing::{Transport, command_timeout};
use rsrs_ros::parameters::{
    Descriptor, NodeParameters, ParameterKind, ParameterServer, ParameterValue,
};

/// The names of all parameters of a controller.
pub const NAMES: [&str; 15] = [
    SPEED,
    UNDETECTED_SPEED,
    SPEED_MAX,
    TURN_RATE,
    UNDETECTED_TURN_RATE,
    TURN_RATE_MAX,
    MIRRORED,
    STAMP_FROM_CLOCK,
    CMD_VEL_TYPE,
    CONSTANT,
    LEASE,
    PERIOD,
    TABLE,
    TRANSITION_KEY,
    CLASS,
];

/// Greatest safe values where no start value is given: those of the Flockbot.
const LIMITS: [(&str, f64); 2] = [(SPEED_MAX, 0.30), (TURN_RATE_MAX, 2.5)];

/// A start value that does not fit its parameter.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum StartValueError {
    /// There is no such parameter.
    #[error("/{robot}/{NODE} has no parameter `{name}`")]
    Unknown {
        /// The robot.
        robot: String,
        /// The name.
        name: String,
    },
    /// It has another type or lies outside its range.
    #[error("/{robot}/{NODE}: `{name}` is {found}, expected {expected}")]
    NotAllowed {
        /// The robot.
        robot: String,
        /// The name.
        name: &'static str,
        /// The value.
        found: ParameterValue,
        /// What it may be.
        expected: String,
    },
}

/// Declares the parameters of a robot's controller, with the values that the command line or a
/// parameter file has `given` them. A robot that is not configured stands: speed and turning rate
/// start at 0.
pub fn declare(
    robot: &str,
    mut given: BTreeMap<String, ParameterValue>,
) -> Result<NodeParameters, StartValueError> {
    let mut parameters = Vec::new();
    for ((limit, default), commanded) in LIMITS.into_iter().zip([
        [
            (SPEED, "Forward speed v where something is detected, in m/s."),
            (UNDETECTED_SPEED, "Forward speed where nothing is, in m/s, unless mirrored."),
        ],
        [
            (TURN_RATE, "Turning rate where something is detected, in rad/s; left is positive."),
            (UNDETECTED_TURN_RATE, "Turning rate where nothing is, in rad/s, unless mirrored."),
        ],
    ]) {
        let most = number(robot, limit, given.remove(limit), default, [0.0, f64::MAX])?;
        for (name, description) in commanded {
            let value = number(robot, name, given.remove(name), 0.0, [-most, most])?;
            let mut descriptor = Descriptor::new(name, ParameterKind::Double, description);
            descriptor.range = Some((-most, most));
            parameters.push((descriptor, ParameterValue::Double(value)));
        }
        let mut descriptor =
            Descriptor::new(limit, ParameterKind::Double, "Greatest safe value, same unit.");
        descriptor.read_only = true;
        parameters.push((descriptor, ParameterValue::Double(most)));
    }
    for (name, default, description) in [
        (
            MIRRORED,
            true,
            "Whether it drives at the same speed and turns the other way where nothing is detected, as \
             the milling controller does.",
        ),
        (
            STAMP_FROM_CLOCK,
            false,
            "Whether commands carry the simulator's clock, one message of it for each detection (lockstep), \
             or the wall's.",
        ),
    ] {
        let value = match given.remove(name) {
            None => default,
            Some(ParameterValue::Bool(value)) => value,
            Some(found) => return not_allowed(robot, name, found, "true or false"),
        };
        let descriptor = Descriptor::new(name, ParameterKind::Bool, description);
        parameters.push((descriptor, ParameterValue::Bool(value)));
    }
    parameters.push(cmd_vel_type(robot, given.remove(CMD_VEL_TYPE))?);
    parameters.push(constant(robot, given.remove(CONSTANT))?);
    parameters.push(lease(robot, given.remove(LEASE))?);
    parameters.push(period(robot, given.remove(PERIOD))?);
    parameters.extend(of_table(robot, [given.remove(TABLE), given.remove(TRANSITION_KEY)])?);
    parameters.push(class(robot, given.remove(CLASS))?);
    match given.into_keys().next() {
        Some(name) => Err(StartValueError::Unknown { robot: robot.to_owned(), name }),
        None => {
            Ok(NodeParameters { namespace: format!("/{robot}"), name: NODE.to_owned(), parameters })
        }
    }
}

fn cmd_vel_type(
    robot: &str,
    given: Option<ParameterValue>,
) -> Result<(Descriptor, ParameterValue), StartValueError> {
    let given = given.unwrap_or_else(|| ParameterValue::String("twist_stamped".to_owned()));
    let is_known = matches!(&given, ParameterValue::String(kind)
        if kind == "twist" || kind == "twist_stamped");
    if !is_known {
        return not_allowed(robot, CMD_VEL_TYPE, given, "`twist` or `twist_stamped`");
    }
    let description = "Type of cmd_vel: twist_stamped, or twist for Humble's drivers.";
    let mut descriptor = Descriptor::new(CMD_VEL_TYPE, ParameterKind::String, description);
    descriptor.read_only = true;
    Ok((descriptor, given))
}

fn lease(
    robot: &str,
    given: Option<ParameterValue>,
) -> Result<(Descriptor, ParameterValue), StartValueError> {
    let given = given.unwrap_or_else(|| ParameterValue::String(LEASE_GATE.to_owned()));
    let is_known = matches!(&given, ParameterValue::String(holder)
        if holder == LEASE_GATE || holder == LEASE_CONTROLLER);
    if !is_known {
        return not_allowed(robot, LEASE, given, "`gate` or `controller`");
    }
    let description = "Who holds the lease: the gate in front of the robot's wheels, or, if it has none, \
                       this controller, which then sends zero without one.";
    let mut descriptor = Descriptor::new(LEASE, ParameterKind::String, description);
    descriptor.read_only = true;
    Ok((descriptor, given))
}

fn period(
    robot: &str,
    given: Option<ParameterValue>,
) -> Result<(Descriptor, ParameterValue), StartValueError> {
    let value = match given {
        None => 0.13,
        Some(ParameterValue::Double(value)) if value > 0.0 && value <= PERIOD_BOUNDS_S[1] => value,
        Some(found) => {
            return not_allowed(robot, PERIOD, found, "a double above 0 and at most 2");
        }
    };
    let description = "Interval of the robot's detections, in s; without one for 2.5 of them, and at \
                       least 0.3 s, a controller that holds the lease sends zero.";
    let mut descriptor = Descriptor::new(PERIOD, ParameterKind::Double, description);
    descriptor.read_only = true;
    Ok((descriptor, ParameterValue::Double(value)))
}

/// The table of a controller with states, and the key of its draws: none until a runner sets them.
fn of_table(
    robot: &str,
    [table, key]: [Option<ParameterValue>; 2],
) -> Result<[(Descriptor, ParameterValue); 2], StartValueError> {
    let is_none = |text: &ParameterValue| *text == ParameterValue::String(String::new());
    if let Some(found) = table.filter(|text| !is_none(text)) {
        return not_allowed(robot, TABLE, found, "none at the start: a runner sets it");
    }
    let key = key.unwrap_or(ParameterValue::Integer(0));
    if !matches!(key, ParameterValue::Integer(_)) {
        return not_allowed(robot, TRANSITION_KEY, key, "an integer");
    }
    let text = "Table of a controller with states, as JSON, in place of speeds and turning rates; empty \
                for none.";
    let draws = "Key of the draws of the table's transitions, of one robot in one run.";
    Ok([
        (
            Descriptor::new(TABLE, ParameterKind::String, text),
            ParameterValue::String(String::new()),
        ),
        (Descriptor::new(TRANSITION_KEY, ParameterKind::Integer, draws), key),
    ])
}

/// The class of the robot: none until a runner sets it.
fn class(
    robot: &str,
    given: Option<ParameterValue>,
) -> Result<(Descriptor, ParameterValue), StartValueError> {
    let given = given.unwrap_or_else(|| ParameterValue::String(String::new()));
    if !matches!(given, ParameterValue::String(_)) {
        return not_allowed(robot, CLASS, given, "a name");
    }
    let text = "Class of the robot, by which the table has its start; empty for none.";
    Ok((Descriptor::new(CLASS, ParameterKind::String, text), given))
}

/// Refuses a table that cannot run, or commands more than the node's limits: `speed_max` and
/// `turn_rate_max`.
pub fn check_table(
    changes: &[(String, ParameterValue)],
    [speed_max_m_s, turn_rate_max_rad_s]: [f64; 2],
) -> Result<(), String> {
    let set = changes.iter().find(|(name, _)| name == TABLE).map(|(_, value)| value);
    let Some(machine) = set.and_then(machine) else { return Ok(()) };
    let fastest = Controller::Machine(machine?).fastest();
    for (found, most, unit) in [
        (fastest.speed_m_s, speed_max_m_s, "m/s"),
        (fastest.turn_rate_rad_s, turn_rate_max_rad_s, "rad/s"),
    ] {
        if found > most {
            return Err(format!(
                "`{TABLE}` commands {found} {unit}, expected at most {most} {unit}"
            ));
        }
    }
    Ok(())
}

/// The greatest commands of a node, as it was declared.
pub fn limits(declared: &NodeParameters) -> [f64; 2] {
    [SPEED_MAX, TURN_RATE_MAX].map(|name| {
        let is_it = |(descriptor, _): &&(Descriptor, ParameterValue)| descriptor.name == name;
        match declared.parameters.iter().find(is_it) {
            Some((_, ParameterValue::Double(most))) => *most,
            other => unreachable!("{name} was declared as a double, found {other:?}"),
        }
    })
}

/// The machine of a table; `None` where there is no table.
fn machine(table: &ParameterValue) -> Option<Result<StateMachine, String>> {
    match table {
        ParameterValue::String(text) if !text.is_empty() => Some(
            StateMachine::from_json(text)
                .map_err(|error| format!("`{TABLE}` is no table: {error}")),
        ),
        _ => None,
    }
}

fn constant(
    robot: &str,
    given: Option<ParameterValue>,
) -> Result<(Descriptor, ParameterValue), StartValueError> {
    let given = given.unwrap_or(ParameterValue::Bool(false));
    if !matches!(given, ParameterValue::Bool(_)) {
        return not_allowed(robot, CONSTANT, given, "true or false");
    }
    let description =
        "Whether it turns counterclockwise whatever is detected: for measuring robots.";
    let mut descriptor = Descriptor::new(CONSTANT, ParameterKind::Bool, description);
    descriptor.read_only = true;
    Ok((descriptor, given))
}

/// A number within a range; `default` where none is given.
fn number(
    robot: &str,
    name: &'static str,
    given: Option<ParameterValue>,
    default: f64,
    [least, most]: [f64; 2],
) -> Result<f64, StartValueError> {
    match given {
        None => Ok(default),
        Some(ParameterValue::Double(value)) if (least..=most).contains(&value) => Ok(value),
        Some(found) => {
            let range = if most < f64::MAX {
                format!("a double from {least} to {most}")
            } else {
                "a double, 0 or more".to_owned()
            };
            not_allowed(robot, name, found, &range)
        }
    }
}

fn not_allowed<T>(
    robot: &str,
    name: &'static str,
    found: ParameterValue,
    expected: &str,
) -> Result<T, StartValueError> {
    let (robot, expected) = (robot.to_owned(), expected.to_owned());
    Err(StartValueError::NotAllowed { robot, name, found, expected })
}

/// Reads what a controller is set to now.
///
/// # Panics
///
/// If the node's parameters were not declared by [`declare`].
pub fn settings(server: &ParameterServer, node: &str) -> Settings {
    let double = |name| match server.get(node, name) {
        Some(ParameterValue::Double(value)) => value,
        other => unreachable!("{name} was declared as a double, found {other:?}"),
    };
    let is_set = |name| server.get(node, name) == Some(ParameterValue::Bool(true));
    let from_clock = is_set(STAMP_FROM_CLOCK);
    let command =
        |speed, turn_rate| Command { speed_m_s: double(speed), turn_rate_rad_s: double(turn_rate) };
    let detected = command(SPEED, TURN_RATE);
    let table = server.get(node, TABLE).as_ref().and_then(machine);
    let controller = if let Some(machine) = table {
        Controller::Machine(machine.expect("a table is checked before it is set"))
    } else if is_set(MIRRORED) {
        ControllerParameters::mirrored(detected.speed_m_s, detected.turn_rate_rad_s).into()
    } else {
        ControllerParameters::of(detected, command(UNDETECTED_SPEED, UNDETECTED_TURN_RATE)).into()
    };
    let transition_key = match server.get(node, TRANSITION_KEY) {
        Some(ParameterValue::Integer(bits)) => Key::from_bits(bits.cast_unsigned()),
        other => unreachable!("{TRANSITION_KEY} was declared as an integer, found {other:?}"),
    };
    let start = match server.get(node, CLASS) {
        Some(ParameterValue::String(class)) => controller.start(Some(&class)),
        other => unreachable!("{CLASS} was declared as a string, found {other:?}"),
    };
    Settings {
        controller,
        transition_key,
        start,
        stamp: if from_clock { Stamp::Clock } else { Stamp::Wall },
        reaction: reaction(server, node),
    }
}

/// Whether a controller publishes stamped commands.
pub fn is_stamped(server: &ParameterServer, node: &str) -> bool {
    server.get(node, CMD_VEL_TYPE) != Some(ParameterValue::String("twist".to_owned()))
}

/// A controller of a robot, as its parameters define it.
///
/// # Panics
///
/// If the node's parameters were not declared by [`declare`].
pub fn controller(server: &ParameterServer, node: &str, robot: &str, transport: Transport) -> Node {
    let settings = settings(server, node);
    let period_s = match server.get(node, PERIOD) {
        Some(ParameterValue::Double(period_s)) => period_s,
        other => unreachable!("{PERIOD} was declared as a double, found {other:?}"),
    };
    if server.get(node, LEASE) == Some(ParameterValue::String(LEASE_CONTROLLER.to_owned())) {
        Node::holding_lease(robot, settings, command_timeout(period_s, transport))
    } else {
        Node::new(robot, settings)
    }
}

/// What a controller makes of its sensor.
pub fn reaction(server: &ParameterServer, node: &str) -> Reaction {
    if server.get(node, CONSTANT) == Some(ParameterValue::Bool(true)) {
        Reaction::Constant
    } else {
        Reaction::ToDetections
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn given(name: &str, value: ParameterValue) -> BTreeMap<String, ParameterValue> {
        BTreeMap::from([(name.to_owned(), value)])
    }

    #[test]
    fn a_speed_above_the_limit_is_refused_at_the_start() {
        let error = declare("robot_1", given("speed", ParameterValue::Double(0.5))).unwrap_err();

        assert!(error.to_string().contains("expected a double from -0.3 to 0.3"), "{error}");
    }

    #[test]
    fn an_integer_is_not_a_double() {
        assert!(declare("robot_1", given("speed", ParameterValue::Integer(0))).is_err());
    }

    #[test]
    fn an_unknown_parameter_is_named() {
        let error = declare("robot_1", given("sped", ParameterValue::Double(0.1))).unwrap_err();

        assert_eq!(error.to_string(), "/robot_1/controller has no parameter `sped`");
    }

    #[test]
    fn the_list_of_names_is_that_of_the_parameters() {
        let declared = declare("robot_1", BTreeMap::new()).unwrap();

        let names: Vec<_> = declared.parameters.iter().map(|(known, _)| &known.name).collect();
        assert_eq!(names, NAMES.iter().collect::<Vec<_>>());
    }

    #[test]
    fn nobody_else_can_hold_the_lease() {
        let nobody = ParameterValue::String("nobody".to_owned());

        let error = declare("robot_1", given("lease", nobody)).unwrap_err();

        assert!(error.to_string().contains("expected `gate` or `controller`"), "{error}");
    }

    #[test]
    fn a_table_that_cannot_run_or_commands_too_much_is_refused() {
        let check = |table: &str| {
            let table = ParameterValue::String(table.to_owned());
            check_table(&[(TABLE.to_owned(), table)], [0.3, 2.5])
        };
        let table = |state: &str, speed: f64| {
            format!(
                r#"{{"rows":[{{"state":"a","command":{{"speed_m_s":{speed},"turn_rate_rad_s":0.5}},
                "next":[{{"state":"{state}","probability":1.0,"after_periods":1}}]}}]}}"#
            )
        };

        assert_eq!(check(""), Ok(()));
        assert_eq!(check(&table("a", -0.3)), Ok(()));
        let refused = check(&table("b", 0.1)).unwrap_err();
        assert_eq!(refused, "`table` is no table: row 1: unknown state `b`; did you mean `a`?");
        let refused = check(&table("a", -0.4)).unwrap_err();
        assert_eq!(refused, "`table` commands 0.4 m/s, expected at most 0.3 m/s");
        assert!(check("{}").is_err());
        let at_start = given("table", ParameterValue::String("{}".to_owned()));
        assert!(declare("robot_1", at_start).is_err(), "no run has set it");
    }

    #[test]
    fn an_unknown_type_of_command_is_refused() {
        let kind = ParameterValue::String("ackermann".to_owned());

        assert!(declare("robot_1", given("cmd_vel_type", kind)).is_err());
    }
}
