//! The simulator and the controllers as processes, ended with this one whatever happens.

use std::process::{Command, Stdio};
use std::time::Duration;

use anyhow::Context;
use tokio::process::Child;

use crate::own_network::OwnNetwork;

/// How long a node may take to end after it was asked to.
const PATIENCE: Duration = Duration::from_secs(5);

/// The processes that stand in for a fleet.
///
/// They end with [`SimulatedFleet::stop`], when this is dropped, and when this process dies. Ctrl-C
/// in a terminal does not reach them: the runner stops the robots first.
pub struct SimulatedFleet {
    simulator: Child,
    controllers: Child,
}

impl SimulatedFleet {
    /// Starts the nodes.
    ///
    /// # Errors
    ///
    /// If a process cannot be started.
    pub fn start(network: &OwnNetwork, robots: &[String]) -> anyhow::Result<Self> {
        Ok(Self {
            simulator: node("sim", network, robots)?,
            controllers: node("controller", network, robots)?,
        })
    }

    /// Waits until one of the nodes ends, which none should.
    ///
    /// # Returns
    ///
    /// Which one, and how.
    pub async fn ended(&mut self) -> String {
        let (node, status) = tokio::select! {
            status = self.simulator.wait() => ("simulator", status),
            status = self.controllers.wait() => ("controllers", status),
        };
        match status {
            Ok(status) => format!("the process of the {node} ended: {status}"),
            Err(error) => format!("the process of the {node} is lost: {error}"),
        }
    }

    /// Asks the nodes to end, and waits for it.
    ///
    /// # Errors
    ///
    /// If a process can neither be asked nor killed.
    pub async fn stop(mut self) -> anyhow::Result<()> {
        for child in [&mut self.simulator, &mut self.controllers] {
            if let Some(pid) = child.id() {
                rsrs_ros::shutdown::terminate(pid).context("ending a node")?;
            }
        }
        for child in [&mut self.simulator, &mut self.controllers] {
            if tokio::time::timeout(PATIENCE, child.wait()).await.is_err() {
                child.kill().await.context("killing a node that does not end")?;
            }
        }
        Ok(())
    }
}

fn node(name: &str, network: &OwnNetwork, robots: &[String]) -> anyhow::Result<Child> {
    let program = std::env::current_exe().context("finding this program")?;
    let mut command = Command::new(program);
    let parent = std::process::id().to_string();
    command.args(["node", "--parent", &parent, name, "--robots", &robots.join(",")]);
    command.args(["--ros-args", "--log-level", "warn"]);
    network.tell(&mut command);
    // A process group of its own: signals from the terminal are for the runner.
    std::os::unix::process::CommandExt::process_group(&mut command, 0);
    command.stdin(Stdio::null()).stdout(Stdio::null());
    tokio::process::Command::from(command)
        .kill_on_drop(true)
        .spawn()
        .with_context(|| format!("starting the node `{name}`"))
}
