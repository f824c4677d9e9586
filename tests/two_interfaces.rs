//! A workstation between two networks that nothing else ties together, as of a wired tracker and of robots
//! on Wi-Fi, over real DDS.

use std::path::Path;

use crate::cables::{ip, start_at_cable};
use crate::processes::{Process, in_own_network, rsrs};
use serde_json::Value;

const ROBOTS: [&str; 2] = ["Alice", "robot_2"];
/// The addresses of the workstation in the two networks, and those of the robots.
const HERE: [&str; 2] = ["10.78.1.1", "10.78.2.1"];
const THERE: [&str; 2] = ["10.78.1.2", "10.78.2.2"];

/// A robot that is alone with the workstation in one of the networks.
fn robot(network: usize) -> Process {
    let (cable, here, there) = (format!("net{network}"), HERE[network], THERE[network]);
    let mut node = rsrs();
    node.args(["node", "robot", "--interface", there, "--robots", ROBOTS[network]]);
    node.args(["--driver", "virtual", "--without-controller"]);
    let plug = || {
        ip(&format!("address add {here}/24 dev {cable}"));
        ip(&format!("link set {cable} up"));
    };
    start_at_cable(&node, &cable, (there, plug))
}

/// Types a stop of both robots.
fn stop(interfaces: &[&str], fleet: &Path, variable: Option<&str>) -> (i32, Value) {
    let mut command = rsrs();
    command.args(["stop", "--format", "json", "--fleet"]).arg(fleet);
    for interface in interfaces {
        command.args(["--interface", interface]);
    }
    command.envs(variable.map(|value| ("RSRS_INTERFACE", value)));
    let output = command.output().expect("the program was built");
    let errors = String::from_utf8_lossy(&output.stderr);
    let report = serde_json::from_slice(&output.stdout).expect(&errors);
    (output.status.code().expect("nobody killed it"), report)
}

/// The robots that have acknowledged.
fn acknowledged(report: &Value) -> Vec<&str> {
    let robots = report["robots"].as_array().expect("a list").iter();
    let stopped = robots.filter(|row| row["acknowledged"] == true);
    stopped.map(|row| row["robot"].as_str().expect("a name")).collect()
}

#[test]
fn a_workstation_with_two_interfaces_reaches_robots_in_both_networks() {
    in_own_network(async || {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let fleet = folder.path().join("fleet.yaml");
        let text = "fileversion: 1\nall: {driver: {kind: ros}, profile: p.yaml}\n\
                    robots: {Alice: {enabled: true}, robot_2: {enabled: true}}\n";
        std::fs::write(&fleet, text).expect("the disk has room");
        let _robots = [robot(0), robot(1)];

        let (code, by_one) = stop(&HERE[..1], &fleet, None);
        assert_eq!((code, acknowledged(&by_one)), (3, vec![ROBOTS[0]]), "{by_one:#}");

        let (code, by_both) = stop(&HERE, &fleet, None);
        assert_eq!((code, acknowledged(&by_both)), (0, ROBOTS.to_vec()), "{by_both:#}");

        let (code, by_names) = stop(&[], &fleet, Some("net1, net0"));
        assert_eq!((code, acknowledged(&by_names)), (0, ROBOTS.to_vec()), "{by_names:#}");
    });
}
