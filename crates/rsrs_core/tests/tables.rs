//! Tables of trials as the fit takes them.

use rsrs_core::trials::fit::Tables;
use rsrs_core::trials::trial::{
    DetectionTrial, MovedBy, PeriodTrial, SpeedTrial, Trials, TurnTrial,
};

/// A table in which no commands paused.
pub fn trials<Row>(file: &str, robots: Vec<String>, rows: Vec<Row>) -> Trials<Row> {
    let (paused, moved_by) = (Vec::new(), MovedBy::default());
    Trials { file: file.to_owned(), robots, rows, paused, moved_by }
}

/// Straight runs, turns in place and detections, with periods if they were measured, and nothing else.
pub fn tables<'a>(
    speed: &'a Trials<SpeedTrial>,
    turn: &'a Trials<TurnTrial>,
    detection: &'a Trials<DetectionTrial>,
    period: Option<&'a Trials<PeriodTrial>>,
) -> Tables<'a> {
    let moved_by = MovedBy::default();
    Tables { speed, turn, detection, period, driven: &[], arc: None, from_rest: &[], moved_by }
}
