//! What a swarm can do: searched for, interrupted, found again, and ready to be swept.

use std::collections::BTreeSet;
use std::path::Path;

use serde_json::Value;

use crate::command::{
    code, done, done_line, json, repository, rsrs, run_line, stderr, stdout, text_in,
};

fn profile() -> String {
    let profile = repository().join("launch_configs/profiles/flockbot.yaml");
    profile.to_str().expect("a path in UTF-8").to_owned()
}

fn explore(place: &Path, folder: &str, more: &[&str]) -> std::process::Output {
    let profile = profile();
    let mut arguments = vec!["explore", &profile, "-o", folder, "--format", "json"];
    arguments.extend(more);
    rsrs(place, &arguments)
}

/// Everything that a search has left, but for where it lies.
fn contents(folder: &Path) -> Vec<(String, Vec<u8>)> {
    let names = ["profile.yaml", "exploration.yaml", "trials.jsonl", "gallery.svg", "gallery.png"];
    let file = |name: &str| {
        let bytes =
            std::fs::read(folder.join(name)).unwrap_or_else(|error| panic!("{name}: {error}"));
        (name.to_owned(), bytes)
    };
    names.into_iter().map(file).collect()
}

#[test]
fn milling_is_found_from_nothing() {
    let place = tempfile::tempdir().expect("a temporary folder");

    let found = explore(place.path(), "milling", &["--behaviour", "milling"]);

    assert_eq!(code(&found), 0, "{}{}", stdout(&found), stderr(&found));
    let found = json(&found);
    let best = &found["found"][0];
    assert_eq!(best["name"], "milling");
    assert!(best["share"].as_f64().is_some_and(|share| share > 0.85), "{best:#}");
    // As anybody's sweep it is swept, and mills there as well.
    let sweep = place.path().join("milling").join(best["sweep"].as_str().expect("a path"));
    let sweep = sweep.to_str().expect("a path in UTF-8");
    let swept = rsrs(place.path(), &["sweep", sweep, "-o", "swept"]);
    assert_eq!(code(&swept), 0, "{}", stderr(&swept));
    let cells = text_in(place.path(), "swept/cells.csv");
    assert!(cells.contains(",stable_milling,"), "{cells}");
}

#[test]
fn what_differs_is_found_and_has_names() {
    let place = tempfile::tempdir().expect("a temporary folder");

    let found = explore(place.path(), "all", &["--walls", "clamp"]);

    assert_eq!(code(&found), 0, "{}", stderr(&found));
    let found = json(&found);
    let entries = found["found"].as_array().expect("a list");
    let surely = |entry: &&Value| entry["share_low"].as_f64().is_some_and(|low| low > 0.5);
    let names: BTreeSet<&str> =
        entries.iter().filter(surely).filter_map(|entry| entry["name"].as_str()).collect();
    for name in
        ["milling", "aggregation", "dispersal", "wall_following", "rotating_crowd", "no_order"]
    {
        assert!(names.contains(name), "no {name} among {names:?}");
    }
    for entry in entries {
        assert!(entry["share"].as_f64().is_some_and(|share| share >= 0.5), "{entry:#}");
        assert_eq!(entry["brown_class"].is_null(), entry["name"] == "other", "{entry:#}");
        let rotation = entry["order_parameters"]["rotation"].as_f64().expect("everybody has it");
        let rotates = ["milling", "wall_following", "rotating_crowd"]
            .contains(&entry["name"].as_str().expect("a name"));
        assert!(!rotates || rotation >= 0.6, "{entry:#}");
        let is_judged = ["milling", "aggregation", "dispersal"]
            .contains(&entry["name"].as_str().expect("a name"));
        assert_eq!(entry["sweep"].is_string(), is_judged, "{entry:#}");
    }
    let html = text_in(place.path(), "all/gallery.html");
    assert_eq!(html.matches("<figure>").count(), entries.len());
    assert!(!html.contains("http://") || html.contains("http://www.w3.org/2000/svg"));
}

#[test]
fn a_fleet_beside_the_profile_has_its_own_number() {
    let place = tempfile::tempdir().expect("a temporary folder");
    let init = "init mine --name epuck --robots 6 --radius 0.035 --speed 0.15 --turn-rate 5.6 \
                --range 0.6 --half-angle 0.3 --period 0.1";
    run_line(place.path(), init);
    let explore = "explore mine/profile.yaml -o found --controllers 64 --replicates 4";

    let text = done_line(place.path(), explore);
    let settings = place.path().join("found/exploration.yaml");
    let settings = std::fs::read_to_string(settings).expect("it was written");
    assert!(settings.contains("robots: 6"), "{settings}");
    assert!(
        text.contains("no sweep: runs are judged for milling, aggregation, dispersal"),
        "{text}"
    );
}

#[test]
fn robots_with_a_single_speed_and_robots_in_the_wind_are_explored_as_well() {
    let place = tempfile::tempdir().expect("a temporary folder");
    for kind in ["smars", "lta"] {
        let profile = repository().join(format!("launch_configs/profiles/{kind}.yaml"));
        let profile = profile.to_str().expect("a path in UTF-8");
        let small = ["--controllers", "100", "--replicates", "4", "--format", "json"];

        let found = rsrs(place.path(), &[&["explore", profile, "-o", kind], &small[..]].concat());

        assert_eq!(code(&found), 0, "{kind}: {}", stderr(&found));
        assert!(json(&found)["found"].as_array().is_some_and(|found| found.len() > 3), "{kind}");
    }
}

#[test]
fn a_search_that_was_cut_short_goes_on_to_the_same_end() {
    let place = tempfile::tempdir().expect("a temporary folder");
    let place = place.path();
    for behaviour in [[].as_slice(), &["--behaviour", "aggregation"]] {
        let name = behaviour.last().copied().unwrap_or("all");
        let at_once = format!("{name}_at_once");
        let cut = format!("{name}_cut");
        let few = ["--replicates", "2"];
        let with = |more: &[&'static str]| [behaviour, &few, more].concat();
        let searched = explore(place, &at_once, &with(&["--controllers", "100"]));
        assert!([0, 3].contains(&code(&searched)), "{}", stderr(&searched));

        explore(place, &cut, &with(&["--controllers", "40", "--threads", "1"]));
        // The last line was being written when the power went.
        let journal = place.join(&cut).join("trials.jsonl");
        let text = std::fs::read_to_string(&journal).expect("it is there");
        std::fs::write(&journal, &text[..text.len() - 40]).expect("it is writable");
        let resumed = explore(place, &cut, &with(&["--controllers", "100"]));

        assert!([0, 3].contains(&code(&resumed)), "{}", stderr(&resumed));
        for (one, other) in contents(&place.join(at_once)).iter().zip(contents(&place.join(cut))) {
            assert_eq!(one.0, other.0);
            assert!(one.1 == other.1, "{name}: {} differs", one.0);
        }
    }
}

#[test]
fn a_search_is_refused_where_it_makes_no_sense() {
    let place = tempfile::tempdir().expect("a temporary folder");
    let place = place.path();
    std::fs::create_dir(place.join("mine")).expect("writable");
    std::fs::write(place.join("mine/notes.txt"), "keep me").expect("writable");
    explore(place, "small", &["--controllers", "20", "--replicates", "4"]);

    for (folder, more, exit_code, expected) in [
        ("mine", ["--controllers", "5"], 1, "is not the folder of a search, and not empty"),
        ("small", ["--controllers", "20"], 1, "is that of another search"),
        ("new", ["--controllers", "0"], 2, "expected a whole number from 1 to 1,000,000"),
        ("new", ["--robots", "0"], 1, "no robots, expected at least 1"),
        ("new", ["--arena", "0.3"], 1, "do not fit"),
        ("new", ["--duration", "20"], 2, "give at least 60 s"),
        ("new", ["--arena", "-1"], 1, "arena_m is -1, expected a number from"),
    ] {
        let refused = explore(place, folder, &more);

        assert_eq!(code(&refused), exit_code, "{more:?}: {}", stderr(&refused));
        assert!(stderr(&refused).contains(expected), "{more:?}: {}", stderr(&refused));
    }
    assert_eq!(text_in(place, "mine/notes.txt"), "keep me");
    assert!(!place.join("new").exists());
}

#[test]
fn what_wheels_cannot_do_is_neither_offered_nor_swept() {
    let place = tempfile::tempdir().expect("a temporary folder");
    let text = std::fs::read_to_string(profile()).expect("it ships");
    let wheels = "actuation:\n  wheels: {base_m: 0.12, speed_max_m_s: 0.2}";
    let on_wheels = place.path().join("on_wheels.yaml");
    std::fs::write(&on_wheels, text.replace("actuation:", wheels)).expect("it can be written");
    let explored = |arguments: &str| {
        let few = ["--controllers", "120", "--replicates", "2", "--format", "json"];
        let arguments: Vec<&str> = arguments.split_whitespace().chain(few).collect();
        let found = rsrs(place.path(), &arguments);
        assert_eq!(code(&found), 0, "{}", stderr(&found));
        let found = json(&found);
        let entries = found["found"].as_array().expect("a list");
        assert!(entries.iter().any(|entry| entry["sweep"].is_string()), "{found:#}");
        entries.clone()
    };

    let found = explored("explore on_wheels.yaml -o found");

    assert_within_wheels(place.path(), "found", &found);
    // Wheels of some of the robots are those of the swarm.
    let classes = "classes: [{name: free}, {name: driven, profile: on_wheels.yaml}]\n";
    std::fs::write(place.path().join("mixed.yaml"), classes).expect("it can be written");
    std::fs::write(place.path().join("free.yaml"), text).expect("it can be written");
    let mixed =
        "explore free.yaml -o mixed --world-file mixed.yaml --arena 3 --robots 4 --duration 100";
    assert_within_wheels(place.path(), "mixed", &explored(mixed));
}

/// Neither commands nor sweeps are beyond wheels of 0.2 m/s that are 0.12 m apart.
fn assert_within_wheels(place: &Path, folder: &str, entries: &[Value]) {
    for entry in entries {
        let (controller, undetected) = (&entry["controller"], &entry["controller"]["undetected"]);
        for command in [controller, undetected].into_iter().filter(|command| !command.is_null()) {
            let of = |key: &str| command[key].as_f64().expect("a number").abs();
            let asked_m_s = of("speed_m_s") + of("turn_rate_rad_s") * 0.06;
            assert!(asked_m_s <= 0.2 + 1e-9, "{entry:#}");
        }
        if let Some(sweep) = entry["sweep"].as_str() {
            let sweep = place.join(folder).join(sweep);
            let text = std::fs::read_to_string(&sweep).expect("it is there");
            let n_robots = text.lines().find_map(|line| line.trim().strip_prefix("robots: "));
            assert!(n_robots.is_some_and(|n| n.parse::<u64>().is_ok()), "{text}");
            let short = text.replace("replicates: 100", "replicates: 1");
            std::fs::write(&sweep, short).expect("it can be written");
            let sweep = sweep.to_str().expect("a path in UTF-8");
            let swept = rsrs(place, &["sweep", sweep, "-o", "swept"]);
            assert_eq!(code(&swept), 0, "{}", stderr(&swept));
            std::fs::remove_dir_all(place.join("swept")).expect("it was written");
        }
    }
}

#[test]
fn what_is_found_is_run_in_other_worlds_however_far_robots_see() {
    let place = tempfile::tempdir().expect("a temporary folder");
    let text = std::fs::read_to_string(profile()).expect("it ships");
    let line_of_sight = "half_angle_rad: 0, range_m: 100";
    let far = text.replace("half_angle_rad: 0.2, range_m: 0.75", line_of_sight);
    assert_ne!(far, text);
    std::fs::write(place.path().join("far.yaml"), far).expect("it can be written");
    let arguments =
        "explore far.yaml -o found --arena 4.5 --controllers 64 --replicates 2 --format json";

    let found = run_line(place.path(), arguments);

    assert_eq!(code(&found), 0, "{}", stderr(&found));
    let found = json(&found);
    let entries = found["found"].as_array().expect("a list");
    assert!(!entries.is_empty());
    for entry in entries {
        let share = |key: &str| entry[key].as_f64().expect("a share");
        assert_eq!(entry["other_contact"], "push", "{entry:#}");
        assert!((0.0..=1.0).contains(&share("share_as_measured")), "{entry:#}");
        let is_surely_rarer = entry["needs_contact"].as_bool().expect("yes or no");
        let is_rarer = share("share_low") > share("share_with_other_contact");
        assert!(is_rarer || !is_surely_rarer, "{entry:#}");
        if let Some(sweep) = entry["sweep"].as_str() {
            let sweep = place.path().join("found").join(sweep);
            let text = std::fs::read_to_string(sweep).expect("it is there");
            assert!(text.contains("placement_radius_m: 0.825"), "{text}");
        }
    }
}

#[test]
fn a_search_begins_where_a_table_puts_the_robots() {
    let place = tempfile::tempdir().expect("a temporary folder");
    let here = place.path();
    let set = |replicate: u64, x_m: f64| {
        let line = |robot: u64| format!("{replicate},{x_m},{},0.5\n", 0.4 * robot as f64 - 0.4);
        (0..3).map(line).collect::<String>()
    };
    let table = format!("replicate,x_m,y_m,heading_rad\n{}{}", set(0, 0.1), set(1, -0.2));
    std::fs::write(here.join("starts.csv"), &table).expect("it can be written");
    std::fs::write(here.join("places.csv"), "x_m,y_m\n0,0\n0,1\n").expect("it can be written");
    let few = ["--controllers", "64", "--replicates", "2", "--duration", "60", "--arena", "2"];
    let explore = |folder: &str, starts: &str, robots: &str| {
        let more = ["--behaviour", "milling", "--starts", starts, "--robots", robots];
        explore(here, folder, &[&few[..], &more].concat())
    };

    let found = explore("found", "starts.csv", "3");
    let too_many = explore("more", "starts.csv", "4");
    let without_headings = explore("none", "places.csv", "2");

    assert!([0, 3].contains(&code(&found)), "{}", stderr(&found));
    let sweep = json(&found)["found"][0]["sweep"].as_str().expect("a path").to_owned();
    let kept = text_in(here, "found/starts.csv");
    assert_eq!(kept, table);
    let text = std::fs::read_to_string(here.join("found").join(&sweep)).expect("it is there");
    assert!(text.contains("path: ../starts.csv") && !text.contains("placement_radius"), "{text}");
    // The sweep begins there, too.
    done(here, &["sweep", &format!("found/{sweep}"), "-o", "swept"]);
    // Other starts are another search.
    std::fs::write(here.join("starts.csv"), table.replace(",0.5", ",0.6")).expect("it is written");
    let other = explore("found", "starts.csv", "3");
    assert!(stderr(&other).contains("starts.csv is that of another search"), "{}", stderr(&other));
    let expected = "replicate 0 has 3 start poses, expected 4";
    assert!(code(&too_many) != 0 && stderr(&too_many).contains(expected), "{}", stderr(&too_many));
    assert!(stderr(&without_headings).contains("no column `heading_rad`"));
}
