//! Where programs speak and under which names, as the environment and `--ros-args` set it.

use std::process::Output;

use crate::command::{code, stderr};
use crate::processes::confined_rsrs;

fn output(variables: &[(&str, &str)], arguments: &[&str]) -> Output {
    let mut command = confined_rsrs();
    command.envs(variables.iter().copied()).args(arguments);
    command.output().expect("the program was built for this test")
}

#[test]
fn who_is_to_stay_on_this_machine_does_so_whatever_interface_is_chosen_and_reports_it() {
    let variables =
        [("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST"), ("RSRS_INTERFACE", "no_such_interface")];

    let stop = output(&variables, &["stop"]);
    let elsewhere = output(&variables[1..], &["stop"]);

    assert_eq!(code(&stop), 3, "no robot is there: {}", stderr(&stop));
    let printed = "ROS_AUTOMATIC_DISCOVERY_RANGE=LOCALHOST: this program uses the loopback interface \
                only, and not `no_such_interface`\n";
    assert!(stderr(&stop).contains(printed), "{}", stderr(&stop));
    assert_eq!(code(&elsewhere), 2, "{}", stderr(&elsewhere));
    assert!(stderr(&elsewhere).contains("no interface or IPv4 address `no_such_interface`"));
}

#[test]
fn names_that_a_node_cannot_take_are_refused_and_not_ignored() {
    let refused = [
        (&["controller", "--robots", "robot_1"][..], "__node:=brain"),
        (&["robot", "--robots", "robot_1", "--driver", "ros"], "__node:=base"),
        (&["sim", "--robots", "robot_1"], "detection:=/camera/seen"),
        (&["runner", "--experiment", "e.yaml"], "/swarm/lease:=/lease"),
        (&["runner", "--experiment", "e.yaml"], "__ns:=/lab"),
    ];
    for (node, rule) in refused {
        let arguments = [&["node"], node, &["--ros-args", "-r", rule]].concat();

        let refused = output(&[("RSRS_INTERFACE", "lo")], &arguments);

        assert_eq!(code(&refused), 1, "{node:?}: {}", stderr(&refused));
        let expected = format!("error: `-r {rule}`: the ");
        assert!(stderr(&refused).starts_with(&expected), "{node:?}: {}", stderr(&refused));
    }
}
