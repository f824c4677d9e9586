//! Gets and sets parameters of other nodes, and repeats requests that are not answered.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use rsrs_core::help::Help;
use rsrs_msgs::RosMessage;
use rsrs_msgs::cdr::{self, ByteOrder, CdrError};
use rsrs_msgs::rcl_interfaces as wire;
use tokio::sync::Semaphore;

use super::service::Service;
use crate::parameter_value::ParameterValue;
use crate::services::Mapping;
use crate::services::raw::{self, RawClient};
use crate::session::{Bytes, NodeHandle, POLL, Session, SessionError, lock};

/// How long a client waits, and how it asks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ClientOptions {
    /// How long to wait for a node to appear and answer, all tries together.
    pub timeout: Duration,
    /// How to ask; `None` to go by the vendor of the node's DDS.
    pub mapping: Option<Mapping>,
}

impl Default for ClientOptions {
    fn default() -> Self {
        Self { timeout: Duration::from_secs(5), mapping: None }
    }
}

/// Why a parameter is not known or not set.
#[derive(Debug, thiserror::Error)]
pub enum ParameterClientError {
    /// The node does not exist, or does not answer.
    #[error("node `{node}` did not answer {tries} times in {waited_s:.1} s")]
    NoAnswer {
        /// Full name of the node.
        node: String,
        /// How long it took to give up, in seconds.
        waited_s: f64,
        /// How often it was asked; 0 if it never appeared.
        tries: u32,
    },
    /// The node does not want to.
    #[error("node `{node}` refused: {reason}")]
    Refused {
        /// Full name of the node.
        node: String,
        /// Its reason.
        reason: String,
    },
    /// The node has no such parameter, or has not set it.
    #[error("node `{node}` has no parameter `{name}`")]
    NoSuchParameter {
        /// Full name of the node.
        node: String,
        /// Name of the parameter.
        name: String,
    },
    /// The answer is not one.
    #[error("answer of node `{node}`")]
    Reply {
        /// Full name of the node.
        node: String,
        /// What is wrong with it.
        #[source]
        source: CdrError,
    },
    /// The answer is about something else.
    #[error("node `{node}` answered {found} values, expected {expected}")]
    Count {
        /// Full name of the node.
        node: String,
        /// Values in the answer.
        found: usize,
        /// Values that were asked for.
        expected: usize,
    },
    /// The question cannot be asked.
    #[error("no parameter client")]
    Session {
        /// Why not.
        #[from]
        source: SessionError,
    },
}

impl Help for ParameterClientError {
    fn help(&self) -> Option<String> {
        matches!(self, Self::NoAnswer { .. })
            .then(|| "`ros2 node list` shows which nodes are there".to_owned())
    }
}

/// First wait for an answer; the next ones double. The first request is lost now and then, because
/// the node may discover us later than we discover it.
const FIRST_TRY: Duration = Duration::from_millis(50);

/// Questions that are under way at the same time. Of hundreds, the last would be answered so late
/// that all of them were asked again meanwhile.
const AT_ONCE: usize = 32;

/// The endpoints for one service of one node; one request at a time.
type Endpoint = Arc<tokio::sync::Mutex<RawClient>>;

/// Asks any number of nodes; the endpoints for each are made once, when they are first needed.
///
/// Questions to different nodes may be asked at the same time (`futures::future::join_all`), which
/// is many times faster than one after the other.
pub struct ParameterClient<'a> {
    session: &'a Session,
    node: NodeHandle,
    options: ClientOptions,
    endpoints: Mutex<BTreeMap<(String, Service, bool), Endpoint>>,
    at_once: Semaphore,
}

impl<'a> ParameterClient<'a> {
    /// A client in the name of one of the session's nodes.
    pub fn new(session: &'a Session, node: &NodeHandle, options: ClientOptions) -> Self {
        let (node, at_once) = (node.clone(), Semaphore::new(AT_ONCE));
        Self { session, node, options, endpoints: Mutex::default(), at_once }
    }

    /// The values of parameters of a node, such as `/robot_3/controller`, in the order of their
    /// names.
    pub async fn get(
        &self,
        node: &str,
        names: &[&str],
    ) -> Result<Vec<ParameterValue>, ParameterClientError> {
        let values = self.get_known(node, names).await?;
        let missing = |name: &str| ParameterClientError::NoSuchParameter {
            node: node.to_owned(),
            name: name.to_owned(),
        };
        values
            .into_iter()
            .zip(names)
            .map(|(value, name)| value.ok_or_else(|| missing(name)))
            .collect()
    }

    /// The values of those parameters that a node has, in the order of their names; `None` for one that
    /// it has not.
    ///
    /// # Errors
    ///
    /// [`ParameterClientError::Count`] among others, because some nodes answer nothing at all if
    /// they lack one of them.
    pub async fn get_known(
        &self,
        node: &str,
        names: &[&str],
    ) -> Result<Vec<Option<ParameterValue>>, ParameterClientError> {
        let request = wire::GetParametersRequest { names: owned(names) };
        let response: wire::GetParametersResponse = self.call(node, Service::Get, &request).await?;
        check_count(node, response.values.len(), names.len())?;
        Ok(response.values.into_iter().map(ParameterValue::from_wire).collect())
    }

    /// Whether a node that offers its parameters is discovered.
    pub fn is_offered_by(&self, node: &str) -> bool {
        self.mapping_of(node, Service::Get).is_some()
    }

    /// Sets all parameters or none.
    ///
    /// If an answer is lost, the request is repeated; setting the same values twice does no harm.
    ///
    /// # Errors
    ///
    /// [`ParameterClientError::Refused`] among others, with the node's reason.
    pub async fn set_atomically(
        &self,
        node: &str,
        values: &[(String, ParameterValue)],
    ) -> Result<(), ParameterClientError> {
        let parameter = |(name, value): &(String, ParameterValue)| wire::Parameter {
            name: name.clone(),
            value: value.to_wire(),
        };
        let parameters = values.iter().map(parameter).collect();
        let request = wire::SetParametersAtomicallyRequest { parameters };
        let response: wire::SetParametersAtomicallyResponse =
            self.call(node, Service::SetAtomically, &request).await?;
        if response.result.successful {
            return Ok(());
        }
        let reason = response.result.reason;
        Err(ParameterClientError::Refused { node: node.to_owned(), reason })
    }

    /// The names of all parameters, in the order of the node.
    pub async fn list(&self, node: &str) -> Result<Vec<String>, ParameterClientError> {
        let request = wire::ListParametersRequest::default();
        let response: wire::ListParametersResponse =
            self.call(node, Service::List, &request).await?;
        Ok(response.result.names)
    }

    /// What parameters mean, in the order of their names.
    pub async fn describe(
        &self,
        node: &str,
        names: &[&str],
    ) -> Result<Vec<wire::ParameterDescriptor>, ParameterClientError> {
        let request = wire::DescribeParametersRequest { names: owned(names) };
        let response: wire::DescribeParametersResponse =
            self.call(node, Service::Describe, &request).await?;
        check_count(node, response.descriptors.len(), names.len())?;
        Ok(response.descriptors)
    }

    async fn call<Q: RosMessage, R: RosMessage>(
        &self,
        node: &str,
        service: Service,
        request: &Q,
    ) -> Result<R, ParameterClientError> {
        let start = Instant::now();
        let deadline = start + self.options.timeout;
        let no_answer = |tries| ParameterClientError::NoAnswer {
            node: node.to_owned(),
            waited_s: start.elapsed().as_secs_f64(),
            tries,
        };
        let mapping = self.wait_for(node, service, deadline).await.ok_or_else(|| no_answer(0))?;
        let endpoint = self.endpoint(node, service, mapping)?;
        let client = endpoint.lock().await;

        let request = Bytes(cdr::encode_body(request));
        let mut wait = FIRST_TRY;
        let mut tries = 0;
        while Instant::now() < deadline {
            let turn = self.at_once.acquire().await;
            let _turn = turn.expect("the semaphore is never closed");
            tries += 1;
            let wait_now = wait.min(deadline.saturating_duration_since(Instant::now()));
            let answer = tokio::time::timeout(wait_now, client.async_call_service(request.clone()));
            match answer.await {
                Ok(Ok(Bytes(body))) => {
                    return cdr::decode_body(&body, ByteOrder::Little).map_err(|source| {
                        ParameterClientError::Reply { node: node.to_owned(), source }
                    });
                }
                Ok(Err(error)) => return Err(SessionError::endpoint(node, &error).into()),
                Err(_) => wait *= 2,
            }
        }
        Err(no_answer(tries))
    }

    /// Waits until a node offers a service, and returns how to request it.
    async fn wait_for(&self, node: &str, service: Service, deadline: Instant) -> Option<Mapping> {
        loop {
            if let Some(mapping) = self.mapping_of(node, service) {
                return Some(mapping);
            }
            if Instant::now() >= deadline {
                return None;
            }
            tokio::time::sleep(POLL).await;
        }
    }

    /// How to request a service of a node; `None` if it is not discovered.
    fn mapping_of(&self, node: &str, service: Service) -> Option<Mapping> {
        let name = service.name();
        let vendor = self.session.vendor_of_writer(&format!("rr{node}/{name}Reply"))?;
        let is_received = self.session.has_reader(&format!("rq{node}/{name}Request"));
        is_received.then(|| self.options.mapping.unwrap_or(Mapping::of_vendor(vendor)))
    }

    fn endpoint(
        &self,
        node: &str,
        service: Service,
        mapping: Mapping,
    ) -> Result<Endpoint, SessionError> {
        let key = (node.to_owned(), service, mapping == Mapping::Cyclone);
        let mut endpoints = lock(&self.endpoints);
        if let Some(endpoint) = endpoints.get(&key) {
            return Ok(Arc::clone(endpoint));
        }
        let name = format!("{node}/{}", service.name());
        let client = raw::client(self.session, &self.node, &name, &service.ros_type(), mapping)?;
        let endpoint = Arc::new(tokio::sync::Mutex::new(client));
        endpoints.insert(key, Arc::clone(&endpoint));
        Ok(endpoint)
    }
}

fn owned(names: &[&str]) -> Vec<String> {
    names.iter().map(|&name| name.to_owned()).collect()
}

fn check_count(node: &str, found: usize, expected: usize) -> Result<(), ParameterClientError> {
    if found == expected {
        Ok(())
    } else {
        Err(ParameterClientError::Count { node: node.to_owned(), found, expected })
    }
}
