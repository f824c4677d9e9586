//! Other names for nodes and topics.

use rsrs_msgs::topics::is_token;

use super::RosArgsError;

/// A rule `[NODE:]FROM:=TO`.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Rule {
    /// Name of the only node it is for.
    node: Option<String>,
    kind: Kind,
    to: String,
    /// As it was given.
    text: String,
}

#[derive(Clone, Debug, PartialEq, Eq)]
enum Kind {
    Namespace,
    NodeName,
    Topic { from: String },
}

/// Whether the topics of a program can have other names.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TopicRules {
    /// They can.
    Followed,
    /// They cannot: other programs find them by theirs.
    Refused,
}

/// All rules, in the order in which they were given.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct Remaps {
    rules: Vec<Rule>,
}

impl Remaps {
    /// Takes the value of a `-r`.
    pub(super) fn take(&mut self, rule: &str) -> Result<(), RosArgsError> {
        let (left, to) = rule.split_once(":=").ok_or_else(|| RosArgsError::Assignment {
            flag: "-r",
            found: rule.to_owned(),
            expected: "[NODE:]FROM:=TO",
        })?;
        let (node, from) = match left.split_once(':') {
            Some((node, from)) => (Some(node), from),
            None => (None, left),
        };
        let (kind, to_is_allowed) = match from {
            "__ns" => (Kind::Namespace, is_namespace(to)),
            "__node" | "__name" => (Kind::NodeName, is_token(to)),
            _ => (Kind::Topic { from: from.to_owned() }, is_topic(to)),
        };
        let refused =
            |name: &str| RosArgsError::Name { rule: rule.to_owned(), name: name.to_owned() };
        if !to_is_allowed {
            return Err(refused(to));
        }
        if matches!(kind, Kind::Topic { .. }) && !is_topic(from) {
            return Err(refused(from));
        }
        if let Some(node) = node.filter(|node| !is_token(node)) {
            return Err(refused(node));
        }
        let text = rule.to_owned();
        self.rules.push(Rule { node: node.map(str::to_owned), kind, to: to.to_owned(), text });
        Ok(())
    }

    /// Refuses rules for nodes of these names that they could not follow.
    pub(super) fn check(&self, nodes: &[&str], topics: TopicRules) -> Result<(), RosArgsError> {
        let is_for_us =
            |rule: &&Rule| rule.node.as_deref().is_none_or(|node| nodes.contains(&node));
        for rule in self.rules.iter().filter(is_for_us) {
            let text = || rule.text.clone();
            match &rule.kind {
                Kind::NodeName if !nodes.contains(&rule.to.as_str()) => {
                    return Err(RosArgsError::FixedNode {
                        rule: text(),
                        nodes: nodes.join("`, `"),
                    });
                }
                Kind::Topic { .. } if topics == TopicRules::Refused => {
                    return Err(RosArgsError::FixedTopic {
                        rule: text(),
                        nodes: nodes.join("`, `"),
                    });
                }
                Kind::Namespace | Kind::NodeName | Kind::Topic { .. } => {}
            }
        }
        Ok(())
    }

    /// Namespace and name of a node; of several rules, the first counts.
    pub(super) fn node(&self, namespace: &str, name: &str) -> (String, String) {
        let first = |kind: &Kind, otherwise: &str| {
            let rule = self.rules_for(name).find(|rule| rule.kind == *kind);
            rule.map_or(otherwise, |rule| rule.to.as_str()).to_owned()
        };
        (first(&Kind::Namespace, namespace), first(&Kind::NodeName, name))
    }

    /// Full name of a topic; of several rules, the first counts.
    pub(super) fn topic(&self, (namespace, name): (&str, &str), topic: &str) -> String {
        let full = |topic: &str| full_name(namespace, name, topic);
        let asked = full(topic);
        let rule = self
            .rules_for(name)
            .find(|rule| matches!(&rule.kind, Kind::Topic { from } if full(from) == asked));
        rule.map_or(asked.clone(), |rule| full(&rule.to))
    }

    fn rules_for(&self, node: &str) -> impl Iterator<Item = &Rule> {
        self.rules.iter().filter(move |rule| rule.node.as_deref().is_none_or(|only| only == node))
    }
}

/// The full name of a relative, private or absolute topic.
fn full_name(namespace: &str, name: &str, topic: &str) -> String {
    let namespace = namespace.trim_end_matches('/');
    if topic.starts_with('/') {
        topic.to_owned()
    } else if let Some(private) = topic.strip_prefix("~/") {
        format!("{namespace}/{name}/{private}")
    } else {
        format!("{namespace}/{topic}")
    }
}

fn is_namespace(text: &str) -> bool {
    text == "/" || text.strip_prefix('/').is_some_and(|rest| rest.split('/').all(is_token))
}

fn is_topic(text: &str) -> bool {
    let text = text.strip_prefix("~/").or_else(|| text.strip_prefix('/')).unwrap_or(text);
    text.split('/').all(is_token)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn remaps(rules: &[&str]) -> Remaps {
        let mut remaps = Remaps::default();
        for rule in rules {
            remaps.take(rule).unwrap();
        }
        remaps
    }

    const NODE: (&str, &str) = ("/robot_3", "controller");

    #[test]
    fn a_node_is_renamed_and_moved() {
        let both = remaps(&["__ns:=/robot_3", "__node:=brain"]);

        assert_eq!(both.node("/", "controller"), ("/robot_3".into(), "brain".into()));
        assert_eq!(remaps(&["__name:=brain"]).node("/", "controller").1, "brain");
        assert_eq!(remaps(&[]).node("/", "controller"), ("/".into(), "controller".into()));
    }

    #[test]
    fn a_topic_is_found_under_its_relative_private_and_absolute_name() {
        for rule in ["cmd_vel:=/base/cmd_vel", "/robot_3/cmd_vel:=/base/cmd_vel"] {
            assert_eq!(remaps(&[rule]).topic(NODE, "cmd_vel"), "/base/cmd_vel");
        }
        assert_eq!(remaps(&["~/status:=status"]).topic(NODE, "~/status"), "/robot_3/status");
    }

    #[test]
    fn a_topic_without_a_rule_gets_its_full_name() {
        let none = remaps(&["detection:=seen"]);

        assert_eq!(none.topic(NODE, "cmd_vel"), "/robot_3/cmd_vel");
        assert_eq!(none.topic(NODE, "~/status"), "/robot_3/controller/status");
        assert_eq!(none.topic(NODE, "/clock"), "/clock");
        assert_eq!(none.topic(("/", "controller"), "cmd_vel"), "/cmd_vel");
    }

    #[test]
    fn the_first_rule_counts() {
        assert_eq!(remaps(&["a:=b", "a:=c", "b:=d"]).topic(NODE, "a"), "/robot_3/b");
        assert_eq!(remaps(&["__ns:=/a", "__ns:=/b"]).node("/", "x").0, "/a");
    }

    #[test]
    fn a_rule_for_one_node_leaves_the_others_alone() {
        let one = remaps(&["controller:__ns:=/robot_9", "controller:a:=b"]);

        assert_eq!(one.node("/", "controller").0, "/robot_9");
        assert_eq!(one.node("/", "robot").0, "/");
        assert_eq!(one.topic(("/", "controller"), "a"), "/b");
        assert_eq!(one.topic(("/", "robot"), "a"), "/a");
    }

    #[test]
    fn what_a_program_could_not_follow_is_refused_by_name() {
        let check = |rule: &str, topics| remaps(&[rule]).check(&["robot", "controller"], topics);
        let refused = |rule, topics| check(rule, topics).unwrap_err().to_string();

        assert!(check("__node:=controller", TopicRules::Refused).is_ok());
        assert!(check("a:=b", TopicRules::Followed).is_ok());
        assert!(check("other:a:=b", TopicRules::Refused).is_ok());
        assert_eq!(
            refused("__node:=brain", TopicRules::Followed),
            "`-r __node:=brain`: the nodes of this program are called `robot`, `controller`, by \
             which others find them"
        );
        assert!(refused("robot:a:=b", TopicRules::Refused).starts_with("`-r robot:a:=b`: the"));
    }

    #[test]
    fn names_that_ros_does_not_allow_are_refused() {
        let rules = [
            "__ns:=robot_3",
            "__ns:=/robot 3",
            "__node:=/a",
            "__node:=3a",
            "a:=",
            ":=b",
            "a//b:=c",
        ];
        for rule in rules {
            let error = Remaps::default().take(rule).unwrap_err();

            assert!(matches!(error, RosArgsError::Name { .. }), "{rule}: {error}");
        }
        let error = Remaps::default().take("cmd_vel=base").unwrap_err();
        assert_eq!(error.to_string(), "`cmd_vel=base` after -r, expected [NODE:]FROM:=TO");
    }
}
