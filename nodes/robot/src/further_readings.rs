//! What further sensors report, of a robot whose hardware has several.

use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::time::Duration;

use rsrs_fleet::robot::detector::{Detector, DetectorSettings, Reading};
use rsrs_msgs::std_msgs::Bool;
use rsrs_msgs::topics;
use rsrs_ros::session::{NodeHandle, Publisher, Session};

/// Each reading by its name, and where it is published.
#[derive(Default)]
pub struct FurtherReadings(BTreeMap<String, (Detector, Publisher<Bool>)>);

impl FurtherReadings {
    /// Takes what the hardware reports; a name that is new gets a topic.
    ///
    /// # Errors
    ///
    /// If the topic cannot be made.
    pub fn take(
        &mut self,
        reported: Vec<(String, bool)>,
        (session, node, robot): (&Session, &NodeHandle, &str),
        (settings, now): (&DetectorSettings, Duration),
    ) -> anyhow::Result<()> {
        for (name, is_true) in reported {
            let (detector, _) = match self.0.entry(name) {
                Entry::Occupied(known) => known.into_mut(),
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
    ///
    /// # Errors
    ///
    /// If a reliable subscriber stops acknowledging.
    pub async fn publish(&self, settings: &DetectorSettings, now: Duration) -> anyhow::Result<()> {
        for (detector, publisher) in self.0.values() {
            if let Ok(data) = detector.detected(settings, now) {
                publisher.publish(Bool { data }).await?;
            }
        }
        Ok(())
    }
}
