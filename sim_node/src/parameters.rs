//! The parameters of the simulator: which world, from which seed, for how many steps, at what pace.

use std::collections::BTreeMap;
use std::time::Duration;

use rsrs_core::conditions::{Conditions, Impossible};
use rsrs_fleet::experiment::Time;
use rsrs_fleet::simulator::{Placed, placement_digest};
use rsrs_ros::parameters::{
    Descriptor, NodeParameters, ParameterKind, ParameterServer, ParameterValue,
};
use rsrs_sim::draw::Seed;
use rsrs_sim::placement::PlacementError;
use rsrs_sim::world::World;

/// Name of the simulator's node.
pub const NODE: &str = "simulator";
/// Its full name: it stands for no robot, so it has no namespace.
pub const FULL_NAME: &str = "/simulator";

const CONDITIONS: &str = "conditions";
const SEED: &str = "seed";
const REPLICATE: &str = "replicate";
const STEPS: &str = "steps";
const TIME: &str = "time";

/// The paces, as the parameter spells them.
const TIMES: [(&str, Time); 2] = [("lockstep", Time::Lockstep), ("real_time", Time::RealTime)];

/// The end of ROS's time, whose seconds have 32 bits.
const END: Duration = Duration::from_secs(i32::MAX.unsigned_abs() as u64);

/// Why parameters do not make a world.
#[derive(Debug, thiserror::Error)]
pub enum WorldError {
    /// There is no such parameter.
    #[error("{FULL_NAME} has no parameter `{name}`")]
    Unknown {
        /// The name.
        name: String,
    },
    /// The conditions are not those of an experiment.
    #[error("`{CONDITIONS}` is not an experiment's: {source}")]
    Unreadable {
        /// Where and why.
        source: serde_json::Error,
    },
    /// A number among the conditions cannot be.
    #[error("`{CONDITIONS}`: {source}")]
    Impossible {
        /// Which, and what it may be.
        #[from]
        source: Impossible,
    },
    /// The conditions ask for no robot, or for more than the simulator stands in for.
    #[error(
        "`{CONDITIONS}`: robots is {asked}, expected 1 to {hosted}, the robots of this simulator"
    )]
    Robots {
        /// Robots asked for.
        asked: usize,
        /// Robots there are.
        hosted: usize,
    },
    /// The run ends after the end of ROS's time.
    #[error("`{STEPS}` is {steps}, expected at most {most} with a period of {period_s} s")]
    TooLong {
        /// Steps asked for.
        steps: u64,
        /// Steps that ROS's time is long enough for.
        most: u64,
        /// Length of a step, in seconds.
        period_s: f64,
    },
    /// There is no such pace.
    #[error("`{TIME}` is `{found}`, expected `lockstep` or `real_time`")]
    Time {
        /// The value.
        found: String,
    },
    /// The robots do not fit where they are to start.
    #[error(transparent)]
    Placement(#[from] PlacementError),
}

/// A world as the parameters ask for it.
pub struct Wanted {
    /// The world, its robots at their start poses.
    pub world: World,
    /// What its pace has to know.
    pub placed: Placed,
}

/// Declares the simulator's parameters: no world, unless one is given at the start.
///
/// # Arguments
///
/// * `given` — start values by name, from the command line or a parameter file.
///
/// # Errors
///
/// [`WorldError::Unknown`]. Values are checked by whoever serves them, and by [`check`].
pub fn declare(mut given: BTreeMap<String, ParameterValue>) -> Result<NodeParameters, WorldError> {
    let text = |name, description| Descriptor::new(name, ParameterKind::String, description);
    let count = |name, description, most: f64| {
        let mut descriptor = Descriptor::new(name, ParameterKind::Integer, description);
        descriptor.range = Some((0.0, most));
        (descriptor, ParameterValue::Integer(0))
    };
    let time = Descriptor {
        additional_constraints: "lockstep or real_time".to_owned(),
        ..text(TIME, "Pace: by the controllers' answers, or by the clock on the wall.")
    };
    let mut parameters = vec![
        (
            text(CONDITIONS, "Conditions of the experiment, as JSON; empty is no world."),
            ParameterValue::String(String::new()),
        ),
        count(SEED, "Seed of the world, below 2^63.", i64::MAX as f64),
        count(REPLICATE, "Number of the replicate, from 0.", i64::MAX as f64),
        count(STEPS, "Steps to make in lockstep.", f64::from(u32::MAX)),
        (time, ParameterValue::String(TIMES[0].0.to_owned())),
    ];
    for (descriptor, value) in &mut parameters {
        if let Some(start) = given.remove(&descriptor.name) {
            *value = start;
        }
    }
    match given.into_keys().next() {
        Some(name) => Err(WorldError::Unknown { name }),
        None => Ok(NodeParameters { namespace: "/".to_owned(), name: NODE.to_owned(), parameters }),
    }
}

/// Whether values can make a world, as far as they tell without the others.
///
/// # Arguments
///
/// * `values` — by name; those that are missing stay as they are.
/// * `hosted` — how many robots the simulator stands in for.
///
/// # Errors
///
/// [`WorldError`], for the answer to whoever sets them.
pub fn check(values: &[(String, ParameterValue)], hosted: usize) -> Result<(), WorldError> {
    let mut conditions = None;
    let mut steps = 0;
    for (name, value) in values {
        match (name.as_str(), value) {
            (CONDITIONS, ParameterValue::String(text)) if !text.is_empty() => {
                conditions = Some(read_conditions(text, hosted)?);
            }
            (TIME, ParameterValue::String(text)) => drop(read_time(text)?),
            (STEPS, ParameterValue::Integer(value)) => steps = value.unsigned_abs(),
            _ => {}
        }
    }
    conditions.map_or(Ok(()), |conditions| check_length(&conditions, steps))
}

/// Makes the world that the parameters ask for.
///
/// # Returns
///
/// `None` while no conditions are set.
///
/// # Errors
///
/// [`WorldError`].
pub fn wanted(server: &ParameterServer, hosted: usize) -> Result<Option<Wanted>, WorldError> {
    let text = |name| match server.get(FULL_NAME, name) {
        Some(ParameterValue::String(text)) => text,
        other => unreachable!("{name} was declared as a string, found {other:?}"),
    };
    let integer = |name| match server.get(FULL_NAME, name) {
        Some(ParameterValue::Integer(value)) => value.unsigned_abs(),
        other => unreachable!("{name} was declared as an integer, found {other:?}"),
    };
    let conditions = text(CONDITIONS);
    if conditions.is_empty() {
        return Ok(None);
    }
    let conditions = read_conditions(&conditions, hosted)?;
    let (seed, replicate, steps) = (integer(SEED), integer(REPLICATE), integer(STEPS));
    check_length(&conditions, steps)?;
    let placed = Placed {
        digest: placement_digest(&conditions, seed, replicate, steps),
        n_robots: conditions.robots,
        steps,
        period_ns: period_ns(&conditions),
        time: read_time(&text(TIME))?,
    };
    let world = World::new(&conditions, Seed { seed, replicate })?;
    Ok(Some(Wanted { world, placed }))
}

/// The period as a whole number of nanoseconds: the stamps of a run are multiples of it.
fn period_ns(conditions: &Conditions) -> u64 {
    nanos(Duration::from_secs_f64(conditions.period_s))
}

fn nanos(duration: Duration) -> u64 {
    u64::try_from(duration.as_nanos()).expect("584 years are longer than any ROS time")
}

fn read_conditions(text: &str, hosted: usize) -> Result<Conditions, WorldError> {
    let conditions: Conditions =
        serde_json::from_str(text).map_err(|source| WorldError::Unreadable { source })?;
    conditions.check()?;
    let asked = conditions.robots;
    if (1..=hosted).contains(&asked) {
        Ok(conditions)
    } else {
        Err(WorldError::Robots { asked, hosted })
    }
}

/// Stamps are simulated times, which must fit ROS's 32-bit seconds.
fn check_length(conditions: &Conditions, steps: u64) -> Result<(), WorldError> {
    let most = nanos(END) / period_ns(conditions);
    if steps <= most {
        return Ok(());
    }
    Err(WorldError::TooLong { steps, most, period_s: conditions.period_s })
}

fn read_time(text: &str) -> Result<Time, WorldError> {
    TIMES
        .into_iter()
        .find_map(|(name, time)| (name == text).then_some(time))
        .ok_or_else(|| WorldError::Time { found: text.to_owned() })
}

#[cfg(test)]
mod tests {
    use rsrs_core::axis::Axis;
    use rsrs_core::conditions::Settings;
    use rsrs_core::profile::RobotProfile;

    use super::*;

    const FLOCKBOT: &str = include_str!("../../launch_configs/profiles/flockbot.yaml");

    fn conditions() -> Conditions {
        let profile = RobotProfile::parse("flockbot.yaml", FLOCKBOT).unwrap();
        let values = vec![(Axis::Speed, 0.15), (Axis::TurnRate, 0.75), (Axis::Robots, 3.0)];
        Conditions::resolve(&profile, &Settings { values, ..Settings::default() }).unwrap()
    }

    fn text(name: &str, value: &str) -> (String, ParameterValue) {
        (name.to_owned(), ParameterValue::String(value.to_owned()))
    }

    fn refusal(values: &[(String, ParameterValue)]) -> String {
        check(values, 3).unwrap_err().to_string()
    }

    #[test]
    fn conditions_that_make_a_world_are_taken() {
        let json = serde_json::to_string(&conditions()).unwrap();

        assert!(check(&[text(CONDITIONS, &json), text(TIME, "real_time")], 3).is_ok());
    }

    #[test]
    fn conditions_that_make_none_are_refused_by_name() {
        let json = |change: fn(&mut Conditions)| {
            let mut conditions = conditions();
            change(&mut conditions);
            text(CONDITIONS, &serde_json::to_string(&conditions).unwrap())
        };

        assert_eq!(
            refusal(&[json(|c| c.robot.radius_m = -0.075)]),
            "`conditions`: robot.radius_m is -0.075, expected a number from 0.000001 to 1000000"
        );
        assert_eq!(
            refusal(&[json(|c| c.robots = 4)]),
            "`conditions`: robots is 4, expected 1 to 3, the robots of this simulator"
        );
        assert!(refusal(&[json(|c| c.robots = 0)]).contains("robots is 0, expected 1 to 3"));
        assert!(refusal(&[text(CONDITIONS, "{}")]).contains("missing field `robots`"));
        assert_eq!(
            refusal(&[text(TIME, "fast")]),
            "`time` is `fast`, expected `lockstep` or `real_time`"
        );
        assert_eq!(
            refusal(&[
                json(|c| c.period_s = 60.0),
                (STEPS.to_owned(), ParameterValue::Integer(i64::from(u32::MAX)))
            ]),
            "`steps` is 4294967295, expected at most 35791394 with a period of 60 s"
        );
    }

    #[test]
    fn start_values_are_taken_and_unknown_ones_named() {
        let given = BTreeMap::from([text(TIME, "real_time")]);
        let declared = declare(given).unwrap();
        let misspelt = declare(BTreeMap::from([text("tim", "real_time")]));

        let values: Vec<_> = declared.parameters.iter().map(|(_, value)| value).collect();
        assert!(values.contains(&&ParameterValue::String("real_time".to_owned())));
        assert_eq!(misspelt.unwrap_err().to_string(), "/simulator has no parameter `tim`");
    }
}
