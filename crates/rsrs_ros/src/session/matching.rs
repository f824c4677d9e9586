//! Waiting for others, by way of the discovery database.

use std::time::{Duration, Instant};

use super::{EndpointKind, NotMatched, POLL, Session, endpoint};

impl Session {
    /// Waits until at least so many subscribers of a topic are known.
    pub async fn wait_for_readers(
        &self,
        topic: &str,
        at_least: usize,
        timeout: Duration,
    ) -> Result<(), NotMatched> {
        self.wait_for(EndpointKind::Reader, topic, at_least, timeout).await
    }

    /// Waits until at least so many publishers of a topic are known.
    pub async fn wait_for_writers(
        &self,
        topic: &str,
        at_least: usize,
        timeout: Duration,
    ) -> Result<(), NotMatched> {
        self.wait_for(EndpointKind::Writer, topic, at_least, timeout).await
    }

    async fn wait_for(
        &self,
        kind: EndpointKind,
        topic: &str,
        wanted: usize,
        timeout: Duration,
    ) -> Result<(), NotMatched> {
        let start = Instant::now();
        loop {
            let found = endpoint::count(&self.participant, kind, topic);
            let waited = start.elapsed();
            if found >= wanted {
                return Ok(());
            }
            if waited >= timeout {
                let topic = topic.to_owned();
                let waited_s = waited.as_secs_f64();
                return Err(NotMatched { topic, kind, found, wanted, waited_s });
            }
            tokio::time::sleep(POLL).await;
        }
    }
}
