//! What DDS Security costs: two processes in a network of their own, plain and secured.
//!
//! ```text
//! cargo run --release -p rsrs_ros --features security --example secured_costs -- 10
//! ```
//! The number is seconds per measurement. One process publishes detections, the other one answers
//! each with a command, as a controller does; the round trip, the processor and the memory of the
//! second process are measured, and how long it takes from its start to its first answer.

use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Child, Command};
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

use anyhow::{Context, bail};
use rsrs_keystore::create::{KeystoreRequest, create};
use rsrs_msgs::RosMessage;
use rsrs_msgs::std_msgs::Bool;
use rsrs_msgs::topics::Qos;
use rsrs_ros::confine;
use rsrs_ros::interfaces::LOOPBACK;
use rsrs_ros::security::{Member, SecurityRequest, Strategy};
use rsrs_ros::session::{RawPublisher, ReceivedRaw, Session, SessionOptions};
use tokio::sync::mpsc::{UnboundedReceiver, unbounded_channel};

/// Domain of the network of its own.
const DOMAIN: u16 = 42;
const THERE: &str = "/robot_1/detection";
const BACK: &str = "/robot_1/cmd_vel";
const QOS: Qos = Qos::reliable(1000);
/// As often as robots of a large fleet together.
const RATE_HZ: u64 = 1000;
/// Round trips are measured one after the other, so far apart.
const PAUSE: Duration = Duration::from_millis(5);
const TIMEOUT: Duration = Duration::from_secs(20);
/// Hundredths of a second are the kernel's unit of processor time.
const TICKS_PER_S: f64 = 100.0;

fn main() -> anyhow::Result<()> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let keystore = |text: &str| (text != "plain").then(|| PathBuf::from(text));
    match arguments.as_slice() {
        [role, text] if role == "answer" => run(answer(keystore(text).as_deref())),
        [seconds] => {
            let seconds: f64 = seconds.parse().context("the number of seconds")?;
            let duration = Duration::try_from_secs_f64(seconds).context("the number of seconds")?;
            // Before the first thread is started.
            confine::into_own_network()?;
            let folder = tempfile::tempdir()?;
            create(&KeystoreRequest {
                folder: folder.path(),
                robots: &["robot_1".to_owned()],
                domain_id: Some(DOMAIN),
                now: since_1970()?,
                validity: Some(Duration::from_secs(24 * 3600)),
                readmitted: &[],
            })?;
            run(async {
                let mut out = std::io::stdout();
                writeln!(
                    out,
                    "| | first answer | round trip, median | 99 % | CPU at {RATE_HZ} messages/s each way | memory |"
                )?;
                writeln!(out, "|---|---|---|---|---|---|")?;
                writeln!(out, "| plain | {} |", measure(None, duration).await?)?;
                Ok(writeln!(
                    out,
                    "| secured | {} |",
                    measure(Some(folder.path()), duration).await?
                )?)
            })
        }
        _ => bail!("expected: SECONDS"),
    }
}

fn run(task: impl Future<Output = anyhow::Result<()>>) -> anyhow::Result<()> {
    tokio::runtime::Builder::new_current_thread().enable_all().build()?.block_on(task)
}

fn since_1970() -> anyhow::Result<Duration> {
    Ok(SystemTime::now().duration_since(UNIX_EPOCH)?)
}

fn open(keystore: Option<&Path>, enclave: &str) -> anyhow::Result<Session> {
    let enclave = match keystore {
        None => None,
        Some(keystore) => SecurityRequest {
            keystore: keystore.to_owned(),
            strategy: Strategy::Enforce,
            enclave: Some(enclave.to_owned()),
        }
        .enclave(Member::Runner, DOMAIN, since_1970()?)?,
    };
    Ok(Session::open(&SessionOptions { domain_id: DOMAIN, interfaces: vec![LOOPBACK], enclave })?)
}

/// Answers every message, until it is killed.
async fn answer(keystore: Option<&Path>) -> anyhow::Result<()> {
    let session = open(keystore, "/controllers")?;
    let publisher = session.publish_raw(BACK, Bool::TYPE_NAME, QOS)?;
    let (sender, mut received) = unbounded_channel();
    let deliver = move |sample: ReceivedRaw| drop(sender.send(sample.message));
    let _subscription = session.subscribe_raw(THERE, Bool::TYPE_NAME, QOS, deliver)?;
    while let Some(message) = received.recv().await {
        publisher.publish(&message).await?;
    }
    Ok(())
}

/// The process that answers; it ends with this one.
struct Answering(Child);

impl Drop for Answering {
    fn drop(&mut self) {
        // It may have ended already.
        drop(self.0.kill());
        drop(self.0.wait());
    }
}

impl Answering {
    /// Time on processors so far, in seconds.
    fn cpu_s(&self) -> anyhow::Result<f64> {
        let stat = std::fs::read_to_string(format!("/proc/{}/stat", self.0.id()))?;
        let (_, fields) = stat.rsplit_once(") ").context("the kernel's table of a process")?;
        let ticks = fields.split(' ').skip(11).take(2).map(str::parse::<f64>);
        Ok(ticks.collect::<Result<Vec<_>, _>>()?.iter().sum::<f64>() / TICKS_PER_S)
    }

    /// Memory in use, in MiB.
    fn memory_mib(&self) -> anyhow::Result<f64> {
        let status = std::fs::read_to_string(format!("/proc/{}/status", self.0.id()))?;
        let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:"));
        let kib = line.and_then(|line| line.split_whitespace().next());
        Ok(kib.context("the kernel's table of a process")?.parse::<f64>()? / 1024.0)
    }
}

async fn measure(keystore: Option<&Path>, duration: Duration) -> anyhow::Result<String> {
    let session = open(keystore, "/simulator")?;
    let publisher = session.publish_raw(THERE, Bool::TYPE_NAME, QOS)?;
    let (sender, mut answers) = unbounded_channel();
    let deliver = move |sample: ReceivedRaw| drop(sender.send(sample.message));
    let subscription = session.subscribe_raw(BACK, Bool::TYPE_NAME, QOS, deliver)?;
    let start = Instant::now();
    let text = keystore.map_or_else(|| "plain".into(), |path| path.as_os_str().to_owned());
    let child = Command::new(std::env::current_exe()?).arg("answer").arg(text).spawn()?;
    let process = Answering(child);
    while !is_answered(&publisher, &mut answers, 0, PAUSE).await? {
        anyhow::ensure!(start.elapsed() < TIMEOUT, "no answer in {TIMEOUT:?}");
    }
    let first = start.elapsed();
    while answers.try_recv().is_ok() {}

    let mut round_trips = Vec::new();
    let start = Instant::now();
    while start.elapsed() < duration {
        let (sent, number) = (Instant::now(), round_trips.len() as u64 + 1);
        anyhow::ensure!(
            is_answered(&publisher, &mut answers, number, TIMEOUT).await?,
            "no answer in {TIMEOUT:?}"
        );
        round_trips.push(sent.elapsed());
        tokio::time::sleep(PAUSE).await;
    }
    round_trips.sort();

    let (before, start) = (process.cpu_s()?, Instant::now());
    let mut tick = tokio::time::interval(Duration::from_micros(1_000_000 / RATE_HZ));
    while start.elapsed() < duration {
        tick.tick().await;
        publisher.publish(&message(0)).await?;
        while answers.try_recv().is_ok() {}
    }
    let share = (process.cpu_s()? - before) / start.elapsed().as_secs_f64();
    let memory_mib = process.memory_mib()?;
    drop((process, publisher, subscription));
    session.close().await;
    let of = |share: usize| round_trips[(round_trips.len() - 1) * share / 100].as_secs_f64() * 1e3;
    Ok(format!(
        "{:.2} s | {:.2} ms | {:.2} ms | {:.0} % of a core | {memory_mib:.1} MiB",
        first.as_secs_f64(),
        of(50),
        of(99),
        share * 100.0
    ))
}

/// Sends a message with a number, and waits for the same.
async fn is_answered(
    publisher: &RawPublisher,
    answers: &mut UnboundedReceiver<Vec<u8>>,
    number: u64,
    timeout: Duration,
) -> anyhow::Result<bool> {
    let message = message(number);
    publisher.publish(&message).await?;
    let answer = async {
        while let Some(answer) = answers.recv().await {
            if answer == message {
                break;
            }
        }
    };
    Ok(tokio::time::timeout(timeout, answer).await.is_ok())
}

fn message(number: u64) -> Vec<u8> {
    [&[0, 1, 0, 0][..], &number.to_le_bytes()].concat()
}
