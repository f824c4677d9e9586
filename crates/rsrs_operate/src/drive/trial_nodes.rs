//! Who moves the robots of trials: started once for several of them.

use anyhow::Context;
use rsrs_experiment_runner::plan::Plan;
use rsrs_fleet::fleet_file::{FleetRobot, LeaseHolder};
use rsrs_fleet::parameters::controller::{CMD_VEL_TYPE, LEASE, PERIOD};
use rsrs_fleet::record::{self, EndingKind};
use rsrs_pipeline::error::with_help;
use rsrs_pipeline::run_summary::RunSummary;
use rsrs_render::operator_event::OperatorEvent;
use rsrs_ros::interfaces;
use rsrs_ros::session::SessionOptions;

use crate::run::node_process::NodeProcess;
use crate::run::operator::Operator;
use crate::run::own_network::OwnNetwork;
use crate::run::simulated_fleet::{SimulatedFleet, of_controllers, ros_arguments};
use crate::run::{RunTarget, on_simulated_fleet, watched};

/// The variable that names the enclave of a program.
const ENCLAVE: &str = "ROS_SECURITY_ENCLAVE_OVERRIDE";
/// The enclave of controllers that are not on their robots.
const CONTROLLERS: &str = "/controllers";

/// The processes that answer detections with a constant command, and what they move.
pub struct TrialNodes<'a> {
    processes: Processes<'a>,
    operator: &'a dyn Operator,
}

enum Processes<'a> {
    /// A simulator and its controllers.
    Simulator(&'a OwnNetwork, Box<SimulatedFleet>),
    /// The controllers of robots of the floor, whose own nodes run already.
    Fleet(&'a SessionOptions, NodeProcess),
}

impl<'a> TrialNodes<'a> {
    /// Starts the processes for a series of trials.
    ///
    /// The plan is that of one of them, with all robots that take part in any; on a real floor,
    /// with the one that is measured.
    pub fn start(
        floor: &'a RunTarget,
        plan: &Plan,
        operator: &'a dyn Operator,
    ) -> anyhow::Result<Self> {
        let robots = &plan.record.robots;
        let processes = match floor {
            RunTarget::Simulator(network) => {
                let fleet = SimulatedFleet::start(network, plan)?;
                Processes::Simulator(network, Box::new(fleet))
            }
            RunTarget::Fleet(network) => {
                if !plan.is_measured {
                    let robot = &plan.robots[0];
                    operator.inform(&OperatorEvent::NoProfile {
                        robot: &robot.name,
                        profile: robot.profile.as_deref(),
                        limits: plan.limits,
                    });
                }
                let arguments = controller_arguments(plan);
                let addresses: Vec<String> =
                    network.interfaces.iter().map(ToString::to_string).collect();
                let start = |command: &mut std::process::Command| {
                    command.env(interfaces::VARIABLE, addresses.join(","));
                    if network.enclave.is_some() {
                        // Not that of this process, which holds the lease and commands nobody.
                        command.env(ENCLAVE, CONTROLLERS);
                    }
                };
                let controller = NodeProcess::start("controller", robots, &arguments, start)?;
                Processes::Fleet(network, controller)
            }
        };
        Ok(Self { processes, operator })
    }

    /// Runs one trial to its end.
    pub async fn run(&mut self, plan: &Plan) -> anyhow::Result<RunSummary> {
        let operator = self.operator;
        let summary = match &mut self.processes {
            Processes::Simulator(network, fleet) => {
                on_simulated_fleet(plan, network, fleet, operator).await
            }
            Processes::Fleet(network, controller) => {
                let stop = async {
                    tokio::select! {
                        reason = operator.stop_requested() => reason,
                        reason = controller.ended() => reason,
                    }
                };
                watched(plan, network, stop, operator).await
            }
        }?;
        completed(plan, &summary, operator)?;
        Ok(summary)
    }

    /// Ends the processes.
    pub async fn stop(self) -> anyhow::Result<()> {
        match self.processes {
            Processes::Simulator(_, mut fleet) => fleet.stop().await,
            Processes::Fleet(_, mut controller) => controller.stop().await,
        }
        .context("ending the nodes of the trial")
    }
}

/// What the controller of a robot of the floor is started with.
fn controller_arguments(plan: &Plan) -> Vec<String> {
    let robot = &plan.robots[0];
    let mut parameters = of_controllers(plan);
    parameters.extend([
        format!("{PERIOD}:={:?}", plan.record.conditions.period_s),
        format!("{CMD_VEL_TYPE}:={}", robot.cmd_vel.key()),
        format!("{LEASE}:={}", robot.lease.key()),
    ]);
    ros_arguments(parameters)
}

/// Refuses a run that was not completed.
fn completed(plan: &Plan, summary: &RunSummary, operator: &dyn Operator) -> anyhow::Result<()> {
    if !summary.not_standing.is_empty() {
        operator.inform(&OperatorEvent::Unconfirmed { robots: &summary.not_standing });
    }
    if summary.ending == EndingKind::Completed && summary.bag.is_some() {
        return Ok(());
    }
    let message =
        format!("trial {}: {}", summary.ending.key(), summary.reason.replace("; ", "\n  "));
    if plan.record.backend == record::Backend::Simulator {
        return Err(anyhow::anyhow!(message));
    }
    let FleetRobot { name, lease, .. } = &plan.robots[0];
    Err(with_help(
        message,
        match lease {
            LeaseHolder::Gate => format!(
                "{name} has `lease: gate`: it needs its node, without its controller: \
                 `rsrs node robot --robots {name} --without-controller …`"
            ),
            LeaseHolder::Controller => format!(
                "{name} has `lease: controller`: it publishes `detection` once in a period and \
                 obeys `cmd_vel`; this command is its controller, and no other may run"
            ),
        },
    ))
}
