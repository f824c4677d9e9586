//! Values for parameters, from `-p` and from files.

use std::collections::BTreeMap;
use std::io;
use std::path::Path;

use super::RosArgsError;
use super::yaml::Yaml;
use crate::parameter_value::ParameterValue;

/// The key under which a node's parameters stand in a file.
const PARAMETERS: &str = "ros__parameters";

#[derive(Clone, Debug, PartialEq)]
struct Override {
    /// Full name of the node, with `*` for any one part and `**` for any number of parts.
    nodes: String,
    name: String,
    value: ParameterValue,
}

/// All values, in the order in which they were given.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Overrides {
    given: Vec<Override>,
}

impl Overrides {
    /// Takes the value of a `-p`.
    pub(super) fn take(&mut self, assignment: &str) -> Result<(), RosArgsError> {
        let (left, text) = assignment.split_once(":=").ok_or_else(|| RosArgsError::Assignment {
            flag: "-p",
            found: assignment.to_owned(),
            expected: "[NODE:]NAME:=VALUE",
        })?;
        let (nodes, name) = match left.split_once(':') {
            Some((node, name)) => (format!("/**/{}", node.trim_start_matches('/')), name),
            None => ("/**".to_owned(), left),
        };
        if name.is_empty() {
            let (rule, name) = (assignment.to_owned(), name.to_owned());
            return Err(RosArgsError::Name { rule, name });
        }
        let yaml: Yaml = serde_saphyr::from_str(text).map_err(|source| {
            let (name, found) = (name.to_owned(), text.to_owned());
            RosArgsError::ValueSyntax { name, found, source: Box::new(source) }
        })?;
        let value = yaml
            .into_value()
            .map_err(|reason| RosArgsError::Value { name: name.to_owned(), reason })?;
        self.given.push(Override { nodes, name: name.to_owned(), value });
        Ok(())
    }

    /// Takes a file of `--params-file`.
    pub(super) fn take_file(
        &mut self,
        path: &Path,
        read: fn(&Path) -> io::Result<String>,
    ) -> Result<(), RosArgsError> {
        let text =
            read(path).map_err(|source| RosArgsError::File { path: path.to_owned(), source })?;
        let yaml = serde_saphyr::from_str(&text).map_err(|source| {
            let (path, source) = (path.to_owned(), Box::new(source));
            RosArgsError::FileSyntax { path, source }
        })?;
        self.take_nodes("", yaml).map_err(|(at, reason)| {
            let path = path.to_owned();
            RosArgsError::FileShape { path, at, reason }
        })
    }

    /// Takes `NODE: {ros__parameters: …}`, where the node may be spread over several keys.
    fn take_nodes(&mut self, above: &str, yaml: Yaml) -> Result<(), (String, String)> {
        let Yaml::Mapping(entries) = yaml else {
            let reason = format!("has no `{PARAMETERS}` below it");
            return Err((above.to_owned(), reason));
        };
        for (key, below) in entries {
            if key == PARAMETERS && !above.is_empty() {
                self.take_parameters(above, "", below)?;
            } else {
                let nodes = format!("{above}/{}", key.trim_matches('/'));
                self.take_nodes(&nodes, below)?;
            }
        }
        Ok(())
    }

    /// Takes a mapping of parameters, whose nested names are joined with dots.
    fn take_parameters(
        &mut self,
        nodes: &str,
        above: &str,
        yaml: Yaml,
    ) -> Result<(), (String, String)> {
        let Yaml::Mapping(entries) = yaml else {
            let reason = format!("must have a mapping under `{PARAMETERS}`");
            return Err((nodes.to_owned(), reason));
        };
        for (key, below) in entries {
            let name = if above.is_empty() { key } else { format!("{above}.{key}") };
            if matches!(below, Yaml::Mapping(_)) {
                self.take_parameters(nodes, &name, below)?;
                continue;
            }
            let value =
                below.into_value().map_err(|reason| (format!("{nodes}: {name}"), reason))?;
            self.given.push(Override { nodes: nodes.to_owned(), name, value });
        }
        Ok(())
    }

    /// The values for one node; the last one counts.
    pub(super) fn of(&self, node: &str) -> BTreeMap<String, ParameterValue> {
        let name = parts(node);
        self.given
            .iter()
            .filter(|given| matches(&parts(&given.nodes), &name))
            .map(|given| (given.name.clone(), given.value.clone()))
            .collect()
    }
}

fn parts(name: &str) -> Vec<&str> {
    name.split('/').filter(|part| !part.is_empty()).collect()
}

/// Whether a name matches a pattern, part by part.
fn matches(pattern: &[&str], name: &[&str]) -> bool {
    match (pattern, name) {
        ([], []) => true,
        (["**", rest @ ..], _) => {
            (0..=name.len()).any(|n_skipped| matches(rest, &name[n_skipped..]))
        }
        ([part, pattern @ ..], [first, name @ ..]) => {
            (*part == "*" || part == first) && matches(pattern, name)
        }
        ([], _) | (_, []) => false,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn flags(assignments: &[&str]) -> Overrides {
        let mut overrides = Overrides::default();
        for assignment in assignments {
            overrides.take(assignment).unwrap();
        }
        overrides
    }

    /// Reads a file whose text is its path.
    fn file(text: &str) -> Result<Overrides, RosArgsError> {
        let mut overrides = Overrides::default();
        let read = |path: &Path| Ok(path.to_str().expect("tests are UTF-8").to_owned());
        overrides.take_file(Path::new(text), read)?;
        Ok(overrides)
    }

    fn double(overrides: &Overrides, node: &str, name: &str) -> Option<f64> {
        match overrides.of(node).get(name) {
            Some(ParameterValue::Double(value)) => Some(*value),
            _ => None,
        }
    }

    const NODE: &str = "/robot_3/controller";

    #[test]
    fn a_flag_without_a_node_is_for_every_node_and_one_with_a_node_is_not() {
        let overrides = flags(&["speed:=0.1", "controller:turn_rate:=0.5", "robot:speed:=0.9"]);

        assert_eq!(double(&overrides, NODE, "speed"), Some(0.1));
        assert_eq!(double(&overrides, NODE, "turn_rate"), Some(0.5));
        assert_eq!(double(&overrides, "/robot_3/robot", "speed"), Some(0.9));
    }

    #[test]
    fn a_flag_that_is_no_assignment_or_has_no_value_is_refused() {
        let take = |text| Overrides::default().take(text).unwrap_err();

        assert!(matches!(take("speed=0.1"), RosArgsError::Assignment { .. }));
        assert!(matches!(take(":=0.1"), RosArgsError::Name { .. }));
        assert!(matches!(take("speed:=[1, 2.0]"), RosArgsError::Value { .. }));
        assert!(matches!(take("speed:="), RosArgsError::Value { .. }));
        assert!(matches!(take("speed:=[1"), RosArgsError::ValueSyntax { .. }));
    }

    #[test]
    fn a_file_names_nodes_in_one_key_or_in_several() {
        let in_one = file("/robot_3/controller: {ros__parameters: {speed: 0.2}}").unwrap();
        let in_two = file("robot_3: {controller: {ros__parameters: {speed: 0.2}}}").unwrap();

        for overrides in [in_one, in_two] {
            assert_eq!(double(&overrides, NODE, "speed"), Some(0.2));
            assert_eq!(double(&overrides, "/robot_4/controller", "speed"), None);
        }
    }

    #[test]
    fn wildcards_stand_for_one_part_or_for_any_number() {
        let case = |pattern: &str, node: &str| matches(&parts(pattern), &parts(node));

        assert!(case("/**", NODE) && case("/**", "/controller"));
        assert!(case("/*/controller", NODE) && !case("/*/controller", "/controller"));
        assert!(case("/**/controller", NODE) && case("/**/controller", "/controller"));
        assert!(case("/a/**/d", "/a/b/c/d") && !case("/a/**/d", "/a/b/c"));
        assert!(!case("/*", NODE) && case("/*", "/controller"));
    }

    #[test]
    fn the_last_value_counts() {
        let overrides = file(
            "{/**: {ros__parameters: {speed: 0.1}}, controller: {ros__parameters: {speed: 0.2}}}",
        )
        .unwrap();

        assert_eq!(double(&overrides, "/controller", "speed"), Some(0.2));
        assert_eq!(double(&overrides, NODE, "speed"), Some(0.1));
    }

    #[test]
    fn nested_parameters_have_dots_in_their_names() {
        let overrides = file("/**: {ros__parameters: {sensor: {cone: {range: 0.75}}}}").unwrap();

        assert_eq!(double(&overrides, NODE, "sensor.cone.range"), Some(0.75));
    }

    #[test]
    fn a_file_of_another_shape_is_refused_with_where_it_differs() {
        let shape = |text| file(text).unwrap_err().to_string();

        assert!(
            shape("controller: {speed: 0.1}")
                .ends_with("`/controller/speed` has no `ros__parameters` below it")
        );
        assert!(
            shape("/**: {ros__parameters: 3}")
                .ends_with("must have a mapping under `ros__parameters`")
        );
        assert!(
            shape("/**: {ros__parameters: {a: [1, b]}}")
                .contains("`/**: a` is a list of several types")
        );
        assert!(matches!(file("a: [1").unwrap_err(), RosArgsError::FileSyntax { .. }));
    }
}
