//! What a run does every now and then, whatever arrives.

use std::collections::BTreeMap;
use std::time::Duration;

use rsrs_core::judge::window::MAX_GAP_S;
use rsrs_fleet::experiment::Time;
use rsrs_fleet::rates::Rates;
use rsrs_msgs::rsrs::Recorded;

use super::Run;
use crate::recorded_topics::Role;
use crate::report::Progress;

impl Run<'_> {
    /// Subscribes what was requested by name, as soon as it has a publisher.
    pub(super) fn look_for_extras(&mut self) -> anyhow::Result<BTreeMap<String, String>> {
        if self.recorder.is_none() {
            self.extras.look(self.session, &mut self.recorded_topics)?;
        }
        Ok(self.extras.unrecordable())
    }

    /// A confirmation that was not received must not hold the world for ever.
    pub(super) async fn repeat_recorded(&mut self) -> anyhow::Result<()> {
        let step = self.recorded_step;
        if step > 0 && !self.is_cut_off {
            self.recorded.publish(Recorded { step }).await?;
        }
        Ok(())
    }

    /// While robots move in real time, reports how long they have, and what comes too rarely.
    pub(super) fn watch_rates(&mut self) {
        let now = self.start.elapsed();
        let (Some(running), Time::RealTime) =
            (self.machine.running_for(now), self.plan.record.time)
        else {
            return;
        };
        let of = Duration::from_secs_f64(self.plan.record.duration_s).as_secs();
        (self.watch)(Progress::Done { done: running.as_secs(), of });
        let (recorded_topics, period_s) =
            (&self.recorded_topics, self.plan.record.conditions.period_s);
        let rates = self.rates.get_or_insert_with(|| {
            let each_s = |role: Role| match role {
                Role::Detection(_) | Role::FurtherDetection(_) | Role::Command(_) => Some(period_s),
                // The judge bridges gaps of twice that.
                Role::Object => Some(MAX_GAP_S / 2.0),
                _ => None,
            };
            let topics = recorded_topics.iter().filter_map(|recorded_topic| {
                Some((recorded_topic.name.clone(), each_s(recorded_topic.role)?))
            });
            Rates::new(topics, now)
        });
        for change in rates.changes(now) {
            self.note(&change);
        }
    }
}
