//! Samples, answers and timers in; leases, requests and a bag out.

mod early;
mod recording;
mod watching;

use std::collections::BTreeMap;
use std::io;
use std::pin::Pin;
use std::time::{Duration, Instant};

use anyhow::Context;
use futures::StreamExt;
use futures::stream::FuturesUnordered;
use rsrs_bags::BagSummary;
use rsrs_core::printable::one_line;
use rsrs_fleet::contradictions::Contradictions;
use rsrs_fleet::experiment::Time;
use rsrs_fleet::message::{RobotState, Status};
use rsrs_fleet::preflight::Graph;
use rsrs_fleet::rates::Rates;
use rsrs_fleet::record::ExperimentRecord;
use rsrs_fleet::runner::{Action, Event, Runner, Target};
use rsrs_fleet::timing::{CONFIGURE_TIMEOUT, NODE_TIMEOUT, TICK};
use rsrs_fleet::wire;
use rsrs_msgs::cdr;
use rsrs_msgs::node_names::RUNNER as NODE;
use rsrs_msgs::rsrs::{Recorded, RunLease};
use rsrs_msgs::std_msgs::{self, Bool};
use rsrs_msgs::topics::{self, Topic};
use rsrs_ros::clock::wall_time;
use rsrs_ros::complaints::Complaints;
use rsrs_ros::logging::Level;
use rsrs_ros::parameters::{ClientOptions, ParameterClient, ParameterServer};
use rsrs_ros::runtime::beat;
use rsrs_ros::session::{
    NodeHandle, Publisher, ReceivedRaw, Session, SessionEnded, SessionOptions,
};
use rsrs_ros::shutdown;
use tokio::sync::mpsc::{UnboundedReceiver, UnboundedSender, unbounded_channel};

use crate::expectation;
use crate::extras::Extras;
use crate::parameters;
use crate::plan::Plan;
use crate::recorded_topics::{self, Queue, RecordedTopic, Role, Sample};
use crate::recorder::{Closing, Recorder, Written};
use crate::report::{Progress, RunReport, Times};
use crate::sample_events;
use crate::tracked::{Sighting, Tracked};
use early::Early;

/// A runner that has not looked for so long has been stopped itself, or its machine is very busy.
const STOOD_STILL: Duration = Duration::from_millis(500);
/// How often the discovery database is looked at.
const POLL_PERIOD: Duration = Duration::from_millis(100);
/// How long one request for parameters is tried before the machine asks again.
const ONE_REQUEST: Duration = CONFIGURE_TIMEOUT;

/// Answers to requests for parameters, and the requests that are under way.
type Requests<'a> = FuturesUnordered<Pin<Box<dyn Future<Output = Event> + 'a>>>;

/// A run and its ends of the network.
struct Run<'a> {
    plan: &'a Plan,
    session: &'a Session,
    client: &'a ParameterClient<'a>,
    node: NodeHandle,
    recorded_topics: Vec<RecordedTopic>,
    /// By recorded topic: its place among those with poses.
    places: Vec<Option<usize>>,
    tracked: Tracked,
    extras: Extras,
    lease: Publisher<RunLease>,
    recorded: Publisher<Recorded>,
    /// The record of the run and its ending, for who looks on.
    notes: [Publisher<std_msgs::String>; 2],
    machine: Runner,
    /// The plan's, with what was read before the bag was opened.
    record: ExperimentRecord,
    start: Instant,
    recorder: Option<Recorder>,
    /// What came before the bag was open, and belongs to its beginning.
    early: Early,
    /// By topic.
    complaints: BTreeMap<usize, Complaints>,
    /// Where the thread that writes the bag reports.
    to_written: UnboundedSender<Written>,
    /// Whether the middleware has ended: then nothing can be published any more.
    is_cut_off: bool,
    /// The last step that was confirmed; 0 is none.
    recorded_step: u64,
    times: Times,
    /// The simulator's last word, and when it came.
    simulator: Option<(Status, Instant)>,
    /// Whether the simulator's next word answers the machine's question.
    asks_simulator: bool,
    /// The simulator that has answered; others have nothing to do with the run.
    answering_simulator: Option<[u8; 16]>,
    /// Questions that are not answered yet. Each is asked again by the client; to ask it twice at a
    /// time would only hold up the answer.
    open: Vec<Action>,
    /// The bag while it is closed.
    closing: Option<Closing>,
    bag: Option<BagSummary>,
    n_lost: u64,
    /// What is watched while robots move in real time.
    rates: Option<Rates>,
    contradictions: Contradictions,
    /// Robots that did not report that they stand, when the machine has finished.
    finished: Option<Vec<String>>,
    watch: &'a mut dyn FnMut(Progress),
}

/// Conducts one run from preflight to the closed bag, while `watch` gets how far it is. When `stop`
/// completes, the run is stopped in order, for the reason that it gives.
///
/// # Errors
///
/// If the network cannot be used. A run that fails is an [`Ending`](rsrs_fleet::record::Ending),
/// not an error.
pub async fn run(
    plan: &Plan,
    network: &SessionOptions,
    watch: &mut dyn FnMut(Progress),
    stop: impl Future<Output = String>,
) -> anyhow::Result<RunReport> {
    let session = Session::open(network)?;
    let node = session.node("/", NODE)?;
    let tracked = Tracked::of_run(plan);
    let readings = plan.record.conditions.robot.reading_names();
    let n_objects = plan.record.conditions.world.n_objects();
    let what = (&readings, n_objects);
    let recorded_topics =
        recorded_topics::recorded_topics(&plan.robots, plan.record.time, what, tracked.topics());
    let place = |topic: &RecordedTopic| tracked.index_of(&topic.name, &topic.type_name);
    let places = recorded_topics.iter().map(place).collect();
    let server = ParameterServer::without_parameters(&session, &node)?;
    let (sender, mut samples) = unbounded_channel();
    let (to_written, mut written) = unbounded_channel();
    let queue = Queue::new(sender);
    let subscriptions = recorded_topics::listen(&session, &recorded_topics, &queue)?;
    let options = ClientOptions { timeout: ONE_REQUEST, mapping: None };
    let client = ParameterClient::new(&session, &node, options);
    let (lease, recorded) = (topics::LEASE, topics::RECORDED);
    let note = |topic: Topic| session.publish_on(&node, topic.name, topic.qos);
    let notes = [note(topics::EXPERIMENT)?, note(topics::ENDING)?];
    let mut run = Run {
        lease: session.publish_on(&node, lease.name, lease.qos)?,
        recorded: session.publish_on(&node, recorded.name, recorded.qos)?,
        notes,
        machine: Runner::new(expectation::runner_options(plan, &recorded_topics))
            .over(network.transport()),
        extras: Extras::new(&plan.recording, &recorded_topics, queue),
        record: plan.record.clone(),
        plan,
        session: &session,
        client: &client,
        node,
        recorded_topics,
        places,
        tracked,
        start: Instant::now(),
        recorder: None,
        early: Early::default(),
        complaints: BTreeMap::new(),
        to_written,
        is_cut_off: false,
        recorded_step: 0,
        times: Times::default(),
        simulator: None,
        asks_simulator: false,
        answering_simulator: None,
        open: Vec::new(),
        closing: None,
        bag: None,
        n_lost: 0,
        rates: None,
        contradictions: Contradictions::new(readings),
        finished: None,
        watch,
    };
    for (robot, own) in &plan.record.own_profiles {
        run.note(&format!("{robot}: {own}"));
    }
    if let Some(unused) = plan.unused_keys() {
        run.note(&unused);
    }
    let ended = run.serve(&mut samples, &mut written, stop).await;
    let report = ended.and_then(|()| run.report());
    drop(run);
    drop((client, subscriptions, server));
    session.close().await;
    report
}

/// What the run waits for.
enum Woken {
    /// Somebody asks for its end.
    Stop(String),
    /// Somebody asks while the bag is closed.
    StopAgain(io::Result<shutdown::Request>),
    /// Nothing is sent or received any more.
    CutOff(SessionEnded),
    /// The bag reports.
    Written(Written),
    Sample(Sample),
    /// A request was answered.
    Answer(Event),
    /// It is time to look at the network.
    Look,
    /// Time passes.
    Tick,
}

/// Ends the run because nothing can be sent or received any more.
fn interrupt(ended: &SessionEnded) -> Event {
    Event::Interrupt { reason: ended.to_string() }
}

impl<'a> Run<'a> {
    async fn serve(
        &mut self,
        samples: &mut UnboundedReceiver<Sample>,
        written: &mut UnboundedReceiver<Written>,
        stop: impl Future<Output = String>,
    ) -> anyhow::Result<()> {
        let mut requests: Requests<'a> = FuturesUnordered::new();
        let mut tick = beat(TICK);
        let mut look = beat(POLL_PERIOD);
        let mut stop = std::pin::pin!(stop);
        let mut is_stopped = false;
        // It installs no handler before it is polled.
        let mut again = Box::pin(shutdown::requested());
        let mut has_signals = true;
        let session = self.session;
        let mut cut_off = std::pin::pin!(session.ended());
        let mut looked = Instant::now();
        while self.finished.is_none() {
            let woken = tokio::select! {
                reason = &mut stop, if !is_stopped && self.closing.is_none() => Woken::Stop(reason),
                request = &mut again, if has_signals && self.closing.is_some() => {
                    again = Box::pin(shutdown::requested());
                    Woken::StopAgain(request)
                }
                ended = &mut cut_off, if !self.is_cut_off => Woken::CutOff(ended),
                Some(written) = written.recv() => Woken::Written(written),
                Some(sample) = samples.recv() => Woken::Sample(sample),
                Some(answer) = requests.next() => Woken::Answer(answer),
                _ = look.tick() => Woken::Look,
                _ = tick.tick() => Woken::Tick,
            };
            // Before anything else is made of the time: no robot is at fault for a silence then.
            let stood_still = std::mem::replace(&mut looked, Instant::now()).elapsed();
            if stood_still >= STOOD_STILL
                && !self.is_cut_off
                && self.closing.is_none()
                && let Some(ended) = session.has_ended_meanwhile().await
            {
                self.is_cut_off = true;
                self.advance(interrupt(&ended), &mut requests).await?;
            }
            match woken {
                Woken::Stop(reason) => {
                    is_stopped = true;
                    self.advance(Event::Interrupt { reason }, &mut requests).await?;
                }
                Woken::StopAgain(request) => {
                    has_signals = request.is_ok();
                    let reason = "interrupted".to_owned();
                    self.advance(Event::Interrupt { reason }, &mut requests).await?;
                }
                Woken::CutOff(_) if self.closing.is_some() => self.is_cut_off = true,
                Woken::CutOff(ended) => {
                    self.is_cut_off = true;
                    self.advance(interrupt(&ended), &mut requests).await?;
                }
                Woken::Written(written) => self.take_written(written, &mut requests).await?,
                Woken::Sample(sample) => self.receive(sample, &mut requests).await?,
                Woken::Answer(answer) => {
                    self.close_question(&answer);
                    self.advance(answer, &mut requests).await?;
                }
                Woken::Look => self.look(&mut requests).await?,
                Woken::Tick => self.advance(Event::Tick, &mut requests).await?,
            }
        }
        if let Some(closing) = self.closing.take() {
            closing.end();
        }
        Ok(())
    }

    /// Looks at what there is in the network, and at what is repeated and counted.
    async fn look(&mut self, requests: &mut Requests<'a>) -> anyhow::Result<()> {
        if let Some(closing) = &self.closing {
            let (done, left_bytes) = closing.progress();
            self.advance(Event::RecorderCloses { done, left_bytes }, requests).await?;
        }
        // It copies thousands of entries, which are seldom needed once all is there.
        if self.machine.looks(self.start.elapsed()) {
            let unrecordable = self.look_for_extras()?;
            let simulator =
                (self.simulator.as_ref()).is_some_and(|(_, at)| at.elapsed() <= NODE_TIMEOUT);
            let graph = expectation::graph(self.session, self.plan, unrecordable);
            let graph = Graph { simulator, ..graph };
            self.advance(Event::Seen(graph), requests).await?;
        }
        self.repeat_recorded().await?;
        self.watch_rates();
        Ok(())
    }

    /// Records a sample, and gives the machine its event.
    async fn receive(&mut self, sample: Sample, requests: &mut Requests<'a>) -> anyhow::Result<()> {
        if let Some(event) = self.record(&sample) {
            self.advance(event, requests).await?;
        }
        let events = self.understand(sample.topic_index, &sample.received);
        let events = events.unwrap_or_else(|reason| {
            let topic = &self.recorded_topics[sample.topic_index].name;
            let complaints = self.complaints.entry(sample.topic_index).or_default();
            complaints.warn(&self.node, &format!("refused a message on {topic}: {reason}"));
            Vec::new()
        });
        if let Some(rates) = &mut self.rates {
            rates.received(&self.recorded_topics[sample.topic_index].name, self.start.elapsed());
        }
        if self.recorder.is_none() {
            self.early.keep(sample, &self.recorded_topics);
        }
        for event in events {
            self.advance(event, requests).await?;
        }
        Ok(())
    }

    /// Tells the operator and the log; what others have put into it stays on its line.
    fn note(&mut self, text: &str) {
        let text = one_line(text);
        self.node.log(Level::Info, &text);
        (self.watch)(Progress::Note(text.into_owned()));
    }

    /// Takes a report of the thread that writes the bag.
    async fn take_written(
        &mut self,
        written: Written,
        requests: &mut Requests<'a>,
    ) -> anyhow::Result<()> {
        let event = match written {
            Written::Opened => Event::RecorderReady,
            Written::Step(step) => {
                self.times.stepped(Instant::now());
                self.recorded_step = step;
                if !self.is_cut_off {
                    self.recorded.publish(Recorded { step }).await?;
                }
                (self.watch)(Progress::Done { done: step, of: self.plan.steps() });
                Event::Recorded { step }
            }
            Written::NotOpened(error) => {
                self.recorder = None;
                Event::RecorderFailed { reason: error.in_full() }
            }
            Written::Failed(error) => Event::RecorderFailed { reason: error.in_full() },
            Written::Closed(summary) => {
                self.bag = Some(summary);
                Event::RecorderClosed
            }
            Written::NotClosed(error) => {
                let reason = error.in_full();
                self.advance(Event::RecorderFailed { reason }, requests).await?;
                Event::RecorderClosed
            }
        };
        self.advance(event, requests).await
    }

    /// The event of a sample.
    fn understand(
        &mut self,
        topic_index: usize,
        received: &ReceivedRaw,
    ) -> anyhow::Result<Vec<Event>> {
        let mut events = self.understand_poses(topic_index, received)?;
        if let Some(contradiction) = self.contradiction(topic_index, received) {
            self.note(&contradiction);
        }
        let topic = &self.recorded_topics[topic_index];
        match topic.role {
            Role::Simulator => {
                let status = sample_events::status(&received.message)?;
                self.simulator = Some((status.clone(), Instant::now()));
                if let Some(answer) = self.answer_of_simulator(&status) {
                    self.answering_simulator = Some(received.writer);
                    events.push(answer);
                }
                if self.answering_simulator.is_none_or(|writer| writer == received.writer) {
                    events.push(Event::SimulatorStatus(status));
                }
            }
            // Where robots are is asked for before they move; then, whether their poses still come, and
            // whether they are where commands lead.
            Role::Transforms if self.rates.is_some() => {}
            _ => events.extend(sample_events::events(self.plan, topic, received)?),
        }
        Ok(events)
    }

    /// What a reading contradicts; the simulator's sensors report one thing each.
    fn contradiction(&mut self, topic_index: usize, received: &ReceivedRaw) -> Option<String> {
        let RecordedTopic { name, role, .. } = &self.recorded_topics[topic_index];
        let (Role::Detection(robot) | Role::FurtherDetection(robot)) = *role else { return None };
        if self.plan.record.time == Time::Lockstep {
            return None;
        }
        let Bool { data } = cdr::decode(&received.message).ok()?;
        let robot = &self.plan.record.robots[robot];
        let Some((_, reading)) = topics::further_reading(name) else {
            return self.contradictions.on_detection(robot, data);
        };
        self.contradictions.on_further(robot, reading, data);
        None
    }

    /// The events of the poses in a sample, if it has some.
    fn understand_poses(
        &mut self,
        topic_index: usize,
        received: &ReceivedRaw,
    ) -> anyhow::Result<Vec<Event>> {
        let place = self.places.get(topic_index).copied().flatten();
        let Some(place) = place.filter(|_| sample_events::looks_at_poses(self.plan)) else {
            return Ok(Vec::new());
        };
        let Sighting { poses, notes } = self.tracked.take(place, received)?;
        for note in notes {
            self.note(&note);
        }
        let poses = poses.into_iter();
        Ok(if self.rates.is_some() {
            poses.flat_map(|seen| sample_events::pose_sampled(self.plan, seen)).collect()
        } else {
            poses.flat_map(sample_events::pose_events).collect()
        })
    }

    /// The simulator's next word answers what the machine has asked it.
    fn answer_of_simulator(&mut self, status: &Status) -> Option<Event> {
        std::mem::take(&mut self.asks_simulator).then(|| {
            let result = if status.state == RobotState::Fault {
                Err(status.stop_reason.clone())
            } else {
                Ok(status.parameter_digest)
            };
            Event::ReadBack { target: Target::Simulator, result }
        })
    }

    /// Lets the machine take an event, and does what follows.
    async fn advance(&mut self, event: Event, requests: &mut Requests<'a>) -> anyhow::Result<()> {
        let mut events = vec![event];
        while let Some(event) = events.pop() {
            for action in self.machine.on_event(event, self.start.elapsed()) {
                events.extend(self.act(action, requests).await?);
            }
        }
        Ok(())
    }

    async fn act(
        &mut self,
        action: Action,
        requests: &mut Requests<'a>,
    ) -> anyhow::Result<Option<Event>> {
        match action {
            Action::PublishLease(_) if self.is_cut_off => {}
            Action::PublishLease(lease) => {
                self.lease.publish(wire::lease_message(&lease, wall_time())).await?;
            }
            Action::Configure(_) | Action::ReadBack(Target::Robot(_))
                if self.open.contains(&action) => {}
            Action::Configure(target) => {
                self.open.push(Action::Configure(target.clone()));
                self.times.found.get_or_insert(self.start.elapsed());
                let (client, plan) = (self.client, self.plan);
                requests.push(Box::pin(async move {
                    let result = parameters::configure(client, plan, &target).await;
                    Event::ParametersSet { target, result }
                }));
            }
            Action::ReadBack(Target::Simulator) => self.asks_simulator = true,
            Action::ReadBack(Target::Robot(robot)) => {
                self.open.push(Action::ReadBack(Target::Robot(robot.clone())));
                let (client, plan) = (self.client, self.plan);
                requests.push(Box::pin(async move {
                    let result = parameters::read_back(client, plan, &robot).await;
                    Event::ReadBack { target: Target::Robot(robot), result }
                }));
            }
            Action::ReadGate(robot) => {
                let client = self.client;
                requests.push(Box::pin(async move {
                    let found = parameters::read_gate(client, &robot).await;
                    Event::GateRead { robot, found }
                }));
            }
            Action::OpenRecorder => {
                self.times.confirmed.get_or_insert(self.start.elapsed());
                self.record.gates = self.machine.gates().clone();
                self.publish_note(0, self.record.to_json()).await?;
                return Ok(self.open_recorder());
            }
            Action::CloseRecorder => return self.close_recorder().await,
            Action::Note(text) => self.note(&text),
            Action::Finish { not_standing, .. } => self.finished = Some(not_standing),
        }
        Ok(None)
    }

    fn close_question(&mut self, answer: &Event) {
        let question = match answer {
            Event::ParametersSet { target, .. } => Action::Configure(target.clone()),
            Event::ReadBack { target, .. } => Action::ReadBack(target.clone()),
            _ => return,
        };
        self.open.retain(|open| *open != question);
    }

    fn report(&mut self) -> anyhow::Result<RunReport> {
        let not_standing =
            self.finished.take().context("the run ends when the machine finishes")?;
        Ok(RunReport {
            ending: self.machine.ending().context("a run that is over has ended")?,
            not_standing,
            bag: self.bag.take(),
            has_started: self.machine.has_started(),
            n_lost: self.n_lost,
            preflight_s: self.times.preflight_s(),
            parameters_s: self.times.parameters_s(),
            stepping_s: self.times.stepping_s(),
        })
    }
}
