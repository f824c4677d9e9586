//! A sweep holds two worlds: robots made worse, and robots as measured.

use std::path::Path;

use crate::command::{bring, code, done, json, repository, rsrs, stderr, stdout};
use crate::prepared_sweeps::{SPEEDS, swept};

fn text(path: &Path) -> String {
    std::fs::read_to_string(path).expect("it is there")
}

#[test]
fn a_sweep_holds_both_worlds_and_a_diagram_states_which_it_shows() {
    let place = swept(SPEEDS, "walls: stop");
    let here = place.path();

    let header = text(&here.join("out/cells.csv")).lines().next().expect("a header").to_owned();
    let draw = |world: &str, file: &str| {
        done(here, &["diagram", "out", "--world", world, "-o", file]);
        text(&here.join(file))
    };
    let (worse, measured) = (draw("harsher", "worse.svg"), draw("as-measured", "measured.svg"));

    assert!(
        header.ends_with(
            "phase,b_s,b_s_low,b_s_high,as_measured_n,as_measured_stable_milling,\
             as_measured_semi_stable_milling,as_measured_unformed,as_measured_dispersion,\
             as_measured_colliding_unstable,as_measured_phase,as_measured_b_s,as_measured_b_s_low,\
             as_measured_b_s_high"
        ),
        "{header}"
    );
    assert!(worse.contains("robots made worse, 9 robots"), "{worse}");
    assert!(measured.contains("robots as measured, 9 robots"), "{measured}");
}

#[test]
fn a_sweep_of_one_world_from_before_is_refused_where_both_are_needed() {
    let place = swept(SPEEDS, "walls: stop");
    let here = place.path();
    let path = here.join("out/cells.csv");
    let n_before = 2 + 1 + 5 + 4;
    let before: String = text(&path)
        .lines()
        .map(|line| line.split(',').take(n_before).collect::<Vec<_>>().join(",") + "\n")
        .collect();
    std::fs::write(&path, before).expect("the folder is writable");

    let choose = rsrs(here, &["choose", "out"]);
    let measured = rsrs(here, &["diagram", "out", "--world", "as-measured", "-o", "m.svg"]);
    let worse = rsrs(here, &["diagram", "out", "-o", "w.svg"]);

    for refused in [&choose, &measured] {
        assert_eq!(code(refused), 1, "{}", stdout(refused));
        let printed = stderr(refused);
        assert!(printed.contains("holds only robots made worse"), "{printed}");
        assert!(printed.contains("rsrs sweep DIR/sweep.yaml -o NEW_DIR"), "{printed}");
    }
    assert_eq!(code(&worse), 0, "{}", stderr(&worse));
}

#[test]
fn more_replicates_never_make_the_choice_fail() {
    let shipped = text(&repository().join("launch_configs/sweeps/flockbot_speed_turn.yaml"));
    let place = tempfile::tempdir().expect("a temporary folder");
    let here = place.path();
    bring("profiles/flockbot.yaml", &here.join("flockbot.yaml"));

    for (seed, replicates) in [(1, 16), (2, 16), (3, 50), (4, 200)] {
        let sweep = shipped
            .replace("../profiles/flockbot.yaml", "flockbot.yaml")
            .replace("replicates: 100", &format!("replicates: {replicates}"))
            .replace("seed: 1 ", &format!("seed: {seed} "));
        let (file, folder) = (format!("{seed}.yaml"), format!("out_{seed}"));
        std::fs::write(here.join(&file), sweep).expect("the folder is writable");
        done(here, &["sweep", &file, "-o", &folder]);

        let output = rsrs(here, &["choose", &folder, "--format", "json"]);

        assert_eq!(code(&output), 0, "seed {seed}, {replicates}: {}", stdout(&output));
        let choice = json(&output);
        let low = |low: &serde_json::Value| low.as_f64().expect("a share");
        assert!(low(&choice["b_s_low"]) >= 0.8, "{choice}");
        assert!(low(&choice["as_measured"]["low"]) >= 0.8, "{choice}");
        // With 200 replicates and more it is one of the deepest true cells, which are three of one row, or
        // next to one, diagonally at most (docs/rules_of_choice.md). A step is 0.025 m/s or 0.25 rad/s.
        let (speed, turn_rate) =
            (low(&choice["cell"]["speed_m_s"]), low(&choice["cell"]["turn_rate_rad_s"]));
        let off = [0.125, 0.15, 0.175]
            .map(|deepest| libm::hypot((speed - deepest) / 0.025, (turn_rate - 0.75) / 0.25))
            .into_iter()
            .fold(f64::INFINITY, f64::min);
        assert!(replicates < 200 || off <= 1.5, "{choice}");
    }
}
