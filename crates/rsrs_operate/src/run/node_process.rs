//! A node of this program as a process of its own, ended with this one whatever happens.

use std::path::Path;
use std::process::{Command, ExitStatus, Stdio};
use std::time::Duration;

use anyhow::Context;
use tokio::process::Child;

/// How long a node may take to end after it was asked to.
const TIMEOUT: Duration = Duration::from_secs(5);

/// A running node.
///
/// It ends with [`NodeProcess::stop`], when this is dropped, and when this process dies. Ctrl-C in a
/// terminal does not reach it: the runner stops the robots first.
pub struct NodeProcess {
    name: &'static str,
    child: Child,
}

/// This very program, also after another one was built or installed in its place: a campaign of a day
/// ends with the program that it was begun with.
fn this_program() -> anyhow::Result<Command> {
    /// What runs, whatever lies at its path now; only Linux has it.
    const RUNNING: &str = "/proc/self/exe";
    let path = std::env::current_exe().context("finding this program")?;
    if !Path::new(RUNNING).exists() {
        return Ok(Command::new(path));
    }
    let mut command = Command::new(RUNNING);
    // Tools that list processes show where it was started from.
    std::os::unix::process::CommandExt::arg0(&mut command, path);
    Ok(command)
}

impl NodeProcess {
    /// Starts the node that `rsrs node` calls by this name, which stands for these robots.
    ///
    /// The parameters are ROS arguments besides the log level, such as `-p speed:=0.1`; `network`
    /// sets the network of the process.
    pub fn start(
        name: &'static str,
        robots: &[String],
        parameters: &[String],
        network: impl FnOnce(&mut Command),
    ) -> anyhow::Result<Self> {
        let mut command = this_program()?;
        let parent = std::process::id().to_string();
        command.args(["node", "--parent", &parent, name, "--robots", &robots.join(",")]);
        command.args(["--ros-args", "--log-level", "warn"]).args(parameters);
        network(&mut command);
        // A process group of its own: signals from the terminal are for the runner.
        std::os::unix::process::CommandExt::process_group(&mut command, 0);
        command.stdin(Stdio::null()).stdout(Stdio::null());
        let child = tokio::process::Command::from(command)
            .kill_on_drop(true)
            .spawn()
            .with_context(|| format!("starting the node `{name}`"))?;
        Ok(Self { name, child })
    }

    /// Waits until the node ends, which it should not, and returns which one it was, and how it
    /// ended.
    pub async fn ended(&mut self) -> String {
        let name = self.name;
        let status: std::io::Result<ExitStatus> = self.child.wait().await;
        match status {
            Ok(status) => format!("the process of the node `{name}` ended: {status}"),
            Err(error) => format!("the process of the node `{name}` is lost: {error}"),
        }
    }

    /// Asks the node to end.
    pub fn ask_to_end(&self) -> anyhow::Result<()> {
        match self.child.id() {
            Some(pid) => rsrs_ros::shutdown::terminate(pid).context("ending a node"),
            None => Ok(()),
        }
    }

    /// Asks the node to end, and waits for it.
    pub async fn stop(&mut self) -> anyhow::Result<()> {
        self.ask_to_end()?;
        if tokio::time::timeout(TIMEOUT, self.child.wait()).await.is_err() {
            self.child.kill().await.context("killing a node that does not end")?;
        }
        Ok(())
    }
}
