//! A thief with the enclave of a robot, whose own middleware asks for no permission.

use std::path::Path;
use std::time::{Duration, Instant};

use rsrs_msgs::RosMessage;
use rsrs_msgs::std_msgs::Bool;
use rsrs_msgs::topics::{self, Qos};
use rsrs_ros::interfaces::LOOPBACK;
use rsrs_testing::network::TIMEOUT;
use rustdds::policy::Reliability;
use rustdds::{
    DomainParticipantBuilder, DomainParticipantSecurityConfigFiles, QosPolicyBuilder, TopicKind,
};

use crate::lab::{DOMAIN, Inbox, Lab, close, subscribe};

/// Long enough for a sample of somebody who is obeyed.
const A_WHILE: Duration = Duration::from_secs(4);

/// What the thief publishes.
#[derive(Debug, serde::Serialize)]
struct Detected {
    data: bool,
}

/// How many samples of a robot's own topic and of the e-stop arrive from a program with its enclave that
/// checks nothing itself.
pub async fn arrives(lab: &Lab) -> (usize, usize) {
    let permissive = |text: &str| {
        let rule = text.find("<topic_rule>").expect("it has a rule for all topics");
        let end = text.find("</topic_rule>").expect("it ends") + "</topic_rule>".len();
        let open = text[rule..end]
            .replace(
                "<topic_expression>*<",
                &format!("<topic_expression>rt{}<", topics::E_STOP.name),
            )
            .replace("access_control>true<", "access_control>false<");
        [&text[..rule], &open, &text[rule..]].concat()
    };
    let enclave = lab.copied("/robot_1", permissive);
    let (viewer, robot, stop) =
        (lab.member("/viewer"), lab.member("/robot_2"), lab.member("/stop"));
    let topic = topics::E_STOP;
    let own = subscribe(&viewer, "/robot_1/detection", Bool::TYPE_NAME, Qos::reliable(100));
    let stops = subscribe(&robot, topic.name, topic.type_name, topic.qos);
    let genuine = stop.publish_raw(topic.name, topic.type_name, topic.qos).expect("it is allowed");

    let thief = thief(enclave.path());
    let writer = |name: &str| {
        let qos = QosPolicyBuilder::new()
            .reliability(Reliability::Reliable {
                max_blocking_time: rustdds::Duration::from_millis(100),
            })
            .build();
        let name = format!("rt{name}");
        let type_name = "std_msgs::msg::dds_::Bool_".to_owned();
        let topic = thief
            .create_topic(name, type_name, &qos, TopicKind::NoKey)
            .expect("its own middleware lets it");
        let publisher = thief.create_publisher(&qos).expect("its own middleware lets it");
        publisher
            .create_datawriter_no_key_cdr::<Detected>(&topic, None)
            .expect("its own middleware lets it")
    };
    let writers = [writer("/robot_1/detection"), writer(topic.name)];
    let n_of = |inbox: &Inbox, last: u8| {
        let samples = inbox.lock().expect("nobody panicked with it");
        samples.iter().filter(|sample| sample[4] == last).count()
    };
    let start = Instant::now();
    while start.elapsed() < A_WHILE || n_of(&own, 1) == 0 || n_of(&stops, 0) == 0 {
        assert!(start.elapsed() < TIMEOUT, "not even what is allowed arrives");
        for writer in &writers {
            writer.write(Detected { data: true }, None).expect("its own middleware lets it");
        }
        genuine.publish(&[0, 1, 0, 0, 0]).await.expect("a healthy network");
        tokio::time::sleep(Duration::from_millis(50)).await;
    }
    let arrived = (n_of(&own, 1), n_of(&stops, 1));
    drop((own, stops, genuine, writers));
    close([viewer, robot, stop]).await;
    arrived
}

fn thief(enclave: &Path) -> rustdds::DomainParticipant {
    let files =
        DomainParticipantSecurityConfigFiles::with_ros_default_names(enclave, String::new());
    DomainParticipantBuilder::new(DOMAIN)
        .with_only_networks([LOOPBACK])
        .builtin_security(files)
        .build()
        .expect("the enclave is well")
}
