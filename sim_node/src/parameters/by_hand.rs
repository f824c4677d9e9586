//! A world by plain parameters, for who types them: `ros2 param set` cannot set JSON.

use std::collections::BTreeMap;
use std::path::Path;

use rsrs_core::conditions::{Conditions, ConditionsError, Settings};
use rsrs_core::quantity::{Cell, CellError};
use rsrs_core::robot::profile::RobotProfile;
use rsrs_ros::parameters::{Descriptor, ParameterKind, ParameterServer, ParameterValue};

use super::{CONDITIONS, FULL_NAME};

/// The cell that is placed.
pub const CELL: &str = "cell";
/// The file that defines the robots.
pub const PROFILE: &str = "profile";

const FLOCKBOT: &str = include_str!("../../../launch_configs/profiles/flockbot.yaml");

/// Why a cell makes no world.
#[derive(Debug, thiserror::Error)]
pub enum CellRefused {
    /// It is no cell.
    #[error("`{CELL}` is `{found}`, expected values such as `speed_m_s=0.15,robots=3`")]
    Syntax {
        /// The value.
        found: String,
        /// What is wrong with it.
        #[source]
        source: CellError,
    },
    /// Robots of this profile have no such cell.
    #[error("`{CELL}`: {source}")]
    Impossible {
        /// Why.
        #[from]
        source: ConditionsError,
    },
}

/// The parameters, with their start values.
pub fn declared() -> Vec<(Descriptor, ParameterValue)> {
    let cell = "Cell of the experiment, such as speed_m_s=0.15,turn_rate_rad_s=0.75,robots=3: \
                places its world, as `conditions` have it then, and is empty again.";
    let profile =
        "Path of the robots' profile, for `cell`: set at the start; empty is the Flockbot's.";
    let cell = Descriptor::new(CELL, ParameterKind::String, cell);
    let profile = Descriptor::new(PROFILE, ParameterKind::String, profile).read_only();
    [cell, profile].map(|it| (it, ParameterValue::String(String::new()))).to_vec()
}

/// The profile that start values name.
pub fn profile(given: &BTreeMap<String, ParameterValue>) -> anyhow::Result<RobotProfile> {
    let path = match given.get(PROFILE) {
        Some(ParameterValue::String(path)) if !path.is_empty() => path,
        _ => return Ok(RobotProfile::parse("flockbot.yaml", FLOCKBOT)?),
    };
    let text = rsrs_files::read_text(Path::new(path))
        .map_err(|error| anyhow::Error::new(error).context(format!("`{PROFILE}`: {path}")))?;
    Ok(RobotProfile::parse(path, &text)?)
}

/// The conditions of a cell.
pub fn conditions(cell: &str, profile: &RobotProfile) -> Result<Conditions, CellRefused> {
    let cell: Cell =
        cell.parse().map_err(|source| CellRefused::Syntax { found: cell.to_owned(), source })?;
    Ok(Conditions::resolve(profile, &Settings::default().with_cell(&cell))?)
}

/// Puts the conditions of a cell that was set where all others are, so that they stand once.
///
/// # Panics
///
/// Never: conditions are plain data, and both parameters take any text.
pub fn take_cell(server: &ParameterServer, profile: &RobotProfile) -> Result<(), CellRefused> {
    let cell = server.text(FULL_NAME, CELL);
    if cell.is_empty() {
        return Ok(());
    }
    let set = |name, value| {
        let value = ParameterValue::String(value);
        server.set_local(FULL_NAME, name, value).expect("it was declared as a text");
    };
    set(CELL, String::new());
    let conditions = conditions(&cell, profile)?;
    set(CONDITIONS, serde_json::to_string(&conditions).expect("conditions are plain data"));
    Ok(())
}
