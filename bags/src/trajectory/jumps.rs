//! Poses that no robot could have reached: outliers, exchanged robots, robots that were carried.

use super::TrajectoryError;
use super::collect::RecordedRobot;
use super::finding::Finding;
use super::pose::PoseSample;

/// Below this, in metres, a change of place may be a tracker's noise; bodies are wider.
const MIN_JUMP_M: f64 = 0.10;

/// A robot may be so much faster than its command.
const SPEED_FACTOR: f64 = 4.0;

/// Or so much faster than it is at most times, whatever its command.
const STEP_FACTOR: f64 = 6.0;

/// More poses in a row than this are no outliers.
const MAX_OUTLIERS: usize = 3;

/// Exchanges in one run beyond which a tracker is not to be believed.
const MAX_SWAPS: usize = 50;

/// How far one robot may get from one pose to another.
struct Reach {
    speed_m_s: f64,
    noise_m: f64,
}

impl Reach {
    fn new(robot: &RecordedRobot) -> Self {
        let speeds = robot.commands.iter().map(|command| command.command.speed_m_s.abs());
        let commanded_m_s = speeds.fold(0.0, f64::max);
        let mut steps_m_s: Vec<f64> = robot
            .poses
            .windows(2)
            .map(|pair| distance_m(&pair[0], &pair[1]) / seconds_between(&pair[0], &pair[1]))
            .collect();
        steps_m_s.sort_unstable_by(f64::total_cmp);
        let usual_m_s = steps_m_s.get(steps_m_s.len() / 2).copied().unwrap_or(0.0);
        let speed_m_s = (SPEED_FACTOR * commanded_m_s).max(STEP_FACTOR * usual_m_s);
        Self { speed_m_s, noise_m: MIN_JUMP_M }
    }

    fn limit_m(&self, from: &PoseSample, to: &PoseSample) -> f64 {
        (self.speed_m_s * seconds_between(from, to)).max(self.noise_m)
    }

    fn allows(&self, from: &PoseSample, to: &PoseSample) -> bool {
        distance_m(from, to) <= self.limit_m(from, to)
    }
}

/// A place in a robot's poses to which it jumped.
#[derive(Clone, Copy)]
struct Jump {
    robot: usize,
    sample: usize,
    stamp_ns: u64,
}

/// Leaves out outliers and sets exchanged robots right, and tells what was done.
///
/// # Errors
///
/// [`TrajectoryError::Jump`] if a robot jumped and no exchange explains it.
pub fn mend(robots: &mut [RecordedRobot], period_ns: u64) -> Result<Vec<Finding>, TrajectoryError> {
    let reaches: Vec<Reach> = robots.iter().map(Reach::new).collect();
    let mut findings = Vec::new();
    for (robot, reach) in robots.iter_mut().zip(&reaches) {
        let n_poses = drop_outliers(&mut robot.poses, reach);
        if n_poses > 0 {
            findings.push(Finding::Outliers { robot: robot.name.clone(), n_poses });
        }
    }
    for _ in 0..=MAX_SWAPS {
        let together = first_jumps(robots, &reaches, period_ns);
        let Some(first) = together.first() else { return Ok(findings) };
        match exchange(robots, &reaches, &together) {
            Some(swap) => findings.push(swap),
            None => return Err(refusal(&robots[first.robot], &reaches[first.robot], *first)),
        }
    }
    let together = first_jumps(robots, &reaches, period_ns);
    match together.first() {
        Some(first) => Err(refusal(&robots[first.robot], &reaches[first.robot], *first)),
        None => Ok(findings),
    }
}

/// Leaves out poses that are out of reach while later ones are within it again.
fn drop_outliers(poses: &mut Vec<PoseSample>, reach: &Reach) -> usize {
    let n_all = poses.len();
    let mut kept: Vec<PoseSample> = Vec::with_capacity(n_all);
    let mut sample = 0;
    while sample < n_all {
        if let Some(last) = kept.last() {
            let ahead = &poses[sample..n_all.min(sample + MAX_OUTLIERS + 1)];
            if let Some(n_out) = ahead.iter().position(|pose| reach.allows(last, pose)) {
                sample += n_out;
            }
        }
        kept.push(poses[sample]);
        sample += 1;
    }
    *poses = kept;
    n_all - poses.len()
}

/// The first jump of any robot, and those of others about the same time.
fn first_jumps(robots: &[RecordedRobot], reaches: &[Reach], period_ns: u64) -> Vec<Jump> {
    let mut jumps: Vec<Jump> = Vec::new();
    for (robot, (recorded, reach)) in robots.iter().zip(reaches).enumerate() {
        let poses = &recorded.poses;
        let found = poses.windows(2).position(|pair| !reach.allows(&pair[0], &pair[1]));
        jumps.extend(found.map(|before| {
            let sample = before + 1;
            Jump { robot, sample, stamp_ns: poses[sample].stamp_ns }
        }));
    }
    let Some(first_ns) = jumps.iter().map(|jump| jump.stamp_ns).min() else { return jumps };
    jumps.retain(|jump| jump.stamp_ns - first_ns <= period_ns + period_ns / 2);
    jumps.sort_by_key(|jump| jump.stamp_ns);
    jumps
}

/// Gives each robot the poses that go on where its own broke off.
fn exchange(robots: &mut [RecordedRobot], reaches: &[Reach], jumps: &[Jump]) -> Option<Finding> {
    let mut sources = Vec::new();
    for jump in jumps {
        let last = &robots[jump.robot].poses[jump.sample - 1];
        let nearest = jumps
            .iter()
            .map(|other| (other, &robots[other.robot].poses[other.sample]))
            .filter(|(_, pose)| reaches[jump.robot].allows(last, pose))
            .min_by(|one, other| distance_m(last, one.1).total_cmp(&distance_m(last, other.1)))?;
        sources.push(nearest.0.robot);
    }
    let mut distinct = sources.clone();
    distinct.sort_unstable();
    distinct.dedup();
    if distinct.len() < sources.len() {
        return None;
    }
    let mut tails: Vec<Option<Vec<PoseSample>>> = vec![None; robots.len()];
    for jump in jumps {
        tails[jump.robot] = Some(robots[jump.robot].poses.split_off(jump.sample));
    }
    for (jump, source) in jumps.iter().zip(sources) {
        let tail = tails[source].take().expect("each source is the source of one robot");
        robots[jump.robot].poses.extend(tail);
    }
    let mut names: Vec<String> = jumps.iter().map(|jump| robots[jump.robot].name.clone()).collect();
    names.sort();
    Some(Finding::Swap { robots: names, time_s: jumps[0].stamp_ns as f64 / 1e9 })
}

fn refusal(robot: &RecordedRobot, reach: &Reach, jump: Jump) -> TrajectoryError {
    let (from, to) = (&robot.poses[jump.sample - 1], &robot.poses[jump.sample]);
    TrajectoryError::Jump {
        robot: robot.name.clone(),
        time_s: jump.stamp_ns as f64 / 1e9,
        distance_m: distance_m(from, to),
        limit_m: reach.limit_m(from, to),
    }
}

fn distance_m(one: &PoseSample, other: &PoseSample) -> f64 {
    libm::hypot(other.pose.x_m - one.pose.x_m, other.pose.y_m - one.pose.y_m)
}

/// Never zero, as stamps were made distinct.
fn seconds_between(one: &PoseSample, other: &PoseSample) -> f64 {
    one.stamp_ns.abs_diff(other.stamp_ns).max(1) as f64 / 1e9
}
