//! A participant in a ROS 2 network: nodes, publishers, subscriptions, and what else is there.
//!
//! One process should have one session, however many robots it stands for: discovery grows with the
//! square of the number of participants. Typed topics belong to a node and show up under its name
//! in `ros2 node info`; raw ones belong to none, as a recorder's do.
//!
//! ros2-client's `Spinner` is not used. Several of them in one participant steal each other's
//! events, so readiness comes from the discovery database ([`Session::wait_for_readers`]) and the
//! names of nodes from our own reader of `ros_discovery_info`.

mod endpoint;
mod error;
mod graph;
mod node;
mod pace;
mod prefix;
mod publisher;
mod qos;
mod raw;
mod subscription;
mod wire;

use std::collections::BTreeMap;
use std::net::IpAddr;
use std::sync::{Arc, Mutex, MutexGuard, Once, PoisonError};
use std::time::{Duration, Instant};

use ros2_client::{Context, MessageTypeName, Name, NodeName, NodeOptions};
use rsrs_msgs::RosMessage;
use rsrs_msgs::topics::Qos;
use rustdds::DomainParticipantBuilder;

pub use endpoint::{Endpoint, EndpointKind};
pub use error::{NotMatched, PublishError, SessionError};
pub use node::NodeHandle;
pub use publisher::Publisher;
pub(crate) use qos::profile;
pub use raw::RawPublisher;
pub(crate) use subscription::Task;
pub use subscription::{Counts, Received, ReceivedRaw, Subscription};
pub(crate) use wire::Bytes;

use endpoint::Index;
use graph::Graph;
use pace::Pace;
use subscription::Tasks;
use wire::Wire;

/// How often the discovery database is asked while waiting for somebody.
pub(crate) const POLL: Duration = Duration::from_millis(20);

/// Where a session lives.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SessionOptions {
    /// `ROS_DOMAIN_ID`; 0 to 232.
    pub domain_id: u16,
    /// The interfaces to use, by address; never empty: loopback when confined.
    pub interfaces: Vec<IpAddr>,
}

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
    graph: Arc<Graph>,
    follows_graph: Once,
    index: Mutex<Index>,
    pace: Pace,
}

impl Session {
    /// Joins a network.
    ///
    /// # Errors
    ///
    /// [`SessionError`], among others if this is not called within a tokio runtime.
    pub fn open(options: &SessionOptions) -> Result<Self, SessionError> {
        if options.interfaces.is_empty() {
            return Err(SessionError::NoInterface);
        }
        let runtime = tokio::runtime::Handle::try_current()
            .map_err(|source| SessionError::NoRuntime { source })?;
        let failed = |reason: String| SessionError::Join { domain_id: options.domain_id, reason };
        let participant = DomainParticipantBuilder::new(options.domain_id)
            .with_only_networks(options.interfaces.iter().copied())
            .build()
            .map_err(|error| failed(error.to_string()))?;
        let qos = rustdds::QosPolicyBuilder::new().build();
        let publisher =
            participant.create_publisher(&qos).map_err(|error| failed(error.to_string()))?;
        let subscriber =
            participant.create_subscriber(&qos).map_err(|error| failed(error.to_string()))?;
        let context = Context::from_domain_participant(participant.clone())
            .map_err(|error| failed(error.to_string()))?;

        Ok(Self {
            participant,
            publisher,
            subscriber,
            context,
            nodes: Mutex::default(),
            tasks: Tasks::on(runtime),
            graph: Arc::default(),
            follows_graph: Once::new(),
            index: Mutex::default(),
            pace: Pace::default(),
        })
    }

    /// A node by its full name, made at the first call.
    ///
    /// It logs to `/rosout` and has no parameter services; see
    /// [`ParameterServer`](crate::parameters::ParameterServer).
    ///
    /// # Arguments
    ///
    /// * `namespace` — absolute, such as `/robot_3` or `/`.
    /// * `name` — such as `controller`.
    ///
    /// # Errors
    ///
    /// [`SessionError::Name`] if ROS 2 does not allow the name.
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
        self.pace.wait(2);
        let node = pace::persist(|| {
            let options = NodeOptions::new().enable_rosout(true).start_parameter_services(false);
            self.context
                .new_node(node_name.clone(), options)
                .map_err(|error| SessionError::endpoint(&full_name, &error))
        })?;
        let handle = NodeHandle::new(full_name.clone(), &node);
        nodes.insert(full_name, (handle.clone(), node));
        Ok(handle)
    }

    /// Starts to publish.
    ///
    /// # Arguments
    ///
    /// * `topic` — absolute, such as `/robot_3/detection`.
    ///
    /// # Errors
    ///
    /// [`SessionError::Name`] and [`SessionError::Endpoint`].
    pub fn publish_on<M: RosMessage>(
        &self,
        node: &NodeHandle,
        topic: &str,
        qos: Qos,
    ) -> Result<Publisher<M>, SessionError> {
        let profile = profile(qos);
        let writer = self.with_node(node, 1, |node| {
            let dds_topic = node.create_topic(&ros_name(topic)?, message_type::<M>(), &profile);
            let dds_topic = dds_topic.map_err(|error| SessionError::endpoint(topic, &error))?;
            node.create_publisher(&dds_topic, Some(profile.clone()))
                .map_err(|error| SessionError::endpoint(topic, &error))
        })?;
        Ok(Publisher::new(topic, writer))
    }

    /// Starts to listen; every sample is handed to `deliver` in a task of its own.
    ///
    /// Samples that do not decode are counted and logged, because another program sent them.
    ///
    /// # Arguments
    ///
    /// * `topic` — absolute, such as `/robot_3/detection`.
    /// * `deliver` — must not block: all tasks may share one thread.
    ///
    /// # Errors
    ///
    /// [`SessionError::Name`] and [`SessionError::Endpoint`].
    pub fn subscribe<M: RosMessage>(
        &self,
        node: &NodeHandle,
        topic: &str,
        qos: Qos,
        deliver: impl FnMut(Received<M>) + Send + 'static,
    ) -> Result<Subscription, SessionError> {
        let profile = profile(qos);
        let reader = self.with_node(node, 1, |node| {
            let dds_topic = node.create_topic(&ros_name(topic)?, message_type::<M>(), &profile);
            let dds_topic = dds_topic.map_err(|error| SessionError::endpoint(topic, &error))?;
            node.create_subscription::<Wire<M>>(&dds_topic, Some(profile.clone()))
                .map_err(|error| SessionError::endpoint(topic, &error))
        })?;
        Ok(self.tasks.deliver(topic, subscription::typed(reader), deliver))
    }

    /// Starts to listen to bytes of any type; they keep their 4 bytes of encapsulation, as in a bag.
    ///
    /// # Arguments
    ///
    /// * `topic` — absolute, such as `/robot_3/detection`.
    /// * `type_name` — such as `std_msgs/msg/Bool`.
    ///
    /// # Errors
    ///
    /// [`SessionError::Name`] and [`SessionError::Endpoint`].
    pub fn subscribe_raw(
        &self,
        topic: &str,
        type_name: &str,
        qos: Qos,
        deliver: impl FnMut(ReceivedRaw) + Send + 'static,
    ) -> Result<Subscription, SessionError> {
        self.pace.wait(1);
        let names = raw::DdsNames::of_topic(topic, type_name)?;
        let policies = qos::policies(qos);
        let reader =
            pace::persist(|| raw::reader(&self.participant, &self.subscriber, &names, &policies))?;
        Ok(self.tasks.deliver(topic, raw::stream(reader), deliver))
    }

    /// Starts to publish bytes of any type.
    ///
    /// # Errors
    ///
    /// [`SessionError::Name`] and [`SessionError::Endpoint`].
    pub fn publish_raw(
        &self,
        topic: &str,
        type_name: &str,
        qos: Qos,
    ) -> Result<RawPublisher, SessionError> {
        self.pace.wait(1);
        let names = raw::DdsNames::of_topic(topic, type_name)?;
        let policies = qos::policies(qos);
        pace::persist(|| {
            RawPublisher::new(topic, &self.participant, &self.publisher, &names, &policies)
        })
    }

    /// Every publisher and subscriber that is known here: those of others, and our own.
    ///
    /// With the first question it begins to listen to the names of nodes, which come a moment later.
    /// Robots do not ask: each word of each of them would go to each other.
    pub fn endpoints(&self) -> Vec<Endpoint> {
        self.follow_names();
        endpoint::all(&self.participant, &self.graph)
    }

    /// Full names of all nodes in the network, our own and others', sorted.
    ///
    /// With the first question it begins to listen to the names, which come a moment later.
    pub fn node_names(&self) -> Vec<String> {
        self.follow_names();
        let mut names = self.graph.node_names(&endpoint::participants(&self.participant));
        names.extend(lock(&self.nodes).keys().cloned());
        names.into_iter().collect()
    }

    /// Waits until at least so many subscribers of a topic are known.
    ///
    /// # Errors
    ///
    /// [`NotMatched`] after `timeout`.
    pub async fn wait_for_readers(
        &self,
        topic: &str,
        at_least: usize,
        timeout: Duration,
    ) -> Result<(), NotMatched> {
        self.wait_for(EndpointKind::Reader, topic, at_least, timeout).await
    }

    /// Waits until at least so many publishers of a topic are known.
    ///
    /// # Errors
    ///
    /// [`NotMatched`] after `timeout`.
    pub async fn wait_for_writers(
        &self,
        topic: &str,
        at_least: usize,
        timeout: Duration,
    ) -> Result<(), NotMatched> {
        self.wait_for(EndpointKind::Writer, topic, at_least, timeout).await
    }

    async fn wait_for(
        &self,
        kind: EndpointKind,
        topic: &str,
        wanted: usize,
        timeout: Duration,
    ) -> Result<(), NotMatched> {
        let start = Instant::now();
        loop {
            let found = endpoint::count(&self.participant, kind, topic);
            let waited = start.elapsed();
            if found >= wanted {
                return Ok(());
            }
            if waited >= timeout {
                let topic = topic.to_owned();
                let waited_s = waited.as_secs_f64();
                return Err(NotMatched { topic, kind, found, wanted, waited_s });
            }
            tokio::time::sleep(POLL).await;
        }
    }

    /// Leaves the network, so that the others see it at once and nothing is left running.
    ///
    /// # Panics
    ///
    /// If a subscriber's `deliver` had panicked, with its panic.
    pub async fn close(self) {
        let Self { participant, publisher, subscriber, context, nodes, tasks, .. } = self;
        tasks.stop().await;
        // It waits for the threads of the middleware.
        tokio::task::spawn_blocking(move || {
            drop(nodes);
            drop(context);
            drop((publisher, subscriber));
            drop(participant);
        })
        .await
        .expect("dropping handles does not panic");
    }

    /// Runs `make` with a node of this session, after the pause that `n_endpoints` take.
    pub(crate) fn with_node<T>(
        &self,
        handle: &NodeHandle,
        n_endpoints: usize,
        mut make: impl FnMut(&mut ros2_client::Node) -> Result<T, SessionError>,
    ) -> Result<T, SessionError> {
        self.pace.wait(n_endpoints);
        let mut nodes = lock(&self.nodes);
        let Some((_, node)) = nodes.get_mut(handle.full_name()) else {
            return Err(SessionError::ForeignNode { name: handle.full_name().to_owned() });
        };
        pace::persist(|| make(node))
    }

    /// Runs a task until the session is closed or the handle is dropped.
    pub(crate) fn run(&self, future: impl Future<Output = ()> + Send + 'static) -> Task {
        self.tasks.run(future)
    }

    /// The vendor of a writer on a DDS topic; `None` while there is none.
    pub(crate) fn vendor_of_writer(&self, dds_topic: &str) -> Option<[u8; 2]> {
        lock(&self.index).refresh(&self.participant).vendor_of_writer(dds_topic)
    }

    /// Whether somebody reads a DDS topic.
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
        let reader = raw::reader(
            &self.participant,
            &self.subscriber,
            &raw::DdsNames::of_graph(),
            &qos::policies(graph::QOS),
        )?;
        let graph = Arc::clone(&self.graph);
        let deliver = move |sample: ReceivedRaw| graph.update(sample.message);
        let subscription = self.tasks.deliver(graph::TOPIC, raw::stream(reader), deliver);
        subscription.until_close();
        Ok(())
    }
}

/// Locks what no panic can leave half-changed.
pub(crate) fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// A topic's name as ros2-client wants it.
fn ros_name(topic: &str) -> Result<Name, SessionError> {
    let refused = |reason: String| SessionError::Name { name: topic.to_owned(), reason };
    if !topic.starts_with('/') {
        return Err(refused("it must be absolute, with a slash in front".to_owned()));
    }
    Name::parse(topic).map_err(|error| refused(error.to_string()))
}

fn message_type<M: RosMessage>() -> MessageTypeName {
    let (package, name) = M::TYPE_NAME
        .split_once("/msg/")
        .expect("only messages are published, and their types are called package/msg/Name");
    MessageTypeName::new(package, name)
}
