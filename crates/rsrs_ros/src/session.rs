//! A participant in a ROS 2 network: nodes, publishers, subscriptions, and what else is there.
//!
//! One process should have one session, however many robots it stands for: discovery grows with the
//! square of the number of participants. Typed topics belong to a node and show up under its name
//! in `ros2 node info`; raw ones belong to none, as a recorder's do.
//!
//! ros2-client's `Spinner` is not used. Several of them in one participant steal each other's
//! events, so readiness comes from the discovery database ([`Session::wait_for_readers`]) and the
//! names of nodes from our own reader of `ros_discovery_info`.

mod absence;
mod addresses;
mod authentication;
mod close;
mod deadlock;
mod endpoint;
mod endpoint_creation;
mod error;
mod graph;
mod join;
mod local;
mod matching;
mod node;
mod publisher;
mod qos;
mod quality;
mod raw;
mod subscribing;
mod subscription;
mod threads;
mod wire;

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, MutexGuard, Once, PoisonError};
use std::time::{Duration, Instant};

use ros2_client::{Context, NodeName, NodeOptions};
use rsrs_fleet::timing::Transport;
use rsrs_msgs::RosMessage;
use rsrs_msgs::topics::Qos;

use crate::ros_args::RosArgs;

pub(crate) use close::is_stuck;
pub use deadlock::start_again_after_deadlock;
pub use endpoint::{Endpoint, EndpointKind};
pub use error::{NotMatched, PublishError, SessionEnded, SessionError};
pub use join::SessionOptions;
pub use node::NodeHandle;
pub use publisher::Publisher;
pub(crate) use qos::profile;
pub use raw::RawPublisher;
pub(crate) use subscription::Task;
pub use subscription::{Counts, Received, ReceivedRaw, Subscription};
pub(crate) use wire::Bytes;

use absence::Absences;
use addresses::Addresses;
use endpoint::Index;
use endpoint_creation::EndpointCreation;
use graph::Graph;
use local::{LocalDelivery, LocalPublisher, Writers};
use node::{message_type, ros_name};
use publisher::TypedWriter;
use quality::Watch;
use raw::RawWriter;
use subscription::Tasks;
use threads::Threads;

/// How often the discovery database is asked while waiting for a match.
pub(crate) const POLL: Duration = Duration::from_millis(20);

/// How often to look whether the session can still send and receive.
const POLL_PERIOD: Duration = Duration::from_millis(250);
/// A thread whose wait was interrupted has run within so long, unless the machine is overloaded.
const INTERRUPTED: Duration = Duration::from_millis(500);
/// How long a handshake may take: ten that start together take 6 to 10 s.
const HANDSHAKE_TIMEOUT: Duration = Duration::from_secs(20);

/// A participant in a ROS 2 network.
///
/// Give up all publishers and subscriptions, then [`close`](Session::close) it.
pub struct Session {
    participant: rustdds::DomainParticipant,
    publisher: rustdds::Publisher,
    subscriber: rustdds::Subscriber,
    context: Context,
    nodes: Mutex<BTreeMap<String, (NodeHandle, ros2_client::Node)>>,
    tasks: Tasks,
    threads: Threads,
    absences: Absences,
    addresses: Addresses,
    graph: Arc<Graph>,
    follows_graph: Once,
    watch: Arc<Watch>,
    watches: Once,
    index: Mutex<Index>,
    endpoint_creation: Arc<EndpointCreation>,
    transport: Transport,
    /// In a secured session only.
    local: Option<Arc<LocalDelivery>>,
    writers: Writers,
    /// The ROS arguments, of which names of topics and `/rosout` matter here.
    arguments: Option<RosArgs>,
}

impl Session {
    /// Joins a network. It must be called within a tokio runtime, else it is an error.
    pub fn open(options: &SessionOptions) -> Result<Self, SessionError> {
        if options.interfaces.is_empty() {
            return Err(SessionError::NoInterface);
        }
        crate::logging::print_beside();
        let runtime = tokio::runtime::Handle::try_current()
            .map_err(|source| SessionError::NoRuntime { source })?;
        let failed = |reason: String| SessionError::Join { domain_id: options.domain_id, reason };
        let (participant, threads) = Threads::started_by(|| join::participant(options))?;
        let qos = rustdds::QosPolicyBuilder::new().build();
        let publisher =
            participant.create_publisher(&qos).map_err(|error| failed(error.to_string()))?;
        let subscriber =
            participant.create_subscriber(&qos).map_err(|error| failed(error.to_string()))?;
        let context = Context::from_domain_participant(participant.clone())
            .map_err(|error| failed(error.to_string()))?;
        let absences = Absences::new(&participant);
        let endpoint_creation = Arc::new(EndpointCreation::new(threads.ids()));

        Ok(Self {
            participant,
            publisher,
            subscriber,
            context,
            absences,
            addresses: Addresses::new(&options.interfaces),
            nodes: Mutex::default(),
            tasks: Tasks::on(runtime),
            threads,
            graph: Arc::default(),
            follows_graph: Once::new(),
            watch: Arc::default(),
            watches: Once::new(),
            index: Mutex::default(),
            endpoint_creation,
            transport: options.transport(),
            local: options.enclave.as_ref().map(|_| Arc::default()),
            writers: Writers::default(),
            arguments: None,
        })
    }

    /// Joins a network, with other names for topics of nodes, and without `/rosout`, where that was
    /// requested of ROS 2. Raw topics belong to no node and keep their names.
    pub fn open_with(options: &SessionOptions, arguments: &RosArgs) -> Result<Self, SessionError> {
        Ok(Self { arguments: Some(arguments.clone()), ..Self::open(options)? })
    }

    /// How messages travel, on which some times of the protocol depend.
    pub fn transport(&self) -> Transport {
        self.transport
    }

    /// The name of a node's topic, after remapping.
    fn remapped(&self, node: &NodeHandle, topic: &str) -> String {
        let Some(arguments) = &self.arguments else { return topic.to_owned() };
        let (namespace, name) = node.full_name().rsplit_once('/').unwrap_or_default();
        let namespace = if namespace.is_empty() { "/" } else { namespace };
        arguments.topic((namespace, name), topic)
    }

    /// A node by its absolute namespace, such as `/robot_3` or `/`, and its name, made at the first
    /// call.
    ///
    /// It logs to `/rosout` and has no parameter services; see
    /// [`ParameterServer`](crate::parameters::ParameterServer).
    pub fn node(&self, namespace: &str, name: &str) -> Result<NodeHandle, SessionError> {
        let full_name =
            if namespace == "/" { format!("/{name}") } else { format!("{namespace}/{name}") };
        let mut nodes = lock(&self.nodes);
        if let Some((handle, _)) = nodes.get(&full_name) {
            return Ok(handle.clone());
        }

        let node_name = NodeName::new(namespace, name).map_err(|error| SessionError::Name {
            name: full_name.clone(),
            reason: error.to_string(),
        })?;
        // Of two publishers of one topic in a secured session only the first is received.
        let first = nodes.values().next().map(|(handle, _)| handle.clone());
        let shared = first.filter(|_| self.local.is_some());
        let node = self.endpoint_creation.make(2, || {
            let to_rosout = self.arguments.as_ref().is_none_or(|arguments| arguments.to_rosout)
                && shared.is_none();
            let options =
                NodeOptions::new().enable_rosout(to_rosout).start_parameter_services(false);
            self.context
                .new_node(node_name.clone(), options)
                .map_err(|error| SessionError::endpoint(&full_name, &error))
        })?;
        let handle = shared.map_or_else(
            || NodeHandle::new(full_name.clone(), &node),
            |first| first.called(full_name.clone()),
        );
        nodes.insert(full_name, (handle.clone(), node));
        Ok(handle)
    }

    /// Starts to publish on an absolute topic, such as `/robot_3/detection`.
    pub fn publish_on<M: RosMessage>(
        &self,
        node: &NodeHandle,
        topic: &str,
        qos: Qos,
    ) -> Result<Publisher<M>, SessionError> {
        let topic = &self.remapped(node, topic);
        let dds_topic = format!("rt{topic}");
        let make = || {
            let writer = self.typed_writer(node, topic, qos)?;
            let local = self.local.as_ref().map(|topics| {
                LocalPublisher::new(topics, dds_topic.clone(), writer.guid().to_bytes())
            });
            Ok(TypedWriter { topic: topic.clone(), writer, local })
        };
        Ok(Publisher::new(match &self.local {
            Some(_) => self.writers.shared(&dds_topic, make)?,
            None => Arc::new(make()?),
        }))
    }

    fn typed_writer<M: RosMessage>(
        &self,
        node: &NodeHandle,
        topic: &str,
        qos: Qos,
    ) -> Result<ros2_client::Publisher<M>, SessionError> {
        let profile = profile(qos);
        self.with_node(node, 1, |node| {
            let dds_topic = node.create_topic(&ros_name(topic)?, message_type::<M>(), &profile);
            let dds_topic = dds_topic.map_err(|error| SessionError::endpoint(topic, &error))?;
            node.create_publisher(&dds_topic, Some(profile.clone()))
                .map_err(|error| SessionError::endpoint(topic, &error))
        })
    }

    /// Starts to publish bytes of any type.
    pub fn publish_raw(
        &self,
        topic: &str,
        type_name: &str,
        qos: Qos,
    ) -> Result<RawPublisher, SessionError> {
        let names = raw::DdsNames::of_topic(topic, type_name)?;
        let policies = qos::policies(qos);
        let make = || {
            self.endpoint_creation.make(1, || {
                RawWriter::new(topic, &self.participant, &self.publisher, &names, &policies)
            })
        };
        Ok(RawPublisher::new(match &self.local {
            Some(topics) => {
                self.writers.shared(names.topic(), || Ok(make()?.delivering_to(topics)))?
            }
            None => Arc::new(make()?),
        }))
    }

    /// Every publisher and subscriber that is known here: those of others, and our own.
    ///
    /// The first call subscribes to the names of nodes, which come a moment later. Robots do not call it:
    /// what each of them announces would go to every other one.
    pub fn endpoints(&self) -> Vec<Endpoint> {
        self.follow_names();
        endpoint::all(&self.participant, &self.graph.owners())
    }

    /// Full names of all nodes in the network, our own and others', sorted.
    ///
    /// With the first question it subscribes to the names, which come a moment later.
    pub fn node_names(&self) -> Vec<String> {
        self.follow_names();
        let mut names = self.graph.node_names(&endpoint::participants(&self.participant));
        names.extend(lock(&self.nodes).keys().cloned());
        names.into_iter().collect()
    }

    /// Waits until nothing is sent or received any more although no call fails. A node ends then, so
    /// that a service can start it again.
    pub async fn ended(&self) -> SessionEnded {
        loop {
            tokio::time::sleep(POLL_PERIOD).await;
            if let Some(ended) = self.threads.have_ended() {
                return ended;
            }
            if let Some(broken) = self.tasks.broken() {
                return broken;
            }
            if let Some(changed) = self.addresses.change() {
                return changed;
            }
            // While the interface is down, a program that starts anew finds no network.
            if self.local.is_some()
                && self.absences.has_lost_itself()
                && self.addresses.are_present()
            {
                return SessionEnded::OwnLeaseExpired;
            }
            if let Some(ended) = self.absences.update() {
                return ended;
            }
        }
    }

    /// Whether the middleware has ended, for a program that has itself stood still for a while: a
    /// process that was stopped should not take the silence of others for their fault.
    pub async fn has_ended_meanwhile(&self) -> Option<SessionEnded> {
        // A thread whose wait was interrupted ends when it runs next, which a busy machine delays; one
        // that is asleep waits again.
        let deadline = Instant::now() + INTERRUPTED;
        loop {
            tokio::time::sleep(POLL).await;
            let ended = self.threads.have_ended();
            if ended.is_some() || self.threads.are_asleep() || Instant::now() >= deadline {
                return ended;
            }
        }
    }

    /// Leaves the network, so that the others see it at once and nothing is left running. What the
    /// middleware does not end in time is left behind: [`shutdown::leave`](crate::shutdown::leave).
    ///
    /// # Panics
    ///
    /// If a subscriber's `deliver` had panicked, with its panic.
    pub async fn close(self) {
        let Self { participant, publisher, subscriber, context, nodes, writers, tasks, .. } = self;
        tasks.stop().await;
        // It waits for the threads of the middleware.
        close::within_deadline(move || {
            drop(writers);
            drop(nodes);
            drop(context);
            drop((publisher, subscriber));
            drop(participant);
        })
        .await;
    }

    /// Runs `make` with a node of this session, after the pause that `n_endpoints` take.
    pub(crate) fn with_node<T>(
        &self,
        handle: &NodeHandle,
        n_endpoints: usize,
        mut make: impl FnMut(&mut ros2_client::Node) -> Result<T, SessionError>,
    ) -> Result<T, SessionError> {
        let mut nodes = lock(&self.nodes);
        let Some((_, node)) = nodes.get_mut(handle.full_name()) else {
            return Err(SessionError::ForeignNode { name: handle.full_name().to_owned() });
        };
        self.endpoint_creation.make(n_endpoints, || make(node))
    }

    /// Runs a task until the session is closed or the handle is dropped.
    pub(crate) fn run(&self, future: impl Future<Output = ()> + Send + 'static) -> Task {
        self.tasks.run(future)
    }

    /// The vendor of a writer on a DDS topic; `None` while there is none.
    pub(crate) fn vendor_of_writer(&self, dds_topic: &str) -> Option<[u8; 2]> {
        lock(&self.index).refresh(&self.participant).vendor_of_writer(dds_topic)
    }

    /// Whether a DDS topic has a reader.
    pub(crate) fn has_reader(&self, dds_topic: &str) -> bool {
        lock(&self.index).refresh(&self.participant).has_reader(dds_topic)
    }

    fn follow_names(&self) {
        self.follows_graph.call_once(|| {
            if let Err(error) = self.follow_graph() {
                log::warn!("nodes have no names: {error}");
            }
        });
    }

    fn follow_graph(&self) -> Result<(), SessionError> {
        let (names, policies) = (raw::DdsNames::of_graph(), qos::policies(graph::QOS));
        let reader = self
            .endpoint_creation
            .make(1, || raw::reader(&self.participant, &self.subscriber, &names, &policies))?;
        let (graph, participant) = (Arc::clone(&self.graph), self.participant.clone());
        let deliver = move |sample: ReceivedRaw| {
            let writer = endpoint::prefix(sample.writer);
            graph.update(writer, sample.message, || endpoint::participants(&participant));
        };
        let subscription = self.tasks.deliver(graph::TOPIC, raw::stream(reader), deliver);
        subscription.until_close();
        Ok(())
    }
}

/// Locks what no panic can leave half-changed.
pub(crate) fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
