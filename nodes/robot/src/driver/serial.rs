//! A microcontroller on a serial line, as on the Flockbots; see `docs/serial_protocol.md`.
//!
//! Opens the port, greets, drives, and begins anew whenever something is wrong: what
//! [`link`] reports, or a port that is unplugged.

pub mod line;
pub mod link;
mod port;

use std::collections::VecDeque;
use std::time::{Duration, Instant};

use anyhow::{Context, bail};
use rsrs_core::robot::controller::Command;
use rsrs_fleet::parameters::gate::{SERIAL_BAUD as BAUD, SERIAL_PORT as PORT};
use rsrs_ros::parameters::{Descriptor, ParameterKind, ParameterValue};

use super::{Driver, DriverContext, Report};
use link::{Counts, Link};
use port::Port;

/// A port that is unplugged is noticed at its next use.
const GONE: &str = "the other end has gone";

/// How long after a failure the port is opened again.
const RETRY: Duration = Duration::from_millis(500);

/// The driver.
pub struct SerialDriver {
    path: String,
    baud: u32,
    start: Instant,
    line: Option<(Port, Link)>,
    retry_at: Instant,
    reports: VecDeque<Report>,
    openings: u16,
    /// What came in before the port was opened last.
    counts_before: Counts,
}

impl Driver for SerialDriver {
    fn parameters() -> Vec<(Descriptor, ParameterValue)> {
        let port = Descriptor::new(PORT, ParameterKind::String, "Path of the serial device.");
        let baud = Descriptor::new(BAUD, ParameterKind::Integer, "Baud rate.");
        vec![
            (port.read_only(), ParameterValue::String("/dev/ttyACM0".to_owned())),
            (baud.within(1200.0, 4e6).read_only(), ParameterValue::Integer(115_200)),
        ]
    }

    fn open(place: DriverContext<'_>) -> anyhow::Result<Self> {
        let node = place.node.full_name();
        let baud = place.server.integer(node, BAUD);
        let baud = u32::try_from(baud).context("the range of the parameter is within 32 bits")?;
        Ok(Self::at(&place.server.text(node, PORT), baud))
    }

    async fn report(&mut self) -> Report {
        loop {
            if let Some(report) = self.reports.pop_front() {
                return report;
            }
            match &mut self.line {
                None => {
                    tokio::time::sleep_until(self.retry_at.into()).await;
                    self.open_port();
                }
                Some((port, link)) => {
                    if let Err(reason) = listen(port, link, &mut self.reports, self.start).await {
                        self.fail(&format!("{reason:#}"));
                    }
                }
            }
        }
    }

    async fn drive(&mut self, command: Command) -> anyhow::Result<()> {
        let Some((port, link)) = &mut self.line else { bail!("`{}` is not open", self.path) };
        let Some(line) = link.drive(command, self.start.elapsed()) else {
            bail!("nothing on `{}` takes commands", self.path);
        };
        let sent = port.send(&line).context(GONE);
        if let Err(error) = &sent {
            self.fail(&format!("{error:#}"));
        }
        sent
    }

    fn sensor(&self) -> String {
        format!("the microcontroller on {}", self.path)
    }

    fn health(&self) -> Vec<(&'static str, String)> {
        let link = self.line.as_ref().map(|(_, link)| link);
        let name = link.and_then(Link::identity).map(|identity| identity.name.clone());
        let counts = self.counts();
        vec![
            ("port", self.path.clone()),
            ("firmware", name.unwrap_or_else(|| "unknown".to_owned())),
            ("openings", self.openings.to_string()),
            ("lines_understood", counts.understood.to_string()),
            ("lines_garbled", counts.garbled.to_string()),
        ]
    }
}

impl SerialDriver {
    /// A driver for a port at a baud rate, which is opened when the first report is asked for; the
    /// device need not be there yet.
    pub fn at(path: &str, baud: u32) -> Self {
        Self {
            path: path.to_owned(),
            baud,
            start: Instant::now(),
            line: None,
            retry_at: Instant::now(),
            reports: VecDeque::new(),
            openings: 0,
            counts_before: Counts::default(),
        }
    }

    fn open_port(&mut self) {
        match Port::open(&self.path, self.baud) {
            Ok(port) => {
                self.openings = self.openings.wrapping_add(1);
                // Another number for each process and opening, so that no old answer counts.
                let nonce = self.openings.wrapping_mul(31).wrapping_add(process_number());
                self.line = Some((port, Link::new(nonce, self.start.elapsed())));
            }
            Err(error) => self.fail(&error.to_string()),
        }
    }

    /// Gives the port up; it is opened again later.
    fn fail(&mut self, reason: &str) {
        self.counts_before = self.counts();
        self.line = None;
        self.retry_at = Instant::now() + RETRY;
        // What came before does not count any more.
        self.reports.clear();
        self.reports.push_back(Report::Down(reason.to_owned()));
    }

    fn counts(&self) -> Counts {
        let now = self.line.as_ref().map_or_else(Counts::default, |(_, link)| link.counts());
        Counts {
            understood: self.counts_before.understood + now.understood,
            garbled: self.counts_before.garbled + now.garbled,
        }
    }
}

fn process_number() -> u16 {
    u16::try_from(std::process::id() % 0x1_0000).expect("a remainder is below its divisor")
}

/// Receives what comes, or sends what is due, whichever is first; what came goes before what is due,
/// so that a stall of this process is not taken for a silence of the other.
async fn listen(
    port: &Port,
    link: &mut Link,
    reports: &mut VecDeque<Report>,
    start: Instant,
) -> anyhow::Result<()> {
    let mut buffer = [0; 1024];
    let due: tokio::time::Instant = (start + link.due()).into();
    tokio::select! {
        biased;
        read = port.read(&mut buffer) => {
            let n_bytes = read.context(GONE)?;
            reports.extend(link.on_bytes(&buffer[..n_bytes], start.elapsed())?);
        }
        () = tokio::time::sleep_until(due) => {
            if let Some(line) = link.on_tick(start.elapsed())? {
                port.send(&line).context(GONE)?;
            }
        }
    }
    Ok(())
}
