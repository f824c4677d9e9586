//! `rsrs completions`: for the shell.

use clap::CommandFactory;
use clap_complete::Shell;

use crate::failure::Outcome;

/// Print completions for a shell.
#[derive(clap::Args)]
pub struct Arguments {
    /// The shell.
    #[arg(value_enum)]
    shell: Shell,
}

/// Runs the command.
pub fn run<C: CommandFactory>(arguments: &Arguments) -> Outcome {
    clap_complete::generate(arguments.shell, &mut C::command(), "rsrs", &mut std::io::stdout());
    Outcome::Done
}
