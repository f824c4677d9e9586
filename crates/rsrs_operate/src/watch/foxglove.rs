//! All topics of a fleet, or of a bag, for Foxglove and Lichtblick: a WebSocket server on this
//! machine, so that nobody needs a bridge or ROS.
//!
//! It publishes nothing and takes no message of a client but for which topics it wants. Foxglove's own
//! crate is not used: its servers are not understood by Lichtblick, which asks for the older name of
//! the protocol.

mod client;
mod hub;
mod protocol;

use std::collections::BTreeSet;
use std::net::{SocketAddr, TcpListener};
use std::path::Path;
use std::sync::Arc;
use std::time::{Duration, Instant};

use anyhow::Context;
use rsrs_bags::{Bag, BagError};
use rsrs_files::quoted;
use rsrs_msgs::schema::schema_text;
use rsrs_msgs::topics::{Durability, Qos, Reliability};
use rsrs_pipeline::error::with_help;
use rsrs_pipeline::recorded_run;
use rsrs_ros::parameters::ParameterServer;
use rsrs_ros::runtime::beat;
use rsrs_ros::session::{
    Endpoint, EndpointKind, Session, SessionError, SessionOptions, Subscription,
};

use hub::Hub;

/// Where Foxglove looks first; nobody on another machine can reach it.
pub const DEFAULT_ADDRESS: &str = "127.0.0.1:8765";
/// How often the discovery database is looked at.
const LOOK: Duration = Duration::from_millis(250);
/// Samples that are kept for a subscription that is not looked at for a moment.
const DEPTH: u32 = 100;
/// How often a client is given the time of a recording, at most.
const CLOCK_PERIOD: Duration = Duration::from_millis(50);
/// How long the last messages of a recording have to reach a client.
const LINGER: Duration = Duration::from_secs(1);

/// An address on which clients may connect from now on.
pub struct Listener(TcpListener);

impl Listener {
    /// Listens at an address of this machine that nobody has yet.
    pub fn bind(address: SocketAddr) -> anyhow::Result<Self> {
        let listener = TcpListener::bind(address).map_err(|error| {
            let help = "end the other program, or name another port: `--foxglove 127.0.0.1:8766`";
            with_help(format!("cannot listen on {address}: {error}"), help)
        })?;
        listener.set_nonblocking(true).context("listening")?;
        Ok(Self(listener))
    }

    /// Where it listens.
    pub fn address(&self) -> anyhow::Result<SocketAddr> {
        self.0.local_addr().context("listening")
    }

    /// Serves clients for as long as it is polled.
    async fn serve(self, hub: Arc<Hub>) -> anyhow::Result<()> {
        let listener = tokio::net::TcpListener::from_std(self.0).context("listening")?;
        loop {
            match listener.accept().await {
                Ok((stream, _)) => {
                    tokio::spawn(client::serve(stream, Arc::clone(&hub)));
                }
                // A client that has gone again, or too many of them.
                Err(error) => {
                    log::warn!("a client is not served: {error}");
                    tokio::time::sleep(LOOK).await;
                }
            }
        }
    }
}

/// Serves the topics of a fleet that runs, until `stop` completes.
///
/// Topics of types that are not known here are left out, because their definition cannot be given.
pub async fn serve_fleet(
    network: &SessionOptions,
    listener: Listener,
    stop: impl Future<Output = ()>,
) -> anyhow::Result<()> {
    let session = Session::open(network)?;
    let hub = Arc::new(Hub::new("rsrs watch", &[]));
    let served = tokio::select! {
        () = stop => Ok(()),
        served = listener.serve(Arc::clone(&hub)) => served,
        looked = look_around(&session, &hub) => looked,
        ended = session.ended() => Err(ended.into()),
    };
    session.close().await;
    served
}

/// Topics that are served, at most: a fleet of a hundred robots has some 2,000.
const MOST_TOPICS: usize = 20_000;

/// Subscribes every topic that appears; never ends but by an error.
async fn look_around(session: &Session, hub: &Arc<Hub>) -> anyhow::Result<()> {
    let node = session.node("/", "rsrs_watch")?;
    let _parameters = ParameterServer::without_parameters(session, &node)?;
    let mut seen = BTreeSet::new();
    let mut subscriptions = Vec::new();
    let mut look = beat(LOOK);
    loop {
        look.tick().await;
        for end in session.endpoints() {
            // Any node in the network may publish under any name, and under any number of them.
            let is_new = seen.len() < MOST_TOPICS && !seen.contains(&end.topic);
            if end.kind == EndpointKind::Writer && is_new {
                seen.insert(end.topic.clone());
                match subscribe(session, hub, end) {
                    Err(error @ SessionError::Name { .. }) => log::warn!("left out: {error}"),
                    subscription => subscriptions.extend(subscription?),
                }
            }
        }
    }
}

/// Subscribes as who only looks: best effort, but for what is latched.
fn subscribe(
    session: &Session,
    hub: &Arc<Hub>,
    end: Endpoint,
) -> Result<Option<Subscription>, SessionError> {
    let Endpoint { topic, type_name, qos, .. } = end;
    let Some(schema) = schema_text(&type_name) else {
        log::info!("{topic} is left out: {type_name} is not known");
        return Ok(None);
    };
    let is_latched = qos.durability == Durability::TransientLocal;
    let qos = if is_latched {
        Qos { reliability: Reliability::Reliable, depth: DEPTH, ..qos }
    } else {
        Qos::best_effort(DEPTH)
    };
    let channel = hub.advertise(&topic, &type_name, schema);
    let hub = Arc::clone(hub);
    let subscription = session.subscribe_raw(&topic, &type_name, qos, move |sample| {
        let time_ns = sample.received_time_ns;
        if is_latched {
            hub.publish_latched(channel, time_ns, &sample.message);
        } else {
            hub.publish(channel, time_ns, &sample.message);
        }
    });
    Ok(Some(subscription?))
}

/// Plays a bag at its recorded pace, once, from when the first client wants a topic of it; ends a moment
/// after its end, or when `stop` completes.
pub async fn serve_bag(
    path: &Path,
    listener: Listener,
    stop: impl Future<Output = ()>,
) -> anyhow::Result<()> {
    let bag = recorded_run::open_damaged(path)?;
    let hub = Arc::new(Hub::new("rsrs watch", &["time"]));
    tokio::select! {
        () = stop => Ok(()),
        served = listener.serve(Arc::clone(&hub)) => served,
        played = play(&bag, &hub) => played,
    }
}

async fn play(bag: &Bag, hub: &Hub) -> anyhow::Result<()> {
    let mut channels = std::collections::BTreeMap::new();
    for topic in bag.topics() {
        let schema = bag.schema(&topic.type_name).map(String::from_utf8_lossy);
        if let Some(schema) = schema.filter(|_| topic.encoding == "cdr") {
            let channel = hub.advertise(&topic.name, &topic.type_name, schema.into_owned());
            channels.insert(topic.name, channel);
        }
    }
    if channels.is_empty() {
        return Err(with_help(
            format!("{}: no topic of ROS 2 is in it", bag.path().display()),
            format!("`rsrs bag info {}` lists what is", quoted(bag.path())),
        ));
    }
    hub.wanted().await;
    let mut anchor = None;
    let mut clock = Instant::now();
    for message in bag.messages_on(channels.keys().cloned().collect::<Vec<_>>()) {
        let message = match message {
            Err(BagError::Incomplete { .. }) => continue,
            message => message?,
        };
        let time_ns = message.log_time_ns;
        let (first_ns, start) = *anchor.get_or_insert((time_ns, Instant::now()));
        let due = start + Duration::from_nanos(time_ns.saturating_sub(first_ns));
        if due > Instant::now() {
            tokio::time::sleep_until(due.into()).await;
        }
        if clock.elapsed() >= CLOCK_PERIOD {
            clock = Instant::now();
            hub.publish_time(time_ns);
            // Clients are served meanwhile, however many messages are due at once.
            tokio::task::yield_now().await;
        }
        hub.publish(channels[&*message.topic], time_ns, &message.bytes);
    }
    tokio::time::sleep(LINGER).await;
    Ok(())
}
