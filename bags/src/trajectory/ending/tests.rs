use proptest::prelude::*;
use rsrs_core::phase::samples_in;
use rsrs_msgs::builtin_interfaces::Time;

use super::*;
use crate::trajectory::read_trajectory;
use crate::{BagOptions, BagWriter, ChannelId, Sample};

const PERIOD_NS: u64 = 130_000_000;

/// Seconds that are kept.
const KEPT: u32 = 3;

/// A run of robots that need no mending.
#[derive(Clone, Debug)]
struct Recipe {
    n_robots: usize,
    n_steps: u64,
    /// Stamps and log times are off by at most so much, in nanoseconds.
    jitter_ns: u64,
    /// Steps at which the lease says RUNNING and STOPPED; `None` without a lease.
    lease: Option<(u64, u64)>,
    /// Steps before the first and behind the last command that moves robots.
    still: (u64, u64),
    is_tracked: bool,
    is_stamped: bool,
    seed: u64,
}

fn recipes() -> impl Strategy<Value = Recipe> {
    let times = (60..200_u64, 0..20_u64, 0..20_u64, 0..20_u64);
    let jitter_ns = prop_oneof![Just(0), 0..2_000_000_u64];
    let flags = (any::<bool>(), any::<bool>(), any::<bool>(), any::<u64>());
    (1..5_usize, times, jitter_ns, flags).prop_map(|(n_robots, times, jitter_ns, flags)| {
        let (n_steps, early, late, still) = times;
        let (has_lease, is_tracked, is_stamped, seed) = flags;
        let lease = has_lease.then_some((early, n_steps - late));
        let still = if has_lease { (0, 0) } else { (early, still) };
        Recipe { n_robots, n_steps, jitter_ns, lease, still, is_tracked, is_stamped, seed }
    })
}

impl Recipe {
    fn noise_ns(&self, (robot, step, what): (usize, u64, u64)) -> u64 {
        let mut mixed = self.seed ^ (robot as u64 + 1) << 40 ^ step << 8 ^ what;
        mixed = mixed.wrapping_mul(0x9e37_79b9_7f4a_7c15);
        mixed = (mixed ^ (mixed >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        (mixed ^ (mixed >> 27)) % (self.jitter_ns + 1)
    }

    /// Writes the bag and opens it.
    fn bag(&self, folder: &std::path::Path) -> Bag {
        let path = folder.join("run");
        let mut writer = BagWriter::create(&path, BagOptions::default()).unwrap();
        let mut channel = |topic: topics::Topic, type_name: &str, robot: usize| {
            let name = topic.for_robot(&format!("robot_{robot}"));
            writer.add_topic(&name, type_name, topic.qos).unwrap()
        };
        let pose_topic = if self.is_tracked { topics::POSE } else { topics::ODOM };
        let command_type = if self.is_stamped { TwistStamped::TYPE_NAME } else { Twist::TYPE_NAME };
        let channels: Vec<(ChannelId, ChannelId)> = (0..self.n_robots)
            .map(|robot| {
                let poses = channel(pose_topic, pose_topic.type_name, robot);
                (poses, channel(topics::CMD_VEL, command_type, robot))
            })
            .collect();
        let lease = self.lease.map(|_| {
            writer.add_topic(topics::LEASE.name, RunLease::TYPE_NAME, topics::LEASE.qos).unwrap()
        });
        let mut messages: Vec<(u64, ChannelId, Vec<u8>)> = Vec::new();
        for step in 0..self.n_steps {
            let at_ns = step * PERIOD_NS;
            let state = self.lease.and_then(|(start, end)| {
                let changes = [(start, RunLease::RUNNING), (end, RunLease::STOPPED)];
                changes.into_iter().find(|(at, _)| *at == step)
            });
            if let Some((_, state)) = state {
                let message = RunLease { state, ..RunLease::default() };
                messages.push((at_ns, lease.unwrap(), cdr::encode(&message)));
            }
            for (robot, (poses, commands)) in channels.iter().enumerate() {
                let stamp_ns = at_ns + self.noise_ns((robot, step, 0));
                let log_ns = at_ns + self.noise_ns((robot, step, 1));
                messages.push((log_ns, *poses, self.pose(robot, stamp_ns)));
                let stamp_ns = at_ns + self.noise_ns((robot, step, 2));
                let log_ns = log_ns + self.noise_ns((robot, step, 3));
                let is_still = step < self.still.0 || step + self.still.1 >= self.n_steps;
                let speed_m_s = if is_still { 0.0 } else { 0.15 };
                messages.push((log_ns, *commands, self.command(speed_m_s, (step, stamp_ns))));
            }
        }
        messages.sort_by_key(|(log_ns, ..)| *log_ns);
        for (log_time_ns, channel, data) in messages {
            let sample = Sample { log_time_ns, publish_time_ns: 0, sequence: 0, data: &data };
            writer.write(channel, sample).unwrap();
        }
        writer.finish().unwrap();
        Bag::open(&path).unwrap()
    }

    fn pose(&self, robot: usize, stamp_ns: u64) -> Vec<u8> {
        let mut message = Odometry::default();
        message.header.stamp = Time::from_nanos(stamp_ns);
        message.pose.pose.position.x = 0.15e-9 * stamp_ns as f64;
        message.pose.pose.position.y = robot as f64;
        if self.is_tracked {
            cdr::encode(&PoseStamped { header: message.header, pose: message.pose.pose })
        } else {
            cdr::encode(&message)
        }
    }

    fn command(&self, speed_m_s: f64, (step, stamp_ns): (u64, u64)) -> Vec<u8> {
        let mut twist = Twist::default();
        twist.linear.x = speed_m_s;
        twist.angular.z = if speed_m_s > 0.0 { step as f64 } else { 0.0 };
        if !self.is_stamped {
            return cdr::encode(&twist);
        }
        let mut message = TwistStamped { twist, ..TwistStamped::default() };
        message.header.stamp = Time::from_nanos(stamp_ns);
        cdr::encode(&message)
    }
}

#[test]
fn what_the_judge_looks_at_is_kept() {
    assert_eq!(Keep::JUDGED, Keep::Ending { seconds: 60 });
    assert!((rsrs_core::phase::WINDOW_S - 60.0).abs() < 1e-12);
}

/// The first sample and the last ones.
fn abridged(mut whole: RecordedTrajectory) -> RecordedTrajectory {
    let all = &mut whole.trajectory;
    let n_last = samples_in(f64::from(KEPT), all.period_s);
    whole.n_left_out = all.n_samples().saturating_sub(n_last + 1);
    let left_out = all.n_robots..(1 + whole.n_left_out) * all.n_robots;
    all.poses.drain(left_out.clone());
    all.commands.drain(left_out);
    whole
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(100))]

    #[test]
    fn the_ending_of_a_clean_run_is_told_in_one_pass_and_is_that_of_the_whole(recipe in recipes()) {
        let folder = tempfile::tempdir().unwrap();
        let bag = recipe.bag(folder.path());
        let keep = Keep::Ending { seconds: KEPT };

        let in_one_pass = read(&bag, &TrajectoryOptions { poses: None, keep });
        let whole = read_trajectory(&bag, &TrajectoryOptions::default());

        let whole = abridged(whole.unwrap());
        let n_all = whole.n_left_out + whole.trajectory.n_samples();
        prop_assert!(n_all > 20, "{n_all}");
        prop_assert_eq!(in_one_pass, Some(whole));
    }
}
