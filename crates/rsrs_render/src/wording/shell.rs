//! Commands that can be pasted into a shell as they are.

use std::path::{Path, PathBuf};

use rsrs_files::quoted;
use rsrs_pipeline::files::experiment_file_beside;

/// The experiment file that lies where a sweep is, as `rsrs init` leaves it; else a name to replace.
pub fn experiment_beside(sweep: &Path) -> String {
    experiment_file_beside(sweep).map_or_else(|| ANY_EXPERIMENT.to_owned(), quoted)
}

/// Stands for an experiment file, to be replaced.
pub const ANY_EXPERIMENT: &str = "EXPERIMENT.yaml";

/// The sweep file that lies beside the folder of its sweep, as `rsrs init` leaves it; else a name to
/// replace. The one in the folder is a result, and stays as it is.
pub fn sweep_beside(sweep: &Path) -> String {
    let there = sweep.parent().map(|parent| parent.join("sweep.yaml")).filter(|it| it.is_file());
    there.map_or_else(|| "SWEEP.yaml".to_owned(), quoted)
}

/// A name that nothing has yet: `results`, or else one beside it.
pub fn free(path: PathBuf) -> PathBuf {
    if path.exists() { free_beside(&path) } else { path }
}

/// A name that nothing has yet: `results_2` beside `results`.
///
/// # Panics
///
/// Never: there are more numbers than files.
pub fn free_beside(path: &Path) -> PathBuf {
    let name = path.file_name().map_or_else(|| "results".to_owned(), |it| it.display().to_string());
    let mut names = (2..).map(|number| path.with_file_name(format!("{name}_{number}")));
    names.find(|path| !path.exists()).expect("there are more numbers than files")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_shell_takes_a_quoted_word_for_one() {
        for word in ["results/flockbot", "first try", "Ana's run", "a$b", "x;y", "*", ""] {
            let echoed = std::process::Command::new("sh")
                .args(["-c", &format!("printf %s {}", quoted(word))])
                .output()
                .expect("there is a shell");

            assert_eq!(String::from_utf8(echoed.stdout).unwrap(), word);
        }
    }

    #[test]
    fn a_number_is_needed_only_where_the_name_is_taken() {
        let place = tempfile::tempdir().unwrap();
        let results = place.path().join("results");

        assert_eq!(free(results.clone()), results);
        std::fs::create_dir(&results).unwrap();
        assert_eq!(free(results), place.path().join("results_2"));
    }

    #[test]
    fn an_experiment_that_lies_beside_a_sweep_is_named() {
        let place = tempfile::tempdir().unwrap();
        let sweep = place.path().join("results");

        assert_eq!(experiment_beside(&sweep), "EXPERIMENT.yaml");
        std::fs::write(place.path().join("experiment.yaml"), "").unwrap();
        assert_eq!(experiment_beside(&sweep), quoted(place.path().join("experiment.yaml")));
    }
}
