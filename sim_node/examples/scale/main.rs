//! How much of a core one simulator takes for many robots, and what is lost on the way.
//!
//! ```text
//! cargo run --release -p rsrs_sim_node --example scale -- 100 real_time 20
//! cargo run --release -p rsrs_sim_node --example scale -- 300 lockstep 60
//! ```
//! The last number is seconds: wall-clock in real time, simulated in lockstep; a path after it names
//! another build of this program, whose simulator is used instead. Everything happens in a network of its
//! own, with this process as every controller, the runner and the recorder.

mod fleet_runner;

use std::io::Write;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use anyhow::{Context, bail};
use clap::Parser;
use fleet_runner::{FleetRunner, Report, TimeMode, conditions, names};
use rsrs_ros::confine;
use rsrs_ros::interfaces::LOOPBACK;
use rsrs_ros::session::{Session, SessionOptions};

/// Domain of the network of its own.
const DOMAIN: u16 = 42;
/// Clock ticks per second in /proc, on every Linux that is in use.
const TICKS_PER_S: f64 = 100.0;
/// Of a lockstep run, in wall-clock time; ten times what three hundred robots take for a minute.
const LONGEST: Duration = Duration::from_secs(200);
/// So long nobody looks, until all are armed and move.
const WARM_UP: Duration = Duration::from_secs(3);

fn main() -> anyhow::Result<()> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    if arguments.first().is_some_and(|role| role == "simulator") {
        return rsrs_sim_node::main(rsrs_sim_node::Flags::parse_from(arguments));
    }
    let [n_robots, pace, seconds, other @ ..] = arguments.as_slice() else {
        bail!("expected: ROBOTS real_time|lockstep SECONDS [PROGRAM]");
    };
    let n_robots: usize = n_robots.parse().context("the number of robots")?;
    let seconds: f64 = seconds.parse().context("the number of seconds")?;
    let pace = match pace.as_str() {
        "real_time" => TimeMode::RealTime,
        "lockstep" => TimeMode::Lockstep { steps: conditions(n_robots).steps(seconds) },
        other => bail!("`{other}` is no pace, expected real_time or lockstep"),
    };
    // Before the first thread is started.
    confine::into_own_network()?;
    tokio::runtime::Builder::new_current_thread().enable_all().build()?.block_on(measure(
        n_robots,
        (pace, seconds),
        other.first().map(String::as_str),
    ))
}

async fn measure(
    n_robots: usize,
    (pace, seconds): (TimeMode, f64),
    other: Option<&str>,
) -> anyhow::Result<()> {
    let begun = Instant::now();
    let mut simulator = simulator(n_robots, other)?;
    let options = SessionOptions { domain_id: DOMAIN, interfaces: vec![LOOPBACK], enclave: None };
    let session = Session::open(&options)?;
    let mut fleet_runner = FleetRunner::new(&session, n_robots, pace).await;
    let matched_s = begun.elapsed().as_secs_f64();
    fleet_runner.place().await;
    let (cpu_s, report) = match pace {
        TimeMode::Lockstep { .. } => {
            let before = cpu_s(&simulator)?;
            let report = fleet_runner.run(LONGEST).await;
            (cpu_s(&simulator)? - before, report)
        }
        TimeMode::RealTime => {
            let watching = async {
                tokio::time::sleep(WARM_UP).await;
                let before = cpu_s(&simulator)?;
                tokio::time::sleep(Duration::from_secs_f64(seconds)).await;
                anyhow::Ok(cpu_s(&simulator)? - before)
            };
            let whole = WARM_UP + Duration::from_secs_f64(seconds);
            let (cpu_s, report) = tokio::join!(watching, fleet_runner.run(whole));
            (cpu_s?, report)
        }
    };
    simulator.kill()?;
    simulator.wait()?;
    let wall_s = match pace {
        TimeMode::RealTime => seconds,
        TimeMode::Lockstep { .. } => report.took.as_secs_f64(),
    };
    drop(fleet_runner);
    session.close().await;
    if report.steps == 0 || report.moving < n_robots {
        bail!(
            "{} of {n_robots} robots moved at the end, after {} steps",
            report.moving,
            report.steps
        );
    }
    if let TimeMode::Lockstep { steps } = pace
        && report.steps < steps
    {
        bail!("only {} of {steps} steps were made within {} s", report.steps, LONGEST.as_secs());
    }
    print_report(n_robots, pace, (matched_s, cpu_s, wall_s), &report)
}

fn print_report(
    n_robots: usize,
    pace: TimeMode,
    (matched_s, cpu_s, wall_s): (f64, f64, f64),
    report: &Report,
) -> anyhow::Result<()> {
    let Report { steps, detections, poses, lost, .. } = report;
    let simulated_s = *steps as f64 * conditions(n_robots).period_s;
    let mut out = std::io::stdout();
    writeln!(out, "{n_robots} robots, all topics matched after {matched_s:.2} s")?;
    writeln!(out, "{steps} steps, {detections} detections, {poses} poses, {lost} lost")?;
    writeln!(out, "simulator: {:.1} % of a core", 100.0 * cpu_s / wall_s)?;
    if pace != TimeMode::RealTime {
        writeln!(out, "{:.2} times real time", simulated_s / wall_s)?;
    }
    Ok(())
}

/// The simulator, as a process of its own in this network.
fn simulator(n_robots: usize, other: Option<&str>) -> anyhow::Result<Child> {
    let this = std::env::current_exe()?;
    Command::new(other.map_or(this.as_path(), Path::new))
        .arg("simulator")
        .args(["--interface", "127.0.0.1", "--robots", &names(n_robots).join(",")])
        .env("ROS_DOMAIN_ID", DOMAIN.to_string())
        .stdout(Stdio::null())
        .spawn()
        .context("starting the simulator")
}

/// Time on processors of a process so far, in seconds.
fn cpu_s(process: &Child) -> anyhow::Result<f64> {
    let text = std::fs::read_to_string(format!("/proc/{}/stat", process.id()))?;
    // The name of the program, in parentheses, may hold spaces.
    let (_, fields) = text.rsplit_once(')').context("a process has a name")?;
    let field = |index: usize| -> anyhow::Result<f64> {
        let text = fields.split_whitespace().nth(index).context("too few fields in /proc")?;
        Ok(text.parse()?)
    };
    Ok((field(11)? + field(12)?) / TICKS_PER_S)
}
