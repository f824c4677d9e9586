//! The arguments of the process, understood or refused in words that need no programming language.

use std::io::IsTerminal;
use std::process::ExitCode;

use clap::{Command, Parser};

use crate::failure::BAD_ARGUMENTS;
use crate::notes::print_painted;

/// What a parser of numbers reports, and what a person reads.
const WORDS: [(&str, &str); 6] = [
    ("invalid float literal", "expected a number with a decimal point, such as 0.15"),
    ("cannot parse float from empty string", "expected a number, found nothing"),
    ("cannot parse integer from empty string", "expected a whole number, found nothing"),
    ("invalid digit found in string", "expected a whole number"),
    ("number too large to fit in target type", "expected a smaller number"),
    ("number too small to fit in target type", "expected a greater number"),
];

/// Understands the arguments of this process. Who asks for help gets it here; arguments that cannot
/// be are reported, and leave an exit code.
pub fn parse<T: Parser>() -> Result<T, ExitCode> {
    let matches = with_negative_numbers(T::command()).try_get_matches();
    match matches.and_then(|matches| T::from_arg_matches(&matches)) {
        Ok(arguments) => Ok(arguments),
        Err(error) if !error.use_stderr() => error.exit(),
        Err(error) => {
            let text = error.render();
            let is_painted = std::io::stderr().is_terminal()
                && std::env::var_os("NO_COLOR").is_none_or(|value| value.is_empty());
            let text = if is_painted { text.ansi().to_string() } else { text.to_string() };
            print_painted(in_words(&text).trim_end());
            Err(ExitCode::from(BAD_ARGUMENTS))
        }
    }
}

/// An error in words that need no programming language.
pub fn in_words(text: &str) -> String {
    WORDS.iter().fold(text.to_owned(), |text, (found, words)| text.replace(found, words))
}

/// A value such as `-0.15` is one, and no flag.
fn with_negative_numbers(command: Command) -> Command {
    let takes_numbers = |argument: clap::Arg| {
        let takes_values = argument.get_action().takes_values();
        if takes_values { argument.allow_negative_numbers(true) } else { argument }
    };
    command.mut_args(takes_numbers).mut_subcommands(with_negative_numbers)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Debug, Parser)]
    struct Line {
        #[command(subcommand)]
        command: Inner,
    }

    #[derive(Debug, clap::Subcommand)]
    enum Inner {
        Go {
            #[arg(long)]
            speed: f64,
            #[arg(long)]
            count: Option<u32>,
            #[arg(long)]
            fast: bool,
        },
    }

    fn refused(line: &[&str]) -> String {
        let command = with_negative_numbers(<Line as clap::CommandFactory>::command());
        let error = command.try_get_matches_from(line).expect_err("it is refused");
        in_words(&error.to_string())
    }

    #[test]
    fn what_is_no_number_is_refused_in_words() {
        for (line, expected) in [
            (
                ["x", "go", "--speed", "fast"],
                "expected a number with a decimal point, such as 0.15",
            ),
            (
                ["x", "go", "--speed", "0,15"],
                "expected a number with a decimal point, such as 0.15",
            ),
            (["x", "go", "--speed", ""], "expected a number, found nothing"),
        ] {
            assert!(refused(&line).contains(expected), "{}", refused(&line));
        }
        let refused = refused(&["x", "go", "--speed", "1", "--count", "1.5"]);
        assert!(refused.contains("expected a whole number"), "{refused}");
    }

    #[test]
    fn a_negative_number_is_a_value() {
        let command = with_negative_numbers(<Line as clap::CommandFactory>::command());

        let matches = command.try_get_matches_from(["x", "go", "--speed", "-0.15", "--fast"]);

        let (_, inner) = matches.as_ref().expect("it is understood").subcommand().expect("go");
        assert_eq!(inner.get_one::<f64>("speed"), Some(&-0.15));
    }
}
