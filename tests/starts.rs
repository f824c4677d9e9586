//! Where robots start, by a table or in a box: in sweeps, in runs, and on the floor.

use std::path::Path;

use crate::command::{bring, code, done, json, repository, rsrs, stderr, stdout, text_in};
use crate::processes::run_in_lockstep;
use crate::recorded::record_of;
use rsrs_sim::draw::Seed;
use rsrs_sim::episode::episode_digests;

/// The Flockbot, nine of them, and a sweep and an experiment with a placement.
fn workplace(placement: &str) -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let files = repository().join("launch_configs");
    for name in ["fleets", "profiles", "experiments"] {
        std::fs::create_dir(folder.path().join(name)).expect("the folder is writable");
    }
    for file in ["fleets/nine_virtual.yaml", "profiles/flockbot.yaml"] {
        std::fs::copy(files.join(file), folder.path().join(file)).expect("it is shipped");
    }
    let experiment = text_in(&files, "experiments/flockbot_milling.yaml")
        .replace("{kind: disc_facing_out, radius_m: 0.825}", placement)
        .replace("duration_s: 300", "duration_s: 60");
    write(folder.path(), "experiments/given.yaml", &experiment);
    let sweep = format!(
        "profile: profiles/flockbot.yaml\nplacement: {}\n\
         axes: {{speed_m_s: [0.15, 0.2]}}\n\
         fixed: {{turn_rate_rad_s: 0.75, robots: 9, arena_m: 15}}\n\
         replicates: 4\nduration_s: 60\nseed: 7\n",
        placement.replace("../", "")
    );
    write(folder.path(), "sweep.yaml", &sweep);
    folder
}

fn write(folder: &Path, name: &str, text: &str) {
    std::fs::write(folder.join(name), text).expect("the folder is writable");
}

/// Nine robots on a ring, each heading along it.
fn ring(radius_m: f64, first: &str) -> String {
    let row = |robot: u32| {
        let angle_rad = f64::from(robot) * std::f64::consts::TAU / 9.0;
        let (y_m, x_m) = libm::sincos(angle_rad);
        let heading_rad = (angle_rad + std::f64::consts::FRAC_PI_2) % std::f64::consts::TAU;
        let (x_m, y_m) = (radius_m * x_m, radius_m * y_m);
        format!("{first}robot_{},{x_m},{y_m},{heading_rad}\n", robot + 1)
    };
    (0..9).map(row).collect()
}

const TABLE: &str = "{kind: file, path: ../starts.csv}";
const HEADER: &str = "robot,x_m,y_m,heading_rad\n";

#[test]
fn robots_start_where_a_table_puts_them_in_sweep_episode_run_and_on_the_floor() {
    let place = workplace(TABLE);
    let here = place.path();
    write(here, "starts.csv", &format!("{HEADER}{}", ring(0.6, "")));

    let sweep = rsrs(here, &["sweep", "sweep.yaml", "-o", "out"]);
    let cell = ["--cell", "speed_m_s=0.15"];
    let episode =
        rsrs(here, &[&["episode", "out"], &cell[..], &["--replicate", "1", "-o", "one"]].concat());
    let placed = rsrs(here, &["place", "experiments/given.yaml", "--format", "json"]);
    let from = [&["--from", "out"], &cell[..]].concat();
    assert_eq!(code(&sweep), 0, "{}", stderr(&sweep));
    run_in_lockstep(Path::new("experiments/given.yaml"), &from, &here.join("run"));

    // The folder of the sweep needs no other file.
    std::fs::remove_file(here.join("starts.csv")).expect("it is there");
    done(here, &["sweep", "out/sweep.yaml", "-o", "again"]);
    assert_eq!(code(&episode), 0, "{}", stderr(&episode));
    assert_eq!(code(&placed), 0, "{}", stderr(&placed));
    let placed = json(&placed);
    assert_eq!(placed["placement"], "file");
    let first = &placed["robots"][0];
    assert_eq!((&first["robot"], &first["x_m"]), (&"robot_1".into(), &0.6.into()));
    // The run over DDS passed through the states of the reference world from these poses.
    let run = record_of(&here.join("run")).1;
    let seed = Seed { seed: run.seed, replicate: run.replicate };
    assert!(!episode_digests(&run.conditions, seed, 60.0).expect("they fit").is_empty());
    assert_eq!(run.conditions.placement, record_of(&here.join("one")).1.conditions.placement);
    done(here, &["compare", "out", "--bags", "run"]);
}

#[test]
fn each_replicate_takes_its_own_set_of_poses() {
    let place = workplace(TABLE);
    let here = place.path();
    let sets = format!("{}{}", ring(0.6, "0,"), ring(0.9, "1,"));
    write(here, "starts.csv", &format!("replicate,{HEADER}{sets}"));
    done(here, &["sweep", "sweep.yaml", "-o", "out"]);
    let start_m = |replicate: &str, bag: &str| -> f64 {
        let cell = ["episode", "out", "--cell", "speed_m_s=0.15", "--replicate", replicate];
        done(here, &[&cell[..], &["-o", bag]].concat());
        let run = record_of(&here.join(bag)).1;
        let seed = Seed { seed: run.seed, replicate: run.replicate };
        let episode = rsrs_sim::episode::run_episode(&run.conditions, seed, 1.0).expect("they fit");
        episode.poses[0].x_m
    };

    let found = [start_m("0", "zero"), start_m("1", "one"), start_m("2", "two")];

    // After one step.
    for (found, expected) in found.into_iter().zip([0.6, 0.9, 0.6]) {
        assert!((found - expected).abs() < 0.05, "{found} m, expected about {expected} m");
    }
}

#[test]
fn tables_that_put_robots_where_they_cannot_be_are_refused_with_what_to_do() {
    let place = workplace(TABLE);
    let here = place.path();
    let ring = ring(0.6, "");
    let rows: Vec<&str> = ring.lines().collect();
    let table = |rows: &[&str]| format!("{HEADER}{}\n", rows.join("\n"));
    let overlap = [&rows[..8], &["robot_9,0.62,0.01,0"]].concat();
    let unnamed: String =
        ring.lines().map(|row| format!("{row}\n").replace("robot_", "bot_")).collect();

    for (text, expected) in [
        (
            table(&overlap),
            "replicate 0: robots 1 and 9 start 0.022 m apart, expected 0.150 m or more: their bodies",
        ),
        (table(&rows[..8]), "replicate 0 has 8 start poses, expected 9, one for each robot"),
        (
            table(&[&rows[..8], &["robot_9,600,0,0"]].concat()),
            "starts.csv:10: x_m is 600: this looks like millimetres, expected metres",
        ),
        (
            table(&[&rows[..8], &["robot_9,0,0,180"]].concat()),
            "heading_rad is 180: this looks like degrees, expected radians",
        ),
        (
            table(&[&rows[..8], &["robot_9,8,0,0"]].concat()),
            "robot 9 starts at (8, 0) m, which is not within the walls of an arena of 15 m",
        ),
        (
            "x_m,y_m\n0,0\n".to_owned(),
            "no column `heading_rad`, so the robots' headings are unknown",
        ),
    ] {
        write(here, "starts.csv", &text);

        let sweep = rsrs(here, &["sweep", "sweep.yaml", "-o", "out"]);
        let run = rsrs(here, &["run", "experiments/given.yaml", "-o", "bag"]);

        for output in [&sweep, &run] {
            assert_eq!(code(output), 1, "{expected}: {}", stdout(output));
            assert!(stderr(output).contains(expected), "{expected}: {}", stderr(output));
        }
        assert!(!here.join("out").exists() && !here.join("bag").exists(), "{expected}");
    }
    write(here, "starts.csv", &format!("{HEADER}{unnamed}"));
    let run = rsrs(here, &["run", "experiments/given.yaml", "-o", "bag"]);
    assert_eq!(code(&run), 1);
    let expected = "start pose 1 is that of bot_1, expected robot_1 as in the fleet file";
    assert!(stderr(&run).contains(expected), "{}", stderr(&run));
    std::fs::remove_file(here.join("starts.csv")).expect("it is there");
    let missing = rsrs(here, &["sweep", "sweep.yaml", "-o", "out"]);
    assert!(stderr(&missing).contains("cannot read starts.csv"), "{}", stderr(&missing));
}

#[test]
fn robots_in_a_box_face_out_of_it_and_a_disc_beside_it_is_refused() {
    let place = workplace("{kind: box_facing_out, width_m: 2, height_m: 1}");
    let here = place.path();

    let placed = rsrs(here, &["place", "experiments/given.yaml", "--format", "json"]);
    let sweep = rsrs(here, &["sweep", "sweep.yaml", "-o", "out"]);
    let text = text_in(here, "sweep.yaml");
    write(here, "both.yaml", &text.replace("robots: 9", "robots: 9, placement_radius_m: 0.6"));
    let both = rsrs(here, &["sweep", "both.yaml", "-o", "both"]);

    assert_eq!((code(&placed), code(&sweep)), (0, 0), "{}{}", stderr(&placed), stderr(&sweep));
    for robot in json(&placed)["robots"].as_array().expect("robots") {
        let number = |key: &str| robot[key].as_f64().expect("a number");
        assert!(number("x_m").abs() <= 1.0 && number("y_m").abs() <= 0.5, "{robot}");
        let away_rad = libm::atan2(number("y_m"), number("x_m")) - number("heading_rad");
        assert!(libm::sin(away_rad).abs() < 1e-9 && libm::cos(away_rad) > 0.0, "{robot}");
    }
    assert_eq!(code(&both), 1);
    let printed = stderr(&both);
    assert!(printed.contains("`placement_radius_m` is given beside `placement`"), "{printed}");
    assert!(printed.contains("help: keep `placement` or `placement_radius_m`"), "{printed}");
}

#[test]
fn whether_cells_are_settled_is_reported_by_sweep_choose_and_episode() {
    let place = tempfile::tempdir().expect("a temporary folder");
    let here = place.path();
    bring("profiles/flockbot.yaml", &here.join("flockbot.yaml"));
    // From far apart, a mill forms late: many are still forming after two minutes.
    let sweep = |radius_m: f64, duration_s: u32| {
        format!(
            "profile: flockbot.yaml\naxes: {{turn_rate_rad_s: [0.25, 0.5, 0.75, 1.0, 1.5]}}\n\
             fixed: {{speed_m_s: 0.15, robots: 9, placement_radius_m: {radius_m}, arena_m: 15}}\n\
             replicates: 50\nduration_s: {duration_s}\nseed: 7\n"
        )
    };
    write(here, "early.yaml", &sweep(0.9, 90));
    write(here, "late.yaml", &sweep(0.6, 600));

    let early = rsrs(here, &["sweep", "early.yaml", "-o", "early", "--format", "json"]);
    for shard in ["1/2", "2/2"] {
        let part = &shard[..1];
        let made = rsrs(here, &["sweep", "early.yaml", "-o", part, "--shard", shard]);
        assert_eq!(code(&made), 0, "{}", stderr(&made));
    }
    let merged = rsrs(here, &["merge", "1", "2", "-o", "merged", "--format", "json"]);
    let late = rsrs(here, &["sweep", "late.yaml", "-o", "late", "--format", "json"]);
    let choose = ["choose", "late", "--confirm", "100", "--viable", "0.5", "--format", "json"];
    let choose = rsrs(here, &choose);
    let cell = ["episode", "late", "--cell", "turn_rate_rad_s=0.75", "--replicate", "0"];
    let episode = rsrs(here, &[&cell[..], &["-o", "bag"]].concat());

    assert_eq!((code(&early), code(&late)), (0, 0), "{}{}", stderr(&early), stderr(&late));
    let unsettled = json(&early)["unsettled_edge"].as_array().expect("a list").clone();
    assert!(!unsettled.is_empty(), "{}", stdout(&early));
    assert_eq!(unsettled[0]["from_s"], 60.0);
    let printed = stderr(&early);
    assert!(
        printed.contains("cells at the edge of the milling region are not settled: of "),
        "{printed}"
    );
    assert!(printed.contains("with a longer `duration_s`"), "{printed}");
    assert_eq!(json(&merged)["unsettled_edge"], json(&early)["unsettled_edge"]);
    assert!(stderr(&merged).contains("cells at the edge"), "{}", stderr(&merged));
    assert_eq!(code(&choose), 0, "{}{}", stdout(&choose), stderr(&choose));
    let settling = &json(&choose)["settling"];
    assert_eq!((&settling["n_replicates"], &settling["from_s"]), (&200.into(), &400.0.into()));
    assert!(settling["n_changed"].as_u64().expect("a count") <= 30, "{settling}");
    assert_eq!(code(&episode), 0, "{}", stderr(&episode));
    let printed = stdout(&episode);
    assert!(
        printed.contains("of 50 runs change their phase in the last third, after 400 s"),
        "{printed}"
    );
}

#[test]
fn where_robots_that_start_closer_together_would_mill_is_reported() {
    let place = tempfile::tempdir().expect("a temporary folder");
    let here = place.path();
    bring("profiles/flockbot.yaml", &here.join("flockbot.yaml"));
    let sweep = "profile: flockbot.yaml\naxes: {turn_rate_rad_s: [0.75]}\n\
                 fixed: {speed_m_s: 0.15, robots: 9, placement_radius_m: 1.6, arena_m: 15}\n\
                 replicates: 50\nduration_s: 300\nseed: 7\n";
    write(here, "far.yaml", sweep);
    rsrs(here, &["sweep", "far.yaml", "-o", "far"]);

    let choose = ["choose", "far", "--confirm", "100", "--viable", "0.6"];
    let text = rsrs(here, &choose);
    let answer = rsrs(here, &[&choose[..], &["--format", "json"]].concat());

    assert_eq!((code(&text), code(&answer)), (3, 3), "{}{}", stdout(&text), stderr(&text));
    let smaller = &json(&answer)["best"]["denser_start"];
    let radius_m = smaller["placement_radius_m"].as_f64().expect("a radius");
    assert!((0.8..1.3).contains(&radius_m), "{smaller}");
    assert!(smaller["b_s_low"].as_f64().expect("a bound") >= 0.6, "{smaller}");
    let printed = format!("with `placement_radius_m: {radius_m}` (now 1.60) B_s is ");
    assert!(stdout(&text).contains(&printed), "{}", stdout(&text));
}
