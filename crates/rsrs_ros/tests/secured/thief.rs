//! A thief with the enclave of a robot, who sends in the name of others with the keys that they have sent it.

use std::net::{Ipv4Addr, UdpSocket};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use rsrs_msgs::topics::{self, Topic};
use rsrs_ros::interfaces::LOOPBACK;
use rsrs_ros::session::{ReceivedRaw, Session, Subscription};
use rsrs_testing::network::{TIMEOUT, eventually};

use crate::lab::{DOMAIN, Inbox, Lab, close, if_started, subscribe};
use crate::stolen_keys::{StolenKey, in_own_memory};
use crate::{forgery, sealed};

/// Participants of one machine whose ports are tried.
const N_PORTS: u16 = 12;
/// The numbers that forged samples have, after the last genuine one.
const N_FORGED: u64 = 40;
/// What no publisher of ours sends, and what all of them send here.
const FORGED: [u8; 8] = *b"forged!!";
const GENUINE: [u8; 8] = *b"genuine!";
/// Who announces publishers, and to whom it does (7.4.5).
const ANNOUNCER: [u8; 4] = [0xff, 0x00, 0x03, 0xc2];
const N_ANNOUNCED: u64 = 64;

/// What a thief forges, and who publishes it.
const TARGETS: [(Topic, &str); 3] = [
    (topics::LEASE, "/runner"),
    (topics::E_STOP, "/stop"),
    (topics::CMD_VEL_UNSTAMPED, "/controllers"),
];

/// What became of a thief's datagrams.
#[derive(Debug, PartialEq, Eq)]
pub struct Theft {
    /// The topics of which a robot received what was forged.
    pub obeyed: Vec<&'static str>,
    /// Whether the robot still receives the genuine ones.
    pub hears: bool,
}

/// A thief with the enclave of robot 1 forges what robot 2 is to receive.
pub async fn steal(lab: &Lab) -> Theft {
    let robot = lab.member("/robot_2");
    let mut received = Vec::new();
    let mut publishers = Vec::new();
    let mut members = Vec::new();
    for (topic, member) in TARGETS {
        let name = topic.for_robot("robot_2");
        received.push(subscribe(&robot, &name, topic.type_name, topic.qos));
        let member = lab.member(member);
        publishers
            .push(member.publish_raw(&name, topic.type_name, topic.qos).expect("it is allowed"));
        members.push(member);
    }
    let genuine = [&[0, 1, 0, 0][..], &GENUINE].concat();
    let count = |of: [u8; 8]| -> Vec<usize> {
        let of_topic = |inbox: &Inbox| {
            let samples = inbox.lock().expect("nobody panicked with it");
            samples.iter().filter(|sample| sample.ends_with(&of)).count()
        };
        received.iter().map(of_topic).collect()
    };
    let mut thief = lab.start("is_a_thief_if_started");
    let start = Instant::now();
    let ended = loop {
        assert!(start.elapsed() < TIMEOUT, "the thief does not end");
        for publisher in &publishers {
            publisher.publish(&genuine).await.expect("a healthy network");
        }
        tokio::time::sleep(Duration::from_millis(50)).await;
        if let Some(ended) = thief.try_wait().expect("it is our child") {
            break ended;
        }
    };
    assert!(ended.success(), "the thief found no keys");

    let forged = count(FORGED).into_iter();
    let obeyed = forged.zip(TARGETS).filter(|(n, _)| *n > 0).map(|(_, (topic, _))| topic.name);
    let obeyed = obeyed.collect();
    let before = count(GENUINE);
    let start = Instant::now();
    let mut hears = false;
    while !hears && start.elapsed() < Duration::from_secs(4) {
        for publisher in &publishers {
            publisher.publish(&genuine).await.expect("a healthy network");
        }
        tokio::time::sleep(Duration::from_millis(50)).await;
        hears = before.iter().zip(count(GENUINE)).all(|(before, now)| now > *before);
    }
    drop((publishers, received));
    close(members.into_iter().chain([robot])).await;
    Theft { obeyed, hears }
}

/// Forges, if this process was started for that.
pub fn steal_if_started() {
    if_started(async |session| {
        for (topic, member) in TARGETS {
            let Some(overheard) = Overheard::new(&session, topic).await else { continue };
            let keys = in_own_memory();
            // That has taken a while, in which the genuine samples have gone on.
            tokio::time::sleep(Duration::from_millis(100)).await;
            let (writer, sequence) = overheard.last();
            let participant = *writer.first_chunk().expect("12 bytes of 16");
            let of_member = keys.of_participants.get(&participant);
            let of_participant =
                of_member.unwrap_or_else(|| panic!("no key of {member}: {keys:?}"));
            let of_writer = keys.of_writers.get(&writer).expect("what arrives can be read");
            let thief = Thief { participant, of_participant, number: 0 };
            thief.forge(writer, sequence, of_writer);
            let mut announcer = writer;
            announcer[12..].copy_from_slice(&ANNOUNCER);
            let of_announcer = keys.of_writers.get(&announcer).expect("it was announced");
            let thief = Thief { participant, of_participant, number: 1 << 32 };
            thief.take_away(writer, announcer, of_announcer);
        }
        session.close().await;
    });
}

/// The GUID of a publisher, and the number of a sample.
type Sample = ([u8; 16], u64);

/// A topic that a thief receives.
struct Overheard {
    last: Arc<Mutex<Option<Sample>>>,
    _subscription: Subscription,
}

impl Overheard {
    /// Once a sample has come; nothing if this member may not receive the topic.
    async fn new(session: &Session, topic: Topic) -> Option<Self> {
        let name = topic.for_robot("robot_2");
        let last = Arc::new(Mutex::new(None));
        let heard = Arc::clone(&last);
        let deliver = move |sample: ReceivedRaw| {
            *heard.lock().expect("nobody panicked") = Some((sample.writer, sample.sequence));
        };
        let subscription =
            session.subscribe_raw(&name, topic.type_name, topic.qos, deliver).ok()?;
        let is_heard = || last.lock().expect("nobody panicked").is_some();
        eventually("a sample is overheard", is_heard).await;
        Some(Self { last, _subscription: subscription })
    }

    /// The publisher, and the number of its last sample.
    fn last(&self) -> Sample {
        self.last.lock().expect("nobody panicked").expect("one has come")
    }
}

/// Who sends in the name of another participant.
struct Thief<'a> {
    participant: [u8; 12],
    of_participant: &'a StolenKey,
    /// What the numbers of its datagrams begin after.
    number: u64,
}

impl Thief<'_> {
    /// Samples in the name of a publisher: encrypted with its key, and plain within a signed datagram.
    fn forge(&self, writer: [u8; 16], sequence: u64, key: &StolenKey) {
        for number in 1..=N_FORGED {
            let sample = forgery::sample(writer, sequence + number, &FORGED);
            self.send(2 * number, &sealed::encrypted(&sample, key, self.number + 2 * number));
            self.send(2 * number + 1, &sample);
        }
    }

    /// What a member announces when it takes a publisher away.
    fn take_away(&self, writer: [u8; 16], announcer: [u8; 16], key: &StolenKey) {
        for number in 1..=N_ANNOUNCED {
            let disposal = disposal(writer, announcer, number);
            self.send(number, &sealed::encrypted(&disposal, key, self.number + number));
        }
    }

    fn send(&self, number: u64, submessages: &[u8]) {
        let socket = UdpSocket::bind((Ipv4Addr::LOCALHOST, 0)).expect("a healthy network");
        let number = self.number + number;
        let datagram = sealed::signed(self.participant, submessages, self.of_participant, number);
        for participant in 0..N_PORTS {
            // RTPS 9.6.2.4: where a participant receives announcements, and what its subscribers are sent.
            for offset in [10, 11] {
                let port = 7400 + 250 * DOMAIN + offset + 2 * participant;
                // Nobody may be there.
                socket.send_to(&datagram, (LOOPBACK, port)).ok();
            }
        }
        // A socket's buffer is finite.
        std::thread::sleep(Duration::from_millis(10));
    }
}

/// RTPS 2.3: DATA without data, by which a publisher is no more.
fn disposal(writer: [u8; 16], announcer: [u8; 16], sequence: u64) -> Vec<u8> {
    let mut data = vec![0, 0, 16, 0];
    data.extend_from_slice(&[0xff, 0x00, 0x03, 0xc7]);
    data.extend_from_slice(&announcer[12..]);
    data.extend_from_slice(&[0; 4]);
    data.extend_from_slice(&u32::try_from(sequence).expect("a small number").to_le_bytes());
    // PID_STATUS_INFO: disposed and unregistered; PID_SENTINEL.
    data.extend_from_slice(&[0x71, 0, 4, 0, 0, 0, 0, 3, 1, 0, 0, 0]);
    // PL_CDR_LE; PID_ENDPOINT_GUID; PID_SENTINEL.
    data.extend_from_slice(&[0, 3, 0, 0, 0x5a, 0, 16, 0]);
    data.extend_from_slice(&writer);
    data.extend_from_slice(&[1, 0, 0, 0]);
    // DATA, with the flags "little-endian", "has inline QoS" and "has key".
    forgery::submessage(0x0b, &data)
}
