//! Samples, readings and timers in; detections, statuses and wheel commands out.

use std::time::Duration;

use rsrs_controller_node::Hosting;
use rsrs_core::robot::controller::Command;
use rsrs_fleet::epoch::ImplausibleEpoch;
use rsrs_fleet::parameters::gate::{CMD_VEL_TYPE, NODE, PERIOD};
use rsrs_fleet::robot::detector::{Detector, Reading};
use rsrs_fleet::robot::limits::Ramp;
use rsrs_fleet::robot::{Event, Lapse, Robot, RobotOptions};
use rsrs_fleet::timing::{TICK, command_timeout};
use rsrs_fleet::wire;
use rsrs_msgs::geometry_msgs::Twist;
use rsrs_msgs::std_msgs::Bool;
use rsrs_ros::clock::{since_boot, wall_time};
use rsrs_ros::complaints::Complaints;
use rsrs_ros::e_stop::{EStopSubscriptions, LocksPublisher};
use rsrs_ros::logging::Level;
use rsrs_ros::parameters::{Arming, ParameterServer};
use rsrs_ros::runtime::beat;
use rsrs_ros::session::{NodeHandle, Session, Subscription};
use rsrs_ros::shutdown;
use tokio::sync::mpsc::{UnboundedReceiver, UnboundedSender, unbounded_channel};

use crate::arguments::RobotArguments;
use crate::declared::cmd_vel_type;
use crate::diagnostics::Health;
use crate::driver::ros::RosDriver;
use crate::driver::serial::SerialDriver;
use crate::driver::virtual_robot::VirtualDriver;
use crate::driver::{Driver, DriverContext, DriverKind, Report, Sensed};
use crate::further_readings::FurtherReadings;
use crate::listening::{Input, listen, listen_to_e_stop};
use crate::parameters::{self, Settings};
use crate::publishers::Publishers;

/// How often the last wheel command is repeated: several times within the wheels' timeout.
const WHEEL_BEAT: Duration = Duration::from_millis(50);
/// How often the robot's health is published.
const HEALTH_BEAT: Duration = Duration::from_secs(1);
/// How many stop commands the wheels get before the node ends.
const LAST_STOPS: usize = 3;

/// Runs robot and controller until SIGINT or SIGTERM; then the wheels stop first.
pub async fn run(options: RobotArguments) -> anyhow::Result<()> {
    let session = Session::open_with(&options.node.session, &options.node.ros)?;
    let ended = match options.driver {
        DriverKind::Serial => host::<SerialDriver>(&session, options).await,
        DriverKind::Ros => host::<RosDriver>(&session, options).await,
        DriverKind::Virtual => host::<VirtualDriver>(&session, options).await,
    };
    session.close().await;
    ended
}

async fn host<D: Driver>(session: &Session, options: RobotArguments) -> anyhow::Result<()> {
    let (received, mut events) = unbounded_channel();
    let mut robot = RobotNode::<D>::new(session, &options, &received)?;
    for note in &options.node.ros.notes {
        robot.node.log(note.level(), &note.to_string());
    }
    robot.node.log(Level::Info, &format!("ready, with a {} driver", options.driver.name()));
    let controller = options.controller.map(|given| Hosting { robot: options.robot, given });
    let ended = tokio::select! {
        biased;
        ended = robot.serve(&mut events) => ended,
        ended = serve_controller(session, controller) => ended,
        ended = session.ended() => Err(ended.into()),
    };
    let stopped = robot.stand_down().await;
    ended.and(stopped)
}

async fn serve_controller(session: &Session, controller: Option<Hosting>) -> anyhow::Result<()> {
    match controller {
        Some(controller) => rsrs_controller_node::serve(session, vec![controller], &[]).await,
        None => std::future::pending().await,
    }
}

/// The robot, its hardware and its ends of the network.
struct RobotNode<'a, D> {
    session: &'a Session,
    name: String,
    node: NodeHandle,
    kind: DriverKind,
    driver: D,
    gate: Robot,
    ramp: Ramp,
    detector: Detector,
    further: FurtherReadings,
    settings: Settings,
    server: ParameterServer,
    publishers: Publishers,
    /// Time since boot at which it began.
    start: Duration,
    period: Duration,
    /// What the driver reports as wrong; at the start, that it has not reported yet.
    driver_fault: Option<String>,
    /// Why the wheels did not take the last command.
    wheel_fault: Option<String>,
    /// The fault of sensor or wheels that the gate was given.
    fault: Option<String>,
    /// Whether sensor and wheels have worked before: hardware that takes its time is no error.
    has_worked: bool,
    /// The last wheel command, and when it was sent.
    sent: Option<(Command, Duration)>,
    refused: u64,
    complaints: OfMessages,
    arming: Arming,
    /// The epoch that the gate refused last, which was logged.
    refused_epoch: Option<ImplausibleEpoch>,
    locks: LocksPublisher,
    _subscriptions: [Subscription; 3],
    _e_stop: EStopSubscriptions,
}

/// Complaints about what others publish and the hardware sends, by what it is.
#[derive(Default)]
struct OfMessages {
    leases: Complaints,
    statuses: Complaints,
    commands: Complaints,
    hardware: Complaints,
}

/// What the loop woke up for.
enum Woken {
    Input(Input),
    Report(Report),
    Tick,
    Period,
    Health,
}

impl<'a, D: Driver> RobotNode<'a, D> {
    fn new(
        session: &'a Session,
        options: &RobotArguments,
        received: &UnboundedSender<Input>,
    ) -> anyhow::Result<Self> {
        let name = options.robot.clone();
        let node = session.node(&format!("/{name}"), NODE)?;
        let full_name = node.full_name();
        let declared = parameters::declare(&name, options.driver, &options.given);
        let changed = received.clone();
        let server = ParameterServer::start(session, vec![declared], move |_, _| {
            changed.send(Input::Parameters).map_err(|_closed| "shutting down".to_owned())
        })?;
        let commands = cmd_vel_type(&server, full_name, CMD_VEL_TYPE)?;
        let period_s = server.double(full_name, PERIOD);
        let place = DriverContext { session, node: &node, robot: &name, server: &server };
        let gate = Robot::new(RobotOptions {
            name: name.clone(),
            command_timeout: command_timeout(period_s, session.transport()),
            lapse: Lapse::Stops,
        })
        .counting_from(wire::first_counter(wall_time()))
        .of_a_new_process();
        Ok(Self {
            driver: D::open(place)?,
            kind: options.driver,
            gate,
            ramp: Ramp::standing(Duration::ZERO),
            detector: Detector::default(),
            further: FurtherReadings::default(),
            session,
            settings: parameters::settings(&server, full_name),
            publishers: Publishers::new(session, &node, &name)?,
            start: since_boot(),
            period: Duration::from_secs_f64(period_s),
            driver_fault: Some("the driver has not answered yet".to_owned()),
            wheel_fault: None,
            fault: None,
            has_worked: false,
            sent: None,
            refused: 0,
            complaints: OfMessages::default(),
            arming: Arming::Disarmed,
            refused_epoch: None,
            locks: LocksPublisher::new(session, &node)?,
            _e_stop: listen_to_e_stop(session, &node, received)?,
            _subscriptions: listen(session, &node, &name, commands, received)?,
            server,
            node,
            name,
        })
    }

    async fn serve(&mut self, events: &mut UnboundedReceiver<Input>) -> anyhow::Result<()> {
        let mut asked_to_stop = std::pin::pin!(shutdown::requested());
        let (mut tick, mut health) = (beat(TICK), beat(HEALTH_BEAT));
        let mut period = beat(self.period);
        loop {
            let woken = tokio::select! {
                biased;
                request = &mut asked_to_stop => {
                    request?;
                    return Ok(());
                }
                Some(received) = events.recv() => Woken::Input(received),
                report = self.driver.report() => Woken::Report(report),
                _ = tick.tick() => Woken::Tick,
                _ = period.tick() => Woken::Period,
                _ = health.tick() => Woken::Health,
            };
            match woken {
                Woken::Input(received) => self.receive(received).await?,
                Woken::Report(report) => self.take(report).await?,
                Woken::Tick => {}
                Woken::Period => self.publish_detection().await?,
                Woken::Health => self.publish_health().await?,
            }
            self.look_for_faults().await?;
            self.step_gate(Event::Tick).await?;
            self.turn_wheels().await;
            self.hold_parameters()?;
        }
    }

    fn now(&self) -> Duration {
        since_boot().saturating_sub(self.start)
    }

    async fn step_gate(&mut self, event: Event) -> anyhow::Result<()> {
        if let Some(status) = self.gate.on_event(event, self.now()) {
            self.publishers.status(&status).await?;
        }
        let refused = self.gate.refused_epoch();
        if refused != self.refused_epoch {
            self.refused_epoch = refused;
            if let Some(refused) = refused {
                self.node.log(Level::Warn, &refused.to_string());
            }
        }
        Ok(self.locks.publish(self.gate.locks()).await?)
    }

    async fn receive(&mut self, received: Input) -> anyhow::Result<()> {
        match received {
            Input::Lease(message) => match wire::lease(message) {
                Ok(lease) => self.step_gate(Event::Lease(lease)).await,
                Err(error) => {
                    self.complaints.leases.warn(&self.node, &format!("refused: {error}"));
                    Ok(())
                }
            },
            Input::EStop(message) => self.step_gate(Event::EStop(message)).await,
            Input::Controller(message) => match wire::status(message) {
                Ok(status) => self.step_gate(Event::Controller(status)).await,
                Err(error) => {
                    self.complaints.statuses.warn(&self.node, &format!("refused: {error}"));
                    Ok(())
                }
            },
            Input::Command(twist) => self.command(&twist).await,
            Input::Parameters => {
                self.settings = parameters::settings(&self.server, self.node.full_name());
                Ok(())
            }
        }
    }

    async fn command(&mut self, twist: &Twist) -> anyhow::Result<()> {
        let checked = wire::command(twist).map_err(|error| error.to_string()).and_then(|command| {
            let fits = self.settings.limits.check(command);
            fits.map(|()| command).map_err(|error| error.to_string())
        });
        match checked {
            Ok(command) => self.step_gate(Event::Command(command)).await,
            Err(reason) => {
                self.refused += 1;
                self.complaints.commands.warn(&self.node, &format!("refused: {reason}"));
                self.step_gate(Event::CommandRefused).await
            }
        }
    }

    async fn take(&mut self, report: Report) -> anyhow::Result<()> {
        match report {
            Report::Up => {
                self.driver_fault = None;
                self.sent = None;
            }
            Report::Down(reason) => self.driver_fault = Some(reason),
            Report::Battery(battery_v) => self.step_gate(Event::Battery(battery_v)).await?,
            Report::Refused(reason) => {
                let text = format!("refused a line of {}: {reason}", self.driver.sensor());
                self.complaints.hardware.warn(&self.node, &text);
            }
            Report::Sensed(Sensed { seen, range, further }) => {
                let measured = range.as_ref().map(|range| Reading::Range(f64::from(range.range)));
                let now = self.now();
                let place = (self.session, &self.node, self.name.as_str());
                self.further.take(further, place, (&self.settings.detector, now))?;
                if let Some(reading) = seen.map(Reading::Seen).or(measured) {
                    self.detector.on_reading(reading, &self.settings.detector, now);
                }
                if let Some(range) = range {
                    self.publishers.range(range).await?;
                }
            }
        }
        Ok(())
    }

    /// Reports to the gate when sensor or wheels fail, and when they work again.
    async fn look_for_faults(&mut self) -> anyhow::Result<()> {
        let of_sensor = self.detector.detected(&self.settings.detector, self.now()).err();
        let found =
            self.driver_fault.clone().or_else(|| self.wheel_fault.clone()).or_else(|| {
                of_sensor.map(|error| format!("{error}, from {}", self.driver.sensor()))
            });
        if found == self.fault {
            return Ok(());
        }
        self.fault.clone_from(&found);
        if let Some(reason) = found {
            let level = if self.has_worked { Level::Error } else { Level::Warn };
            self.node.log(level, &reason);
            self.step_gate(Event::Fault(reason)).await?;
        } else {
            self.has_worked = true;
            self.node.log(Level::Info, "sensor and wheels work");
            self.step_gate(Event::Repaired).await?;
        }
        self.publish_health().await
    }

    /// Makes the wheels do what the gate lets through.
    async fn turn_wheels(&mut self) {
        let now = self.now();
        let command = self.ramp.toward(self.gate.drive(now), &self.settings.limits, now);
        let is_sent = self
            .sent
            .is_some_and(|(sent, at)| sent == command && now.saturating_sub(at) < WHEEL_BEAT);
        if is_sent || self.driver_fault.is_some() {
            return;
        }
        // A driver that did not take a command gets the next one soon, and has to take that one.
        self.sent = Some((command, now));
        self.wheel_fault = self.driver.drive(command).await.err().map(|error| format!("{error:#}"));
    }

    /// Nobody changes limits during a run.
    fn hold_parameters(&mut self) -> anyhow::Result<()> {
        let arming = if self.gate.is_in_run(self.now()) { Arming::Armed } else { Arming::Disarmed };
        if arming != self.arming {
            self.arming = arming;
            self.server.set_arming(self.node.full_name(), arming)?;
        }
        Ok(())
    }

    /// Publishes what the robot sees, that of its first sensor last; nothing while nothing is known.
    async fn publish_detection(&mut self) -> anyhow::Result<()> {
        let now = self.now();
        self.further.publish(&self.settings.detector, now).await?;
        if let Ok(data) = self.detector.detected(&self.settings.detector, now) {
            self.publishers.detection(Bool { data }).await?;
        }
        Ok(())
    }

    async fn publish_health(&self) -> anyhow::Result<()> {
        let now = self.now();
        let health = Health {
            robot: &self.name,
            driver: self.kind.name(),
            fault: self.fault.as_deref(),
            values: self.driver.health(),
            standing: self.gate.standing(now),
            state: self.gate.state(now),
            refused: self.refused,
        };
        Ok(self.publishers.health(health).await?)
    }

    /// Stops the wheels, then publishes it.
    async fn stand_down(mut self) -> anyhow::Result<()> {
        for _ in 0..LAST_STOPS {
            if let Err(error) = self.driver.drive(Command::STOP).await {
                let text = format!("the wheels' own timeout has to stop them: {error:#}");
                self.node.log(Level::Warn, &text);
                break;
            }
            tokio::time::sleep(TICK).await;
        }
        self.step_gate(Event::Fault("the robot's node has ended".to_owned())).await
    }
}
