//! How fast bags are written, recovered and read, and with how much memory.
//!
//! ```text
//! cargo run --release -p rsrs_bags --example bag_throughput -- FOLDER [MEGABYTES]
//! ```
//!
//! It writes small messages as fast as one thread can, then a bag of MEGABYTES (1000 if it is not
//! given) for each way of packing, and saves each as a damaged one and reads the trajectory in it.
//! Each step runs in a process of its own, so that its memory is its own; the bags are in FOLDER
//! only meanwhile. "Disk" is bytes of the bag, "content" those of the messages in it. Rates are per
//! second of processor time, all threads together, so that other programs on the machine do not
//! count, nor do waits for the disk; wall-clock seconds stand beside them.

#![expect(clippy::print_stdout, reason = "its output is a table")]

use std::env;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Instant;

use rsrs_bags::trajectory::{TrajectoryOptions, read_trajectory};
use rsrs_bags::{
    Bag, BagError, BagOptions, BagWriter, ChannelId, Compression, Packing, Sample, recover_into,
};
use rsrs_core::judge::phase;
use rsrs_core::judge::trajectory::Bodies;
use rsrs_msgs::builtin_interfaces::Time;
use rsrs_msgs::geometry_msgs::{TransformStamped, TwistStamped};
use rsrs_msgs::nav_msgs::Odometry;
use rsrs_msgs::rsrs::{LeaseState, RunLease};
use rsrs_msgs::std_msgs::Bool;
use rsrs_msgs::tf2_msgs::TFMessage;
use rsrs_msgs::topics::Qos;
use rsrs_msgs::{RosMessage, cdr, topics};

/// Control period, in nanoseconds.
const PERIOD_NS: u64 = 130_000_000;

const N_ROBOTS: usize = 9;

/// Bytes of one picture; what makes bags of a gigabyte is cameras.
const PICTURE_BYTES: usize = 200_000;

/// The unit in which the system reports processor time: the same on every Linux that there is.
const TICKS_PER_S: f64 = 100.0;

/// Messages for the write path alone.
const N_SMALL: u64 = 3_000_000;

type Outcome = Result<(), Box<dyn std::error::Error>>;

/// What a bag is filled with.
#[derive(Clone, Copy)]
enum Content {
    /// Detections, commands and odometry of nine robots.
    Swarm,
    /// The same, and each hundredth pose is missing: a run that must be mended.
    SwarmWithGaps,
    /// Without gaps, and the poses of all robots in one message.
    SwarmOnTf,
    /// Without gaps, and a camera above them.
    SwarmAndCamera,
}

fn main() -> Outcome {
    let mut arguments = env::args().skip(1);
    let folder = arguments.next().ok_or("name a folder in which there is room")?;
    let folder = PathBuf::from(folder);
    let asked = arguments.next();
    if let Some(step) = asked.as_deref().and_then(Step::named) {
        return step.measure(&folder.join("run"));
    }
    let megabytes: u64 = asked.map_or(Ok(1000), |text| text.parse())?;
    fs::create_dir_all(&folder)?;
    small_messages(&folder)?;
    println!(
        "bag                       step      MB disk  MB content  wall s   CPU s  disk MB/s  content MB/s  peak MiB"
    );
    for (content, compression) in [
        (Content::Swarm, Compression::None),
        (Content::Swarm, Compression::Zstd),
        (Content::SwarmWithGaps, Compression::None),
        (Content::SwarmWithGaps, Compression::Zstd),
        (Content::SwarmOnTf, Compression::Zstd),
        (Content::SwarmAndCamera, Compression::None),
        (Content::SwarmAndCamera, Compression::Zstd),
        (Content::SwarmAndCamera, Compression::Lz4),
    ] {
        one_kind(&folder, content, compression, megabytes * 1_000_000)?;
    }
    Ok(())
}

/// What is done with a bag.
#[derive(Clone, Copy)]
enum Step {
    Read,
    Label,
    Recover,
}

impl Step {
    const ALL: [Self; 3] = [Self::Read, Self::Label, Self::Recover];

    fn name(self) -> &'static str {
        match self {
            Self::Read => "read all",
            Self::Label => "label",
            Self::Recover => "recover",
        }
    }

    fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|step| step.name() == name)
    }

    /// Does it and prints wall-clock seconds, those of processors, and the most memory in MiB.
    fn measure(self, path: &Path) -> Outcome {
        let start = Instant::now();
        match self {
            Self::Read => read_all(path),
            Self::Label => label(path),
            Self::Recover => save(path),
        }?;
        println!("{} {} {}", start.elapsed().as_secs_f64(), processor_s(), peak_mib());
        Ok(())
    }
}

fn read_all(path: &Path) -> Outcome {
    let n_messages = Bag::open(path)?.messages().try_fold(0_u64, |n, one| one.map(|_| n + 1))?;
    if n_messages == 0 { Err("nothing was read".into()) } else { Ok(()) }
}

fn label(path: &Path) -> Outcome {
    let recorded = read_trajectory(&Bag::open(path)?, &TrajectoryOptions::default())?;
    let bodies = Bodies { radius_m: None, reach_m: Some(0.75), ..Bodies::UNKNOWN };
    let verdict = phase::label(&recorded.trajectory, &bodies)?;
    if verdict.n_robots == N_ROBOTS { Ok(()) } else { Err("robots are missing".into()) }
}

fn save(path: &Path) -> Outcome {
    let saved = fresh(&path.with_file_name("saved"))?;
    let recovered = recover_into(path, &saved, None)?;
    fs::remove_dir_all(&saved)?;
    if recovered.is_complete() { Ok(()) } else { Err("something was lost".into()) }
}

/// The write path alone: no robots, no network.
fn small_messages(folder: &Path) -> Outcome {
    for compression in [Compression::None, Compression::Lz4, Compression::Zstd] {
        let path = fresh(&folder.join("small"))?;
        let packing = Packing { compression, ..Packing::default() };
        let mut writer = BagWriter::create_packed(&path, BagOptions::default(), packing)?;
        let channel = writer.add_topic("/robot_1/detection", Bool::TYPE_NAME, Qos::reliable(5))?;
        let data = [cdr::encode(&Bool { data: false }), cdr::encode(&Bool { data: true })];
        let start = processor_s();
        for message in 0..N_SMALL {
            // 100,000 a second of recorded time, each second flushed.
            let time_ns = message * 10_000;
            let data = &data[usize::from(message % 3 == 0)];
            writer.write(channel, sample(time_ns, data))?;
        }
        writer.finish()?;
        let rate = N_SMALL as f64 / (processor_s() - start);
        println!("write {compression:?}: {rate:.0} messages of 5 bytes a second on one core");
        fs::remove_dir_all(&path)?;
    }
    Ok(())
}

fn one_kind(folder: &Path, content: Content, compression: Compression, n_bytes: u64) -> Outcome {
    let path = fresh(&folder.join("run"))?;
    let kind = match content {
        Content::Swarm => "swarm",
        Content::SwarmWithGaps => "swarm with gaps",
        Content::SwarmOnTf => "swarm on /tf",
        Content::SwarmAndCamera => "swarm and camera",
    };
    let name = format!("{kind}, {compression:?}");
    let content_bytes = write_bag(&path, content, compression, n_bytes)?;
    let disk_bytes = fs::metadata(path.join("run_0.mcap"))?.len();
    for step in Step::ALL {
        let child = Command::new(env::current_exe()?).arg(folder).arg(step.name()).output()?;
        let text = String::from_utf8_lossy(&child.stdout).into_owned();
        let printed: Vec<f64> =
            text.split_whitespace().map(str::parse).collect::<Result<_, _>>()?;
        let [wall_s, seconds, peak_mib] = printed[..] else {
            return Err(String::from_utf8_lossy(&child.stderr).into());
        };
        let (disk_mb, content_mb) = (disk_bytes as f64 / 1e6, content_bytes as f64 / 1e6);
        let (disk_mb_s, content_mb_s) = (disk_mb / seconds, content_mb / seconds);
        let step = step.name();
        println!(
            "{name:<24}  {step:<9}{disk_mb:>8.0}{content_mb:>12.0}{wall_s:>8.1}{seconds:>8.1}{disk_mb_s:>11.0}{content_mb_s:>14.0}{peak_mib:>10.0}",
        );
    }
    fs::remove_dir_all(&path)?;
    Ok(())
}

/// Writes a bag of so many bytes on disk, and counts the bytes in it before compression.
fn write_bag(
    path: &Path,
    content: Content,
    compression: Compression,
    n_bytes: u64,
) -> Result<u64, Box<dyn std::error::Error>> {
    let packing = Packing { compression, ..Packing::default() };
    let mut writer = BagWriter::create_packed(path, BagOptions::default(), packing)?;
    let mut add =
        |name: String, type_name: &str| writer.add_topic(&name, type_name, Qos::reliable(5));
    let lease = add(topics::LEASE.name.to_owned(), RunLease::TYPE_NAME)?;
    let camera = add("/camera/image".to_owned(), Bool::TYPE_NAME)?;
    let is_on_tf = matches!(content, Content::SwarmOnTf);
    let tf = add(topics::TF.name.to_owned(), TFMessage::TYPE_NAME)?;
    let robots = (1..=N_ROBOTS).map(|robot| {
        let named = |topic: topics::Topic| topic.for_robot(&format!("robot_{robot}"));
        Ok([
            add(named(topics::DETECTION), Bool::TYPE_NAME)?,
            add(named(topics::CMD_VEL), TwistStamped::TYPE_NAME)?,
            if is_on_tf { tf } else { add(named(topics::ODOM), Odometry::TYPE_NAME)? },
        ])
    });
    let robots: Vec<[ChannelId; 3]> = robots.collect::<Result<_, BagError>>()?;

    let running =
        cdr::encode(&RunLease { state: u8::from(LeaseState::Running), ..RunLease::default() });
    writer.write(lease, sample(0, &running))?;
    let file = path.join("run_0.mcap");
    let mut noise = Noise(42);
    let mut picture = vec![0; PICTURE_BYTES];
    let mut content_bytes = 0;
    for step in 0.. {
        if step % 64 == 0 && fs::metadata(&file)?.len() >= n_bytes {
            break;
        }
        let time_ns = step * PERIOD_NS;
        if matches!(content, Content::SwarmAndCamera) {
            noise.fill(&mut picture);
            content_bytes += put(&mut writer, camera, time_ns, &picture)?;
        }
        let mut transforms = Vec::new();
        for (robot, [detection, cmd_vel, odom]) in robots.iter().enumerate() {
            let message = Bool { data: noise.uniform() < 0.5 };
            content_bytes += put(&mut writer, *detection, time_ns, &cdr::encode(&message))?;
            let message = command(time_ns, &mut noise);
            content_bytes += put(&mut writer, *cmd_vel, time_ns, &cdr::encode(&message))?;
            let message = odometry((robot, step), &mut noise);
            if is_on_tf {
                transforms.push(transform(robot, &message));
            } else if !matches!(content, Content::SwarmWithGaps) || noise.uniform() > 0.01 {
                content_bytes += put(&mut writer, *odom, time_ns, &cdr::encode(&message))?;
            }
        }
        if is_on_tf {
            content_bytes +=
                put(&mut writer, tf, time_ns, &cdr::encode(&TFMessage { transforms }))?;
        }
    }
    writer.finish()?;
    Ok(content_bytes)
}

fn put(
    writer: &mut BagWriter,
    channel: ChannelId,
    time_ns: u64,
    data: &[u8],
) -> Result<u64, BagError> {
    writer.write(channel, sample(time_ns, data))?;
    Ok(data.len() as u64)
}

fn sample(time_ns: u64, data: &[u8]) -> Sample<'_> {
    Sample { log_time_ns: time_ns, publish_time_ns: time_ns, sequence: 0, data }
}

fn command(time_ns: u64, noise: &mut Noise) -> TwistStamped {
    let mut message = TwistStamped::default();
    message.header.stamp = Time::from_nanos(time_ns);
    message.twist.linear.x = 0.15;
    message.twist.angular.z = if noise.uniform() < 0.5 { 0.75 } else { -0.75 };
    message
}

/// A robot on a circle, as a tracker sees it.
fn odometry((robot, step): (usize, u64), noise: &mut Noise) -> Odometry {
    let time_ns = step * PERIOD_NS;
    let mut message = Odometry::default();
    message.header.stamp = Time::from_nanos(time_ns);
    "map".clone_into(&mut message.header.frame_id);
    let angle_rad = 0.3 * time_ns as f64 / 1e9 + robot as f64;
    let pose = &mut message.pose.pose;
    pose.position.x = 0.5 * libm::cos(angle_rad) + 1e-3 * noise.uniform();
    pose.position.y = 0.5 * libm::sin(angle_rad) + 1e-3 * noise.uniform();
    pose.orientation.z = libm::sin(0.5 * angle_rad);
    pose.orientation.w = libm::cos(0.5 * angle_rad);
    message
}

/// The same pose as a transform.
fn transform(robot: usize, odometry: &Odometry) -> TransformStamped {
    let pose = &odometry.pose.pose;
    let mut message =
        TransformStamped { header: odometry.header.clone(), ..TransformStamped::default() };
    message.child_frame_id = format!("robot_{}/base_link", robot + 1);
    message.transform.translation.x = pose.position.x;
    message.transform.translation.y = pose.position.y;
    message.transform.rotation = pose.orientation;
    message
}

/// Random enough that nothing compresses it (splitmix64).
struct Noise(u64);

impl Noise {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut mixed = self.0;
        mixed = (mixed ^ (mixed >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        mixed ^ (mixed >> 31)
    }

    fn uniform(&mut self) -> f64 {
        (self.next() >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn fill(&mut self, bytes: &mut [u8]) {
        for chunk in bytes.chunks_mut(8) {
            chunk.copy_from_slice(&self.next().to_le_bytes()[..chunk.len()]);
        }
        // As CDR starts.
        bytes[..4].copy_from_slice(&[0, 1, 0, 0]);
    }
}

/// What all threads of this program have computed for so far, in seconds; NaN where the system does
/// not report it.
fn processor_s() -> f64 {
    let stat = fs::read_to_string("/proc/self/stat").unwrap_or_default();
    // Behind the name, which may have spaces in it, these are the twelfth and the thirteenth.
    let behind_name = stat.rsplit_once(')').map_or("", |(_, rest)| rest);
    let ticks: Vec<f64> = behind_name
        .split_whitespace()
        .skip(11)
        .take(2)
        .filter_map(|text| text.parse().ok())
        .collect();
    if ticks.len() == 2 { ticks.iter().sum::<f64>() / TICKS_PER_S } else { f64::NAN }
}

/// A path at which nothing is.
fn fresh(path: &Path) -> std::io::Result<PathBuf> {
    if path.exists() {
        fs::remove_dir_all(path)?;
    }
    Ok(path.to_owned())
}

/// The most memory of this program so far, in MiB; NaN where the system does not report it.
fn peak_mib() -> f64 {
    let status = fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    let kib = line.and_then(|line| line.trim().strip_suffix("kB")?.trim().parse::<f64>().ok());
    kib.map_or(f64::NAN, |kib| kib / 1024.0)
}
