//! Secured sessions over real DDS, each test with a keystore and in a network of its own.

mod controllers;
#[path = "secured/forgery.rs"]
mod forgery;
#[path = "secured/insider.rs"]
mod insider;
#[path = "secured/lab.rs"]
mod lab;
#[path = "secured/sealed.rs"]
mod sealed;
#[path = "secured/stolen_keys.rs"]
mod stolen_keys;
#[path = "secured/thief.rs"]
mod thief;

use std::time::{Duration, Instant};

use lab::{DOMAIN, Lab, subscribe};
use rsrs_core::help::Help;
use rsrs_msgs::RosMessage;
use rsrs_msgs::std_msgs::Bool;
use rsrs_msgs::topics::{self, Qos};
use rsrs_ros::parameters::{ClientOptions, ParameterClient, ParameterServer, ParameterValue};
use rsrs_ros::security::SecurityError;
use rsrs_ros::session::{Session, SessionError};
use rsrs_testing::network::{TIMEOUT, eventually, in_own_network, session};
use thief::Theft;

/// Long enough for a sample of somebody who is obeyed, and for the handshakes before it.
const A_WHILE: Duration = Duration::from_secs(4);

/// What is sent until something arrives; no other message here has its first byte.
const PROBE: [u8; 8] = [0, 1, 0, 0, 9, 9, 9, 9];

#[test]
fn secured_members_exchange_every_topic_of_ours_whatever_the_length() {
    in_own_network(
        "secured_members_exchange_every_topic_of_ours_whatever_the_length",
        async || {
            let lab = Lab::new();
            let viewer = lab.member("/viewer");
            let enclaves = ["/robot_1", "/simulator", "/runner", "/stop", "/tracker"];
            let members = enclaves.map(|enclave| lab.member(enclave));
            // The two types of commands share a name, and so do those of poses.
            let all = topics::ALL.iter().filter(|topic| {
                **topic != topics::CMD_VEL_UNSTAMPED
                    && **topic != topics::HARDWARE_CMD_VEL_UNSTAMPED
                    && **topic != topics::POSE_ARRAY
            });
            let mut open = Vec::new();
            for topic in all {
                // Further detections have the name of any reading.
                let name = topic.for_robot("robot_1").replace('*', "wall");
                let qos = Qos::reliable(100);
                let allowed = members.iter().find_map(|member| {
                    Some((member, member.publish_raw(&name, topic.type_name, qos).ok()?))
                });
                let allowed = allowed.unwrap_or_else(|| panic!("nobody may publish {name}"));
                let received = subscribe(&viewer, &name, topic.type_name, qos);
                open.push((name, allowed, received));
            }
            for (name, (member, publisher), received) in &open {
                viewer.wait_for_writers(name, 1, TIMEOUT).await.unwrap();
                member.wait_for_readers(name, 1, TIMEOUT).await.unwrap();
                let sent: Vec<Vec<u8>> = [1, 2, 3, 4, 5, 333, 100_000]
                    .map(|length| [&[0, 1, 0, 0][..], &vec![7; length]].concat())
                    .to_vec();
                // Two that have found each other may still lack a key, and what is sent meanwhile is lost.
                let start = Instant::now();
                while received.lock().unwrap().is_empty() {
                    assert!(start.elapsed() < TIMEOUT, "{name} brings nothing");
                    publisher.publish(&PROBE).await.unwrap();
                    tokio::time::sleep(Duration::from_millis(50)).await;
                }
                for bytes in &sent {
                    publisher.publish(bytes).await.unwrap();
                }
                let as_sent = || {
                    let received = received.lock().unwrap();
                    let is_probe = |got: &&Vec<u8>| got.starts_with(&PROBE);
                    let received: Vec<&Vec<u8>> =
                        received.iter().filter(|got| !is_probe(got)).collect();
                    let is_padded = |(got, sent): (&&Vec<u8>, &Vec<u8>)| {
                        got.starts_with(sent) && got.len() <= sent.len() + 3
                    };
                    received.len() == sent.len() && received.iter().zip(&sent).all(is_padded)
                };
                eventually(&format!("{name} brings every length"), as_sent).await;
            }
            drop(open);
            lab::close(members.into_iter().chain([viewer])).await;
        },
    );
}

#[test]
fn plain_programs_and_members_of_another_keystore_are_not_obeyed_and_receive_nothing() {
    let name = "plain_programs_and_members_of_another_keystore_are_not_obeyed_and_receive_nothing";
    in_own_network(name, async || {
        let (lab, other_lab) = (Lab::new(), Lab::new());
        let topic = topics::CMD_VEL_UNSTAMPED;
        let command = topic.for_robot("robot_1");
        let robot = lab.member("/robot_1");
        let obeyed = subscribe(&robot, &command, topic.type_name, topic.qos);
        // Its own controller is the control: what it sends arrives.
        let controllers = lab.member("/controllers");
        let strangers = [session(), other_lab.member("/controllers")];
        let publish =
            |session: &Session| session.publish_raw(&command, topic.type_name, topic.qos).unwrap();
        let of_strangers: Vec<_> = strangers.iter().map(publish).collect();
        let overheard: Vec<_> = strangers
            .iter()
            .map(|stranger| subscribe(stranger, &command, topic.type_name, topic.qos))
            .collect();
        let own = publish(&controllers);
        robot.wait_for_writers(&command, 1, TIMEOUT).await.unwrap();

        let start = Instant::now();
        let mut n_obeyed = 0;
        while n_obeyed == 0 || start.elapsed() < A_WHILE {
            own.publish(&[0, 1, 0, 0, 1]).await.unwrap();
            for publisher in &of_strangers {
                publisher.publish(&[0, 1, 0, 0, 66]).await.unwrap();
            }
            tokio::time::sleep(Duration::from_millis(50)).await;
            n_obeyed = obeyed.lock().unwrap().len();
            assert!(start.elapsed() < TIMEOUT, "not even its controller is obeyed");
        }

        let is_own = obeyed.lock().unwrap().iter().all(|bytes| bytes[4] == 1);
        assert!(is_own, "a stranger was obeyed");
        // The strangers receive themselves and each other's kind at most, never the member.
        for overheard in &overheard {
            let is_strange = overheard.lock().unwrap().iter().all(|bytes| bytes[4] == 66);
            assert!(is_strange, "a stranger received a member");
        }
        drop((of_strangers, own));
        lab::close(strangers.into_iter().chain([robot, controllers])).await;
    });
}

#[test]
fn whoever_asks_itself_for_no_permission_is_asked_by_the_others() {
    in_own_network("whoever_asks_itself_for_no_permission_is_asked_by_the_others", async || {
        let (n_own, n_stops) = insider::arrives(&Lab::new()).await;

        assert!(n_own > 0, "the control: what the permissions allow arrives");
        assert_eq!(n_stops, 0, "a robot stopped another one");
    });
}

#[test]
fn an_enclave_without_the_permission_publishes_nothing() {
    in_own_network("an_enclave_without_the_permission_publishes_nothing", async || {
        let lab = Lab::new();
        let robot = lab.member("/robot_2");

        for topic in ["/robot_1/cmd_vel", "/robot_1/detection", "/swarm/lease", "/swarm/e_stop"] {
            let refused = robot.publish_raw(topic, Bool::TYPE_NAME, Qos::reliable(1)).err();

            assert!(matches!(refused, Some(SessionError::Endpoint { .. })), "{topic}: {refused:?}");
        }
        let own = robot.publish_raw("/robot_2/detection", Bool::TYPE_NAME, Qos::reliable(1));
        assert!(own.is_ok());
        drop(own);
        lab::close([robot]).await;
    });
}

#[test]
fn permissions_that_were_changed_and_other_domains_are_refused() {
    in_own_network("permissions_that_were_changed_and_other_domains_are_refused", async || {
        let lab = Lab::new();

        let elsewhere = lab.enclave("/robot_1", DOMAIN + 1).unwrap_err();
        assert!(matches!(elsewhere, SecurityError::Enclave { .. }));
        assert!(elsewhere.to_string().contains("has no rule for domain 43"), "{elsewhere}");
        assert!(elsewhere.help().is_some_and(|help| help.contains("set ROS_DOMAIN_ID")));

        let path = lab.path("/robot_1").join("permissions.p7s");
        let signed = std::fs::read_to_string(&path).unwrap();
        let looked_at = lab.enclave("/robot_1", DOMAIN).unwrap();
        std::fs::write(&path, signed.replace("rt/robot_1/detection", "rt/robot_2/detection"))
            .unwrap();
        let changed = lab.enclave("/robot_1", DOMAIN).unwrap_err().to_string();
        assert!(changed.contains("is not what permissions_ca.cert.pem has signed"), "{changed}");
        // Also where it was changed behind a look.
        let refused = lab::join(looked_at).err();
        assert!(matches!(refused, Some(SessionError::Join { .. })), "{refused:?}");

        std::fs::remove_file(&path).unwrap();
        let missing = lab.enclave("/robot_1", DOMAIN).unwrap_err();
        assert!(missing.to_string().contains("permissions.p7s is missing"), "{missing}");
        assert!(lab.open("/robot_2").is_ok());
    });
}

#[test]
fn a_keystore_of_the_openssl_program_is_used_and_the_default_of_sros2_is_not_before_it_is_hardened()
{
    let name = "a_keystore_of_the_openssl_program_is_used_and_the_default_of_sros2_is_not_before_it_\
                is_hardened";
    in_own_network(name, async || {
        let lab = Lab::new();
        lab.sign_governance_with_openssl(|text| {
            text.replace("<data_protection_kind>NONE", "<data_protection_kind>ENCRYPT")
        });

        let refused = lab.enclave("/robot_1", DOMAIN).unwrap_err();
        assert!(refused.to_string().contains("multiple of 4"), "{refused}");
        assert!(refused.help().is_some_and(|help| help.contains("rsrs keystore harden")));

        lab.sign_governance_with_openssl(str::to_owned);
        let robot = lab.member("/robot_1");
        assert!(robot.publish_raw("/robot_1/detection", Bool::TYPE_NAME, Qos::reliable(1)).is_ok());
        lab::close([robot]).await;
    });
}

#[test]
fn a_runner_sets_the_parameters_of_a_robot_and_a_viewer_does_not() {
    in_own_network("a_runner_sets_the_parameters_of_a_robot_and_a_viewer_does_not", async || {
        let lab = Lab::new();
        let (robot, runner, viewer) =
            (lab.member("/robot_1"), lab.member("/runner"), lab.member("/viewer"));
        let declared = vec![controllers::controller(1, 0.1, 0.5)];
        let server = ParameterServer::start(&robot, declared, |_, _| Ok(())).unwrap();
        let options = ClientOptions { timeout: TIMEOUT, mapping: None };
        let value = [("speed".to_owned(), ParameterValue::Double(0.2))];

        let node = runner.node("/", "experiment_runner").unwrap();
        let client = ParameterClient::new(&runner, &node, options);
        client.set_atomically("/robot_1/controller", &value).await.unwrap();
        let set = server.get("/robot_1/controller", "speed");

        let node = viewer.node("/", "viewer").unwrap();
        let hasty = ClientOptions { timeout: Duration::from_secs(1), mapping: None };
        let of_viewer = ParameterClient::new(&viewer, &node, hasty);
        let refused = of_viewer.set_atomically("/robot_1/controller", &value).await;

        assert_eq!(set, Some(ParameterValue::Double(0.2)));
        assert!(refused.is_err());
        drop((client, of_viewer, server));
        lab::close([robot, runner, viewer]).await;
    });
}

#[test]
fn a_forged_datagram_is_obeyed_in_a_plain_fleet_and_not_in_a_secured_one() {
    in_own_network(
        "a_forged_datagram_is_obeyed_in_a_plain_fleet_and_not_in_a_secured_one",
        async || {
            let plain = forgery::is_obeyed(session(), session()).await;
            let lab = Lab::new();
            let secured = forgery::is_obeyed(lab.member("/runner"), lab.member("/robot_1")).await;

            assert!(plain, "the control: whoever forges well is obeyed in a plain fleet");
            assert!(!secured, "a forged lease was obeyed");
        },
    );
}

/// As SROS2 has it: the keys of a member are all that it takes to send in its name.
fn without_origin_authentication(governance: &str) -> String {
    governance.replace("_WITH_ORIGIN_AUTHENTICATION", "")
}

#[test]
fn a_thief_with_the_keys_that_members_send_each_other_is_obeyed_by_nobody() {
    in_own_network(
        "a_thief_with_the_keys_that_members_send_each_other_is_obeyed_by_nobody",
        async || {
            let open = Lab::new();
            open.sign_governance_with_openssl(without_origin_authentication);
            let all = Theft { obeyed: vec!["/swarm/lease", "/swarm/e_stop"], hears: false };
            let mut control = thief::steal(&open).await;
            // A thief is in a race with whom it forges, and may lose it.
            for _ in 0..2 {
                if control != all {
                    control = thief::steal(&open).await;
                }
            }
            let theft = thief::steal(&Lab::new()).await;

            assert_eq!(control, all, "the control: whoever has the keys can do it");
            assert_eq!(theft, Theft { obeyed: Vec::new(), hears: true });
        },
    );
}

/// Not a test of its own: the process of the thief.
#[test]
fn is_a_thief_if_started() {
    thief::steal_if_started();
}

#[test]
fn a_member_that_is_killed_and_started_again_is_received_within_5_s() {
    in_own_network(
        "a_member_that_is_killed_and_started_again_is_received_within_5_s",
        async || {
            let lab = Lab::new();
            let viewer = lab.member("/viewer");
            let received = subscribe(&viewer, lab::DETECTIONS, Bool::TYPE_NAME, Qos::reliable(100));
            let n_received = || received.lock().unwrap().len();
            let mut first = lab.start("publishes_detections_until_it_is_killed");
            eventually("the first process is received", || n_received() > 0).await;

            first.kill().unwrap();
            first.wait().unwrap();
            let (start, before) = (Instant::now(), n_received());
            let mut second = lab.start("publishes_detections_until_it_is_killed");
            eventually("the second process is received", || n_received() > before).await;
            let took = start.elapsed();

            second.kill().unwrap();
            second.wait().unwrap();
            lab::close([viewer]).await;
            assert!(took < Duration::from_secs(5), "it took {took:?}");
        },
    );
}

/// Not a test of its own: the process that is killed above.
#[test]
fn publishes_detections_until_it_is_killed() {
    lab::publish_if_started();
}

#[test]
fn nodes_of_one_member_receive_each_other_and_each_receives_what_others_publish() {
    let name = "nodes_of_one_member_receive_each_other_and_each_receives_what_others_publish";
    in_own_network(name, async || {
        let lab = Lab::new();
        let (robot, runner) = (lab.member("/robot_1"), lab.member("/runner"));
        // As gate and controller of a robot: two nodes of one process.
        let (lease, status) = (topics::LEASE, topics::CONTROLLER_STATUS);
        let status_name = status.for_robot("robot_1");
        let both = [(); 2].map(|()| subscribe(&robot, lease.name, lease.type_name, lease.qos));
        let own = subscribe(&robot, &status_name, status.type_name, status.qos);
        let of_runner = subscribe(&runner, &status_name, status.type_name, status.qos);
        let publish = |session: &Session, name: &str, topic: &topics::Topic| {
            session.publish_raw(name, topic.type_name, topic.qos).unwrap()
        };
        let leases = publish(&runner, lease.name, &lease);
        let publishers = [(); 2].map(|()| publish(&robot, &status_name, &status));

        let start = Instant::now();
        loop {
            leases.publish(&[0, 1, 0, 0, 1]).await.unwrap();
            // One after the other: the last one replaces those before it that nobody has taken yet.
            for (number, publisher) in (1..).zip(&publishers) {
                publisher.publish(&[0, 1, 0, 0, number]).await.unwrap();
                tokio::time::sleep(Duration::from_millis(50)).await;
            }
            let n = [&both[0], &both[1], &own].map(|inbox| inbox.lock().unwrap().len());
            let of_each = [1, 2].map(|number| {
                of_runner.lock().unwrap().iter().filter(|bytes| bytes[4] == number).count()
            });
            if n.iter().chain(&of_each).all(|n| *n > 0) {
                break;
            }
            assert!(start.elapsed() < TIMEOUT, "received {n:?} and {of_each:?}");
        }
        drop((leases, publishers, both, own, of_runner));
        lab::close([robot, runner]).await;
    });
}
