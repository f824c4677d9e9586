//! Topics that are there under nearly the name of one that is missing.

use rsrs_core::document;

use super::{Expected, ExpectedTopic, Graph};

/// A topic of the same type that nobody else expects: a slip of the hand away, or the same in another namespace.
pub(super) fn nearest(
    missing: &ExpectedTopic,
    expected: &Expected,
    graph: &Graph,
) -> Option<String> {
    let is_expected = |name: &str| expected.topics.iter().any(|topic| topic.name == name);
    let mut others: Vec<&str> = (graph.publishers.iter())
        .filter(|end| end.type_name == missing.type_name && !is_expected(&end.topic))
        .map(|end| end.topic.as_str())
        .collect();
    others.sort_unstable();
    let is_in_another =
        |other: &&str| other.ends_with(&missing.name) || missing.name.ends_with(*other);
    let slip = others.iter().find(|other| is_slip(&missing.name, other));
    slip.or_else(|| others.iter().find(|other| is_in_another(other))).map(|name| (*name).to_owned())
}

/// Whether each part of a name is nearly that of another, with the same digits: `robot_4` is another robot than
/// `robot_3`.
fn is_slip(name: &str, other: &str) -> bool {
    let digits = |part: &str| -> String { part.chars().filter(char::is_ascii_digit).collect() };
    let [parts, others] = [name, other].map(|name| name.split('/').collect::<Vec<_>>());
    let is_near = |(part, other): (&&str, &&str)| {
        part == other
            || digits(part) == digits(other) && document::nearest(part, [*other]).is_some()
    };
    parts.len() == others.len() && parts.iter().zip(&others).all(is_near)
}
