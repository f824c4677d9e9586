//! Programs that have a network of their own, at the end of a virtual cable.

use std::process::{Command, Stdio};

use crate::processes::{Process, join_alone};
use rsrs_ros::confine;

/// Runs `ip` with arguments that a space separates.
pub fn ip(arguments: &str) {
    let status = Command::new("ip").args(arguments.split(' ')).status();
    assert!(status.expect("`ip` is installed").success(), "ip {arguments}");
}

/// Runs `ip` in the network of a program.
pub fn ip_of(program: &Process, arguments: &str) {
    let status = Command::new("nsenter")
        .args(["--target", &program.0.id().to_string(), "--net", "ip"])
        .args(arguments.split(' '))
        .status();
    assert!(status.expect("`nsenter` is installed").success(), "ip {arguments}");
}

/// Starts a program that has an interface `eth0` with this address; the other end of its cable is in the
/// network of the caller, who plugs it in.
pub fn start_at_cable(
    program: &Command,
    cable: &str,
    (address, plug): (&str, impl FnOnce()),
) -> Process {
    // It starts when its network has a cable, of which a line on its input informs it.
    let mut waiting = Command::new("sh");
    waiting.args(["-c", "read _; exec \"$@\"", "sh"]).arg(program.get_program());
    waiting.args(program.get_args());
    for (variable, value) in program.get_envs() {
        match value {
            Some(value) => waiting.env(variable, value),
            None => waiting.env_remove(variable),
        };
    }
    waiting.stdin(Stdio::piped()).stdout(Stdio::null()).stderr(Stdio::piped());
    let started = confine::start_in_own_network(&mut waiting).spawn();
    let mut program = Process(started.expect("namespaces are allowed"));
    ip(&format!("link add {cable} type veth peer name eth0 netns {}", program.0.id()));
    plug();
    let input = program.0.stdin.take();
    ip_of(&program, &format!("address add {address}/24 dev eth0"));
    ip_of(&program, "link set eth0 up");
    join_alone();
    drop(input);
    program
}
