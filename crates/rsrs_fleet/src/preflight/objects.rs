//! Objects that a tracker sees, beside those of the run's world.

use std::collections::BTreeSet;

use rsrs_msgs::topics;

use super::{Expected, Graph, Problem};

/// Topics with poses of objects that the world does not have.
fn unknown(objects: &BTreeSet<String>, graph: &Graph) -> Vec<String> {
    let names: BTreeSet<&str> = graph.publishers.iter().map(|end| end.topic.as_str()).collect();
    let is_unknown = |name: &&str| topics::object_of(name).is_some_and(|it| !objects.contains(it));
    names.into_iter().filter(is_unknown).map(str::to_owned).collect()
}

/// What is on the floor of a world with objects, and not in it.
pub(super) fn strange(expected: &Expected, graph: &Graph) -> Option<Problem> {
    let objects = expected.objects.as_ref().filter(|objects| !objects.is_empty())?;
    let topics = unknown(objects, graph);
    let n_objects = objects.len();
    (!topics.is_empty()).then_some(Problem::StrangeObjects { topics, n_objects })
}

/// That objects are tracked where the world has none: they may be those of a run beside it.
pub(crate) fn note(expected: &Expected, graph: &Graph) -> Option<String> {
    let objects = expected.objects.as_ref().filter(|objects| objects.is_empty())?;
    let topics = unknown(objects, graph);
    (!topics.is_empty()).then(|| {
        let topics = topics.join(", ");
        format!(
            "note: {topics}: the run's world has no objects (if these are on its floor, name a `world` with them)"
        )
    })
}
