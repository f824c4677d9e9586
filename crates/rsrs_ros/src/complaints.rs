//! Warnings about what others publish, which may be wrong a thousand times a second.

use std::time::{Duration, Instant};

use crate::logging::Level;
use crate::session::NodeHandle;

/// How often warnings of one kind are logged, at most.
const COMPLAINT: Duration = Duration::from_secs(1);

/// Warnings of one kind, of which one a second is logged, with the number of those in between: a wrong
/// program sends thousands of messages, and the log goes to all of `/rosout`.
#[derive(Clone, Copy, Debug, Default)]
pub struct Complaints {
    last: Option<Instant>,
    n_left_out: u64,
}

impl Complaints {
    /// Logs a warning, or counts it.
    pub fn warn(&mut self, node: &NodeHandle, text: &str) {
        if let Some(text) = self.due(text, Instant::now()) {
            node.log(Level::Warn, &text);
        }
    }

    fn due(&mut self, text: &str, now: Instant) -> Option<String> {
        if self.last.is_some_and(|last| now.saturating_duration_since(last) < COMPLAINT) {
            self.n_left_out += 1;
            return None;
        }
        self.last = Some(now);
        Some(match std::mem::take(&mut self.n_left_out) {
            0 => text.to_owned(),
            n_left_out => format!("{text} (and {n_left_out} more since the last of these)"),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn of_a_thousand_wrong_messages_a_second_one_is_logged_and_the_others_are_counted() {
        let mut complaints = Complaints::default();
        let start = Instant::now();

        let logged: Vec<_> = (0..3000)
            .filter_map(|at| complaints.due("refused", start + Duration::from_millis(at)))
            .collect();

        let more = "refused (and 999 more since the last of these)";
        assert_eq!(logged, ["refused", more, more]);
    }
}
