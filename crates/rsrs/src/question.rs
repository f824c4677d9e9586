//! A question to the person at the terminal.

use std::io::{BufRead, Write};

use anyhow::Context;

/// Puts a question, and reads the line that answers it, without the blanks around it; an error if the
/// input ends `before` something.
pub fn put(
    (input, output): (&mut dyn BufRead, &mut dyn Write),
    question: &str,
    before: &str,
) -> anyhow::Result<String> {
    write!(output, "{question}: ").and_then(|()| output.flush()).context("asking")?;
    let mut line = String::new();
    if input.read_line(&mut line).context("reading the answer")? == 0 {
        anyhow::bail!("standard input ended before {before}");
    }
    Ok(line.trim().to_owned())
}
