//! The ending of a run whose robots lack poses here and there, or were not seen at the same times.

use super::Run;
use super::finish::Ending;
use crate::trajectory::Keep;
use crate::trajectory::ending::track::Track;
use crate::trajectory::ending::{NotClean, Outcome};
use crate::trajectory::pose::PoseSample;
use crate::trajectory::resample::{Seen, Times, check, most_gap_ns, most_step_ns};
use crate::trajectory::rows::Rows;

impl Run {
    /// The ending, interpolated as [`crate::trajectory::resample::resample`] does it.
    pub(super) fn resampled(&mut self, times: Times) -> Outcome<Ending> {
        let robots = self.names.iter().zip(&self.tracks);
        let seen = robots
            .map(|(name, track)| see(name, track, times.recorded_ns))
            .collect::<Outcome<Vec<Seen>>>()?;
        let mut findings = Vec::new();
        // Who is refused is told by the whole of the run.
        let span_ns = check(&seen, times, &mut findings).map_err(|_refused| NotClean)?;
        let n_all = (span_ns.1 - span_ns.0) / times.period_ns + 1;
        let keep = Keep::Ending { seconds: self.seconds };
        let sizes = (self.tracks.len(), times.period_ns);
        let mut rows = Rows::new((n_all, span_ns.0), sizes, keep);
        let times_ns = rows.times_ns();
        for (robot, track) in self.tracks.iter_mut().enumerate() {
            let poses: Option<Vec<PoseSample>> =
                times_ns.iter().map(|time_ns| track.pose_at(*time_ns)).collect();
            let poses = poses.ok_or(NotClean)?;
            let n_first = usize::from(rows.n_left_out > 0);
            let (first, last) = poses.split_at(n_first);
            let mut answers = Vec::with_capacity(poses.len());
            for pose in first {
                answers.push(track.first_answer(pose, times.period_ns)?);
            }
            answers.extend(track.last_answers(last, times.period_ns)?);
            rows.fill(robot, &poses, &answers);
        }
        let Rows { trajectory, n_left_out, start_ns, .. } = rows;
        Ok(Ending { trajectory, n_left_out, start_ns, findings })
    }
}

/// How completely a robot was seen.
fn see<'a>(robot: &'a str, track: &Track, recorded_ns: u64) -> Outcome<Seen<'a>> {
    let (Some(first), Some(last)) = (track.first.first(), track.recent.back()) else {
        return Err(NotClean);
    };
    let (_, longest_ns) = track.steps_ns.ok_or(NotClean)?;
    if longest_ns > most_gap_ns(recorded_ns) {
        return Err(NotClean);
    }
    let gaps = track.gaps.above(most_step_ns(recorded_ns)).ok_or(NotClean)?;
    Ok(Seen {
        robot,
        span_ns: (first.stamp_ns, last.stamp_ns),
        longest_ns,
        missing_ns: gaps.sum_ns - gaps.n * recorded_ns,
    })
}
