//! Which robots the rows of a world are: ours, or real ones that the simulator follows.

/// The rows of a world.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Rows {
    /// Name of each row's robot; shape `[n_robots]`.
    pub names: Vec<String>,
    /// Rows of the robots that this simulator stands in for, in the order in which it does.
    pub ours: Vec<usize>,
    /// Rows of the others.
    pub tracked: Vec<usize>,
}

/// Why names do not make the rows of a world.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum RowsError {
    /// The conditions ask for no robot, or for more than the simulator stands in for.
    #[error(
        "`conditions`: robots is {asked}, expected 1 to {hosted}, the robots of this simulator; \
         name those of others in `robots`, in the same request"
    )]
    TooMany {
        /// Robots asked for.
        asked: usize,
        /// Robots there are.
        hosted: usize,
    },
    /// As many names as robots are needed.
    #[error("`robots` names {named} robots, expected {asked} as in `conditions`")]
    Count {
        /// Names given.
        named: usize,
        /// Robots asked for.
        asked: usize,
    },
    /// A robot has one row.
    #[error("`robots` names {name} twice")]
    Twice {
        /// The name.
        name: String,
    },
    /// Our robots stand in for themselves, in their order.
    #[error("`robots` has {found} of this simulator's, expected the first {} in their order: {}", expected.len(), expected.join(", "))]
    Order {
        /// Ours among the names, as they are named.
        found: String,
        /// As they should be.
        expected: Vec<String>,
    },
    /// There is nothing to simulate.
    #[error("`robots` names none of this simulator's: {}", hosted.join(", "))]
    NoneOfOurs {
        /// What there is.
        hosted: Vec<String>,
    },
}

impl Rows {
    /// Understands the names of a world's robots in the order of its rows, of which so many are
    /// `asked` for. Without names they are the first of those that this simulator has (`hosted`).
    pub fn new(names: &[String], hosted: &[String], asked: usize) -> Result<Self, RowsError> {
        if names.is_empty() {
            let are_there = (1..=hosted.len()).contains(&asked);
            let names = are_there.then(|| hosted[..asked].to_vec());
            let names = names.ok_or(RowsError::TooMany { asked, hosted: hosted.len() })?;
            return Ok(Self { names, ours: (0..asked).collect(), tracked: Vec::new() });
        }
        if names.len() != asked {
            return Err(RowsError::Count { named: names.len(), asked });
        }
        let mut seen = names.iter().enumerate();
        if let Some((_, name)) = seen.find(|(row, name)| names[..*row].contains(name)) {
            return Err(RowsError::Twice { name: name.clone() });
        }
        let (ours, tracked): (Vec<usize>, Vec<usize>) =
            (0..asked).partition(|row| hosted.contains(&names[*row]));
        if ours.is_empty() {
            return Err(RowsError::NoneOfOurs { hosted: hosted.to_vec() });
        }
        let named: Vec<String> = ours.iter().map(|row| names[*row].clone()).collect();
        let expected = &hosted[..ours.len()];
        if named != expected {
            let found = named.join(", ");
            return Err(RowsError::Order { found, expected: expected.to_vec() });
        }
        Ok(Self { names: names.to_vec(), ours, tracked })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn named(names: &[&str]) -> Vec<String> {
        names.iter().map(|name| (*name).to_owned()).collect()
    }

    fn rows(names: &[&str], asked: usize) -> Result<Rows, RowsError> {
        Rows::new(&named(names), &named(&["a", "b", "c"]), asked)
    }

    #[test]
    fn without_names_the_first_of_ours_are_meant() {
        let two = rows(&[], 2).unwrap();

        assert_eq!((two.names, two.ours, two.tracked), (named(&["a", "b"]), vec![0, 1], vec![]));
        assert_eq!(rows(&[], 4), Err(RowsError::TooMany { asked: 4, hosted: 3 }));
        assert_eq!(rows(&[], 0), Err(RowsError::TooMany { asked: 0, hosted: 3 }));
    }

    #[test]
    fn names_that_are_not_ours_are_followed() {
        let mixed = rows(&["a", "real", "b"], 3).unwrap();

        assert_eq!((mixed.ours, mixed.tracked), (vec![0, 2], vec![1]));
    }

    #[test]
    fn names_that_make_no_world_are_refused() {
        assert_eq!(rows(&["a"], 2), Err(RowsError::Count { named: 1, asked: 2 }));
        assert_eq!(rows(&["a", "r", "r"], 3), Err(RowsError::Twice { name: "r".into() }));
        assert!(matches!(rows(&["r"], 1), Err(RowsError::NoneOfOurs { .. })));
        assert_eq!(
            rows(&["b", "a"], 2).unwrap_err().to_string(),
            "`robots` has b, a of this simulator's, expected the first 2 in their order: a, b"
        );
    }
}
