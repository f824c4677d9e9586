//! How long it takes on one host from a detection over its command to the wheels.
//!
//! ```text
//! cargo run --release -p rsrs_robot_node --example latency -- 30
//! ```
//! The number is seconds; everything happens in a network of its own. Once the controller is in the
//! robot's process, and once it is a process of its own. This process is the runner and the base
//! driver: its distance sensor sees something, and then nothing, again and again, and every change
//! of the detection is followed. Detections, commands and wheel commands carry the time at which
//! they were sent; the base driver takes the time at which it has the wheel command in hand.

mod base;

use std::io::Write;
use std::process::{Child, Command, Stdio};
use std::time::Duration;

use anyhow::{Context, bail};
use base::{Base, Followed};
use clap::Parser;
use rsrs_ros::confine;
use rsrs_ros::interfaces::LOOPBACK;
use rsrs_ros::session::{Session, SessionOptions};

/// Domain of the network of its own.
const DOMAIN: u16 = 42;
const ROBOT: &str = "robot_1";

/// A process that ends with this one.
struct Node(Child);

impl Drop for Node {
    fn drop(&mut self) {
        // It may have ended already.
        drop(self.0.kill());
        drop(self.0.wait());
    }
}

fn main() -> anyhow::Result<()> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    match arguments.as_slice() {
        [role, ..] if role == "robot" => {
            rsrs_robot_node::main(rsrs_robot_node::Flags::parse_from(arguments))
        }
        [role, ..] if role == "controller" => {
            rsrs_controller_node::main(rsrs_controller_node::Flags::parse_from(arguments))
        }
        [seconds] => {
            let seconds: f64 = seconds.parse().context("the number of seconds")?;
            let duration = Duration::try_from_secs_f64(seconds).context("the number of seconds")?;
            // Before the first thread is started.
            confine::into_own_network()?;
            let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build()?;
            runtime.block_on(async {
                report("controller in the robot's process", &inside(duration).await?)?;
                report("controller in a process of its own", &outside(duration).await?)
            })
        }
        _ => bail!("expected: SECONDS"),
    }
}

async fn inside(duration: Duration) -> anyhow::Result<Vec<Followed>> {
    let _robot = robot(&[])?;
    follow(duration).await
}

async fn outside(duration: Duration) -> anyhow::Result<Vec<Followed>> {
    let _robot = robot(&["--without-controller"])?;
    let _controller = node("controller", &[])?;
    follow(duration).await
}

/// Accelerations that put nothing between a command and the wheels, and many detections.
fn robot(more: &[&str]) -> anyhow::Result<Node> {
    let settings = [
        "--driver",
        "ros",
        "--ros-args",
        "-p",
        "acceleration_max:=100.0",
        "-p",
        "turn_acceleration_max:=1000.0",
        "-p",
        "period:=0.02",
    ];
    node("robot", &[more, &settings].concat())
}

fn node(role: &str, more: &[&str]) -> anyhow::Result<Node> {
    let mut command = Command::new(std::env::current_exe()?);
    command.args([role, "--interface", "127.0.0.1", "--robots", ROBOT]).args(more);
    command.env("ROS_DOMAIN_ID", DOMAIN.to_string()).stdout(Stdio::null());
    Ok(Node(command.spawn().with_context(|| format!("starting the {role}"))?))
}

async fn follow(duration: Duration) -> anyhow::Result<Vec<Followed>> {
    let options = SessionOptions { domain_id: DOMAIN, interfaces: vec![LOOPBACK], enclave: None };
    let session = Session::open(&options)?;
    let mut base = Base::new(&session).await?;
    base.set_controller(&session).await?;
    let followed = base.run(duration).await?;
    drop(base);
    session.close().await;
    Ok(followed)
}

fn report(what: &str, followed: &[Followed]) -> anyhow::Result<()> {
    let mut out = std::io::stdout();
    writeln!(out, "{what}: {} changes of the detection", followed.len())?;
    let all = |of: fn(&Followed) -> u64| followed.iter().map(of).collect();
    line(&mut out, "command sent", all(|change| change.command_ns))?;
    line(&mut out, "wheels set", all(|change| change.wheels_ns))?;
    line(&mut out, "base driver has it", all(|change| change.base_ns))
}

fn line(out: &mut impl Write, what: &str, mut times_ns: Vec<u64>) -> anyhow::Result<()> {
    times_ns.sort_unstable();
    let Some(last) = times_ns.len().checked_sub(1) else { bail!("no detection was followed") };
    let percentile_ms = |percent: usize| times_ns[last * percent / 100] as f64 / 1e6;
    let (median, ninety_ninth, longest) =
        (percentile_ms(50), percentile_ms(99), percentile_ms(100));
    writeln!(
        out,
        "  {what:<18} median {median:.3} ms, 99th percentile {ninety_ninth:.3} ms, longest \
         {longest:.3} ms"
    )?;
    Ok(())
}
