//! What a node logs to standard error.

use std::io::{self, IsTerminal, Write};
use std::str::FromStr;
use std::sync::OnceLock;

use log::LevelFilter;
use rsrs_core::printable::lines;

use crate::printing::{Printed, Printer};

/// Severity from which on a node logs; the names are those of ROS 2.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub enum Level {
    /// For developers.
    Debug,
    /// For the curious.
    #[default]
    Info,
    /// May go wrong.
    Warn,
    /// Went wrong.
    Error,
    /// The end.
    Fatal,
}

/// A level that is not one of ROS 2's.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("log level `{found}`, expected debug, info, warn, error or fatal")]
pub struct NoSuchLevel {
    /// What was given.
    pub found: String,
}

impl FromStr for Level {
    type Err = NoSuchLevel;

    fn from_str(text: &str) -> Result<Self, NoSuchLevel> {
        match text.to_ascii_lowercase().as_str() {
            "debug" => Ok(Self::Debug),
            "info" => Ok(Self::Info),
            "warn" => Ok(Self::Warn),
            "error" => Ok(Self::Error),
            "fatal" => Ok(Self::Fatal),
            _ => Err(NoSuchLevel { found: text.to_owned() }),
        }
    }
}

impl Level {
    /// The closest level of the `log` crate, which has no "fatal".
    pub(crate) fn as_log(self) -> log::Level {
        match self {
            Self::Debug => log::Level::Debug,
            Self::Info => log::Level::Info,
            Self::Warn => log::Level::Warn,
            Self::Error | Self::Fatal => log::Level::Error,
        }
    }
}

/// What the middleware may log. It calls much a warning that no user can act upon, and at shutdown
/// it complains about readers of a participant that has gone.
const MIDDLEWARE: [(&str, LevelFilter); 11] = [
    ("rustdds", LevelFilter::Error),
    // A receive buffer that the kernel keeps small loses samples, and the text states what to do.
    ("rustdds::network::udp_listener", LevelFilter::Warn),
    // Whatever is refused in a secured network is logged for each datagram: those of strangers, who
    // could fill the disk, and those of members until they have authenticated each other.
    ("rustdds::discovery::secure_discovery", LevelFilter::Off),
    ("rustdds::rtps::message_receiver", LevelFilter::Off),
    ("rustdds::rtps::reader", LevelFilter::Off),
    ("rustdds::rtps::writer", LevelFilter::Off),
    ("rustdds::security", LevelFilter::Off),
    ("rustdds::dds::pubsub", LevelFilter::Off),
    ("rustdds::dds::participant", LevelFilter::Off),
    ("ros2_client", LevelFilter::Error),
    // What goes to `/rosout` is logged to standard error by us already.
    ("ros2_client::rosout", LevelFilter::Off),
];

/// Sends log lines of `level` and worse to stderr, and of the middleware what a user can act upon;
/// `RUST_LOG`, if it is set, overrides both for developers.
///
/// A second call in one process changes nothing.
pub fn init(level: Level) {
    install(builder(level));
}

/// As [`init`], for a person who wants to read every step of a command: what is done stands there
/// without where it is logged, and anything worse has its severity in front.
pub fn init_steps() {
    let mut builder = builder(Level::Info);
    builder.format(|out, record| match record.level() {
        log::Level::Info => writeln!(out, "{}", text_of(record)),
        level => writeln!(out, "{}: {}", level.as_str().to_lowercase(), text_of(record)),
    });
    install(builder);
}

fn builder(level: Level) -> env_logger::Builder {
    let mut builder = env_logger::Builder::new();
    builder.filter_level(level.as_log().to_level_filter());
    for (module, filter) in MIDDLEWARE {
        builder.filter_module(module, filter);
    }
    if let Ok(filter) = std::env::var("RUST_LOG") {
        builder.parse_filters(&filter);
    }
    // A pipe has no colours by itself.
    let is_plain = std::env::var_os("NO_COLOR").is_some_and(|value| !value.is_empty());
    let is_coloured = io::stderr().is_terminal() && !is_plain;
    let style =
        if is_coloured { env_logger::WriteStyle::Always } else { env_logger::WriteStyle::Never };
    builder.target(env_logger::Target::Pipe(Box::new(Lines))).write_style(style);
    builder.format(|out, record| {
        let (level, target) = (record.level(), record.target());
        let style = out.default_level_style(level);
        // What stands on further lines is further in, and so no other entry of a journal.
        let text = text_of(record).replace('\n', "\n    ");
        writeln!(out, "[{style}{level:<5}{style:#} {target}] {text}")
    });
    builder
}

/// What is logged, fit for a terminal.
fn text_of(record: &log::Record<'_>) -> String {
    lines(&record.args().to_string()).into_owned()
}

/// Lines that wait to be printed, at most.
const ROOM: usize = 1000;

/// Prints lines of the log, once a session is open; `None` if there was no thread for it.
static PRINTER: OnceLock<Option<Printer<Vec<u8>>>> = OnceLock::new();

/// From now on the log is printed by a thread of its own: whoever logs has deadlines.
///
/// Before that it is printed at once, because a process with threads cannot move into a network of
/// its own.
pub(crate) fn print_beside() {
    PRINTER.get_or_init(|| Printer::start(ROOM, || print).ok());
}

fn print(line: Printed<Vec<u8>>) {
    let mut stderr = io::stderr().lock();
    // Without standard error there is no way to report it.
    drop(match line {
        Printed::This(line) => stderr.write_all(&line),
        Printed::LeftOut(n_lines) => {
            writeln!(
                stderr,
                "[{n_lines} lines of the log were left out: nothing read them in time]"
            )
        }
    });
}

/// Waits until everything that was logged so far is printed, but not for a terminal that takes nothing.
pub fn flush() {
    if let Some(Some(printer)) = PRINTER.get() {
        printer.flush();
    }
}

/// Where the logger writes, one line at a time.
struct Lines;

impl Write for Lines {
    fn write(&mut self, line: &[u8]) -> io::Result<usize> {
        match PRINTER.get() {
            Some(Some(printer)) => {
                printer.print(line.to_owned());
                Ok(line.len())
            }
            _ => io::stderr().write(line),
        }
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

fn install(mut builder: env_logger::Builder) {
    let logger = Filtered(builder.build());
    let level = logger.0.filter();
    // It fails only if there is a logger already.
    if log::set_boxed_logger(Box::new(logger)).is_ok() {
        log::set_max_level(level);
    }
}

/// Leaves out one text of the middleware that has no module of its own.
struct Filtered(env_logger::Logger);

impl log::Log for Filtered {
    fn enabled(&self, metadata: &log::Metadata<'_>) -> bool {
        self.0.enabled(metadata)
    }

    fn log(&self, record: &log::Record<'_>) {
        if !is_farewell(record) {
            self.0.log(record);
        }
    }

    fn flush(&self) {
        self.0.flush();
    }
}

/// A listener that is closed leaves its multicast group by the interface of the default route, which
/// fails where it had joined by another one. The kernel takes it out of the group anyway.
fn is_farewell(record: &log::Record<'_>) -> bool {
    record.target() == "rustdds::network::udp_listener"
        && record.args().to_string().starts_with("leave_multicast_group")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn levels_are_read_in_any_case_and_an_unknown_one_is_refused_with_the_known_ones() {
        assert_eq!("WARN".parse(), Ok(Level::Warn));
        assert_eq!("debug".parse(), Ok(Level::Debug));
        assert!(Level::Debug < Level::Info && Level::Error < Level::Fatal);
        let error = "loud".parse::<Level>().unwrap_err().to_string();
        assert_eq!(error, "log level `loud`, expected debug, info, warn, error or fatal");
    }
}
