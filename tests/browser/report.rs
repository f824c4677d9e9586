//! The report: it responds, moves, prints, and can be used by everybody.

use std::path::Path;

use super::browse;
use crate::command::{bring, code, done, rsrs, stderr, text_in};
use crate::prepared_sweeps::workplace;
use crate::simulated_bags::Run;
use rsrs_core::conditions::Conditions;
use rsrs_pipeline::sweep::source::ResolvedSweep;

#[test]
fn a_report_of_a_hundred_robots_opens_and_draws_its_frames() {
    let place = tempfile::tempdir().expect("a temporary folder");
    let here = place.path();
    bring("profiles/flockbot.yaml", &here.join("flockbot.yaml"));
    let sweep = "profile: flockbot.yaml\n\
                 axes:\n  speed_m_s: [0.15]\n  turn_rate_rad_s: [0.75]\n\
                 fixed: {robots: 100, placement_radius_m: 2.0, arena_m: 15}\n\
                 replicates: 2\nduration_s: 64\nseed: 7\n";
    std::fs::write(here.join("sweep.yaml"), sweep).expect("the folder is writable");
    done(here, &["sweep", "sweep.yaml", "-o", "out"]);
    let run = Run { duration_s: 64.0, recorded_s: 64.0, ..Run::new(1) };
    Run { robots: 100, placement_radius_m: 2.0, ..run }.record(here, "run");
    let report = rsrs(here, &["report", "out", "-o", "report.html", "--bags", "run"]);
    assert!([0, 3].contains(&code(&report)), "{}", stderr(&report));

    let found = browse("frames.py", &here.join("report.html"), &[]);

    assert!(found.ends_with("all is well\n"), "{found}");
}

#[test]
fn a_report_of_nine_runs_is_small_responds_moves_and_prints_in_a_browser() {
    let place = workplace("speed_m_s: {from: 0.05, to: 0.30, steps: 11}", "true_positive: 0.8");
    let here = place.path();
    let sweep = text_in(here, "sweep.yaml");
    let sweep = sweep
        .replace("[0.25, 0.75]", "[0.25, 0.5, 0.75, 1, 1.25, 1.5, 1.75, 2]")
        .replace("replicates: 16", "replicates: 3")
        .replace("duration_s: 120", "duration_s: 300");
    std::fs::write(here.join("sweep.yaml"), sweep).expect("the folder is writable");
    let swept = rsrs(here, &["sweep", "sweep.yaml", "-o", "out"]);
    assert_eq!(code(&swept), 0, "{}", stderr(&swept));
    let names: Vec<String> = (1..=9).map(|run| format!("run_{run}")).collect();
    for (seed, name) in (1..).zip(&names) {
        let run = Run { duration_s: 300.0, recorded_s: 300.0, ..Run::new(seed) };
        run.record(here, name);
    }
    let mut arguments = vec!["report", "out", "-o", "report.html", "--bags"];
    arguments.extend(names.iter().map(String::as_str));
    let report = rsrs(here, &arguments);
    assert!([0, 3].contains(&code(&report)), "{}", stderr(&report));

    let n_bytes = here.join("report.html").metadata().expect("it was written").len();
    assert!(n_bytes < 2_500_000, "{n_bytes} bytes");
    let html = text_in(here, "report.html");
    for name in &names {
        let mut titles = html.split("<title>").skip(1).filter_map(|it| it.split("</title>").next());
        assert!(titles.any(|title| title.contains(name)), "no mark of {name}");
    }
    let screenshots = Path::new(env!("CARGO_TARGET_TMPDIR")).join("report");
    let found = browse("report.py", &here.join("report.html"), &[&screenshots]);
    assert!(found.contains("cells: 88\n") && found.ends_with("all is well\n"), "{found}");
    let sweep = ResolvedSweep::read_either(&here.join("out/sweep.yaml")).expect("it was swept");
    let (address, digest) = found
        .lines()
        .find_map(|line| line.strip_prefix("simulated: ")?.rsplit_once(' '))
        .expect("a cell was simulated in the browser");
    let cells = sweep.cells("sweep.yaml").expect("they were swept");
    let is_it = |world: &Conditions| format!("{:016x}", world.digest()) == digest;
    let (cell, _) = cells.iter().find(|(_, world)| is_it(world)).expect("it is one of them");
    let cell = cell.to_string().replace(',', "&");
    assert!(address.starts_with(&cell), "{address} is not {cell}");
}
