//! The simulator and the controllers as processes, ended with this one whatever happens.

use rsrs_experiment_runner::plan::Plan;

use crate::run::node_process::NodeProcess;
use crate::run::own_network::OwnNetwork;

/// The processes that stand in for a fleet.
pub struct SimulatedFleet {
    simulator: NodeProcess,
    controllers: NodeProcess,
    robots: Vec<String>,
    /// Greatest commands that the controllers take, in m/s and rad/s.
    limits: [f64; 2],
    /// ROS arguments of the controllers beyond their limits.
    reaction: &'static [&'static str],
    /// Whether the last run that they were there for was completed, or there was none.
    pub(super) has_completed: bool,
}

/// ROS arguments of controllers that turn one way whatever is detected: for trials.
pub const CONSTANT: [&str; 2] = ["-p", "constant:=true"];

impl SimulatedFleet {
    /// Starts the nodes: for the robots of a plan, with the limits of their profile.
    pub fn start(network: &OwnNetwork, plan: &Plan) -> anyhow::Result<Self> {
        Self::start_with(network, plan, &[])
    }

    /// Starts the nodes for a trial: the command is constant, whatever is detected.
    pub fn start_constant(network: &OwnNetwork, plan: &Plan) -> anyhow::Result<Self> {
        Self::start_with(network, plan, &CONSTANT)
    }

    fn start_with(
        network: &OwnNetwork,
        plan: &Plan,
        reaction: &'static [&'static str],
    ) -> anyhow::Result<Self> {
        let robots = &plan.record.robots;
        let start = |name, parameters: &[&str]| {
            NodeProcess::start(name, robots, parameters, |command| {
                network.configure(command);
            })
        };
        let limits = limit_parameters(plan);
        let of_controllers: Vec<&str> =
            reaction.iter().copied().chain(limits.iter().map(String::as_str)).collect();
        Ok(Self {
            simulator: start("sim", &[])?,
            controllers: start("controller", &of_controllers)?,
            robots: robots.clone(),
            limits: plan.limits,
            reaction,
            has_completed: true,
        })
    }

    /// Whether the nodes are those that a plan needs.
    pub fn is_for(&self, plan: &Plan) -> bool {
        self.robots == plan.record.robots
            && self.limits.map(f64::to_bits) == plan.limits.map(f64::to_bits)
    }

    /// Waits until one of the nodes ends, which none should, and returns which one it was, and how
    /// it ended.
    pub async fn ended(&mut self) -> String {
        tokio::select! {
            reason = self.simulator.ended() => reason,
            reason = self.controllers.ended() => reason,
        }
    }

    /// Asks the nodes to end, and waits for it.
    pub async fn stop(&mut self) -> anyhow::Result<()> {
        // Both end at the same time.
        self.controllers.ask_to_end()?;
        self.simulator.stop().await?;
        self.controllers.stop().await
    }

    /// Ends the nodes and starts them anew, for the same robots: it may be one of them that a run failed for.
    pub(super) async fn restart(
        &mut self,
        network: &OwnNetwork,
        plan: &Plan,
    ) -> anyhow::Result<()> {
        self.stop().await?;
        *self = Self::start_with(network, plan, self.reaction)?;
        Ok(())
    }
}

/// ROS arguments of controllers that take no more than their robots may be commanded.
pub fn limit_parameters(plan: &Plan) -> [String; 4] {
    let [most_m_s, most_rad_s] = plan.limits;
    let parameter = || "-p".to_owned();
    [
        parameter(),
        format!("speed_max:={most_m_s:?}"),
        parameter(),
        format!("turn_rate_max:={most_rad_s:?}"),
    ]
}
