//! The bag of a run: opened, filled and closed.

use rsrs_fleet::runner::Event;
use rsrs_msgs::std_msgs;

use super::{Run, Sample};
use crate::recorder::Recorder;

impl Run<'_> {
    /// Has a sample written into the bag, if one is open.
    pub(super) fn record(&mut self, sample: &Sample) -> Option<Event> {
        let recorder = self.recorder.as_mut()?;
        let taken = recorder.take(
            sample.topic_index,
            &self.recorded_topics[sample.topic_index],
            &sample.received,
        );
        taken.err().map(|error| Event::RecorderFailed { reason: error.in_full() })
    }

    pub(super) fn open_recorder(&mut self) -> Option<Event> {
        let to_written = self.to_written.clone();
        let opened = Recorder::open(self.plan, &self.record, &self.recorded_topics, to_written);
        let begun = opened.and_then(|mut recorder| {
            for (topic_index, received) in self.early.take() {
                recorder.take(topic_index, &self.recorded_topics[topic_index], &received)?;
            }
            Ok(recorder)
        });
        match begun {
            Ok(recorder) => {
                self.recorder = Some(recorder);
                None
            }
            Err(error) => Some(Event::RecorderFailed { reason: error.in_full() }),
        }
    }

    /// Publishes what the bag also holds.
    pub(super) async fn publish_note(&self, publisher: usize, data: String) -> anyhow::Result<()> {
        if !self.is_cut_off {
            self.notes[publisher].publish(std_msgs::String { data }).await?;
        }
        Ok(())
    }

    pub(super) async fn close_recorder(&mut self) -> anyhow::Result<Option<Event>> {
        let ending = self.machine.ending();
        let ending = ending.expect("the recorder is closed when the run has ended");
        self.publish_note(1, ending.to_json(&self.plan.record.run_id)).await?;
        let Some(recorder) = self.recorder.take() else {
            return Ok(Some(Event::RecorderClosed));
        };
        self.n_lost = recorder.n_lost();
        self.closing = Some(recorder.close(&ending));
        Ok(None)
    }
}
