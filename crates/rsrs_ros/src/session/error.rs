//! What can go wrong in a session.

use super::{
    AddressChanged, EndpointKind, MiddlewareEnded, NotAuthenticated, OutOfReach, OwnLeaseExpired,
    SubscriptionEnded,
};

/// Why there is no session, node or endpoint.
#[derive(Debug, thiserror::Error)]
pub enum SessionError {
    /// No interface was given; an empty list would mean all of them.
    #[error("a session needs at least one network interface, found none")]
    NoInterface,
    /// There is nothing to run the subscriptions.
    #[error("a session needs a tokio runtime to run in")]
    NoRuntime {
        /// The runtime's error.
        #[source]
        source: tokio::runtime::TryCurrentError,
    },
    /// The network cannot be joined.
    #[error("cannot join domain {domain_id}: {reason}")]
    Join {
        /// Which `ROS_DOMAIN_ID`.
        domain_id: u16,
        /// The middleware's error.
        reason: String,
    },
    /// This program was built without what an enclave needs.
    #[error("enclave `{enclave}` cannot be used: this program was built without DDS Security")]
    NotSecured {
        /// Its name.
        enclave: String,
    },
    /// The middleware's threads cannot be watched.
    #[error("the threads of this process cannot be listed")]
    Threads {
        /// The kernel's error.
        #[source]
        source: std::io::Error,
    },
    /// ROS 2 does not allow this name.
    #[error("`{name}` is no ROS 2 name: {reason}")]
    Name {
        /// The name of a node, topic or type.
        name: String,
        /// Which rule it breaks.
        reason: String,
    },
    /// A node handle of another session.
    #[error("node `{name}` belongs to another session")]
    ForeignNode {
        /// Its full name.
        name: String,
    },
    /// The middleware does not make an endpoint or node.
    #[error("cannot create `{name}`: {reason}")]
    Endpoint {
        /// The topic, service or node.
        name: String,
        /// The middleware's error.
        reason: String,
    },
}

impl SessionError {
    pub(crate) fn endpoint(name: &str, error: &impl ToString) -> Self {
        Self::Endpoint { name: name.to_owned(), reason: error.to_string() }
    }
}

/// Not enough publishers or subscribers of a topic appeared in time.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("topic `{topic}` has {found} {kind}s after {waited_s:.1} s, expected at least {wanted}")]
pub struct NotMatched {
    /// The topic, absolute.
    pub topic: String,
    /// What was waited for.
    pub kind: EndpointKind,
    /// How many there are.
    pub found: usize,
    /// How many there should be.
    pub wanted: usize,
    /// How long it took to give up, in seconds.
    pub waited_s: f64,
}

/// Why a sample was not sent.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum PublishError {
    /// A reliable subscriber acknowledges nothing, and no more samples can wait for it.
    #[error("topic `{topic}` has a subscriber that acknowledged nothing for {waited_s:.1} s")]
    Full {
        /// The topic, absolute.
        topic: String,
        /// How long it took to give up, in seconds.
        waited_s: f64,
    },
    /// Bytes that do not start as a bag's messages do.
    #[error("a raw sample for `{topic}` has encapsulation {found:02x?}, expected [00, 01, 00, 00]")]
    Encapsulation {
        /// The topic, absolute.
        topic: String,
        /// The first bytes, up to four.
        found: Vec<u8>,
    },
    /// The session is closed, or the middleware has failed.
    #[error("cannot publish on `{topic}`: {reason}")]
    Middleware {
        /// The topic, absolute.
        topic: String,
        /// The middleware's error.
        reason: String,
    },
}

/// Why nothing is sent or received any more.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum SessionEnded {
    /// The middleware has ended by itself.
    #[error(transparent)]
    Middleware(#[from] MiddlewareEnded),
    /// A subscription has ended by itself; it may be the one to stops.
    #[error(transparent)]
    Subscription(#[from] SubscriptionEnded),
    /// The others were out of reach for too long.
    #[error(transparent)]
    OutOfReach(#[from] OutOfReach),
    /// The interface of a secured participant was down for too long.
    #[error(transparent)]
    OwnLeaseExpired(#[from] OwnLeaseExpired),
    /// This participant's interface has another address.
    #[error(transparent)]
    AddressChanged(#[from] AddressChanged),
    /// The others of a secured network have not authenticated this participant.
    #[error(transparent)]
    NotAuthenticated(#[from] NotAuthenticated),
}
