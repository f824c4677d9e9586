//! What can go wrong in a session.

use std::net::IpAddr;

use super::{EndpointKind, HANDSHAKE_TIMEOUT};

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
    /// A thread of the middleware has ended, although the session is open.
    #[error(
        "the middleware has ended ({found} of its {expected} threads run), as it does when a process \
         is stopped (Ctrl-Z, SIGSTOP) and continued: nothing is sent or received any more; start this \
         program again"
    )]
    Middleware {
        /// Threads that still run.
        found: usize,
        /// Threads that it started.
        expected: usize,
    },
    /// A subscription takes nothing any more although nobody has ended it; it may be the one to stops.
    #[error("`{topic}` is not received any more: {reason}")]
    Subscription {
        /// The topic, absolute.
        topic: String,
        /// Why.
        reason: String,
    },
    /// This participant was out of reach of others for longer than their leases, and they are back.
    #[error(
        "{returned} of {known} other participants were out of reach for longer than their leases, and \
         the middleware does not match their topics again: start this program again"
    )]
    OutOfReach {
        /// Participants that were lost, and are back.
        returned: usize,
        /// These, and those that were there all the time.
        known: usize,
    },
    /// This participant received nothing of its own for longer than its lease, and dropped itself.
    ///
    /// Each participant discovers itself, too. With its interface down for that long it drops its own keys
    /// in a secured session, and then nobody can authenticate with it any more. A plain session goes on.
    #[error(
        "the network interface was down for longer than the leases of DDS, after which a secured \
         participant does not join again: start this program again"
    )]
    OwnLeaseExpired,
    /// An interface of this participant has another address than at the start.
    #[error(
        "the network interface {interface} had {before} and has {now} now, and the middleware receives \
         at the old address only: start this program again"
    )]
    AddressChanged {
        /// Its name.
        interface: String,
        /// Its address when this participant was started.
        before: IpAddr,
        /// One that it has now.
        now: IpAddr,
    },
    /// Nobody in a secured network authenticated this participant in time.
    #[error(
        "no handshake with any of {n_others} other participants was completed within {} s ({ids}): \
         start this program again, a second apart from others",
        HANDSHAKE_TIMEOUT.as_secs()
    )]
    NotAuthenticated {
        /// How many were tried.
        n_others: usize,
        /// Their identities in DDS, in hexadecimal digits.
        ids: String,
    },
}
