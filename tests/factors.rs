//! Which factor makes simulated robots worse, as a person reads it.

use crate::command::{code, json, rsrs, stderr, stdout};
use crate::prepared_sweeps::{SPEEDS, swept, workplace};

#[test]
fn choose_states_what_each_factor_does_in_its_cell() {
    let place = swept(SPEEDS, "walls: stop");

    let text = rsrs(place.path(), &["choose", "out", "--confirm", "100", "--viable", "0.5"]);
    let arguments = ["choose", "out", "--confirm", "100", "--viable", "0.5", "--format", "json"];
    let report = json(&rsrs(place.path(), &arguments));

    assert_eq!(code(&text), 0, "{}", stderr(&text));
    let printed = stdout(&text);
    // As many of these few runs mill in both worlds, so that no factor is to be blamed.
    let told = "100 other runs of each do not show that the factors of `harsher` make robots do worse at \
                speed_m_s=0.15";
    assert!(printed.contains(told), "{printed}");
    let factors = &report["factors"];
    assert_eq!(factors["n_replicates"], 100);
    let names: Vec<&str> = factors["factors"]
        .as_array()
        .expect("a list")
        .iter()
        .map(|effect| effect["factor"].as_str().expect("a name"))
        .collect();
    assert_eq!(names, ["gain_sd_factor", "miss_factor", "false_positive_factor"]);
    assert!(factors["factors"][0]["b_s_alone"].as_f64().expect("a share") > 0.5);
}

#[test]
fn a_sweep_of_robots_that_a_factor_has_blinded_reports_it_and_names_the_factor() {
    let place = workplace(SPEEDS, "walls: stop");
    let file = place.path().join("sweep.yaml");
    let sweep = std::fs::read_to_string(&file).expect("it was written");
    std::fs::write(&file, format!("{sweep}harsher: {{miss_factor: 48}}\n")).expect("writable");

    let output = rsrs(place.path(), &["sweep", "sweep.yaml", "-o", "out"]);

    assert_eq!(code(&output), 0, "{}", stderr(&output));
    let warning = "true positive rate: the simulated robot has 0.04, which is hardly more than its \
                   false detections; the measured one has 0.98; set `harsher: {miss_factor: ";
    assert!(stderr(&output).contains(warning), "{}", stderr(&output));
    assert!(stdout(&output).contains("miss_factor does most of it"), "{}", stdout(&output));
}
