//! Files that people write, and the messages about what is wrong with them.

use crate::command::{code, rsrs, stderr};

#[test]
fn an_experiment_that_lacks_several_keys_is_refused_with_all_of_them_at_once() {
    let place = tempfile::tempdir().expect("a temporary folder");
    std::fs::write(place.path().join("run.yaml"), "seed: 3\n").expect("the folder is writable");

    let output = rsrs(place.path(), &["run", "run.yaml", "-o", "bag"]);

    assert_eq!(code(&output), 1);
    let printed = stderr(&output);
    assert!(printed.contains("missing keys `fleet`, `placement`, `duration_s`"), "{printed}");
    assert!(printed.contains("help: give `fleet:`, `placement:`, `duration_s:`"), "{printed}");
}
