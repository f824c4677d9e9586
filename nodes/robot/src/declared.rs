//! Parameters as drivers and robots declare them.

use anyhow::Context;
use rsrs_fleet::fleet_file::CmdVel;
use rsrs_ros::parameters::{Descriptor, ParameterKind, ParameterServer, ParameterValue};

/// A text that is set for good; `words` states what it may be.
pub fn choice(
    name: &str,
    description: &str,
    words: &str,
    value: &str,
) -> (Descriptor, ParameterValue) {
    let descriptor = Descriptor::new(name, ParameterKind::String, description);
    (descriptor.limited_to(words).read_only(), ParameterValue::String(value.to_owned()))
}

/// The type of commands that a parameter of a node names.
pub fn cmd_vel_type(server: &ParameterServer, node: &str, name: &str) -> anyhow::Result<CmdVel> {
    let found = server.text(node, name);
    CmdVel::from_key(&found)
        .with_context(|| format!("`{name}` is `{found}`, expected twist_stamped or twist"))
}
