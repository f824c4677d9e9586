//! What viewers are shown of the world: the transform tree and the markers.
//!
//! Viewers are guests. Nothing is made for them while none is there, they get ten frames of each
//! second, by the world's clock or by the wall clock, whichever goes faster, and the world never
//! waits for them: a task of its own publishes the newest picture, and forgets those that it had no
//! time for. In lockstep, where a second of the world takes milliseconds, markers come twice in each
//! of its seconds, because they are large.

mod history;
mod markers;
mod scene;

use std::sync::Arc;
use std::time::{Duration, Instant};

use rsrs_msgs::tf2_msgs::TFMessage;
use rsrs_msgs::topics;
use rsrs_msgs::visualization_msgs::MarkerArray;
use rsrs_ros::session::{NodeHandle, Publisher, Session};
use tokio::sync::watch;
use tokio::task::JoinHandle;

pub use history::History;
pub use scene::{Look, Scene};

/// Least time between two pictures.
const SHOWN_EVERY: Duration = Duration::from_millis(100);

/// Least time of the world between two pictures, for bags that are played at the world's pace: a
/// little less, because a period may end just before it is over.
const SHOWN_EVERY_NS: u64 = 99_000_000;

/// Least time of the world between two pictures with markers, where it is faster than the wall clock's.
const MARKED_EVERY_NS: u64 = 500_000_000;

/// How often the display looks for viewers.
const LOOKS_EVERY: Duration = Duration::from_millis(500);

/// Least time between two judgements.
const JUDGED_EVERY: Duration = Duration::from_secs(2);

/// Publishes the world for viewers.
pub struct Display {
    pictures: watch::Sender<Option<Picture>>,
    publishing: JoinHandle<()>,
    watched: Watched,
    looked: Option<Instant>,
    shown: Option<Shown>,
    /// When markers were shown last.
    marked: Option<Shown>,
    judging: Judging,
}

/// When something was shown, by both clocks.
#[derive(Clone, Copy, Debug)]
struct Shown {
    at: Instant,
    /// Of the world, in nanoseconds.
    world_ns: u64,
}

impl Shown {
    /// Whether it was long enough ago by one of them; the world's goes back when it is placed anew.
    fn is_old(&self, world_ns: u64, every_ns: u64) -> bool {
        self.at.elapsed() >= SHOWN_EVERY || world_ns.abs_diff(self.world_ns) >= every_ns
    }
}

/// Which of the two topics have subscribers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Watched {
    frames: bool,
    markers: bool,
}

/// What is published next.
#[derive(Clone, Debug)]
enum Picture {
    Scene(Box<Scene>, Watched),
    /// There is no world any more.
    Nothing,
}

/// The judge works on another thread, on one run at a time.
#[derive(Default)]
struct Judging {
    at: Option<Instant>,
    working: Option<JoinHandle<String>>,
    label: String,
}

impl Drop for Display {
    fn drop(&mut self) {
        self.publishing.abort();
    }
}

impl Display {
    /// Offers the two topics; to be called within a runtime.
    pub fn new(session: &Session, node: &NodeHandle) -> anyhow::Result<Self> {
        let frames = session.publish_on(node, topics::TF.name, topics::TF.qos)?;
        let markers = session.publish_on(node, topics::MARKERS.name, topics::MARKERS.qos)?;
        let (pictures, newest) = watch::channel(None);
        Ok(Self {
            pictures,
            publishing: tokio::spawn(publish(frames, markers, newest)),
            watched: Watched::default(),
            looked: None,
            shown: None,
            marked: None,
            judging: Judging::default(),
        })
    }

    /// Finds out now and then whether anybody looks.
    pub async fn look_around(&mut self, session: &Session) {
        if self.looked.is_some_and(|at| at.elapsed() < LOOKS_EVERY) {
            return;
        }
        self.looked = Some(Instant::now());
        let is_read = async |name| session.wait_for_readers(name, 1, Duration::ZERO).await.is_ok();
        self.watched = Watched {
            frames: is_read(topics::TF.name).await,
            markers: is_read(topics::MARKERS.name).await,
        };
    }

    /// Whether it is time (of the world, in nanoseconds) for the next picture, and there is a
    /// viewer.
    pub fn is_due(&self, world_ns: u64) -> bool {
        self.watched != Watched::default()
            && self.shown.is_none_or(|shown| shown.is_old(world_ns, SHOWN_EVERY_NS))
    }

    /// Shows a scene at a time of the world, in nanoseconds.
    pub fn show(&mut self, scene: Scene, world_ns: u64) {
        let now = Some(Shown { at: Instant::now(), world_ns });
        let markers = self.watched.markers
            && self.marked.is_none_or(|marked| marked.is_old(world_ns, MARKED_EVERY_NS));
        self.shown = now;
        if markers {
            self.marked = now;
        }
        let watched = Watched { markers, ..self.watched };
        // Who publishes ends with this.
        self.pictures.send_replace(Some(Picture::Scene(Box::new(scene), watched)));
    }

    /// Wipes what was shown: there is no world.
    pub fn wipe(&mut self) {
        self.judging = Judging::default();
        self.pictures.send_replace(Some(Picture::Nothing));
    }

    /// The judge's verdict on a run, as of a few seconds ago.
    pub async fn label(&mut self, history: &History) -> String {
        self.judging.label(history).await
    }
}

impl Judging {
    async fn label(&mut self, history: &History) -> String {
        if let Some(working) = self.working.take_if(|working| working.is_finished()) {
            self.label = working.await.expect("the judge takes any trajectory");
        }
        let is_due = self.at.is_none_or(|at| at.elapsed() >= JUDGED_EVERY);
        if is_due && self.working.is_none() {
            self.at = Some(Instant::now());
            let history = history.clone();
            self.working = Some(tokio::task::spawn_blocking(move || history.label()));
        }
        self.label.clone()
    }
}

async fn publish(
    frames: Publisher<TFMessage>,
    markers: Publisher<MarkerArray>,
    mut newest: watch::Receiver<Option<Picture>>,
) {
    while newest.changed().await.is_ok() {
        let picture = newest.borrow_and_update().clone();
        let (tree, array) = match picture {
            None => continue,
            Some(Picture::Nothing) => (None, Some(markers::nothing())),
            Some(Picture::Scene(scene, watched)) => (
                watched.frames.then(|| scene.frames()),
                watched.markers.then(|| markers::markers(&scene)),
            ),
        };
        let sent = async {
            if let Some(tree) = tree {
                frames.publish(tree).await?;
            }
            match array {
                Some(array) => markers.publish(array).await,
                None => Ok(()),
            }
        };
        if let Err(error) = sent.await {
            log::warn!("viewers miss a picture: {error}");
        }
    }
}

/// The names of robots, shared by every scene.
pub type Names = Arc<[String]>;

#[cfg(test)]
mod tests {
    use rsrs_core::conditions::{Arena, Conditions, Walls};
    use rsrs_core::judge::behaviour::Behaviour;
    use rsrs_core::world::WorldFile;
    use rsrs_testing::conditions::flockbot_conditions;

    const WORLD: &str = "
objects: [{places_m: [[1, 1], [1, 1.3]], radius_m: 0.1}, {places_m: [[-1, 1]], radius_m: 0.25}]
goals: [{place_m: [0.6, -0.6], radius_m: 0.3}]
";

    /// Flockbots with a window for their behaviour among three objects, of which two are side by
    /// side, and a goal.
    pub fn pushing(window: &str) -> Conditions {
        let window = if window.contains(':') { format!("{{{window}}}") } else { window.to_owned() };
        let behaviour = format!(
            "name: heaping\nwords: {{noun: heaping, swarm: a swarm that heaps, verb: [heap, heaps, heaped]}}\n\
             phases: [{{key: heaped}}, {{key: strewn}}]\n\
             rules: [{{phase: heaped, when: {{objects_clustered: {{at_least: 0.5}}}}}}]\n\
             otherwise: strewn\nwindow: {window}\n"
        );
        let mut conditions = flockbot_conditions();
        conditions.period_s = 0.1;
        conditions.arena = Arena { side_m: 4.0, walls: Walls::Clamp };
        conditions.world = WorldFile::parse("world.yaml", WORLD, &[4.0], &[]).expect("it is one");
        conditions.behaviour = Behaviour::parse("heap.yaml", &behaviour).expect("it is one");
        conditions.check().expect("they make a world");
        conditions
    }
}
