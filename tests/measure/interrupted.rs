//! Ctrl-C where a person is asked.

use std::io::Read;
use std::process::Command;

use super::trials;
use crate::command::repository;
use crate::processes::{Process, confined_rsrs};
use crate::terminal::Terminal;

#[test]
fn ctrl_c_at_a_question_ends_the_command_and_makes_no_bag() {
    let place = trials();
    let terminal = Terminal::open();
    let mut command = confined_rsrs();
    let fleet = repository().join("launch_configs/fleets/nine_virtual.yaml");
    command.current_dir(&place).args(["measure", "drive"]).arg(fleet);
    command.args(["--robot", "robot_1", "--alone", "--backend", "fleet"]);
    command.args(["--interface", "127.0.0.1", "-o", "bag"]).stdin(terminal.input());
    let mut process = Process::start(&mut command);
    let mut stderr = process.0.stderr.take().expect("it is piped");
    let mut printed = String::new();
    while !printed.contains("q ends here") {
        let mut piece = [0; 4096];
        let n = stderr.read(&mut piece).expect("it can be read");
        assert!(n > 0, "it ended before it asked: {printed}");
        printed.push_str(&String::from_utf8_lossy(&piece[..n]));
    }

    let pid = process.0.id().to_string();
    let given = Command::new("kill").args(["-INT", &pid]).status().expect("kill starts");
    assert!(given.success());
    let (status, _) = process.wait();

    assert!(status.code().is_some(), "it ended by itself: {status}");
    assert!(!place.path().join("bag").exists(), "nothing was driven");
}
