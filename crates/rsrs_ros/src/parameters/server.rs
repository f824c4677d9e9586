//! Answers parameter services for many nodes of one session, and publishes what changed.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex};

use rsrs_msgs::rcl_interfaces::{Parameter, ParameterEvent};
use rsrs_msgs::topics;
use tokio::sync::mpsc;

use super::service::{Reply, Request, Service, answer};
use super::store::{Arming, Refusal, Setter, Store};
use crate::clock::wall_time;
use crate::parameter_value::{Descriptor, ParameterValue};
use crate::services::raw;
use crate::session::{NodeHandle, Publisher, Session, SessionError, Task, lock};

/// A node and its parameters.
#[derive(Clone, Debug, PartialEq)]
pub struct NodeParameters {
    /// Absolute, such as `/robot_3`.
    pub namespace: String,
    /// Such as `controller`.
    pub name: String,
    /// What there is, and its first value.
    pub parameters: Vec<(Descriptor, ParameterValue)>,
}

/// Why a node has no parameters.
#[derive(Debug, thiserror::Error)]
pub enum ParameterServerError {
    /// There is nothing to serve.
    #[error("a parameter server needs at least one node, found none")]
    NoNode,
    /// The services or the topic of events cannot be made.
    #[error("no parameter services")]
    Session {
        /// Why not.
        #[from]
        source: SessionError,
    },
    /// A parameter does not fit its descriptor, or is declared twice.
    #[error("parameters of `{node}`")]
    Declaration {
        /// Full name of the node.
        node: String,
        /// What is wrong.
        #[source]
        source: Refusal,
    },
    /// A node that is not of this server.
    #[error("node `{node}` has no parameters here")]
    NoSuchNode {
        /// Full name of the node.
        node: String,
    },
}

/// Whether a node agrees with changes that its descriptors allow.
type Validator = dyn FnMut(&str, &[(String, ParameterValue)]) -> Result<(), String> + Send;

/// What all services of a server share.
struct State {
    stores: BTreeMap<String, Store>,
    validator: Box<Validator>,
    events: mpsc::UnboundedSender<ParameterEvent>,
}

/// Answers the six parameter services of its nodes until it is dropped or the session is closed.
pub struct ParameterServer {
    state: Arc<Mutex<State>>,
    _tasks: Vec<Task>,
}

impl ParameterServer {
    /// Starts to answer for a node that has no parameters: tools that list those of all nodes wait for
    /// each that does not answer.
    pub fn without_parameters(
        session: &Session,
        node: &NodeHandle,
    ) -> Result<Self, ParameterServerError> {
        let (namespace, name) = node.full_name().rsplit_once('/').unwrap_or_default();
        let namespace = if namespace.is_empty() { "/" } else { namespace }.to_owned();
        let node = NodeParameters { namespace, name: name.to_owned(), parameters: Vec::new() };
        Self::start(session, vec![node], |_, _| Ok(()))
    }

    /// Declares parameters and starts to answer, for nodes that are made if the session does not
    /// have them.
    ///
    /// Before changes that the descriptors allow are made, `validator` is asked, with the full name
    /// of the node; it must not call this server.
    ///
    /// `use_sim_time` is not declared: nodes of ours follow `/clock` in lockstep or not at all, and
    /// a foreign tool that switched it would stop their timers.
    pub fn start(
        session: &Session,
        nodes: Vec<NodeParameters>,
        validator: impl FnMut(&str, &[(String, ParameterValue)]) -> Result<(), String> + Send + 'static,
    ) -> Result<Self, ParameterServerError> {
        let mut handles = Vec::new();
        let mut stores = BTreeMap::new();
        for NodeParameters { namespace, name, parameters } in nodes {
            let handle = session.node(&namespace, &name)?;
            let mut store = Store::default();
            for (descriptor, value) in parameters {
                store.declare(descriptor, value).map_err(|source| {
                    let node = handle.full_name().to_owned();
                    ParameterServerError::Declaration { node, source }
                })?;
            }
            stores.insert(handle.full_name().to_owned(), store);
            handles.push(handle);
        }

        let first = handles.first().ok_or(ParameterServerError::NoNode)?;
        let topic = topics::PARAMETER_EVENTS;
        let publisher = session.publish_on(first, topic.name, topic.qos)?;
        let (events, receiver) = mpsc::unbounded_channel();
        for (node, store) in &stores {
            let declared = store.values().map(|(name, value)| (name.to_owned(), value.clone()));
            let new_parameters = declared.map(parameter).collect();
            send(&events, ParameterEvent { new_parameters, ..event(node) });
        }
        let validator = Box::new(validator);
        let state = Arc::new(Mutex::new(State { stores, validator, events }));

        let mut tasks = vec![session.run(publish_events(publisher, receiver))];
        for handle in &handles {
            for service in Service::ALL {
                tasks.push(serve(session, handle, service, Arc::clone(&state))?);
            }
        }
        Ok(Self { state, _tasks: tasks })
    }

    /// The value of a parameter; `None` if there is no such node or parameter.
    pub fn get(&self, node: &str, name: &str) -> Option<ParameterValue> {
        lock(&self.state).stores.get(node)?.get(name).cloned()
    }

    /// The value of a parameter that was declared as a number.
    ///
    /// # Panics
    ///
    /// If it was not.
    pub fn double(&self, node: &str, name: &str) -> f64 {
        match self.get(node, name) {
            Some(ParameterValue::Double(value)) => value,
            other => unreachable!("{name} was declared as a double, found {other:?}"),
        }
    }

    /// The value of a parameter that was declared as a whole number.
    ///
    /// # Panics
    ///
    /// If it was not.
    pub fn integer(&self, node: &str, name: &str) -> i64 {
        match self.get(node, name) {
            Some(ParameterValue::Integer(value)) => value,
            other => unreachable!("{name} was declared as an integer, found {other:?}"),
        }
    }

    /// The value of a parameter that was declared as a text.
    ///
    /// # Panics
    ///
    /// If it was not.
    pub fn text(&self, node: &str, name: &str) -> String {
        match self.get(node, name) {
            Some(ParameterValue::String(value)) => value,
            other => unreachable!("{name} was declared as a string, found {other:?}"),
        }
    }

    /// Sets a parameter in the name of its node, which may set what others may only read.
    ///
    /// The validator is not asked.
    pub fn set_local(
        &self,
        node: &str,
        name: &str,
        value: ParameterValue,
    ) -> Result<(), ParameterServerError> {
        let mut state = lock(&self.state);
        let store = state.store(node)?;
        let changes = [(name.to_owned(), value)];
        store.check(&changes, Setter::Owner).map_err(|source| {
            ParameterServerError::Declaration { node: node.to_owned(), source }
        })?;
        store.apply(&changes);
        state.publish_changes(node, changes.to_vec());
        Ok(())
    }

    /// Locks the parameters of an armed robot, or unlocks them.
    pub fn set_arming(&self, node: &str, arming: Arming) -> Result<(), ParameterServerError> {
        lock(&self.state).store(node)?.arming = arming;
        Ok(())
    }
}

impl State {
    fn store(&mut self, node: &str) -> Result<&mut Store, ParameterServerError> {
        self.stores
            .get_mut(node)
            .ok_or_else(|| ParameterServerError::NoSuchNode { node: node.to_owned() })
    }

    fn answer(&mut self, node: &str, request: Request) -> Vec<u8> {
        let Self { stores, validator, .. } = self;
        let store = stores.get_mut(node).expect("each service was started for one of the stores");
        let Reply { body, changes } = answer(request, store, &mut |c| validator(node, c));
        self.publish_changes(node, changes);
        body
    }

    /// Publishes changes, if there are any.
    fn publish_changes(&self, node: &str, changes: Vec<(String, ParameterValue)>) {
        if !changes.is_empty() {
            let changed_parameters = changes.into_iter().map(parameter).collect();
            send(&self.events, ParameterEvent { changed_parameters, ..event(node) });
        }
    }
}

fn parameter((name, value): (String, ParameterValue)) -> Parameter {
    Parameter { name, value: value.to_wire() }
}

/// An event of a node, now, without changes yet.
fn event(node: &str) -> ParameterEvent {
    ParameterEvent { stamp: wall_time(), node: node.to_owned(), ..ParameterEvent::default() }
}

/// Hands an event to the task that publishes; while the session closes, no task receives any more.
fn send(events: &mpsc::UnboundedSender<ParameterEvent>, event: ParameterEvent) {
    if let Err(unsent) = events.send(event) {
        log::debug!("a change of `{}` is not published any more", unsent.0.node);
    }
}

async fn publish_events(
    publisher: Publisher<ParameterEvent>,
    mut events: mpsc::UnboundedReceiver<ParameterEvent>,
) {
    while let Some(event) = events.recv().await {
        if let Err(error) = publisher.publish(event).await {
            log::warn!("a change of parameters is not published: {error}");
        }
    }
}

/// Answers one service of one node.
fn serve(
    session: &Session,
    node: &NodeHandle,
    service: Service,
    state: Arc<Mutex<State>>,
) -> Result<Task, SessionError> {
    let node_name = node.full_name().to_owned();
    let name = format!("{node_name}/{}", service.name());
    let server = raw::server(session, node, &name, &service.ros_type())?;
    let decode = move |body: &[u8]| Request::decode(service, body);
    let answer = move |request| std::future::ready(Some(lock(&state).answer(&node_name, request)));
    Ok(session.run(raw::answer_all(name, server, decode, || None, answer)))
}
