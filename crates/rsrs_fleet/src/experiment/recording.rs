//! What is recorded besides the topics of every run, and how the bag is laid out.

use rsrs_msgs::topics;
use serde::Deserialize;

/// The part of an experiment file on what is recorded.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct RecordOptions {
    /// Topics of any type. A name with a slash in front is one topic; one without is a topic of each
    /// robot, in its namespace.
    pub topics: Vec<String>,
    /// Folders with the definitions of their types, relative to the experiment file: a workspace, its
    /// `src` or `install`, or a prefix. Those of `AMENT_PREFIX_PATH` come behind them.
    pub definitions: Vec<String>,
    /// A bag of this size takes no more and ends the run, in GiB; no limit by default.
    pub max_bag_gib: Option<f64>,
    /// A file of this size is closed and another one opened, in GiB; one file by default.
    pub split_gib: Option<f64>,
    /// How the bag is compressed.
    pub compression: BagCompression,
}

/// How a bag is compressed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum BagCompression {
    /// Not at all.
    None,
    /// Small.
    #[default]
    Zstd,
    /// Fast.
    Lz4,
}

const GIB: f64 = (1_u64 << 30) as f64;

/// Whole bytes in so many GiB, which are positive and finite, as [`RecordOptions::check`] leaves
/// them.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "sizes are positive, and more than any disk holds stays at the largest number"
)]
pub fn bytes(gib: f64) -> u64 {
    (gib * GIB) as u64
}

/// Why a `record:` is refused.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum RecordRefused {
    /// A size that is none.
    #[error("record.{key} is {found_gib} GiB, expected a finite size above 0 GiB")]
    Size {
        /// The key.
        key: &'static str,
        /// The value found, in GiB.
        found_gib: f64,
    },
    /// A name that ROS 2 does not allow.
    #[error(
        "record.topics: {found:?} is no topic, expected a name such as `/map`, or `battery` for one of \
         each robot"
    )]
    Topic {
        /// The name.
        found: String,
    },
}

impl RecordOptions {
    /// Refuses the first of the options that cannot be meant.
    pub fn check(&self) -> Result<(), RecordRefused> {
        for (key, size) in [("max_bag_gib", self.max_bag_gib), ("split_gib", self.split_gib)] {
            match size {
                Some(found_gib) if !(found_gib > 0.0 && found_gib.is_finite()) => {
                    return Err(RecordRefused::Size { key, found_gib });
                }
                _ => {}
            }
        }
        match self.topics.iter().find(|name| !is_name(name)) {
            Some(found) => Err(RecordRefused::Topic { found: found.clone() }),
            None => Ok(()),
        }
    }

    /// Full names of the topics, for these robots; each once.
    pub fn topics_of(&self, robots: &[String]) -> Vec<String> {
        let mut names = Vec::new();
        for topic in &self.topics {
            if topic.starts_with('/') {
                names.push(topic.clone());
            } else {
                names.extend(robots.iter().map(|robot| format!("/{robot}/{topic}")));
            }
        }
        names.sort();
        names.dedup();
        names
    }
}

/// Whether ROS 2 allows the name.
fn is_name(name: &str) -> bool {
    name.strip_prefix('/').unwrap_or(name).split('/').all(topics::is_token)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_without_a_slash_is_a_topic_of_each_robot() {
        let options = RecordOptions {
            topics: ["battery", "/map", "camera/image", "/map"].map(str::to_owned).into(),
            ..RecordOptions::default()
        };

        let topics = options.topics_of(&["a".to_owned(), "b".to_owned()]);

        let expected = ["/a/battery", "/a/camera/image", "/b/battery", "/b/camera/image", "/map"];
        assert_eq!(topics, expected);
    }

    #[test]
    fn what_cannot_be_meant_is_refused() {
        for name in ["", "/", "a//b", "~/a", "2d", "a b", "/a/"] {
            let options =
                RecordOptions { topics: vec![name.to_owned()], ..RecordOptions::default() };

            assert!(matches!(options.check(), Err(RecordRefused::Topic { .. })), "{name}");
        }
        for found_gib in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            let options = RecordOptions { split_gib: Some(found_gib), ..RecordOptions::default() };

            assert!(matches!(options.check(), Err(RecordRefused::Size { .. })), "{found_gib}");
        }
    }
}
