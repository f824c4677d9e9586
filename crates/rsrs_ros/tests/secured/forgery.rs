//! A datagram that looks as if it came from somebody else.

use std::net::{Ipv4Addr, UdpSocket};
use std::sync::{Arc, Mutex};
use std::time::Duration;

use rsrs_msgs::topics;
use rsrs_ros::interfaces::LOOPBACK;
use rsrs_ros::session::{ReceivedRaw, Session};
use rsrs_testing::network::{TIMEOUT, eventually};

use crate::lab::DOMAIN;

/// What no runner sends.
const FORGED: [u8; 8] = *b"forged!!";
/// Participants of one machine whose ports are tried.
const N_PORTS: u16 = 16;
/// How many datagrams are sent, and the pause between them.
const N_FORGED: u64 = 40;
const PAUSE: Duration = Duration::from_millis(50);

/// Whether a robot receives a lease that somebody made up in the name of the runner's publisher, whose
/// identity everybody on the network sees.
pub async fn is_obeyed(runner: Session, robot: Session) -> bool {
    let topic = topics::LEASE;
    let publisher =
        runner.publish_raw(topic.name, topic.type_name, topic.qos).expect("a healthy network");
    let samples = Arc::new(Mutex::new(Vec::<ReceivedRaw>::new()));
    let received = Arc::clone(&samples);
    let deliver = move |sample| received.lock().expect("nobody panicked with it").push(sample);
    let subscription = robot
        .subscribe_raw(topic.name, topic.type_name, topic.qos, deliver)
        .expect("a healthy network");
    robot.wait_for_writers(topic.name, 1, TIMEOUT).await.expect("a healthy network");
    let mut writer = None;
    while writer.is_none() {
        publisher
            .publish(&[&[0, 1, 0, 0][..], b"genuine!"].concat())
            .await
            .expect("a healthy network");
        tokio::time::sleep(PAUSE).await;
        writer = samples
            .lock()
            .expect("nobody panicked with it")
            .last()
            .map(|sample| (sample.writer, sample.sequence));
    }
    let (writer, sequence) = writer.expect("the loop has just ended");

    let socket = UdpSocket::bind((Ipv4Addr::LOCALHOST, 0)).expect("a healthy network");
    for number in 0..N_FORGED {
        let datagram = datagram(writer, sequence + 100 + number);
        for participant in 0..N_PORTS {
            // RTPS 9.6.2.4: where a participant receives what its subscribers are sent.
            let port = 7400 + 250 * DOMAIN + 11 + 2 * participant;
            // Nobody may be there.
            socket.send_to(&datagram, (LOOPBACK, port)).ok();
        }
        tokio::time::sleep(PAUSE).await;
    }
    // The genuine one is still received, so the robot was not deaf meanwhile.
    let n_genuine = || {
        let samples = samples.lock().expect("nobody panicked with it");
        samples.iter().filter(|sample| sample.message.ends_with(b"genuine!")).count()
    };
    let (before, is_obeyed) = (n_genuine(), is_among(&samples));
    if !is_obeyed {
        publisher
            .publish(&[&[0, 1, 0, 0][..], b"genuine!"].concat())
            .await
            .expect("a healthy network");
        eventually("a genuine lease is received", || n_genuine() > before).await;
    }

    drop((publisher, subscription));
    runner.close().await;
    robot.close().await;
    is_obeyed
}

fn is_among(samples: &Mutex<Vec<ReceivedRaw>>) -> bool {
    samples
        .lock()
        .expect("nobody panicked with it")
        .iter()
        .any(|sample| sample.message.ends_with(&FORGED))
}

/// RTPS 2.3 with one sample.
fn datagram(writer: [u8; 16], sequence: u64) -> Vec<u8> {
    let header = [b"RTPS\x02\x03\x01\x12", &writer[..12]].concat();
    [header, sample(writer, sequence, &FORGED)].concat()
}

/// RTPS 2.3: DATA with a message, from a publisher to whoever subscribes.
pub fn sample(writer: [u8; 16], sequence: u64, message: &[u8]) -> Vec<u8> {
    let mut data = vec![0, 0, 16, 0];
    data.extend_from_slice(&[0; 4]);
    data.extend_from_slice(&writer[12..]);
    data.extend_from_slice(&[0; 4]);
    data.extend_from_slice(&u32::try_from(sequence).expect("a small number").to_le_bytes());
    data.extend_from_slice(&[0, 1, 0, 0]);
    data.extend_from_slice(message);
    // With the flags "little-endian" and "has data".
    submessage(0x05, &data)
}

/// A DATA submessage with these flags, of which one is "little-endian".
pub fn submessage(flags: u8, data: &[u8]) -> Vec<u8> {
    let [low, high] = u16::try_from(data.len()).expect("it is short").to_le_bytes();
    [&[0x15, flags, low, high], data].concat()
}
