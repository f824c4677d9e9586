//! What a process sees of its surroundings: variables and files.

use std::collections::BTreeMap;
use std::ffi::OsString;
use std::io;
use std::path::Path;

/// What the names of variables begin with that set something for a node.
const PREFIXES: [&str; 3] = ["ROS_", "RMW_", "RSRS_"];

/// A variable whose value is no text.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the value of {variable} is not UTF-8")]
pub struct NoText {
    /// Its name.
    pub variable: String,
}

/// What a process sees of its surroundings: variables and files.
#[derive(Clone, Debug)]
pub struct Environment {
    variables: BTreeMap<String, String>,
    /// Variables of ROS 2 and of ours whose values are not UTF-8.
    no_text: Vec<String>,
    pub(crate) read_file: fn(&Path) -> io::Result<String>,
}

impl Environment {
    /// The real one.
    pub fn of_this_process() -> Self {
        Self::from_variables(std::env::vars_os())
    }

    fn from_variables(given: impl Iterator<Item = (OsString, OsString)>) -> Self {
        let (mut variables, mut no_text) = (BTreeMap::new(), Vec::new());
        for (name, value) in given {
            let Ok(name) = name.into_string() else { continue };
            match value.into_string() {
                Ok(value) => drop(variables.insert(name, value)),
                Err(_) if PREFIXES.iter().any(|of_ros| name.starts_with(of_ros)) => {
                    no_text.push(name);
                }
                Err(_) => {}
            }
        }
        Self { variables, no_text, read_file: rsrs_files::read_text }
    }

    /// Refuses values that cannot be read: who set one does not want to go without it.
    pub fn check(&self) -> Result<(), NoText> {
        match self.no_text.first() {
            Some(variable) => Err(NoText { variable: variable.clone() }),
            None => Ok(()),
        }
    }

    /// One made up.
    pub fn new(variables: &[(&str, &str)], read_file: fn(&Path) -> io::Result<String>) -> Self {
        let owned = |&(name, value): &(&str, &str)| (name.to_owned(), value.to_owned());
        Self { variables: variables.iter().map(owned).collect(), no_text: Vec::new(), read_file }
    }

    /// The value of a variable; `None` if it is not set.
    pub fn variable(&self, name: &str) -> Option<&str> {
        self.variables.get(name).map(String::as_str)
    }
}

#[cfg(test)]
mod tests {
    use std::os::unix::ffi::OsStringExt;

    use super::*;

    #[test]
    fn a_variable_of_ros_that_is_no_text_is_an_error_and_never_as_if_it_were_not_set() {
        let no_text = || OsString::from_vec(b"tr\xffue".to_vec());
        let parsed = |name: &str| {
            let environment = Environment::from_variables([(name.into(), no_text())].into_iter());
            environment.check().map_err(|error| error.to_string())
        };

        for name in ["ROS_SECURITY_ENABLE", "ROS_SECURITY_KEYSTORE", "RSRS_INTERFACE"] {
            assert_eq!(parsed(name), Err(format!("the value of {name} is not UTF-8")));
        }
        assert_eq!(parsed("LS_COLORS"), Ok(()));
    }
}
