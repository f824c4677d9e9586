//! The simulator and the controllers as processes, ended with this one whatever happens.

use rsrs_core::robot::controller::Reaction;
use rsrs_experiment_runner::plan::Plan;
use rsrs_fleet::parameters::controller::{CONSTANT, SPEED_MAX, TURN_RATE_MAX};

use crate::run::node_process::NodeProcess;
use crate::run::own_network::OwnNetwork;

/// The processes that stand in for a fleet.
pub struct SimulatedFleet {
    simulator: NodeProcess,
    controllers: NodeProcess,
    robots: Vec<String>,
    /// Greatest commands that the controllers take, in m/s and rad/s.
    limits: [f64; 2],
    /// Whether the last run that they were there for was completed, or there was none.
    pub(super) has_completed: bool,
}

impl SimulatedFleet {
    /// Starts the nodes: for the robots of a plan, with the limits of their profile.
    pub fn start(network: &OwnNetwork, plan: &Plan) -> anyhow::Result<Self> {
        let robots = &plan.record.robots;
        let start = |name, parameters: &[String]| {
            NodeProcess::start(name, robots, parameters, |command| {
                network.configure(command);
            })
        };
        Ok(Self {
            simulator: start("sim", &[])?,
            controllers: start("controller", &ros_arguments(of_controllers(plan)))?,
            robots: robots.clone(),
            limits: plan.limits,
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
        *self = Self::start(network, plan)?;
        Ok(())
    }
}

/// Parameters of controllers that take no more than their robots may be commanded, and in trials turn one
/// way whatever is detected.
pub fn of_controllers(plan: &Plan) -> Vec<String> {
    let [most_m_s, most_rad_s] = plan.limits;
    vec![
        format!("{CONSTANT}:={}", plan.reaction() == Reaction::Constant),
        format!("{SPEED_MAX}:={most_m_s:?}"),
        format!("{TURN_RATE_MAX}:={most_rad_s:?}"),
    ]
}

/// The ROS arguments that set parameters, such as `speed:=0.1`.
pub fn ros_arguments(parameters: Vec<String>) -> Vec<String> {
    parameters.into_iter().flat_map(|parameter| ["-p".to_owned(), parameter]).collect()
}
