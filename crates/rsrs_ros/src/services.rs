//! Services of any type, each request answered in the mapping of its client; and a client.

pub(crate) mod mapping;
pub(crate) mod raw;

use std::marker::PhantomData;
use std::time::{Duration, Instant};

use ros2_client::ServiceTypeName;
use rsrs_msgs::RosMessage;
use rsrs_msgs::cdr::{self, ByteOrder, CdrError};
use tokio::sync::oneshot;

use crate::session::{Bytes, NodeHandle, POLL, Session, SessionError, Task};
pub use mapping::Mapping;
use raw::RawClient;

/// A service that is offered until this is dropped or the session is closed.
pub struct Service {
    _task: Task,
}

/// Answers one request, whose client waits.
#[derive(Debug)]
pub struct Responder<R>(oneshot::Sender<R>);

impl<R> Responder<R> {
    /// Answers. Who asks next waits until this is done.
    pub fn send(self, answer: R) {
        if self.0.send(answer).is_err() {
            log::debug!("an answer is not sent any more");
        }
    }
}

/// Understands the body of a request of this type.
pub fn decode<Q: RosMessage>(body: &[u8]) -> Option<Q> {
    cdr::decode_body(body, ByteOrder::Little).ok()
}

/// Offers a service of a node, with a name below the node's, such as `step_simulation`.
///
/// Every request is answered unless `deliver`, which must not block, drops its responder; then the
/// client waits in vain. A request that `decode` does not understand, as of another version of the
/// service, is answered with the default of the response, which by its type means that it was refused.
///
/// # Panics
///
/// If the request is not of a type called `package/srv/Name_Request`: then it is none.
pub fn offer<Q: RosMessage, R: RosMessage + Default>(
    session: &Session,
    node: &NodeHandle,
    name: &str,
    decode: impl Fn(&[u8]) -> Option<Q> + Send + 'static,
    mut deliver: impl FnMut(Q, Responder<R>) + Send + 'static,
) -> Result<Service, SessionError> {
    let service = format!("{}/{name}", node.full_name());
    let server = raw::server(session, node, &service, &type_name::<Q>())?;
    let refusal = || Some(cdr::encode_body(&R::default()));
    let answer = move |request| {
        let (sender, answer) = oneshot::channel();
        deliver(request, Responder(sender));
        async move { answer.await.ok().map(|answer: R| cdr::encode_body(&answer)) }
    };
    Ok(Service { _task: session.run(raw::answer_all(service, server, decode, refusal, answer)) })
}

fn type_name<Q: RosMessage>() -> ServiceTypeName {
    let (package, kind) = Q::TYPE_NAME
        .strip_suffix("_Request")
        .and_then(|name| name.split_once("/srv/"))
        .expect("only requests are asked, and their types are called package/srv/Name_Request");
    ServiceTypeName::new(package, kind)
}

/// Why a service gave no answer.
#[derive(Debug, thiserror::Error)]
pub enum CallError {
    /// It is not there, or does not answer.
    #[error("service `{service}` did not answer in {waited_s:.1} s")]
    NoAnswer {
        /// Full name of the service.
        service: String,
        /// How long it took to give up, in seconds.
        waited_s: f64,
    },
    /// The answer is not one.
    #[error("answer of service `{service}`")]
    Answer {
        /// Full name of the service.
        service: String,
        /// What is wrong with it.
        #[source]
        source: CdrError,
    },
    /// The question cannot be asked.
    #[error("service `{service}` cannot be asked")]
    Session {
        /// Full name of the service.
        service: String,
        /// Why not.
        #[source]
        source: SessionError,
    },
}

/// Asks one service; each question once, because not every service may be asked twice.
pub struct ServiceClient<'a, Q: RosMessage, R: RosMessage> {
    session: &'a Session,
    service: String,
    client: RawClient,
    answers: PhantomData<(Q, R)>,
}

impl<'a, Q: RosMessage, R: RosMessage> ServiceClient<'a, Q, R> {
    /// A client in the name of one of the session's nodes, for a service such as
    /// `/simulator/step_simulation`.
    ///
    /// # Panics
    ///
    /// As [`offer`].
    pub fn new(
        session: &'a Session,
        node: &NodeHandle,
        service: &str,
        mapping: Mapping,
    ) -> Result<Self, SessionError> {
        let client = raw::client(session, node, service, &type_name::<Q>(), mapping)?;
        Ok(Self { session, service: service.to_owned(), client, answers: PhantomData })
    }

    /// Asks, and waits for the answer.
    pub async fn call(&self, request: &Q, timeout: Duration) -> Result<R, CallError> {
        let start = Instant::now();
        let service = || self.service.clone();
        let no_answer =
            || CallError::NoAnswer { service: service(), waited_s: start.elapsed().as_secs_f64() };
        let topic = format!("rq{}Request", self.service);
        while !self.session.has_reader(&topic) {
            if start.elapsed() >= timeout {
                return Err(no_answer());
            }
            tokio::time::sleep(POLL).await;
        }
        // The service may discover us later than we discover it.
        tokio::time::sleep(MATCHING).await;
        let request = Bytes(cdr::encode_body(request));
        let left = timeout.saturating_sub(start.elapsed());
        let called = tokio::time::timeout(left, self.client.async_call_service(request)).await;
        let Ok(called) = called else { return Err(no_answer()) };
        let Bytes(body) = called.map_err(|error| CallError::Session {
            service: service(),
            source: SessionError::endpoint(&self.service, &error),
        })?;
        cdr::decode_body(&body, ByteOrder::Little)
            .map_err(|source| CallError::Answer { service: service(), source })
    }
}

/// Time in which the other side of a new connection learns of it.
const MATCHING: Duration = Duration::from_millis(200);
