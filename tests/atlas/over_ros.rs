//! Entries of the atlas from the sweep to the comparison: few robots for a short time, over ROS 2 in lockstep.

use std::fs;
use std::path::Path;

use rsrs_pipeline::sweep::source::ResolvedSweep;
use rsrs_sim::draw::Seed;

use super::files_of;
use crate::command::{code, json, rsrs, stderr, stdout};
use crate::processes::run_in_lockstep;
use crate::recorded::{
    assert_commands_of_replicate, assert_digests_of_replicate, assert_objects_of_replicate,
    record_of, seed_of,
};

/// An entry, and how it is made small.
struct Entry {
    /// Its folder.
    folder: &'static str,
    /// The sweep of it.
    sweep: &'static str,
    n_robots: usize,
    /// How long each run is, in seconds: five times what is judged of it, or what all of a run may be judged from.
    duration_s: &'static str,
    /// What stands in the place of a line of the sweep, by its key.
    lines: &'static [(&'static str, &'static str)],
    /// A world in the place of its own, called `small.yaml`.
    world: Option<&'static str>,
    n_objects: usize,
}

/// That of the sweeps; a run with another one is compared with them.
const SEED: u64 = 1;

const ENTRIES: [Entry; 3] = [
    Entry {
        folder: "gauci_aggregation",
        sweep: "forty.yaml",
        n_robots: 10,
        duration_s: "50",
        lines: &[
            ("fixed", "{robots: 10, arena_m: 40, walls: none}"),
            ("placement", "{kind: box_facing_any_way, width_m: 0.5, height_m: 0.5}"),
        ],
        world: None,
        n_objects: 0,
    },
    Entry {
        folder: "gauci_clustering",
        sweep: "trials.yaml",
        n_robots: 3,
        duration_s: "50",
        lines: &[
            ("fixed", "{robots: 3, arena_m: 1, walls: clamp}"),
            ("placement", "{kind: box_facing_any_way, width_m: 0.9, height_m: 0.9}"),
            ("world", "small.yaml"),
        ],
        world: Some("objects: [{count: 4, radius_m: 0.05}]\n"),
        n_objects: 4,
    },
    Entry {
        folder: "mitrano_segregation",
        sweep: "beam_angle.yaml",
        n_robots: 8,
        duration_s: "60",
        lines: &[
            ("axes", "{half_angle_rad: [0.2618]}"),
            ("fixed", "{robots: 8, arena_m: 2, walls: clamp}"),
            ("placement", "{kind: box_facing_any_way, width_m: 1.5, height_m: 1.5}"),
        ],
        world: None,
        n_objects: 0,
    },
];

/// The value of a key of a sweep file in one line.
fn value_of<'a>(text: &'a str, key: &str) -> &'a str {
    let line = text.lines().find(|line| line.split(':').next() == Some(key));
    let line = line.unwrap_or_else(|| panic!("no `{key}` in {text}"));
    line.split_once(": ").expect("it has a value").1
}

/// Writes the small sweep, a fleet of its robots, and an experiment of the cell that is chosen from it.
fn write_files(place: &Path, entry: &Entry) {
    let write = |name: &str, text: &str| {
        fs::write(place.join(name), text).expect("the folder is writable");
    };
    let mut text = fs::read_to_string(place.join(entry.sweep)).expect("the entry has it");
    let all = [("replicates", "2"), ("duration_s", entry.duration_s)];
    for (key, value) in entry.lines.iter().chain(&all) {
        let before = format!("{key}: {}", value_of(&text, key));
        text = text.replace(&before, &format!("{key}: {value}"));
    }
    write("sweep.yaml", &text);
    if let Some(world) = entry.world {
        write("small.yaml", world);
    }
    let robots: Vec<String> = (1..=entry.n_robots)
        .map(|robot| format!("robot_{robot}: {{enabled: true, type: e_puck}}"))
        .collect();
    let robots = robots.join(", ");
    write(
        "fleet.yaml",
        &format!(
            "fileversion: 1\nall: {{cmd_vel: twist_stamped, pose: odom}}\nrobot_types:\n  e_puck: {{profile: {}, \
             driver: {{kind: virtual}}}}\nrobots: {{{robots}}}\n",
            value_of(&text, "profile")
        ),
    );
    for seed in [SEED, SEED + 1] {
        write(
            &format!("experiment_{seed}.yaml"),
            &format!(
                "fleet: fleet.yaml\nfrom: out\nplacement: {}\nduration_s: {}\nseed: {seed}\nsimulator: \
                 {{time: lockstep, profile: measured}}\n",
                value_of(&text, "placement"),
                entry.duration_s,
            ),
        );
    }
}

/// What the sweep finds of the chosen cell is what runs of it do, each step of the way.
fn goes_through(entry: &Entry) {
    let folder = files_of(entry.folder);
    let here = folder.path();
    write_files(here, entry);
    let done = |arguments: &[&str], codes: &[i32]| {
        let output = rsrs(here, arguments);
        let words = || format!("{arguments:?}: {}{}", stdout(&output), stderr(&output));
        assert!(codes.contains(&code(&output)), "{}", words());
        output
    };

    done(&["sweep", "sweep.yaml", "-o", "out"], &[0]);
    let few = ["--confirm", "8", "--viable", "0.3"];
    done(&[&["choose", "out", "-o", "out/choice.json"], &few[..]].concat(), &[0]);
    for seed in [SEED, SEED + 1] {
        let experiment = here.join(format!("experiment_{seed}.yaml"));
        run_in_lockstep(&experiment, &[], &here.join(format!("bag_{seed}")));
    }

    let (bag, record) = record_of(&here.join("bag_1"));
    let sweep = ResolvedSweep::read_either(&here.join("out/sweep.yaml")).expect("it was swept");
    let cells = sweep.cells("sweep.yaml").expect("they were swept");
    let (cell, conditions) = &cells[0];
    assert_eq!(record.conditions.digest(), conditions.digest(), "the run is of the cell");
    assert_eq!(seed_of(&record), Seed { seed: sweep.sweep.seed, replicate: 0 });
    assert_eq!(sweep.sweep.seed, SEED);
    assert_eq!(record.conditions.world.n_objects(), entry.n_objects);
    assert_digests_of_replicate(&bag, &record);
    assert_commands_of_replicate(&bag, &record);
    let n_pushed = assert_objects_of_replicate(&bag, &record);
    assert_eq!(n_pushed > 0, entry.n_objects > 0, "{n_pushed} were pushed");

    let labelled = json(&done(&["label", "bag_1", "--format", "json"], &[0]));
    let cell = cell.to_string();
    let episode = ["episode", "out", "--cell", &cell, "--replicate", "0", "-o", "episode"];
    let episode = json(&done(&[&episode[..], &["--format", "json"]].concat(), &[0]));
    assert_eq!(
        labelled[0]["evidence"], episode["evidence"],
        "the bag shows what the sweep counted"
    );
    assert_eq!(labelled[0]["phase"], episode["phase"]);
    let itself = done(&["compare", "out", "--bags", "bag_1"], &[1]);
    assert!(stderr(&itself).contains("is a replicate of the sweep itself"), "{}", stderr(&itself));
    let other = ["compare", "out", "--bags", "bag_2", "--margin", "0.5", "--format", "json"];
    let compared = json(&done(&other, &[0, 3]));
    assert_eq!(compared["bags"].as_array().map(Vec::len), Some(1), "{compared:#}");
    assert!(compared["verdict"].is_string(), "{compared:#}");
}

#[test]
fn entries_go_from_the_sweep_over_ros_2_to_the_comparison() {
    ENTRIES.iter().for_each(goes_through);
}
