//! Whoever sees to it that robots stand where a trial wants them.

use rsrs_core::trials::trial::Trial;
use rsrs_experiment_runner::plan::Plan;
use rsrs_fleet::record::Backend;

use super::Arguments;
use super::operator;
use crate::experiment_bar::TerminalOperator;
use rsrs_operate::drive::placement::wanted;
use rsrs_operate::drive::result::Motion;
use rsrs_operate::drive::{OperatorFuture, Ready, TrialOperator};
use rsrs_operate::run::operator::Operator;
use rsrs_operate::run::place_command;
use rsrs_pipeline::measure::plan_folder::enabled_robots;
use rsrs_render::driven_trials::instruction;

/// Who places robots before a trial.
pub enum Placing {
    /// The simulator, by itself.
    Simulator,
    /// A program.
    Program {
        /// The program, as a shell takes it.
        program: String,
        /// All robots of the fleet that may be used.
        robots: Vec<String>,
    },
    /// A person, who is asked.
    Person {
        /// Whether the person is asked before a robot drives, too.
        before_drives: bool,
    },
}

impl Placing {
    /// Who does it, by the command line.
    pub fn new(arguments: &Arguments) -> anyhow::Result<Self> {
        if arguments.backend() == Backend::Simulator {
            return Ok(Self::Simulator);
        }
        let Some(program) = &arguments.place_command else {
            return Ok(Self::Person { before_drives: !arguments.yes });
        };
        let robots = enabled_robots(&arguments.fleet)?;
        Ok(Self::Program { program: program.clone(), robots })
    }
}

impl TrialOperator for Placing {
    fn operator(&self) -> &dyn Operator {
        &TerminalOperator
    }

    fn ready<'a>(&'a self, robot: &'a str, trial: &'a Trial) -> OperatorFuture<'a, Ready> {
        Box::pin(async move {
            match (self, trial) {
                (Self::Simulator, _)
                | (Self::Person { before_drives: false }, Trial::Drive { .. }) => Ok(Ready::Go),
                (Self::Program { program, robots }, _) => {
                    let wanted = wanted(robot, robots, trial)?;
                    place_command::place(program, &wanted, &TerminalOperator).await?;
                    Ok(Ready::Go)
                }
                (Self::Person { .. }, _) => operator::ready(&instruction(robot, trial)).await,
            }
        })
    }

    fn measure<'a>(&'a self, plan: &'a Plan) -> OperatorFuture<'a, Motion> {
        Box::pin(operator::ask(plan))
    }
}
