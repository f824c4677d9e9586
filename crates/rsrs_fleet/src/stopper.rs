//! Who stops everything: says so until every robot has acknowledged, with or without a runner.
//!
//! A robot acknowledges by its status: while the e-stop holds it, it is stopped and its reason begins
//! with [`E_STOP_REASON`](crate::message::E_STOP_REASON). The lock outlives whoever engaged it; a
//! release is a word too. A robot that was stopped in a run stands until a newer epoch arms it,
//! released or not.

use std::collections::BTreeMap;
use std::time::Duration;

use crate::message::{RobotState, Status};
use crate::timing::{ACKNOWLEDGE, BEAT, LOOK};

/// What every robot is to hear.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Word {
    /// Stand, whatever anybody else says.
    Engage,
    /// A newer epoch may move you.
    Release,
}

/// What happens to a stopper.
#[derive(Clone, Debug, PartialEq)]
pub enum Event {
    /// There is a robot of this name, or there should be.
    Found {
        /// The robot.
        robot: String,
    },
    /// A robot said what it does.
    Status {
        /// The robot.
        robot: String,
        /// Its word.
        status: Status,
    },
    /// Someone does not want to wait any longer.
    Interrupt,
    /// Time passed.
    Tick,
}

/// What a stopper does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Action {
    /// Publish this on the e-stop topic.
    Say(bool),
    /// It is over, and so it ended; nothing more comes.
    Finish(Ending),
}

/// How a stop or release ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ending {
    /// Every known robot has acknowledged, and there is at least one.
    Acknowledged,
    /// The time is up, and some robot has not acknowledged, or there is none.
    TimedOut,
    /// It was interrupted while some robot had not acknowledged.
    Interrupted,
    /// A release would do harm: robots are in a run, and would take the silence after it for a stop.
    /// Nothing was said.
    InRun,
}

/// What came of a stop for one robot.
#[derive(Clone, Debug, PartialEq)]
pub struct Answer {
    /// The robot.
    pub robot: String,
    /// From the first word until its acknowledgement was heard; `None` if it has not acknowledged.
    pub acknowledged_after: Option<Duration>,
    /// Its last status; `None` if none was heard.
    pub last: Option<Status>,
}

/// Stops, or releases, every robot there is.
#[derive(Clone, Debug)]
pub struct Stopper {
    word: Word,
    robots: BTreeMap<String, Heard>,
    started: Option<Duration>,
    /// When the word was said first, and last.
    said: Option<(Duration, Duration)>,
    is_interrupted: bool,
    is_over: bool,
}

#[derive(Clone, Debug, Default)]
struct Heard {
    /// Its newest status, and when it came.
    last: Option<(Status, Duration)>,
    acknowledged: Option<Duration>,
}

impl Stopper {
    /// A stopper that knows no robot and has said nothing.
    pub fn new(word: Word) -> Self {
        Self {
            word,
            robots: BTreeMap::new(),
            started: None,
            said: None,
            is_interrupted: false,
            is_over: false,
        }
    }

    /// Takes an event.
    ///
    /// # Returns
    ///
    /// What to do, in order.
    pub fn on_event(&mut self, event: Event, now: Duration) -> Vec<Action> {
        if self.is_over {
            return Vec::new();
        }
        let started = *self.started.get_or_insert(now);
        self.take(event, now);

        let elapsed = now.saturating_sub(started);
        let mut actions: Vec<_> = self.say(elapsed, now).into_iter().collect();
        if let Some(ending) = self.ending(elapsed) {
            self.is_over = true;
            actions.push(Action::Finish(ending));
        }
        actions
    }

    /// What came of it for each robot so far, by name.
    pub fn answers(&self) -> Vec<Answer> {
        let first = self.said.map_or(Duration::ZERO, |(first, _)| first);
        let answers = self.robots.iter().map(|(robot, heard)| Answer {
            robot: robot.clone(),
            acknowledged_after: heard.acknowledged.map(|at| at.saturating_sub(first)),
            last: heard.last.as_ref().map(|(status, _)| status.clone()),
        });
        answers.collect()
    }

    fn take(&mut self, event: Event, now: Duration) {
        match event {
            Event::Found { robot } => {
                self.robots.entry(robot).or_default();
            }
            Event::Status { robot, status } => {
                let (word, has_said) = (self.word, self.said.is_some());
                let heard = self.robots.entry(robot).or_default();
                let last = heard.last.as_ref().map(|(status, at)| (status.counter, *at));
                if !status.is_news(last, now) {
                    return;
                }
                // A status that contradicts an earlier one counts: another word may have come after
                // ours.
                heard.acknowledged = (has_said && acknowledges(word, &status))
                    .then(|| heard.acknowledged.unwrap_or(now));
                heard.last = Some((status, now));
            }
            Event::Interrupt => self.is_interrupted = true,
            Event::Tick => {}
        }
    }

    /// Says the word ten times a second; a release only after a look at what it would do.
    fn say(&mut self, elapsed: Duration, now: Duration) -> Option<Action> {
        if self.said.is_none() && self.word == Word::Release && (elapsed < LOOK || self.is_in_run())
        {
            return None;
        }
        let is_due = self.said.is_none_or(|(_, last)| now.saturating_sub(last) >= BEAT);
        is_due.then(|| {
            let first = self.said.map_or(now, |(first, _)| first);
            self.said = Some((first, now));
            Action::Say(self.word == Word::Engage)
        })
    }

    fn ending(&self, elapsed: Duration) -> Option<Ending> {
        let all = !self.robots.is_empty()
            && self.robots.values().all(|heard| heard.acknowledged.is_some());
        if self.word == Word::Release && elapsed >= LOOK && self.said.is_none() {
            return Some(Ending::InRun);
        }
        if all && elapsed >= LOOK {
            Some(Ending::Acknowledged)
        } else if self.is_interrupted {
            Some(if all { Ending::Acknowledged } else { Ending::Interrupted })
        } else {
            (elapsed >= LOOK + ACKNOWLEDGE).then_some(Ending::TimedOut)
        }
    }

    fn is_in_run(&self) -> bool {
        let last = self.robots.values().filter_map(|heard| heard.last.as_ref());
        last.into_iter()
            .any(|(status, _)| matches!(status.state, RobotState::Armed | RobotState::Moving))
    }
}

/// A robot whose hardware has failed stands as well, and can say no more than that.
fn acknowledges(word: Word, status: &Status) -> bool {
    match word {
        Word::Engage => status.holds_e_stop() || status.state == RobotState::Fault,
        Word::Release => !status.holds_e_stop(),
    }
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::{AtomicU64, Ordering};

    use super::*;
    use crate::message::E_STOP_REASON;

    fn ms(milliseconds: u64) -> Duration {
        Duration::from_millis(milliseconds)
    }

    fn status(state: RobotState, stop_reason: &str) -> Status {
        // Each is newer than all before it.
        static COUNTER: AtomicU64 = AtomicU64::new(1);
        Status {
            counter: COUNTER.fetch_add(1, Ordering::Relaxed),
            epoch: 0,
            parameter_digest: 0,
            state,
            stop_reason: stop_reason.to_owned(),
            battery_v: f32::NAN,
        }
    }

    fn says(robot: &str, state: RobotState, stop_reason: &str) -> Event {
        Event::Status { robot: robot.to_owned(), status: status(state, stop_reason) }
    }

    fn found(robot: &str) -> Event {
        Event::Found { robot: robot.to_owned() }
    }

    #[test]
    fn the_first_word_is_said_at_once_and_then_ten_times_a_second() {
        let mut stopper = Stopper::new(Word::Engage);

        let times: Vec<_> = (0..30)
            .map(|tick| 10 * tick)
            .filter(|at| stopper.on_event(Event::Tick, ms(*at)) == [Action::Say(true)])
            .collect();

        assert_eq!(times, [0, 100, 200]);
    }

    #[test]
    fn it_ends_when_every_robot_stands_and_none_turns_up_any_more() {
        let mut stopper = Stopper::new(Word::Engage);
        stopper.on_event(Event::Tick, ms(0));
        stopper.on_event(says("robot_1", RobotState::Stopped, "e-stop"), ms(40));

        assert!(!stopper.on_event(Event::Tick, ms(1_999)).contains(&finished()));
        assert!(stopper.on_event(Event::Tick, ms(2_000)).contains(&finished()));
        assert_eq!(stopper.answers()[0].acknowledged_after, Some(ms(40)));
    }

    fn finished() -> Action {
        Action::Finish(Ending::Acknowledged)
    }

    #[test]
    fn a_robot_that_stands_for_another_reason_has_not_acknowledged() {
        for (state, reason) in [
            (RobotState::Idle, "belongs to no run"),
            (RobotState::Armed, "armed, waiting for the start"),
            (RobotState::Moving, ""),
            (RobotState::Stopped, "lease ran out"),
        ] {
            let mut stopper = Stopper::new(Word::Engage);
            stopper.on_event(Event::Tick, ms(0));

            stopper.on_event(says("robot_1", state, reason), ms(50));

            assert_eq!(stopper.answers()[0].acknowledged_after, None, "{state}");
        }
    }

    #[test]
    fn who_is_expected_and_silent_is_named_after_a_bounded_time() {
        let mut stopper = Stopper::new(Word::Engage);
        stopper.on_event(found("robot_9"), ms(0));
        stopper.on_event(says("robot_1", RobotState::Fault, "hardware fault: wheel"), ms(50));

        let end = stopper.on_event(Event::Tick, ms(7_000));

        assert!(end.contains(&Action::Finish(Ending::TimedOut)), "{end:?}");
        let silent: Vec<_> = stopper
            .answers()
            .into_iter()
            .filter(|answer| answer.acknowledged_after.is_none())
            .map(|answer| answer.robot)
            .collect();
        assert_eq!(silent, ["robot_9"]);
    }

    #[test]
    fn an_acknowledgement_that_comes_late_or_again_is_none() {
        let mut stopper = Stopper::new(Word::Engage);
        stopper.on_event(Event::Tick, ms(0));
        let earlier = says("a", RobotState::Stopped, E_STOP_REASON);
        stopper.on_event(says("a", RobotState::Moving, ""), ms(10));

        stopper.on_event(earlier, ms(20));

        assert_eq!(stopper.answers()[0].acknowledged_after, None);
    }

    #[test]
    fn no_robot_at_all_is_no_acknowledgement() {
        let mut stopper = Stopper::new(Word::Engage);
        stopper.on_event(Event::Tick, ms(0));

        let end = stopper.on_event(Event::Tick, ms(7_000));

        assert!(end.contains(&Action::Finish(Ending::TimedOut)), "{end:?}");
    }

    #[test]
    fn a_robot_that_is_released_by_someone_else_has_no_longer_acknowledged() {
        let mut stopper = Stopper::new(Word::Engage);
        stopper.on_event(Event::Tick, ms(0));
        stopper.on_event(says("robot_1", RobotState::Stopped, "e-stop"), ms(50));

        stopper.on_event(says("robot_1", RobotState::Stopped, "stopped by the e-stop"), ms(90));

        assert_eq!(stopper.answers()[0].acknowledged_after, None);
    }

    #[test]
    fn a_release_looks_first_and_ends_when_no_robot_is_locked() {
        let mut stopper = Stopper::new(Word::Release);
        let locked = || says("robot_1", RobotState::Stopped, "e-stop");
        assert_eq!(stopper.on_event(locked(), ms(0)), []);

        assert_eq!(stopper.on_event(locked(), ms(2_000)), [Action::Say(false)]);
        let end =
            stopper.on_event(says("robot_1", RobotState::Stopped, "lease ran out"), ms(2_050));

        assert_eq!(end, [finished()]);
    }

    #[test]
    fn a_release_among_moving_robots_says_nothing() {
        let mut stopper = Stopper::new(Word::Release);
        stopper.on_event(says("robot_1", RobotState::Moving, ""), ms(0));

        assert_eq!(stopper.on_event(Event::Tick, ms(2_000)), [Action::Finish(Ending::InRun)]);
    }
}
