//! Names of runs.

use std::path::Path;

use anyhow::Context;
use jiff::Timestamp;

/// A name that no two runs share, on whatever machine: the experiment, when, and 64 random bits.
///
/// A runner's leases, its robots and its bag are distinguished from another's by this name alone,
/// so it must differ also where clocks and process numbers are equal, as they are in two
/// containers, or where many runs are planned within one millisecond.
pub fn new_run_id(experiment: &Path) -> anyhow::Result<String> {
    let random = getrandom::u64().context("cannot draw the random part of a run's name")?;
    Ok(run_id(experiment, Timestamp::now(), random))
}

fn run_id(experiment: &Path, now: Timestamp, random: u64) -> String {
    let stem = experiment.file_stem().map_or_else(|| "run".into(), |stem| stem.to_string_lossy());
    format!("{stem}_{}_{random:016x}", now.strftime("%Y%m%dT%H%M%S.%3fZ")).replace('.', "_")
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    #[test]
    fn ten_thousand_runs_of_one_experiment_in_one_moment_have_as_many_names() {
        let experiment = Path::new("experiments/milling.yaml");

        let ids: BTreeSet<String> = (0..10_000).map(|_| new_run_id(experiment).unwrap()).collect();

        assert_eq!(ids.len(), 10_000);
        // What distinguishes them is not the clock, which two machines may have in common.
        let random = |id: &String| id.rsplit('_').next().unwrap().to_owned();
        assert_eq!(ids.iter().map(random).collect::<BTreeSet<_>>().len(), 10_000);
    }

    #[test]
    fn the_name_of_a_run_can_be_read_and_names_a_folder() {
        let now = "2026-11-22T10:20:30.045Z".parse().unwrap();

        let id = run_id(Path::new("experiments/milling.v2.yaml"), now, 0xab);

        assert_eq!(id, "milling_v2_20261122T102030_045Z_00000000000000ab");
    }
}
