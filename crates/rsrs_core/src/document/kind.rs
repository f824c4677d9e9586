//! Which kind of file a document is, for one that was given in place of another.

use std::collections::BTreeSet;

use super::{Keys, Problem, parse};

/// A kind of file that people write.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Kind {
    /// With its article, as in "this is a fleet file".
    pub name: &'static str,
    /// Where it is used.
    pub used_by: &'static str,
    /// Keys that together are in no other kind.
    keys: &'static [&'static str],
}

const KINDS: [Kind; 9] = [
    Kind {
        name: "a robot profile",
        used_by: "sweep files and fleet files name it as `profile`",
        keys: &["body", "actuation"],
    },
    Kind {
        name: "a fleet file",
        used_by: "experiment files name it as `fleet`",
        keys: &["robots", "robot_types"],
    },
    Kind {
        name: "a sweep file",
        used_by: "`rsrs sweep` takes it",
        keys: &["profile", "replicates"],
    },
    Kind {
        name: "an experiment file",
        used_by: "`rsrs run` takes it",
        keys: &["fleet", "duration_s"],
    },
    Kind {
        name: "a controller file",
        used_by: "sweep files and experiment files name it as `controller`",
        keys: &["rows"],
    },
    Kind {
        name: "a behaviour",
        used_by: "sweep files and experiment files name it as `behaviour`",
        keys: &["phases", "rules"],
    },
    Kind {
        name: "a world",
        used_by: "sweep files and experiment files name it as `world`",
        keys: &["objects"],
    },
    Kind {
        name: "a world",
        used_by: "sweep files and experiment files name it as `world`",
        keys: &["goals"],
    },
    Kind { name: "a campaign file", used_by: "`rsrs campaign` takes it", keys: &["experiments"] },
];

/// The problem of a document that has an unknown key: that it is of another kind, if it is.
pub(super) fn of_another(problem: Problem, text: &str) -> Problem {
    let Problem::UnknownKey { key, expected, .. } = &problem else { return problem };
    let Ok(Keys(found)) = parse::<Keys>("", text) else { return problem };
    let is_of_its_kind = KINDS.iter().any(|kind| kind.takes(expected) && kind.is_of(&found));
    // A key that is wrong within a part is a slip, in whatever file.
    if is_of_its_kind || !found.contains(key) {
        return problem;
    }
    match KINDS.into_iter().find(|kind| kind.is_of(&found)) {
        Some(kind) => Problem::OtherKind { kind, expected: expected.clone() },
        None => problem,
    }
}

impl Kind {
    fn is_of(&self, found: &BTreeSet<String>) -> bool {
        self.keys.iter().all(|key| found.contains(*key))
    }

    fn takes(&self, expected: &[String]) -> bool {
        self.keys.iter().all(|key| expected.iter().any(|other| other == key))
    }
}

#[cfg(test)]
mod tests {
    use serde::Deserialize;

    use super::*;
    use crate::help::Help as _;

    #[derive(Debug, Deserialize)]
    #[serde(deny_unknown_fields)]
    struct Sweep {
        #[expect(dead_code, reason = "parsed only")]
        profile: String,
        #[expect(dead_code, reason = "parsed only")]
        replicates: u32,
    }

    fn refused(text: &str) -> super::super::DocumentError {
        parse::<Sweep>("floor.yaml", text).expect_err("it is no sweep")
    }

    #[test]
    fn a_file_of_another_kind_is_named_with_the_command_that_takes_it() {
        let error = refused("fleet: nine.yaml\nduration_s: 3\n");

        assert_eq!(
            error.to_string(),
            "floor.yaml:1:1: this is an experiment file, expected a file with the keys profile, replicates"
        );
        assert_eq!(error.help().unwrap(), "`rsrs run` takes it");
    }

    #[test]
    fn a_wrong_key_in_a_file_of_the_right_kind_is_a_wrong_key() {
        let is_wrong_key = |text: &str| matches!(refused(text).problem, Problem::UnknownKey { .. });

        assert!(is_wrong_key("profile: p.yaml\nreplicates: 3\nfleet: nine.yaml\n"));
        assert!(is_wrong_key("profile: p.yaml\nreplicates: 3\nduration_s: 3\nfleet: x\n"));
        assert!(is_wrong_key("fleet: nine.yaml\n"));
    }
}
