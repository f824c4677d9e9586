//! Names of robots in the order in which people count: `robot_2` before `robot_10`.

use std::cmp::Ordering;

/// The name of a robot.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Name(String);

impl Name {
    pub(super) fn new(name: String) -> Self {
        Self(name)
    }

    pub(super) fn as_str(&self) -> &str {
        &self.0
    }

    /// What comes before the number at its end, and the number.
    fn parts(&self) -> (&str, Option<u64>) {
        let letters = self.0.trim_end_matches(|sign: char| sign.is_ascii_digit());
        (letters, self.0[letters.len()..].parse().ok())
    }
}

impl Ord for Name {
    fn cmp(&self, other: &Self) -> Ordering {
        self.parts().cmp(&other.parts()).then_with(|| self.0.cmp(&other.0))
    }
}

impl PartialOrd for Name {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn robots_are_in_the_order_of_their_numbers() {
        let mut names = ["robot_10", "robot_9", "base", "robot_2", "robot_02", "anna"]
            .map(|name| Name::new(name.to_owned()));

        names.sort();

        let names = names.each_ref().map(Name::as_str);
        assert_eq!(names, ["anna", "base", "robot_02", "robot_2", "robot_9", "robot_10"]);
    }
}
