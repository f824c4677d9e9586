//! The parameters of a controller: ROS names, with unit and range in their descriptors.

use std::collections::BTreeMap;

use rsrs_core::bounds::Bounds;
use rsrs_core::draw::Key;
use rsrs_core::robot::controller::{Command, Reaction};
use rsrs_fleet::controller::{Controller as Node, Settings, Stamp};
use rsrs_fleet::fleet_file::{CmdVel, LeaseHolder};
use rsrs_fleet::parameters::controller::{
    CLASS, CMD_VEL_TYPE, CONSTANT, LEASE, MIRRORED, NODE, PERIOD, SPEED, SPEED_MAX,
    STAMP_FROM_CLOCK, TABLE, TRANSITION_KEY, TURN_RATE, TURN_RATE_MAX, UNDETECTED_SPEED,
    UNDETECTED_TURN_RATE, of_values,
};
use rsrs_fleet::parameters::gate::usual;
use rsrs_fleet::parameters::one_of;
use rsrs_fleet::timing::{Transport, command_timeout};
use rsrs_ros::parameters::{
    Descriptor, NodeParameters, ParameterKind as Kind, ParameterServer, ParameterValue as Value,
};

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
        name: String,
        /// The value.
        found: Value,
        /// What it may be.
        expected: String,
    },
}

/// Declares the parameters of a robot's controller, with the values that the command line or a
/// parameter file has `given` them. A robot that is not configured stands: speed and turning rate
/// start at 0.
pub fn declare(
    robot: &str,
    mut given: BTreeMap<String, Value>,
) -> Result<NodeParameters, StartValueError> {
    let mut take =
        |descriptor: Descriptor, usual, is_allowed: &dyn Fn(&_) -> bool, expected: &str| {
            let found = given.remove(&descriptor.name).unwrap_or(usual);
            if is_allowed(&found) {
                return Ok((descriptor, found));
            }
            let (robot, name, expected) = (robot.to_owned(), descriptor.name, expected.to_owned());
            Err(StartValueError::NotAllowed { robot, name, found, expected })
        };
    let mut parameters = Vec::new();
    for (limit, commanded) in [SPEED_MAX, TURN_RATE_MAX].into_iter().zip([
        [
            (SPEED, "Forward speed v where something is detected, in m/s."),
            (UNDETECTED_SPEED, "Forward speed where nothing is, in m/s, unless mirrored."),
        ],
        [
            (TURN_RATE, "Turning rate where something is detected, in rad/s; left is positive."),
            (UNDETECTED_TURN_RATE, "Turning rate where nothing is, in rad/s, unless mirrored."),
        ],
    ]) {
        let is_limit =
            |it: &_| matches!(it, Value::Double(most) if (0.0..=f64::MAX).contains(most));
        let usual = usual(limit);
        let limit = Descriptor::new(limit, Kind::Double, "Greatest safe value, same unit.");
        let limit =
            take(limit.read_only(), Value::Double(usual), &is_limit, "a double, 0 or more")?;
        let Value::Double(most) = limit.1 else { unreachable!("it is a limit") };
        let is_within = |it: &_| matches!(it, Value::Double(it) if (-most..=most).contains(it));
        let range = format!("a double from {} to {most}", -most);
        for (name, description) in commanded {
            let descriptor = Descriptor::new(name, Kind::Double, description).within(-most, most);
            parameters.push(take(descriptor, Value::Double(0.0), &is_within, &range)?);
        }
        parameters.push(limit);
    }
    let is_bool = |it: &_| matches!(it, Value::Bool(_));
    let is_text = |it: &_| matches!(it, Value::String(_));
    let is_integer = |it: &_| matches!(it, Value::Integer(_));
    let is_period = |it: &_| matches!(it, Value::Double(it) if Bounds::PERIOD.contains(*it));
    let range_s = format!("a double {}", Bounds::PERIOD);
    let text = |text: &str| Value::String(text.to_owned());
    let mirrored = "Whether it drives at the same speed and turns the other way where nothing is detected, \
                    as the milling controller does.";
    let mirrored = Descriptor::new(MIRRORED, Kind::Bool, mirrored);
    let stamp = "Whether commands carry the simulator's clock, one message of it for each detection \
                 (lockstep), or the wall's.";
    let stamp = Descriptor::new(STAMP_FROM_CLOCK, Kind::Bool, stamp);
    let cmd_vel = "Type of cmd_vel; drivers of Humble take twist.";
    let cmd_vels = one_of(&CmdVel::ALL.map(CmdVel::key));
    let cmd_vel = Descriptor::new(CMD_VEL_TYPE, Kind::String, cmd_vel);
    let cmd_vel = cmd_vel.limited_to(&cmd_vels).read_only();
    let is_cmd_vel = |it: &_| CmdVel::ALL.map(|it| text(it.key())).contains(it);
    let constant = "Whether it turns counterclockwise whatever is detected: for measuring robots.";
    let constant = Descriptor::new(CONSTANT, Kind::Bool, constant).read_only();
    let lease = "Who holds the lease: the gate in front of the robot's wheels, or, if it has none, \
                 this controller, which then sends zero without one.";
    let holders = one_of(&LeaseHolder::ALL.map(LeaseHolder::key));
    let lease = Descriptor::new(LEASE, Kind::String, lease).limited_to(&holders).read_only();
    let is_lease = |it: &_| LeaseHolder::ALL.map(|it| text(it.key())).contains(it);
    let period = "Interval of the robot's detections, in s; without one for 2.5 of them, and at \
                  least 0.3 s, a controller that holds the lease sends zero.";
    let period = Descriptor::new(PERIOD, Kind::Double, period).read_only();
    let table = "Table of a controller with states, as JSON, in place of speeds and turning rates; \
                 empty for none.";
    let table = Descriptor::new(TABLE, Kind::String, table);
    let none_yet = "none at the start: a runner sets it";
    let key = "Key of the draws of the table's transitions, of one robot in one run.";
    let key = Descriptor::new(TRANSITION_KEY, Kind::Integer, key);
    let class = "Class of the robot, by which the table has its start; empty for none.";
    let class = Descriptor::new(CLASS, Kind::String, class);
    parameters.extend([
        take(mirrored, Value::Bool(true), &is_bool, "true or false")?,
        take(stamp, Value::Bool(false), &is_bool, "true or false")?,
        take(cmd_vel, text(CmdVel::default().key()), &is_cmd_vel, &cmd_vels)?,
        take(constant, Value::Bool(false), &is_bool, "true or false")?,
        take(lease, text(LeaseHolder::default().key()), &is_lease, &holders)?,
        take(period, Value::Double(usual(PERIOD)), &is_period, &range_s)?,
        take(table, text(""), &|it| *it == text(""), none_yet)?,
        take(key, Value::Integer(0), &is_integer, "an integer")?,
        take(class, text(""), &is_text, "a name")?,
    ]);
    match given.into_keys().next() {
        Some(name) => Err(StartValueError::Unknown { robot: robot.to_owned(), name }),
        None => {
            Ok(NodeParameters { namespace: format!("/{robot}"), name: NODE.to_owned(), parameters })
        }
    }
}

/// The names of all parameters of a controller.
#[expect(clippy::missing_panics_doc, reason = "the usual values are allowed")]
pub fn names() -> Vec<String> {
    let declared = declare("", BTreeMap::new()).expect("the usual values are allowed");
    declared.parameters.into_iter().map(|(descriptor, _)| descriptor.name).collect()
}

/// Refuses a table that cannot run, or commands more than the node's limits: `speed_max` and
/// `turn_rate_max`.
pub fn check_table(
    changes: &[(String, Value)],
    [speed_max_m_s, turn_rate_max_rad_s]: [f64; 2],
) -> Result<(), String> {
    let set = changes.iter().find(|(name, _)| name == TABLE);
    let Some((_, Value::String(table))) = set else { return Ok(()) };
    let fastest = of_values(table, Command::STOP, None)?.fastest();
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
        let is_it = |(descriptor, _): &&(Descriptor, Value)| descriptor.name == name;
        match declared.parameters.iter().find(is_it) {
            Some((_, Value::Double(most))) => *most,
            other => unreachable!("{name} was declared as a double, found {other:?}"),
        }
    })
}

/// Reads what a controller is set to now.
///
/// # Panics
///
/// If the node's parameters were not declared by [`declare`].
pub fn settings(server: &ParameterServer, node: &str) -> Settings {
    let double = |name| server.double(node, name);
    let is_set = |name| server.get(node, name) == Some(Value::Bool(true));
    let from_clock = is_set(STAMP_FROM_CLOCK);
    let command =
        |speed, turn_rate| Command { speed_m_s: double(speed), turn_rate_rad_s: double(turn_rate) };
    let undetected = (!is_set(MIRRORED)).then(|| command(UNDETECTED_SPEED, UNDETECTED_TURN_RATE));
    let controller = of_values(&server.text(node, TABLE), command(SPEED, TURN_RATE), undetected)
        .expect("a table is checked before it is set");
    Settings {
        transition_key: Key::from_bits(server.integer(node, TRANSITION_KEY).cast_unsigned()),
        start: controller.start(Some(&server.text(node, CLASS))),
        controller,
        stamp: if from_clock { Stamp::Clock } else { Stamp::Wall },
        reaction: reaction(server, node),
    }
}

/// As what a controller publishes commands.
pub fn cmd_vel(server: &ParameterServer, node: &str) -> CmdVel {
    CmdVel::from_key(&server.text(node, CMD_VEL_TYPE)).expect("it was declared to be one")
}

/// A controller of a robot, as its parameters define it.
///
/// # Panics
///
/// If the node's parameters were not declared by [`declare`].
pub fn controller(server: &ParameterServer, node: &str, robot: &str, transport: Transport) -> Node {
    let settings = settings(server, node);
    let period_s = server.double(node, PERIOD);
    if server.text(node, LEASE) == LeaseHolder::Controller.key() {
        Node::holding_lease(robot, settings, command_timeout(period_s, transport))
    } else {
        Node::new(robot, settings)
    }
}

/// What a controller makes of its sensor.
pub fn reaction(server: &ParameterServer, node: &str) -> Reaction {
    if server.get(node, CONSTANT) == Some(Value::Bool(true)) {
        Reaction::Constant
    } else {
        Reaction::ToDetections
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn given(name: &str, value: Value) -> BTreeMap<String, Value> {
        BTreeMap::from([(name.to_owned(), value)])
    }

    #[test]
    fn start_values_that_cannot_be_are_refused_by_name() {
        let text = |text: &str| Value::String(text.to_owned());
        for (name, value, expected) in [
            ("speed", Value::Double(0.5), "expected a double from -0.3 to 0.3"),
            ("speed", Value::Integer(0), "speed"),
            ("sped", Value::Double(0.1), "/robot_1/controller has no parameter `sped`"),
            ("lease", text("nobody"), "expected gate or controller"),
            ("cmd_vel_type", text("ackermann"), "cmd_vel_type"),
        ] {
            let error = declare("robot_1", given(name, value)).unwrap_err().to_string();

            assert!(error.contains(expected), "{error}");
        }
    }

    #[test]
    fn a_table_that_cannot_run_or_commands_too_much_is_refused() {
        let check = |table: &str| {
            let table = Value::String(table.to_owned());
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
        let at_start = given("table", Value::String("{}".to_owned()));
        assert!(declare("robot_1", at_start).is_err(), "no run has set it");
    }
}
