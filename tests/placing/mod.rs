//! `rsrs place`, and `rsrs stop` where it must not go.

use std::process::Command;

use crate::command::{code, done, repository, rsrs, stderr, stdout, text_in};
use crate::processes::in_own_network;

const EXPERIMENT: &str = "launch_configs/experiments/flockbot_milling.yaml";

#[test]
fn start_poses_are_the_same_for_a_seed_and_come_with_a_picture() {
    let folder = tempfile::tempdir().unwrap();
    let (svg, png) = (folder.path().join("start.svg"), folder.path().join("start.png"));
    let place = |more: &[&str]| done(&repository(), &[&["place", EXPERIMENT], more].concat());

    let first = place(&["--format", "json", "-o", &svg.display().to_string()]);
    let again = place(&["--format", "json", "--seed", "1", "-o", &png.display().to_string()]);
    let other = place(&["--format", "json", "--seed", "2"]);

    assert_eq!(first, again);
    assert_ne!(first, other);
    let poses: serde_json::Value = serde_json::from_str(&first).unwrap();
    assert_eq!(poses["robots"].as_array().map(Vec::len), Some(9));
    assert_eq!(poses["robots"][8]["robot"], "robot_9");
    assert_eq!(std::fs::read_to_string(svg).unwrap().matches("<circle").count(), 10);
    assert!(std::fs::read(png).unwrap().starts_with(b"\x89PNG"));
    assert!(place(&[]).contains("robot     x (m)   y (m)  heading (°)  heading (rad)"));
}

#[test]
fn robots_that_do_not_fit_are_refused_with_what_to_do() {
    let folder = tempfile::tempdir().unwrap();
    for file in ["fleets/nine_virtual.yaml", "profiles/flockbot.yaml"] {
        let path = folder.path().join(file);
        std::fs::create_dir_all(path.parent().expect("it is in a folder")).unwrap();
        std::fs::copy(repository().join("launch_configs").join(file), path).unwrap();
    }
    let text = std::fs::read_to_string(repository().join(EXPERIMENT)).unwrap();
    std::fs::create_dir(folder.path().join("experiments")).unwrap();
    std::fs::write(folder.path().join("experiments/tight.yaml"), text.replace("0.825", "0.2"))
        .unwrap();

    let output = rsrs(folder.path(), &["place", "experiments/tight.yaml"]);

    assert_eq!(code(&output), 1);
    assert!(stderr(&output).contains("9 robots do not fit into a disc of radius 0.200 m"));
    assert!(stderr(&output).contains("help: widen `placement_radius_m`"));
}

#[test]
fn a_program_that_does_not_place_the_robots_of_a_run_keeps_it_from_starting() {
    in_own_network(async || {
        let folder = tempfile::tempdir().unwrap();
        let fleet = repository().join("launch_configs/fleets/nine_flockbots.yaml");
        let text = std::fs::read_to_string(repository().join(EXPERIMENT)).unwrap();
        let text = text.replace("../fleets/nine_virtual.yaml", &fleet.display().to_string());
        std::fs::write(folder.path().join("milling.yaml"), text).unwrap();
        let run = |more: &[&str]| {
            let program = ["--place-command", "cat > wanted.json; echo stuck; exit 7"];
            let common = ["run", "milling.yaml", "--seed", "7", "-o", "run_7"];
            rsrs(folder.path(), &[&common[..], &program, more].concat())
        };

        let in_simulator = run(&[]);
        let on_fleet = run(&["--backend", "fleet", "--interface", "127.0.0.1"]);

        assert_eq!(code(&in_simulator), 2);
        assert!(stderr(&in_simulator).contains("help: for the fleet: `--backend fleet"));
        for flag in [["--interface", "wlan0"], ["--place-check", "require"]] {
            for command in [&["run", "milling.yaml"][..], &["campaign", "none.yaml"]] {
                let forgotten =
                    rsrs(folder.path(), &[command, &flag, &["-o", "simulated"]].concat());

                assert_eq!(code(&forgotten), 2, "{command:?} {flag:?}");
                let refused = format!("`{}` is for a fleet", flag[0]);
                assert!(stderr(&forgotten).contains(&refused), "{}", stderr(&forgotten));
            }
        }
        assert_eq!(code(&on_fleet), 1);
        let printed = stderr(&on_fleet);
        assert!(printed.contains("did not place the robots (exit status: 7)"), "{printed}");
        assert!(printed.contains("stuck"), "{printed}");
        assert!(!folder.path().join("run_7").exists(), "nothing was run");
        let wanted = text_in(folder.path(), "wanted.json");
        let wanted: serde_json::Value = serde_json::from_str(&wanted).unwrap();
        let arguments = ["place", "milling.yaml", "--seed", "7", "--format", "json"];
        let shown = stdout(&rsrs(folder.path(), &arguments));
        let shown: serde_json::Value = serde_json::from_str(&shown).unwrap();
        assert_eq!(wanted["purpose"], "run_7");
        let robots = |given: &serde_json::Value| given["robots"].as_array().unwrap().clone();
        assert_eq!((robots(&wanted).len(), robots(&shown).len()), (9, 9));
        for (wanted, shown) in robots(&wanted).iter().zip(robots(&shown)) {
            assert_eq!(wanted["name"], shown["robot"]);
            for key in ["x_m", "y_m", "heading_rad"] {
                assert_eq!(wanted[key], shown[key], "{key}");
            }
        }
    });
}

#[test]
fn a_stop_is_never_sent_into_a_network_that_nobody_chose() {
    let output = Command::new(env!("CARGO_BIN_EXE_rsrs"))
        .arg("stop")
        .env_remove("RSRS_INTERFACE")
        .output()
        .unwrap();

    assert_eq!(code(&output), 2);
    assert!(stderr(&output).contains("no network interface is chosen"), "{}", stderr(&output));
}
