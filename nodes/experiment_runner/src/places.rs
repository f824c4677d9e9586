//! Where the robots of a run are seen now, held against where they should start; nothing is sent to any
//! of them.

use std::collections::{BTreeMap, BTreeSet};
use std::ops::ControlFlow;
use std::time::{Duration, Instant};

use rsrs_bags::trajectory::TrackedTopic;
use rsrs_core::robot::pose_source::PoseSource;
use rsrs_core::robot::unicycle::Pose;
use rsrs_fleet::observation::Rate;
use rsrs_fleet::placement::{SeenPlaces, SeenRobot, WantedStart, deviations};
use rsrs_fleet::preflight::{self, Expected, ExpectedTopic, Graph, Problem, Publishers, Seen};
use rsrs_msgs::cdr;
use rsrs_msgs::node_names::PLACE as NODE;
use rsrs_msgs::tf2_msgs::TFMessage;
use rsrs_msgs::topics;
use rsrs_ros::runtime::beat;
use rsrs_ros::session::{ReceivedRaw, Session, SessionOptions};
use tokio::sync::mpsc::{UnboundedReceiver, UnboundedSender, unbounded_channel};

use crate::expectation;
use crate::plan::Plan;
use crate::recorded_topics::{RecordedTopic, Role};
use crate::tracked::{SeenPose, Sighting, Tracked};

/// A pose that is older than this shows where the robot was.
const FRESH: Duration = Duration::from_secs(1);
/// Notes that are kept.
const MOST_NOTES: usize = 20;

/// Shows where robots are seen, and decides whether that is enough.
pub type Show<'a> = &'a mut dyn FnMut(&SeenPlaces) -> anyhow::Result<ControlFlow<()>>;

/// What is known of a robot.
#[derive(Default)]
struct Known {
    /// Frame, place and time of the last pose that counts.
    last: Option<(String, Pose, Instant)>,
    unusable: Option<String>,
    rate: Rate,
}

/// What was received.
struct Places<'a> {
    plan: &'a Plan,
    tracked: Tracked,
    known: BTreeMap<String, Known>,
    /// By frame: the one that it is in.
    parents: BTreeMap<String, String>,
    notes: Vec<String>,
    start: Instant,
}

/// Shows where robots are seen, over and over, until `show` finds that it is enough or somebody
/// stops it.
pub async fn watch(
    plan: &Plan,
    network: &SessionOptions,
    every: Duration,
    show: Show<'_>,
    stop: impl Future<Output = ()>,
) -> anyhow::Result<()> {
    let session = Session::open(network)?;
    session.node("/", NODE)?;
    let (sender, mut samples) = unbounded_channel();
    let mut places = Places::new(plan);
    let topics = places.topics();
    let subscriptions = topics
        .iter()
        .enumerate()
        .map(|(index, topic)| listen(&session, index, topic, &sender))
        .collect::<Result<Vec<_>, _>>()?;
    let watched = tokio::select! {
        () = stop => Ok(()),
        ended = session.ended() => Err(ended.into()),
        watched = places.watch(&session, &topics, (every, show), &mut samples) => watched,
    };
    drop(subscriptions);
    session.close().await;
    watched
}

type Sample = (usize, ReceivedRaw);

fn listen(
    session: &Session,
    index: usize,
    topic: &RecordedTopic,
    sender: &UnboundedSender<Sample>,
) -> Result<rsrs_ros::session::Subscription, rsrs_ros::session::SessionError> {
    let sender = sender.clone();
    session.subscribe_raw(&topic.name, &topic.type_name, topic.qos, move |received| {
        // There is no receiver once the command ends.
        drop(sender.send((index, received)));
    })
}

impl<'a> Places<'a> {
    fn new(plan: &'a Plan) -> Self {
        let robots = plan.record.robots.iter();
        Self {
            plan,
            tracked: Tracked::of_run(plan),
            known: robots.map(|robot| (robot.clone(), Known::default())).collect(),
            parents: BTreeMap::new(),
            notes: Vec::new(),
            start: Instant::now(),
        }
    }

    /// The topics with poses, and those with transforms, which tie frames together.
    fn topics(&self) -> Vec<RecordedTopic> {
        let role = |topic: &TrackedTopic| {
            let robots = self.plan.record.robots.iter();
            let place = robots.enumerate().find(|(_, robot)| topic.robot.as_ref() == Some(robot));
            match (self.plan.tracked_by(), place) {
                (PoseSource::Odom, Some((index, _))) => Role::Odometry(index),
                (PoseSource::Pose, Some((index, _))) => Role::Pose(index),
                (PoseSource::Tf, _) if topic.topic == topics::TF_STATIC => Role::StaticTransforms,
                (PoseSource::Tf, _) => Role::Transforms,
                _ => Role::Tracker,
            }
        };
        let of_tracker = self.tracked.topics().iter();
        let mut all: Vec<RecordedTopic> = of_tracker
            .map(|topic| RecordedTopic::new(topic.name.clone(), topic.topic, role(topic)))
            .collect();
        for topic in [topics::TF, topics::TF_STATIC] {
            if !all.iter().any(|known| known.name == topic.name) {
                let name = topic.name.to_owned();
                all.push(RecordedTopic::new(name, topic, Role::Other));
            }
        }
        all
    }

    async fn watch(
        &mut self,
        session: &Session,
        topics: &[RecordedTopic],
        (every, show): (Duration, Show<'_>),
        samples: &mut UnboundedReceiver<Sample>,
    ) -> anyhow::Result<()> {
        let mut show_next = beat(every);
        show_next.tick().await;
        loop {
            tokio::select! {
                biased;
                _ = show_next.tick() => {
                    if show(&self.seen(session, topics))?.is_break() {
                        return Ok(());
                    }
                }
                Some((index, received)) = samples.recv() => self.receive(&topics[index], &received),
            }
        }
    }

    fn receive(&mut self, topic: &RecordedTopic, received: &ReceivedRaw) {
        if topic.type_name == topics::TF.type_name
            && let Ok(message) = cdr::decode::<TFMessage>(&received.message)
        {
            for transform in message.transforms {
                let child = transform.child_frame_id.trim_start_matches('/').to_owned();
                self.parents.insert(child, transform.header.frame_id);
            }
        }
        let Some(place) = self.tracked.index_of(&topic.name, &topic.type_name) else { return };
        let sighting = self.tracked.take(place, received).unwrap_or_else(|reason| Sighting {
            notes: vec![format!("refused a message on {}: {reason}", topic.name)],
            ..Sighting::default()
        });
        for note in sighting.notes {
            if self.notes.len() < MOST_NOTES && !self.notes.contains(&note) {
                self.notes.push(note);
            }
        }
        let now = Instant::now();
        for SeenPose { robot, frame, pose, counts, .. } in sighting.poses {
            let Some(known) = self.known.get_mut(&robot).filter(|_| counts) else { continue };
            match pose {
                Ok(pose) => {
                    known.rate.received(now.duration_since(self.start));
                    known.last = Some((frame, pose, now));
                    known.unusable = None;
                }
                Err(reason) => known.unusable = Some(reason),
            }
        }
    }

    fn seen(&self, session: &Session, topics: &[RecordedTopic]) -> SeenPlaces {
        let now = Instant::now();
        let plan = self.plan;
        let is_fresh = |at: &Instant| now.duration_since(*at) <= FRESH;
        let mut robots = Vec::new();
        let mut standing = Vec::new();
        for (number, robot) in plan.record.robots.iter().enumerate() {
            let known = &self.known[robot];
            if let Some((_, pose, at)) = &known.last
                && is_fresh(at)
            {
                standing.push((number, robot.clone(), *pose));
            }
            robots.push(self.seen_robot(robot, known, now));
        }
        let wanted = WantedStart::new(&plan.record.conditions, plan.record.replicate);
        let deviations: Vec<String> =
            deviations(&wanted, &standing).iter().map(ToString::to_string).collect();
        let problems: Vec<String> =
            self.problems(session, topics).iter().map(ToString::to_string).collect();
        let is_as_wanted = standing.len() == robots.len()
            && robots.iter().all(|robot| robot.unusable.is_none())
            && deviations.is_empty()
            && problems.is_empty();
        SeenPlaces {
            pose_source: plan.tracked_by(),
            topics: self.tracked.topics().iter().map(|topic| topic.name.clone()).collect(),
            tracker_frame: plan
                .record
                .tracker
                .as_ref()
                .map(|tracker| tracker.frame)
                .filter(|frame| !frame.is_the_floors()),
            robots,
            deviations,
            problems,
            notes: self.without_world().into_iter().chain(self.notes.clone()).collect(),
            others: self.tracked.others().map(str::to_owned).collect(),
            is_as_wanted,
            looked_for_s: now.duration_since(self.start).as_secs_f64(),
        }
    }

    /// That virtual robots are not seen before they have a world.
    fn without_world(&self) -> Option<String> {
        let unseen =
            self.plan.robots.iter().filter(|robot| {
                self.plan.is_virtual(robot) && self.known[&robot.name].last.is_none()
            });
        let names: Vec<&str> = unseen.map(|robot| robot.name.as_str()).collect();
        (!names.is_empty()).then(|| {
            let names = names.join(", ");
            format!("virtual, and seen once a run has placed them in a world: {names}")
        })
    }

    fn seen_robot(&self, robot: &str, known: &Known, now: Instant) -> SeenRobot {
        let tracker = self.plan.record.tracker.as_ref();
        SeenRobot {
            robot: robot.to_owned(),
            body: tracker.and_then(|tracker| tracker.bodies.get(robot).cloned()),
            pose: known.last.as_ref().map(|(_, pose, _)| *pose),
            frame: known.last.as_ref().map(|(frame, ..)| frame.clone()),
            age_s: known.last.as_ref().map(|(.., at)| now.duration_since(*at).as_secs_f64()),
            rate_hz: known.rate.hz(now.duration_since(self.start)),
            unusable: known.unusable.clone(),
        }
    }

    /// What preflight would find wrong with the poses.
    fn problems(&self, session: &Session, topics: &[RecordedTopic]) -> Vec<Problem> {
        let poses = topics.iter().filter(|topic| topic.role != Role::Other);
        let poses = poses.map(|topic| ExpectedTopic {
            name: topic.name.clone(),
            type_name: topic.type_name.clone(),
            publishers: expectation::publishers_of_poses(self.plan, topic),
        });
        let objects = expectation::objects(self.plan);
        let of_objects = objects.iter().flatten().map(|object| ExpectedTopic {
            name: topics::object_pose(object),
            type_name: topics::OBJECT_POSE.type_name.to_owned(),
            publishers: Publishers::One,
        });
        let expected = Expected {
            topics: poses.chain(of_objects).collect(),
            apart: expectation::apart(self.plan),
            objects: objects.clone(),
            ..Expected::default()
        };
        let known = || self.known.iter();
        let pose = |(robot, known): (&String, &Known)| {
            let (frame, pose, _) = known.last.clone()?;
            Some((robot.clone(), (frame, pose)))
        };
        let unusable =
            |(robot, known): (&String, &Known)| Some((robot.clone(), known.unusable.clone()?));
        let publishers = expectation::publishers_there(session);
        let seen = Seen {
            graph: Graph { publishers, ..Graph::default() },
            poses: known().filter_map(pose).collect(),
            unusable_poses: known().filter_map(unusable).collect(),
            parents: self.parents.clone(),
            ..Seen::default()
        };
        let outside = preflight::outside(self.plan.geofence, &self.plan.record.robots, &seen.poses);
        let mut told = BTreeSet::new();
        let problems = preflight::problems(&expected, &seen).into_iter().chain(outside);
        problems.filter(|problem| told.insert(problem.to_string())).collect()
    }
}
