//! Order parameters that a window has only where the rules of a behaviour ask for them: so others cost nothing.

use std::fmt;
use std::ops::Range;

use serde::de::{Deserialize, Deserializer, IgnoredAny, MapAccess, Visitor};
use serde::{Serialize, Serializer};

use super::measure::{Look, N_ASKED};
use super::parameter::{Parameter, Prerequisite};
use super::samples::Samples;
use super::{rounded, rounds_surely};
use crate::judge::trajectory::{Bodies, Trajectory};

/// The values of those that were asked for; in files under their names, beside the others.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Asked(pub(super) [Option<f64>; N_ASKED]);

impl Serialize for Asked {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let known = Parameter::all_asked().zip(self.0);
        serializer.collect_map(known.filter_map(|(it, value)| Some((it.key(), value?))))
    }
}

impl<'de> Deserialize<'de> for Asked {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct ByKey;
        impl<'de> Visitor<'de> for ByKey {
            type Value = Asked;
            fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
                formatter.write_str("order parameters by name")
            }
            fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Asked, A::Error> {
                let mut asked = Asked::default();
                while let Some(key) = map.next_key::<String>()? {
                    let mut named = Parameter::all_asked().zip(&mut asked.0);
                    match named.find(|(it, _)| it.key() == key) {
                        Some((_, value)) => *value = map.next_value()?,
                        None => {
                            map.next_value::<IgnoredAny>()?;
                        }
                    }
                }
                Ok(asked)
            }
        }
        deserializer.deserialize_map(ByKey)
    }
}

/// Measures what is asked for in a window of one lane, which is not empty. What has a field of its
/// own is left out, and so is what lacks something that it needs.
pub fn measured<S: Samples>(
    (samples, bodies): (&S, &Bodies),
    window: &Range<usize>,
    lane: usize,
    asked: &[Parameter],
) -> Asked {
    let mut found = Asked::default();
    if asked.is_empty() {
        return found;
    }
    let has_objects = samples.n_objects() == bodies.world.n_objects();
    let has_classes = samples.poses_at(window.start).len() == bodies.classes.len();
    let is_measured = |it: &Parameter| {
        asked.contains(it)
            && it.lacks(bodies).is_none()
            && (has_objects || !it.needs(Prerequisite::Objects))
            && (has_classes || !it.needs(Prerequisite::Classes))
    };
    let all = Parameter::all().filter_map(|it| Some((it, it.asked()?)));
    let mut look: Option<Look> = None;
    for ((parameter, measure), value) in all.zip(&mut found.0) {
        if !is_measured(&parameter) {
            continue;
        }
        let look = look.get_or_insert_with(|| Look::new(samples, bodies, window, lane));
        *value = Some(if measure.is_of_headings {
            let mean = (measure.of)(look);
            // As the means over headings among the sums: by how much one may differ is a constant for what a
            // heading may be longer or shorter than 1, and for each addition.
            let margin = 2e-13 + 2.3e-16 * look.places.len() as f64;
            let again = (!rounds_surely(mean, margin))
                .then(|| samples.trajectory(lane, window.clone()))
                .flatten();
            let by_definition =
                |it: Trajectory| (measure.of)(&Look::new(&it, bodies, &(0..it.n_samples()), 0));
            rounded(again.map_or(mean, by_definition))
        } else {
            (measure.of)(look)
        });
    }
    found
}
