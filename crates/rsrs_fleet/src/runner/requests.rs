//! Requests that are repeated until each has been answered well.

use std::time::Duration;

use super::Target;
use crate::timing::RETRY_PERIOD;

/// One request to each target.
#[derive(Clone, Debug, Default)]
pub(super) struct Requests {
    open: Vec<Request>,
}

#[derive(Clone, Debug)]
struct Request {
    target: Target,
    asked: Option<Duration>,
    problem: Option<String>,
}

impl Requests {
    pub(super) fn new(targets: impl IntoIterator<Item = Target>) -> Self {
        let open = targets
            .into_iter()
            .map(|target| Request { target, asked: None, problem: None })
            .collect();
        Self { open }
    }

    /// Targets to ask now, for the first time or again.
    pub(super) fn due(&mut self, now: Duration) -> Vec<Target> {
        self.open
            .iter_mut()
            .filter(|request| {
                request.asked.is_none_or(|asked| now.saturating_sub(asked) >= RETRY_PERIOD)
            })
            .map(|request| {
                request.asked = Some(now);
                request.target.clone()
            })
            .collect()
    }

    pub(super) fn answer(&mut self, target: &Target, result: Result<(), String>) {
        match result {
            Ok(()) => self.open.retain(|request| request.target != *target),
            Err(problem) => {
                for request in self.open.iter_mut().filter(|request| request.target == *target) {
                    request.problem = Some(problem.clone());
                }
            }
        }
    }

    pub(super) fn is_done(&self) -> bool {
        self.open.is_empty()
    }

    /// Targets that have not answered well, with what they answered last.
    pub(super) fn problems(&self) -> Vec<(Target, String)> {
        self.open
            .iter()
            .map(|request| {
                let problem = request.problem.clone();
                (request.target.clone(), problem.unwrap_or_else(|| "no answer".to_owned()))
            })
            .collect()
    }
}
