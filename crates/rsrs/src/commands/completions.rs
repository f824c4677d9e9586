//! `rsrs completions`: for the shell.

use anyhow::Context;
use clap::CommandFactory;
use clap_complete::Shell;

use crate::commands::print_verbatim;
use crate::failure::Outcome;

/// Print completions for a shell.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  rsrs completions bash > ~/.local/share/bash-completion/completions/rsrs
  rsrs completions zsh > ~/.zfunc/_rsrs
  rsrs completions fish > ~/.config/fish/completions/rsrs.fish")]
pub struct Arguments {
    /// The shell.
    #[arg(value_enum)]
    shell: Shell,
}

pub fn run<C: CommandFactory>(arguments: &Arguments) -> anyhow::Result<Outcome> {
    let mut script = Vec::new();
    clap_complete::generate(arguments.shell, &mut C::command(), "rsrs", &mut script);
    print_verbatim(String::from_utf8(script).context("completions are text")?.trim_end())?;
    Ok(Outcome::Done)
}
