//! The terminal itself: taken over for a while, and given back as it was.

use std::io::IsTerminal;
use std::time::Duration;

use anyhow::Context;
use ratatui::DefaultTerminal;
use ratatui::crossterm::event::{self, Event};
use rsrs_pipeline::error::with_help;
use rsrs_ros::environment::Environment;

use super::keys::{Request, request};
use super::screen::draw;
use super::view::View;

/// Makes sure that standard output is a terminal, and one that can place letters.
pub fn check(environment: &Environment) -> anyhow::Result<()> {
    let elsewhere = "for programs there are `ros2 topic echo /robot_1/status` and `rsrs bag info`";
    if !std::io::stdout().is_terminal() {
        return Err(with_help(
            "standard output is not a terminal, and there is nothing else to draw on",
            format!("run it in a terminal, over ssh with `ssh -t`; {elsewhere}"),
        ));
    }
    if environment.variable("TERM") == Some("dumb") {
        return Err(with_help(
            "TERM is `dumb`, expected a terminal on which letters can be placed",
            format!("run it in a terminal of its own; {elsewhere}"),
        ));
    }
    Ok(())
}

/// A terminal that shows a [`View`]. When it is dropped, or the program panics, it is as it was.
pub struct Screen {
    terminal: DefaultTerminal,
}

impl Screen {
    /// Takes the terminal over.
    pub fn open() -> anyhow::Result<Self> {
        let terminal = ratatui::try_init().context("setting up the terminal")?;
        let screen = Self { terminal };
        ignore_other_sizes()?;
        Ok(screen)
    }

    /// Shows what there is to see, and counts for how many robots there is room.
    pub fn show(&mut self, view: &View<'_>) -> anyhow::Result<usize> {
        let mut n_rows = 0;
        let shown = self.terminal.draw(|frame| {
            n_rows = draw(view, frame.area(), frame.buffer_mut());
        });
        shown.context("writing to the terminal")?;
        Ok(n_rows)
    }

    /// Waits for a key, for so long at most.
    pub fn wait(&mut self, patience: Duration) -> anyhow::Result<Option<Request>> {
        let reading = || "reading from the terminal";
        if !event::poll(patience).with_context(reading)? {
            return Ok(None);
        }
        match event::read().with_context(reading)? {
            Event::Key(key) => {
                let request = request(key);
                if request == Some(Request::Redraw) {
                    self.terminal.clear().with_context(reading)?;
                }
                Ok(request)
            }
            _ => Ok(None),
        }
    }
}

/// Makes the library for keys receive no `SIGWINCH`: of a key that is pressed together with a change of
/// size it reads the size alone, and the key only with the next one. That key may be the one for stop.
/// What is drawn has the size that the terminal has then, so nobody misses the signal.
#[expect(unsafe_code, reason = "a system call without a safe wrapper")]
fn ignore_other_sizes() -> anyhow::Result<()> {
    // It takes the signal with the first key that it waits for.
    event::poll(Duration::ZERO).context("reading from the terminal")?;
    // SAFETY: takes numbers; what the signal does by default is nothing.
    let previous = unsafe { libc::signal(libc::SIGWINCH, libc::SIG_DFL) };
    if previous == libc::SIG_ERR {
        return Err(std::io::Error::last_os_error()).context("setting up the terminal");
    }
    Ok(())
}

impl Drop for Screen {
    fn drop(&mut self) {
        ratatui::restore();
    }
}
