//! The parameters of the simulator: which world, from which seed, for how many steps.

use rsrs_core::conditions::Conditions;
use rsrs_ros::parameters::{
    Descriptor, NodeParameters, ParameterKind, ParameterServer, ParameterValue,
};
use rsrs_sim::draw::Seed;
use rsrs_sim::placement::PlacementError;
use rsrs_sim::world::World;

/// Name of the simulator's node.
pub const NODE: &str = "simulator";
const FULL_NAME: &str = "/simulator";

const CONDITIONS: &str = "conditions";
const SEED: &str = "seed";
const REPLICATE: &str = "replicate";
const STEPS: &str = "steps";

/// Why parameters do not make a world.
#[derive(Debug, thiserror::Error)]
pub enum WorldError {
    /// The conditions are not those of an experiment.
    #[error("`{CONDITIONS}` is not an experiment's: {source}")]
    Conditions {
        /// Where and why.
        source: serde_json::Error,
    },
    /// The control period is no time that a world can step by.
    #[error("the control period is {found_s} s, expected above 0 and at most 60 s")]
    Period {
        /// The period, in seconds.
        found_s: f64,
    },
    /// The simulator stands in for fewer robots than the conditions ask for.
    #[error("the conditions ask for {asked} robots, this simulator stands in for {hosted}")]
    TooManyRobots {
        /// Robots asked for.
        asked: usize,
        /// Robots there are.
        hosted: usize,
    },
    /// The robots do not fit where they are to start.
    #[error(transparent)]
    Placement(#[from] PlacementError),
}

/// A world as the parameters ask for it.
pub struct Wanted {
    /// The placed world.
    pub world: World,
    /// Steps that it is to make.
    pub steps: u64,
    /// Length of one step, in nanoseconds.
    pub period_ns: u64,
}

/// Declares the simulator's parameters: no world yet.
pub fn declare() -> NodeParameters {
    let conditions = "Conditions of the experiment, as JSON; empty is no world.";
    let integers = [
        (SEED, "Seed of the world, below 2^63."),
        (REPLICATE, "Number of the replicate, from 0."),
        (STEPS, "Steps to make."),
    ];
    let mut parameters = vec![(
        Descriptor::new(CONDITIONS, ParameterKind::String, conditions),
        ParameterValue::String(String::new()),
    )];
    parameters.extend(integers.map(|(name, description)| {
        let mut descriptor = Descriptor::new(name, ParameterKind::Integer, description);
        #[expect(clippy::cast_precision_loss, reason = "a limit that no run comes near")]
        let most = i64::MAX as f64;
        descriptor.range = Some((0.0, most));
        (descriptor, ParameterValue::Integer(0))
    }));
    NodeParameters { namespace: "/".to_owned(), name: NODE.to_owned(), parameters }
}

/// Whether a change would make a world, for the answer to whoever sets it.
///
/// # Errors
///
/// The reason, for people.
pub fn check(changes: &[(String, ParameterValue)], hosted: usize) -> Result<(), String> {
    let text = changes.iter().find_map(|(name, value)| match value {
        ParameterValue::String(text) if name == CONDITIONS && !text.is_empty() => Some(text),
        _ => None,
    });
    match text {
        None => Ok(()),
        Some(text) => read_conditions(text, hosted).map(drop).map_err(|error| error.to_string()),
    }
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
    let text = match server.get(FULL_NAME, CONDITIONS) {
        Some(ParameterValue::String(text)) if !text.is_empty() => text,
        _ => return Ok(None),
    };
    let integer = |name| match server.get(FULL_NAME, name) {
        Some(ParameterValue::Integer(value)) => value.unsigned_abs(),
        other => unreachable!("{name} was declared as an integer, found {other:?}"),
    };
    let conditions = read_conditions(&text, hosted)?;
    let seed = Seed { seed: integer(SEED), replicate: integer(REPLICATE) };
    Ok(Some(Wanted {
        world: World::new(&conditions, seed)?,
        steps: integer(STEPS),
        period_ns: period_ns(&conditions),
    }))
}

/// The period as a whole number of nanoseconds: the stamps of a run are multiples of it.
fn period_ns(conditions: &Conditions) -> u64 {
    let period = std::time::Duration::from_secs_f64(conditions.period_s);
    u64::try_from(period.as_nanos()).expect("conditions allow at most 60 s")
}

fn read_conditions(text: &str, hosted: usize) -> Result<Conditions, WorldError> {
    let conditions: Conditions =
        serde_json::from_str(text).map_err(|source| WorldError::Conditions { source })?;
    if !(conditions.period_s > 0.0 && conditions.period_s <= 60.0) {
        return Err(WorldError::Period { found_s: conditions.period_s });
    }
    if conditions.robots > hosted {
        return Err(WorldError::TooManyRobots { asked: conditions.robots, hosted });
    }
    Ok(conditions)
}
