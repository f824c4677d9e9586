//! The simulator and the controllers as processes, ended with this one whatever happens.

use crate::run::node_process::NodeProcess;
use crate::run::own_network::OwnNetwork;

/// The processes that stand in for a fleet.
pub struct SimulatedFleet {
    simulator: NodeProcess,
    controllers: NodeProcess,
}

/// ROS arguments of controllers that turn one way whatever is detected: for trials.
pub const CONSTANT: [&str; 2] = ["-p", "constant:=true"];

impl SimulatedFleet {
    /// Starts the nodes.
    ///
    /// # Errors
    ///
    /// If a process cannot be started.
    pub fn start(network: &OwnNetwork, robots: &[String]) -> anyhow::Result<Self> {
        Self::start_with(network, robots, &[])
    }

    /// Starts the nodes for a trial: the command is constant, whatever is detected.
    ///
    /// # Errors
    ///
    /// If a process cannot be started.
    pub fn start_constant(network: &OwnNetwork, robots: &[String]) -> anyhow::Result<Self> {
        Self::start_with(network, robots, &CONSTANT)
    }

    fn start_with(
        network: &OwnNetwork,
        robots: &[String],
        controller: &[&str],
    ) -> anyhow::Result<Self> {
        let start = |name, parameters: &[&str]| {
            NodeProcess::start(name, robots, parameters, |command| {
                network.configure(command);
            })
        };
        Ok(Self { simulator: start("sim", &[])?, controllers: start("controller", controller)? })
    }

    /// Waits until one of the nodes ends, which none should.
    ///
    /// # Returns
    ///
    /// Which one, and how.
    pub async fn ended(&mut self) -> String {
        tokio::select! {
            reason = self.simulator.ended() => reason,
            reason = self.controllers.ended() => reason,
        }
    }

    /// Asks the nodes to end, and waits for it.
    ///
    /// # Errors
    ///
    /// If a process can neither be asked nor killed.
    pub async fn stop(self) -> anyhow::Result<()> {
        // Both end at the same time.
        self.controllers.ask_to_end()?;
        self.simulator.stop().await?;
        self.controllers.stop().await
    }
}
