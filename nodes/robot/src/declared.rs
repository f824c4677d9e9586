//! Parameters as drivers and robots declare them.

use anyhow::Context;
use rsrs_fleet::fleet_file::CmdVel;
use rsrs_fleet::parameters::{Number, one_of};
use rsrs_ros::parameters::{Descriptor, ParameterKind, ParameterServer, ParameterValue};

/// A number as a node declares it.
pub fn number(it: Number) -> (Descriptor, ParameterValue) {
    let [lowest, highest] = it.range;
    let descriptor = Descriptor::new(it.name, ParameterKind::Double, &it.description());
    let descriptor = Descriptor { read_only: it.read_only, ..descriptor.within(lowest, highest) };
    (descriptor, ParameterValue::Double(it.usual))
}

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

/// A type of velocity commands that is set for good.
pub fn cmd_vel(name: &str, description: &str, usual: CmdVel) -> (Descriptor, ParameterValue) {
    choice(name, description, &cmd_vels(), usual.key())
}

/// The type of commands that a parameter of a node names.
pub fn cmd_vel_type(server: &ParameterServer, node: &str, name: &str) -> anyhow::Result<CmdVel> {
    let found = server.text(node, name);
    CmdVel::from_key(&found)
        .with_context(|| format!("`{name}` is `{found}`, expected {}", cmd_vels()))
}

/// What such a parameter may be, in words.
fn cmd_vels() -> String {
    one_of(&CmdVel::ALL.map(CmdVel::key))
}
