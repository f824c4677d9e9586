//! Who moves the robots of trials: started once for several of them.

use anyhow::Context;
use rsrs_experiment_runner::plan::Plan;
use rsrs_fleet::fleet_file::{CmdVel, FleetRobot, LeaseHolder};
use rsrs_fleet::record::{self, EndingKind};
use rsrs_ros::interfaces;
use rsrs_ros::logging::{self, Level};
use rsrs_ros::session::SessionOptions;

use crate::commands::Backend;
use crate::experiment_bar::TerminalOperator;
use crate::fleet_network::chosen_network;
use crate::interrupt::asked_to_stop;
use crate::notes::print_note;
use rsrs_pipeline::error::with_help;
use rsrs_pipeline::run::node_process::NodeProcess;
use rsrs_pipeline::run::own_network::OwnNetwork;
use rsrs_pipeline::run::simulated_fleet::{CONSTANT, SimulatedFleet};
use rsrs_pipeline::run::{RunSummary, on_simulated_fleet, watched};

/// Where trials are driven.
pub enum RunTarget {
    /// A network of this process's own.
    Simulated(OwnNetwork),
    /// The fleet's.
    Real(SessionOptions),
}

impl RunTarget {
    /// Enters the network; to be called before the first thread is started.
    ///
    /// # Errors
    ///
    /// If there is no such network.
    pub fn enter(backend: Backend, interface: Option<&str>) -> anyhow::Result<Self> {
        let floor = match backend {
            Backend::Sim => Self::Simulated(OwnNetwork::enter()?),
            Backend::Fleet => Self::Real(chosen_network(interface)?),
        };
        logging::init(Level::Warn, std::env::var("RUST_LOG").ok().as_deref());
        Ok(floor)
    }
}

/// The processes that answer detections with a constant command, and what they move.
pub enum TrialNodes<'a> {
    /// A simulator and its controllers.
    Simulated(&'a OwnNetwork, SimulatedFleet),
    /// The controllers of robots of the floor, whose own nodes run already.
    Real(&'a SessionOptions, NodeProcess),
}

impl<'a> TrialNodes<'a> {
    /// Starts the processes.
    ///
    /// # Arguments
    ///
    /// * `plan` — one of the trials, with all robots that take part in any of them; on a real floor,
    ///   with the one that is measured.
    ///
    /// # Errors
    ///
    /// If a process cannot be started.
    pub fn start(floor: &'a RunTarget, plan: &Plan) -> anyhow::Result<Self> {
        let robots = &plan.record.robots;
        match floor {
            RunTarget::Simulated(network) => {
                let fleet = SimulatedFleet::start_constant(network, robots)?;
                Ok(Self::Simulated(network, fleet))
            }
            RunTarget::Real(network) => {
                if !plan.is_measured {
                    print_note(&unmeasured(plan));
                }
                let parameters = controller_parameters(plan);
                let parameters: Vec<&str> = parameters.iter().map(String::as_str).collect();
                let address =
                    network.interfaces.first().map(ToString::to_string).unwrap_or_default();
                let start = |command: &mut std::process::Command| {
                    command.env(interfaces::VARIABLE, address);
                };
                let controller = NodeProcess::start("controller", robots, &parameters, start)?;
                Ok(Self::Real(network, controller))
            }
        }
    }

    /// Runs one trial to its end.
    ///
    /// # Errors
    ///
    /// If the network cannot be used, or the run was not completed.
    pub async fn conduct(&mut self, plan: &Plan) -> anyhow::Result<RunSummary> {
        let summary = match self {
            Self::Simulated(network, fleet) => {
                on_simulated_fleet(plan, network, fleet, &TerminalOperator).await
            }
            Self::Real(network, controller) => {
                let stop = async {
                    tokio::select! {
                        reason = asked_to_stop() => reason,
                        reason = controller.ended() => reason,
                    }
                };
                watched(plan, network, stop, &TerminalOperator).await
            }
        }?;
        completed(plan, &summary)?;
        Ok(summary)
    }

    /// Ends the processes.
    ///
    /// # Errors
    ///
    /// If one can neither be asked nor killed.
    pub async fn stop(self) -> anyhow::Result<()> {
        match self {
            Self::Simulated(_, fleet) => fleet.stop().await,
            Self::Real(_, controller) => controller.stop().await,
        }
        .context("ending the nodes of the trial")
    }
}

/// What to say of a robot whose profile is not there.
fn unmeasured(plan: &Plan) -> String {
    let robot = &plan.robots[0];
    let [most_m_s, most_rad_s] = plan.limits;
    let profile = match &robot.profile {
        Some(profile) => format!("the profile `{profile}` of {} is not there yet", robot.name),
        None => format!("{} has no profile yet", robot.name),
    };
    format!("{profile}; its limits are those of the trials, {most_m_s} m/s and {most_rad_s} rad/s")
}

/// What the controller of a robot of the floor is started with.
fn controller_parameters(plan: &Plan) -> Vec<String> {
    let robot = &plan.robots[0];
    let [most_m_s, most_rad_s] = plan.limits;
    let mut parameters: Vec<String> = CONSTANT.map(str::to_owned).to_vec();
    let mut set = |parameter: String| parameters.extend(["-p".to_owned(), parameter]);
    set(format!("speed_max:={most_m_s:?}"));
    set(format!("turn_rate_max:={most_rad_s:?}"));
    set(format!("period:={:?}", plan.record.conditions.period_s));
    if robot.cmd_vel == CmdVel::Twist {
        set("cmd_vel_type:=twist".to_owned());
    }
    if robot.lease == LeaseHolder::Controller {
        set("lease:=controller".to_owned());
    }
    parameters
}

/// Refuses a run that was not completed.
fn completed(plan: &Plan, summary: &RunSummary) -> anyhow::Result<()> {
    if !summary.not_standing.is_empty() {
        print_note(&format!(
            "not confirmed to stand, go and look: {}",
            summary.not_standing.join(", ")
        ));
    }
    if summary.ending == EndingKind::Completed.key() && summary.bag.is_some() {
        return Ok(());
    }
    let message = format!("trial {}: {}", summary.ending, summary.reason.replace("; ", "\n  "));
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
