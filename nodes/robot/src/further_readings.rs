//! What further sensors report, of a robot whose hardware has several.

use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::time::Duration;

use rsrs_core::robot::sensor::MOST_READINGS;
use rsrs_fleet::robot::detector::{Detector, DetectorSettings, Reading};
use rsrs_msgs::std_msgs::Bool;
use rsrs_msgs::topics;
use rsrs_ros::logging::Level;
use rsrs_ros::session::{NodeHandle, Publisher, Session};

/// What further sensors report.
#[derive(Default)]
pub struct FurtherReadings {
    /// Each reading by its name, and where it is published.
    published: BTreeMap<String, (Detector, Publisher<Bool>)>,
    /// Whether it was said that there are more.
    are_too_many: bool,
}

/// Readings that a robot has besides `detection`.
const MOST_FURTHER: usize = MOST_READINGS - 1;

impl FurtherReadings {
    /// Takes what the hardware reports; a name that is new gets a topic, as long as robots may have so many.
    pub fn take(
        &mut self,
        reported: Vec<(String, bool)>,
        (session, node, robot): (&Session, &NodeHandle, &str),
        (settings, now): (&DetectorSettings, Duration),
    ) -> anyhow::Result<()> {
        for (name, is_true) in reported {
            let n_known = self.published.len();
            let (detector, _) = match self.published.entry(name) {
                Entry::Occupied(known) => known.into_mut(),
                Entry::Vacant(new) if n_known == MOST_FURTHER => {
                    if !std::mem::replace(&mut self.are_too_many, true) {
                        let text = format!(
                            "the hardware reports `{}` beside {MOST_FURTHER} further readings, which is as many as a \
                             robot has; it is not published",
                            new.key()
                        );
                        node.log(Level::Warn, &text);
                    }
                    continue;
                }
                Entry::Vacant(new) => {
                    let topic = topics::further_detection(robot, new.key());
                    // As `detection` is: in real time the newest counts.
                    let publisher = session.publish_on(node, &topic, topics::DETECTION.qos)?;
                    new.insert((Detector::default(), publisher))
                }
            };
            detector.on_reading(Reading::Seen(is_true), settings, now);
        }
        Ok(())
    }

    /// Publishes each of which something is known.
    pub async fn publish(&self, settings: &DetectorSettings, now: Duration) -> anyhow::Result<()> {
        for (detector, publisher) in self.published.values() {
            if let Ok(data) = detector.detected(settings, now) {
                publisher.publish(Bool { data }).await?;
            }
        }
        Ok(())
    }
}
