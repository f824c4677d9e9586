//! A motion tracker that watches an episode and records what it makes of it.

use std::path::Path;

use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use rsrs_bags::{BagOptions, BagWriter, ChannelId, Sample};
use rsrs_core::judge::trajectory::Trajectory;
use rsrs_core::judge::window::{MAX_GAP_S, WINDOW_S};
use rsrs_core::robot::unicycle::Pose;
use rsrs_msgs::builtin_interfaces::Time as Stamp;
use rsrs_msgs::geometry_msgs::{PoseStamped, TwistStamped};
use rsrs_msgs::rsrs::{LeaseState, RunLease};
use rsrs_msgs::{cdr, topics};

/// What is wrong with a tracker.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Tracker {
    /// It misses one pose in twenty.
    Misses,
    /// Its stamps are up to 20 ms off.
    Jitters,
    /// Its positions are 1 cm off, as a standard deviation, and its headings as those of a body with
    /// markers 10 cm apart.
    IsNoisy,
    /// It looks 30 times a second.
    At30Hertz,
    /// It looks 7.7 times a second, but not when the robots do.
    At7Hertz,
    /// Each robot is hidden from it once in the time that is judged, for nearly as long as is bridged.
    IsOccluded,
    /// All of the faults above but for the last one, 30 times a second.
    All30,
    /// The same, 7.7 times a second.
    All7,
}

const POSITION_SD_M: f64 = 0.01;
const HEADING_SD_RAD: f64 = 0.1;
const JITTER_S: f64 = 0.02;
const MISSED: f64 = 0.05;
/// How long a robot is hidden, in seconds.
const OCCLUSION_S: f64 = MAX_GAP_S - 0.2;

impl Tracker {
    /// All of them.
    pub const ALL: [Self; 8] = [
        Self::Misses,
        Self::Jitters,
        Self::IsNoisy,
        Self::At30Hertz,
        Self::At7Hertz,
        Self::IsOccluded,
        Self::All30,
        Self::All7,
    ];

    fn has(self, fault: Self) -> bool {
        self == fault || (fault != Self::IsOccluded && matches!(self, Self::All30 | Self::All7))
    }

    /// Time between two looks, in seconds.
    fn period_s(self, episode: &Trajectory) -> f64 {
        match self {
            Self::At30Hertz | Self::All30 => 1.0 / 30.0,
            Self::At7Hertz | Self::All7 => 1.0 / 7.7,
            Self::Misses | Self::Jitters | Self::IsNoisy | Self::IsOccluded => episode.period_s,
        }
    }

    /// Records an episode as this tracker sees it.
    pub fn record(self, folder: &Path, episode: &Trajectory, seed: u64) {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let mut messages = self.poses(episode, &mut random);
        for sample in 0..episode.n_samples() {
            let time_ns = nanoseconds(sample as f64 * episode.period_s);
            for (robot, command) in episode.commands_at(sample).iter().enumerate() {
                let mut twist = TwistStamped::default();
                twist.header.stamp = Stamp::from_nanos(time_ns);
                twist.twist.linear.x = command.speed_m_s;
                twist.twist.angular.z = command.turn_rate_rad_s;
                messages.push((time_ns, 2 * robot + 1, cdr::encode(&twist)));
            }
        }
        messages.sort_by_key(|(time_ns, channel, _)| (*time_ns, *channel));
        write(folder, episode, &messages);
    }

    fn poses(self, episode: &Trajectory, random: &mut ChaCha8Rng) -> Vec<Message> {
        let end_s = (episode.n_samples() - 1) as f64 * episode.period_s;
        let phase_s = if self == Self::At7Hertz { 0.05 } else { 0.0 };
        let n_looks = whole((end_s - phase_s) / self.period_s(episode));
        let last_s = end_s - OCCLUSION_S - 1.0;
        let mut hidden = |_| last_s - (WINDOW_S - OCCLUSION_S - 2.0) * random.random::<f64>();
        let hidden_from_s: Vec<f64> = if self.has(Self::IsOccluded) {
            (0..episode.n_robots).map(&mut hidden).collect()
        } else {
            vec![f64::INFINITY; episode.n_robots]
        };
        let mut messages = Vec::new();
        for look in 0..=n_looks {
            let time_s = phase_s + look as f64 * self.period_s(episode);
            for (robot, from_s) in hidden_from_s.iter().enumerate() {
                if (*from_s..from_s + OCCLUSION_S).contains(&time_s) {
                    continue;
                }
                if self.has(Self::Misses) && random.random::<f64>() < MISSED {
                    continue;
                }
                let mut pose = pose_at(episode, robot, time_s);
                let mut stamp_s = time_s;
                if self.has(Self::IsNoisy) {
                    pose.x_m += POSITION_SD_M * normal(random);
                    pose.y_m += POSITION_SD_M * normal(random);
                    pose.heading_rad += HEADING_SD_RAD * normal(random);
                }
                if self.has(Self::Jitters) {
                    stamp_s += JITTER_S * (2.0 * random.random::<f64>() - 1.0);
                }
                let stamp_ns = nanoseconds(stamp_s.max(0.0));
                messages.push((
                    nanoseconds(time_s),
                    2 * robot,
                    cdr::encode(&posed(pose, stamp_ns)),
                ));
            }
        }
        messages
    }
}

/// Time in nanoseconds, index of its channel, bytes.
type Message = (u64, usize, Vec<u8>);

/// Where a robot is between two steps of the world: it drives straight, and turns.
fn pose_at(episode: &Trajectory, robot: usize, time_s: f64) -> Pose {
    let steps = time_s / episode.period_s;
    let last = episode.n_samples() - 1;
    let before = whole(steps).min(last);
    let share = (steps - before as f64).clamp(0.0, 1.0);
    let from = episode.poses_at(before)[robot];
    let to = episode.poses_at((before + 1).min(last))[robot];
    let turn_rad = libm::remainder(to.heading_rad - from.heading_rad, std::f64::consts::TAU);
    Pose {
        x_m: from.x_m + (to.x_m - from.x_m) * share,
        y_m: from.y_m + (to.y_m - from.y_m) * share,
        heading_rad: from.heading_rad + turn_rad * share,
    }
}

fn write(folder: &Path, episode: &Trajectory, messages: &[Message]) {
    let mut writer = BagWriter::create(folder, BagOptions::default()).expect("the disk has room");
    let mut channels: Vec<ChannelId> = Vec::new();
    for robot in 1..=episode.n_robots {
        for topic in [topics::POSE, topics::CMD_VEL] {
            let name = topic.for_robot(&format!("robot_{robot}"));
            let channel = writer.add_topic(&name, topic.type_name, topic.qos);
            channels.push(channel.expect("the topic is new"));
        }
    }
    let lease = topics::LEASE;
    let lease = writer.add_topic(lease.name, lease.type_name, lease.qos).expect("it is new");
    let end_ns = nanoseconds(episode.duration_s());
    put(&mut writer, lease, 0, &state(LeaseState::Running));
    for (time_ns, channel, data) in messages {
        let (log_time_ns, publish_time_ns) = (*time_ns, *time_ns);
        let sample = Sample { log_time_ns, publish_time_ns, sequence: 0, data };
        writer.write(channels[*channel], sample).expect("the disk has room");
    }
    put(&mut writer, lease, end_ns, &state(LeaseState::Stopped));
    writer.finish().expect("the disk has room");
}

fn state(state: LeaseState) -> Vec<u8> {
    cdr::encode(&RunLease { state: state.into(), epoch: 1, ..RunLease::default() })
}

fn put(writer: &mut BagWriter, channel: ChannelId, time_ns: u64, data: &[u8]) {
    let sample = Sample { log_time_ns: time_ns, publish_time_ns: time_ns, sequence: 0, data };
    writer.write(channel, sample).expect("the disk has room");
}

fn posed(pose: Pose, stamp_ns: u64) -> PoseStamped {
    let mut message = PoseStamped::default();
    message.header.stamp = Stamp::from_nanos(stamp_ns);
    "map".clone_into(&mut message.header.frame_id);
    message.pose.position.x = pose.x_m;
    message.pose.position.y = pose.y_m;
    let (sine, cosine) = libm::sincos(pose.heading_rad / 2.0);
    (message.pose.orientation.z, message.pose.orientation.w) = (sine, cosine);
    message
}

fn nanoseconds(time_s: f64) -> u64 {
    whole((time_s * 1e9).round()) as u64
}

/// The whole number below one that is not negative.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "casts from floats saturate, and times and shares of them are not negative"
)]
pub fn whole(number: f64) -> usize {
    number as usize
}

fn normal(random: &mut ChaCha8Rng) -> f64 {
    let radius = libm::sqrt(-2.0 * libm::log(1.0 - random.random::<f64>()));
    radius * libm::cos(std::f64::consts::TAU * random.random::<f64>())
}
