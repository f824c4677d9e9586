//! The parameters of one node, and the rules for changing them: pure, with no wire in sight.

use std::collections::BTreeMap;

use crate::parameter_value::{Descriptor, ParameterKind, ParameterValue};

/// Why a parameter is not set. The texts are shown by other tools.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Refusal {
    /// There is no such parameter.
    #[error("parameter '{name}' cannot be set because it was not declared")]
    Undeclared {
        /// Its name.
        name: String,
    },
    /// It exists already.
    #[error("parameter '{name}' has already been declared")]
    DeclaredTwice {
        /// Its name.
        name: String,
    },
    /// Parameters of ours do not come and go.
    #[error("parameter '{name}' cannot be undeclared")]
    NotSet {
        /// Its name.
        name: String,
    },
    /// Its type is for good.
    #[error(
        "wrong parameter type, parameter '{name}' is of type '{expected}', \
         setting it to '{found}' is not allowed"
    )]
    Kind {
        /// Its name.
        name: String,
        /// Its type.
        expected: ParameterKind,
        /// The type of the value.
        found: ParameterKind,
    },
    /// Not a number is no value.
    #[error("parameter '{name}' cannot be NaN")]
    NotANumber {
        /// Its name.
        name: String,
    },
    /// A number is too small or too large.
    #[error("parameter '{name}' must be between {low} and {high}, found {found}")]
    Range {
        /// Its name.
        name: String,
        /// Lowest value, in the unit of the parameter.
        low: f64,
        /// Highest value, in the unit of the parameter.
        high: f64,
        /// The value.
        found: f64,
    },
    /// It never changes.
    #[error("parameter '{name}' cannot be set because it is read-only")]
    ReadOnly {
        /// Its name.
        name: String,
    },
    /// It does not change now.
    #[error("parameter '{name}' cannot be set while the robot is armed")]
    Armed {
        /// Its name.
        name: String,
    },
    /// The node has its own reasons.
    #[error("{reason}")]
    Validator {
        /// The node's reason.
        reason: String,
    },
}

/// Who wants to change a parameter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Setter {
    /// Another program, through a service.
    Anybody,
    /// The node itself, which may change what others may only read.
    Owner,
}

/// Whether a robot may move, during which its parameters stay as they were checked.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Arming {
    /// It may not, and its parameters can be set.
    #[default]
    Disarmed,
    /// It may, and only the node itself sets its parameters.
    Armed,
}

#[derive(Clone, Debug)]
struct Declared {
    descriptor: Descriptor,
    value: ParameterValue,
}

/// The parameters of one node.
#[derive(Clone, Debug, Default)]
pub struct Store {
    declared: BTreeMap<String, Declared>,
    /// Whether others may set anything now.
    pub arming: Arming,
}

impl Store {
    /// Adds a parameter.
    pub fn declare(
        &mut self,
        descriptor: Descriptor,
        value: ParameterValue,
    ) -> Result<(), Refusal> {
        let name = descriptor.name.clone();
        if self.declared.contains_key(&name) {
            return Err(Refusal::DeclaredTwice { name });
        }
        check_value(&descriptor, &value)?;
        self.declared.insert(name, Declared { descriptor, value });
        Ok(())
    }

    /// The value of a parameter; `None` if there is no such parameter.
    pub fn get(&self, name: &str) -> Option<&ParameterValue> {
        self.declared.get(name).map(|declared| &declared.value)
    }

    /// What a parameter means; `None` if there is no such parameter.
    pub fn descriptor(&self, name: &str) -> Option<&Descriptor> {
        self.declared.get(name).map(|declared| &declared.descriptor)
    }

    /// All parameters and their values, by name.
    pub fn values(&self) -> impl Iterator<Item = (&str, &ParameterValue)> {
        self.declared.iter().map(|(name, declared)| (name.as_str(), &declared.value))
    }

    /// Names of parameters, and the parts of them before the last dot, as `list_parameters` wants
    /// them.
    ///
    /// `prefixes` are names or parts of names up to a dot, none for all parameters. After a prefix,
    /// `depth` dots may follow; 0 stands for any number.
    ///
    /// # Source
    ///
    /// `NodeParameters::list_parameters` of rclcpp.
    pub fn list(&self, prefixes: &[String], depth: u64) -> (Vec<String>, Vec<String>) {
        let shallow = |rest: &str| depth == 0 || (rest.matches('.').count() as u64) < depth;
        let wanted = |name: &str| {
            prefixes.iter().any(|prefix| match name.strip_prefix(prefix.as_str()) {
                Some("") => true,
                Some(rest) => rest.strip_prefix('.').is_some_and(shallow),
                None => false,
            }) || (prefixes.is_empty() && shallow(name))
        };
        let names: Vec<String> =
            self.declared.keys().filter(|name| wanted(name)).cloned().collect();
        let mut parents: Vec<String> = names
            .iter()
            .filter_map(|name| name.rsplit_once('.'))
            .map(|(parent, _)| parent.to_owned())
            .collect();
        parents.dedup();
        (names, parents)
    }

    /// Whether all these changes are allowed together.
    pub(super) fn check(
        &self,
        changes: &[(String, ParameterValue)],
        setter: Setter,
    ) -> Result<(), Refusal> {
        for (name, value) in changes {
            let Some(Declared { descriptor, .. }) = self.declared.get(name) else {
                return Err(Refusal::Undeclared { name: name.clone() });
            };
            if setter == Setter::Anybody && descriptor.read_only {
                return Err(Refusal::ReadOnly { name: name.clone() });
            }
            if setter == Setter::Anybody && self.arming == Arming::Armed {
                return Err(Refusal::Armed { name: name.clone() });
            }
            check_value(descriptor, value)?;
        }
        Ok(())
    }

    /// Makes changes that [`Store::check`] allowed.
    ///
    /// # Panics
    ///
    /// If a parameter is not declared.
    pub(super) fn apply(&mut self, changes: &[(String, ParameterValue)]) {
        for (name, value) in changes {
            let declared = self.declared.get_mut(name).expect("the changes were checked");
            declared.value = value.clone();
        }
    }
}

fn check_value(descriptor: &Descriptor, value: &ParameterValue) -> Result<(), Refusal> {
    let name = || descriptor.name.clone();
    if value.kind() != descriptor.kind {
        let (expected, found) = (descriptor.kind, value.kind());
        return Err(Refusal::Kind { name: name(), expected, found });
    }
    if value.has_nan() {
        return Err(Refusal::NotANumber { name: name() });
    }
    if let Some((low, high)) = descriptor.range
        && let Some(found) =
            value.numbers().into_iter().find(|number| !(low..=high).contains(number))
    {
        return Err(Refusal::Range { name: name(), low, high, found });
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn store() -> Store {
        let mut store = Store::default();
        let mut speed = Descriptor::new("speed", ParameterKind::Double, "Forward speed, in m/s.");
        speed.range = Some((0.0, 0.3));
        let mut digest = Descriptor::new("digest", ParameterKind::String, "Of the profile.");
        digest.read_only = true;
        store.declare(speed, ParameterValue::Double(0.15)).unwrap();
        store.declare(digest, ParameterValue::String("abc".into())).unwrap();
        for name in ["sensor.cone.range", "sensor.cone.half_angle", "sensor.rate", "sensors"] {
            let descriptor = Descriptor::new(name, ParameterKind::Integer, "A number.");
            store.declare(descriptor, ParameterValue::Integer(1)).unwrap();
        }
        store
    }

    fn refused(name: &str, value: ParameterValue) -> Refusal {
        store().check(&[(name.to_owned(), value)], Setter::Anybody).unwrap_err()
    }

    #[test]
    fn what_a_parameter_cannot_be_is_refused_as_ros_does() {
        for (name, value, expected) in [
            (
                "speed",
                ParameterValue::Integer(0),
                "wrong parameter type, parameter 'speed' is of type 'double', \
                 setting it to 'integer' is not allowed",
            ),
            (
                "speed",
                ParameterValue::Double(0.31),
                "parameter 'speed' must be between 0 and 0.3, found 0.31",
            ),
            (
                "height",
                ParameterValue::Double(1.0),
                "parameter 'height' cannot be set because it was not declared",
            ),
        ] {
            assert_eq!(refused(name, value).to_string(), expected);
        }
        for (value, is_number) in [(f64::NAN, false), (f64::INFINITY, true)] {
            let refusal = refused("speed", ParameterValue::Double(value));
            assert_eq!(matches!(refusal, Refusal::Range { .. }), is_number, "{refusal}");
            assert_eq!(matches!(refusal, Refusal::NotANumber { .. }), !is_number, "{refusal}");
        }
        for end in [0.0, 0.3] {
            let change = [("speed".to_owned(), ParameterValue::Double(end))];
            assert_eq!(store().check(&change, Setter::Anybody), Ok(()));
        }
    }

    #[test]
    fn what_is_read_only_changes_for_its_owner_alone() {
        let change = [("digest".to_owned(), ParameterValue::String("def".into()))];

        assert!(matches!(refused("digest", change[0].1.clone()), Refusal::ReadOnly { .. }));
        assert_eq!(store().check(&change, Setter::Owner), Ok(()));
    }

    #[test]
    fn an_armed_robot_keeps_its_parameters() {
        let mut store = store();
        store.arming = Arming::Armed;
        let change = [("speed".to_owned(), ParameterValue::Double(0.1))];

        let refusal = store.check(&change, Setter::Anybody).unwrap_err();

        assert_eq!(refusal, Refusal::Armed { name: "speed".into() });
        assert_eq!(store.check(&change, Setter::Owner), Ok(()));
    }

    #[test]
    fn a_value_that_breaks_its_own_descriptor_is_not_declared() {
        let mut store = store();
        let speed = store.descriptor("speed").unwrap().clone();
        let other = Descriptor { name: "other".into(), ..speed.clone() };

        assert!(matches!(
            store.declare(speed, ParameterValue::Double(0.1)),
            Err(Refusal::DeclaredTwice { .. })
        ));
        assert!(matches!(
            store.declare(other, ParameterValue::Double(9.0)),
            Err(Refusal::Range { .. })
        ));
    }

    #[test]
    fn lists_follow_prefix_and_depth() {
        let names = |prefixes: &[&str], depth| {
            let prefixes: Vec<String> = prefixes.iter().map(|&prefix| prefix.into()).collect();
            store().list(&prefixes, depth).0
        };

        assert_eq!(names(&[], 1), ["digest", "sensors", "speed"]);
        assert_eq!(names(&[], 0).len(), 6);
        assert_eq!(names(&["sensor"], 1), ["sensor.rate"]);
        assert_eq!(
            names(&["sensor"], 2),
            ["sensor.cone.half_angle", "sensor.cone.range", "sensor.rate"]
        );
        assert_eq!(names(&["speed", "sensor.cone"], 0).len(), 3);
        assert_eq!(names(&["sens"], 0), Vec::<String>::new());
        assert_eq!(store().list(&[], 0).1, ["sensor.cone", "sensor"], "each prefix once");
    }
}
