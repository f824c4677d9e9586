//! The page on which what `rsrs explore` finds is put on a floor that is not ours: its tables are those of the results
//! that its command left. `docs/floors/discovery.py` makes the numbers, in `.ci/long`.

use std::fs;
use std::path::PathBuf;
use std::process::Command;

use rsrs_core::statistics::interval::Interval;
use rsrs_testing::python::must_run;
use serde_json::Value;

use crate::command::repository;
use crate::predictors::has_the_tables_of;

const PAGE: &str = "docs/discovery.md";
/// Finds that are deployed of each world, at most.
const WORLDS: [(&str, usize); 2] = [("calibrated", 30), ("ideal", 18)];

fn discovery() -> PathBuf {
    repository().join("docs/floors/discovery.py")
}

fn finds<'a>(results: &'a Value, world: &str) -> &'a Vec<Value> {
    results["worlds"][world]["finds"].as_array().expect("a list of finds")
}

fn attempts(find: &Value) -> Vec<bool> {
    let attempts = find["attempts"].as_array().expect("a list of attempts");
    attempts.iter().map(|it| it["shows"].as_bool().expect("yes or no")).collect()
}

#[test]
fn the_page_of_discovery_has_the_tables_of_its_results() {
    let committed = has_the_tables_of(PAGE, &discovery(), "docs/floors/discovery.json");

    let page = fs::read_to_string(repository().join(PAGE)).expect("the page is there");
    let n_attempts = committed["n_attempts"].as_u64().expect("a count");
    for (world, most) in WORLDS {
        let finds = finds(&committed, world);
        assert!((1..=most).contains(&finds.len()), "{world}: {}", finds.len());
        let n = finds.len() as u64;
        let stated = |works: &dyn Fn(Vec<bool>) -> bool| {
            let hits = finds.iter().filter(|find| works(attempts(find))).count() as u64;
            let Interval { low, high } = Interval::clopper_pearson(hits, n);
            format!("{hits} of {n}: {:.2} ({low:.2} to {high:.2})", hits as f64 / n as f64)
        };
        let at_once = stated(&|shows| shows[0]);
        let within_all = stated(&|shows| shows.contains(&true));
        let more = if n_attempts > 1 { format!(" {within_all} |") } else { String::new() };
        let begins = format!("| {world} | {at_once} |{more}");
        assert!(page.lines().any(|line| line.starts_with(&begins)), "{PAGE} has no `{begins}`");
        for find in finds {
            let shows = attempts(find);
            let (last, before) = shows.split_last().expect("everything is tried");
            assert!(
                (*last || shows.len() as u64 == n_attempts) && !before.contains(&true),
                "{find}"
            );
            assert!(find["share"].as_f64() >= Some(0.5), "{find}");
            for attempt in find["attempts"].as_array().into_iter().flatten() {
                let names = attempt["names"].as_array().expect("a list of names");
                assert_eq!(attempt["shows"] == true, names.contains(&find["name"]), "{find}");
            }
        }
    }
}

#[test]
fn one_find_of_each_name_is_deployed_in_turn() {
    let script = "\
import sys
sys.path.insert(0, sys.argv[1])
from discovery import chosen
found = [{'name': name, 'number': number} for number, name in enumerate(sys.argv[2:])]
print(*(find['number'] for find in chosen(found, 5)))";
    let names = "other aggregation aggregation milling rotating_crowd no_order milling aggregation";

    let printed = must_run(
        Command::new("python3")
            .args(["-c", script])
            .arg(repository().join("docs/floors"))
            .args(names.split(' ')),
    );

    // The first of each that stands for a behaviour, and then the second.
    assert_eq!(printed.trim(), "3 1 4 6 2");
}
