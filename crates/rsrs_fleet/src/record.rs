//! The record of one run: all that it takes to repeat it, and how it ended. Both go into its bag.

use std::collections::BTreeMap;
use std::fmt;

use rsrs_core::comparison::fixed::FixedRun;
use rsrs_core::conditions::operator::OperatorConditions;
use rsrs_core::conditions::{Conditions, Impossible, MOST_DURATION_S};
use rsrs_core::program;
use rsrs_core::robot::pose_source::PoseSource;
use rsrs_core::tracker::Tracker;
use rsrs_core::trials::trial::TrialBackend;
use serde::{Deserialize, Serialize};

use crate::experiment::{RobotLost, Time};
use crate::fleet_file::{Driver, FleetRobot, is_name};
use crate::parameters::GateSettings;

/// Name of the attachment of a bag that holds an [`ExperimentRecord`] as JSON.
pub const ATTACHMENT: &str = rsrs_msgs::topics::EXPERIMENT_ATTACHMENT;

/// Name of the metadata record of a bag that holds an [`Ending`].
pub const ENDING: &str = "rsrs_ending";

/// Name of the metadata record of a bag that holds what is missing in it, by topic.
pub const RECORDING: &str = "rsrs.recording";

/// Version of [`ExperimentRecord`]'s shape.
pub const RECORD_SCHEMA_VERSION: u32 = 1;

/// All that it takes to repeat one run; it goes into the run's bag.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ExperimentRecord {
    /// Names the run, in the bag and in its leases.
    pub run_id: String,
    /// Names of the robots, in the order of the world's rows.
    pub robots: Vec<String>,
    /// The resolved conditions, the paper's `E`.
    pub conditions: Conditions,
    /// How long the robots were to move, in seconds.
    pub duration_s: f64,
    /// Seed of the simulated world.
    pub seed: u64,
    /// Which replicate of the cell it is.
    pub replicate: u64,
    /// What was to be done about a lost robot.
    pub robot_lost: RobotLost,
    /// What moved the robots.
    pub backend: Backend,
    /// Robots that had no gate of ours in front of their wheels: their lease was their controller's
    /// only.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub controller_only: Vec<String>,
    /// Where the poses of all its robots come from; `None` in records of programs that did not write
    /// it down.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub pose_source: Option<PoseSource>,
    /// How a tracker published them, and where its frame is on the floor: bags hold poses as they were
    /// published. `None` where they are on the floor as they come, in the names and on the topics of the
    /// robots.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tracker: Option<Tracker>,
    /// The pace.
    pub time: Time,
    /// Where it comes from.
    pub provenance: RecordProvenance,
    /// What the gate of each robot was set to when the run began, by robot and parameter; robots whose
    /// gates are not ours, or were not asked, are left out.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub gates: BTreeMap<String, GateSettings>,
    /// Robots with a profile of their own, by name; that of the others is named in `provenance`.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub own_profiles: BTreeMap<String, OwnProfile>,
    /// Which run of a design it is whose number of runs was fixed before the first; `None` where none was.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub fixed: Option<FixedRun>,
}

/// A profile that holds for one robot in the place of the fleet's.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct OwnProfile {
    /// Its digest.
    pub digest: String,
    /// Which of its numbers differ from the fleet's, in words; empty if only its name or the origin of
    /// the numbers does.
    pub differs: Vec<String>,
}

impl fmt::Display for OwnProfile {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let differs = match &self.differs[..] {
            [] => "its numbers are the fleet's".to_owned(),
            differs => differs.join(", "),
        };
        write!(formatter, "own profile: {differs}")
    }
}

/// What moves the robots of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Backend {
    /// The simulator, which stands in for every robot.
    Simulator,
    /// The robots.
    Fleet,
    /// Some of the robots, and the simulator in place of the others: it is no evidence about
    /// reality.
    Mixed,
}

impl From<TrialBackend> for Backend {
    fn from(asked_for: TrialBackend) -> Self {
        match asked_for {
            TrialBackend::Simulator => Self::Simulator,
            TrialBackend::Fleet => Self::Fleet,
        }
    }
}

impl Backend {
    /// Whether a robot of such a run is on the floor.
    pub fn is_real(self, robot: &FleetRobot) -> bool {
        match self {
            Self::Simulator => false,
            Self::Mixed => robot.driver != Driver::Virtual,
            Self::Fleet => true,
        }
    }

    /// What moved the robots, for a sentence.
    pub fn in_words(self) -> &'static str {
        match self {
            Self::Simulator => "the simulator",
            Self::Fleet => "themselves",
            Self::Mixed => "the simulator, at least some of them",
        }
    }

    /// That it is no evidence about reality, for the title of a picture; `None` for real robots.
    pub fn mark(self) -> Option<&'static str> {
        match self {
            Self::Simulator => Some("simulated"),
            Self::Fleet => None,
            Self::Mixed => Some("partly simulated"),
        }
    }
}

/// Robots of one run whose poses come from different sources, so that nothing ties them together.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "the poses of {robot} come from `{source_of_robot}` and those of {other} from \
     `{source_of_other}`, expected one `pose:` for all robots of a run"
)]
pub struct DifferentPoses {
    /// A robot.
    pub robot: String,
    /// Where its poses come from.
    pub source_of_robot: PoseSource,
    /// Another one.
    pub other: String,
    /// Where those come from.
    pub source_of_other: PoseSource,
}

/// Where the poses of all robots of a run come from: a simulator publishes all of its own as
/// odometry, and follows real robots by what tracks these.
pub fn pose_source(
    backend: Backend,
    robots: &[FleetRobot],
) -> Result<PoseSource, Box<DifferentPoses>> {
    let mut real = robots.iter().filter(|robot| backend.is_real(robot));
    let Some(first) = real.next() else { return Ok(PoseSource::Odom) };
    match real.find(|robot| robot.pose != first.pose) {
        None => Ok(first.pose),
        Some(other) => Err(Box::new(DifferentPoses {
            robot: first.name.clone(),
            source_of_robot: first.pose,
            other: other.name.clone(),
            source_of_other: other.pose,
        })),
    }
}

/// Robots of one run that are tracked in different ways.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum UnsuitableTracker {
    /// The record has one description of it.
    #[error(
        "{robot} and {other} have a `tracker` each, which differ: expected one for all robots of a run"
    )]
    Several {
        /// A robot.
        robot: String,
        /// Another one.
        other: String,
    },
    /// An array without names has no such robot.
    #[error(
        "{robot} has `pose: pose_array`, and the `names` of its `tracker` have no `{body}`, only {}: \
         add it where its pose is in a message, or give {robot} a `body:` with the name that is there",
        names.join(", ")
    )]
    NotAmongNames {
        /// The robot.
        robot: String,
        /// What the tracker calls it.
        body: String,
        /// All names.
        names: Vec<String>,
    },
    /// The simulator follows real robots by their own topics, as they are.
    #[error(
        "{robot} has `pose: {poses}`{}, expected `odom` or `pose` without `tracker` and `body` in a run \
         with virtual robots: the simulator follows real ones by no others",
        if *has_keys { " and a `tracker` or `body`" } else { "" }
    )]
    Mixed {
        /// A real robot.
        robot: String,
        /// Where its poses come from.
        poses: PoseSource,
        /// Whether it has a `tracker` or a `body`.
        has_keys: bool,
    },
}

/// The tracker of a run with these robots; `None` where poses come on the robots' own topics, in the
/// frame of the floor.
pub fn tracker(
    backend: Backend,
    robots: &[FleetRobot],
) -> Result<Option<Tracker>, UnsuitableTracker> {
    let mut real = robots.iter().filter(|robot| backend.is_real(robot));
    let Some(first) = real.clone().next() else { return Ok(None) };
    if let Some(other) = real.clone().find(|robot| robot.tracker != first.tracker) {
        return Err(UnsuitableTracker::Several {
            robot: first.name.clone(),
            other: other.name.clone(),
        });
    }
    let is_named = |robot: &FleetRobot| first.tracker.names.iter().any(|it| it == robot.body());
    if first.pose == PoseSource::PoseArray
        && let Some(robot) = real.clone().find(|robot| !is_named(robot))
    {
        return Err(UnsuitableTracker::NotAmongNames {
            robot: robot.name.clone(),
            body: robot.body().to_owned(),
            names: first.tracker.names.clone(),
        });
    }
    let bodies = real.clone().filter_map(|robot| Some((robot.name.clone(), robot.body.clone()?)));
    let tracker = Tracker { bodies: bodies.collect(), ..first.tracker.clone() };
    let has_keys = tracker != Tracker::default();
    let is_plain = first.pose.is_of_each_robot() && !has_keys;
    if is_plain {
        return Ok(None);
    }
    match (backend, real.next()) {
        (Backend::Mixed, Some(robot)) => {
            Err(UnsuitableTracker::Mixed { robot: robot.name.clone(), poses: robot.pose, has_keys })
        }
        _ => Ok(Some(tracker)),
    }
}

/// Where a record comes from.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RecordProvenance {
    /// Version of the program.
    pub version: String,
    /// Commit that it was built from.
    pub commit: String,
    /// Digest of the robots' profile: 16 hexadecimal digits.
    pub profile_digest: String,
    /// Digest of the conditions: 16 hexadecimal digits.
    pub conditions_digest: String,
    /// Version of the record's shape.
    pub schema_version: u32,
}

impl RecordProvenance {
    /// The provenance of a run of this program, with a measured robot's digest, under these conditions.
    pub fn new(profile_digest: &str, conditions: &Conditions) -> Self {
        Self {
            version: program::VERSION.to_owned(),
            commit: program::commit().to_owned(),
            profile_digest: profile_digest.to_owned(),
            conditions_digest: format!("{:016x}", conditions.digest()),
            schema_version: RECORD_SCHEMA_VERSION,
        }
    }
}

/// Why a record does not read.
#[derive(Debug, thiserror::Error)]
pub enum RecordError {
    /// It is of another version of its shape.
    #[error(
        "a record of version {found}, expected {RECORD_SCHEMA_VERSION}: read it with the version of \
         rsrs that recorded it"
    )]
    Version {
        /// Its version.
        found: u64,
    },
    /// Its numbers make no world.
    #[error("conditions.{source}")]
    Conditions {
        /// Which, and why.
        source: Box<Impossible>,
    },
    /// The time that robots were to move is none.
    #[error("duration_s is {found}, expected a time above 0 s, and at most {MOST_DURATION_S} s")]
    Duration {
        /// Its time, in seconds.
        found: f64,
    },
    /// A robot has a name that no robot can have.
    #[error("`{found}` is no name of a robot")]
    Name {
        /// The name.
        found: String,
    },
    /// It is damaged, or no record.
    #[error(transparent)]
    Json(#[from] serde_json::Error),
}

impl ExperimentRecord {
    /// The record as JSON, on one line.
    ///
    /// # Panics
    ///
    /// Never: a record is plain data.
    pub fn to_json(&self) -> String {
        serde_json::to_string(self).expect("a record is plain data")
    }

    /// Reads a record back.
    pub fn from_json(text: &str) -> Result<Self, RecordError> {
        // A newer shape may have any keys.
        let record: serde_json::Value = serde_json::from_str(text).unwrap_or_default();
        let found = record["provenance"]["schema_version"].as_u64();
        if let Some(found) = found.filter(|found| *found != u64::from(RECORD_SCHEMA_VERSION)) {
            return Err(RecordError::Version { found });
        }
        let record: Self = serde_json::from_str(text)?;
        record.check()?;
        Ok(record)
    }

    /// Refuses what no run can have had: a record comes from a bag of anybody's, or from the network.
    fn check(&self) -> Result<(), RecordError> {
        let in_conditions = |source| RecordError::Conditions { source: Box::new(source) };
        self.conditions.check().map_err(in_conditions)?;
        if !(self.duration_s > 0.0 && self.duration_s <= MOST_DURATION_S) {
            return Err(RecordError::Duration { found: self.duration_s });
        }
        match self.robots.iter().find(|robot| !is_name(robot)) {
            Some(robot) => Err(RecordError::Name { found: robot.clone() }),
            None => Ok(()),
        }
    }

    /// Whether a completed run counts although these robots were lost on the way: only where the
    /// experiment had fixed that beforehand, and none was lost before the time that is judged.
    pub fn counts_without(&self, lost: &[LostRobot]) -> bool {
        let window = self.conditions.behaviour.window();
        let is_late =
            |lost: &LostRobot| !self.robot_lost.ends_run(lost.after_s, self.duration_s, window);
        match self.robot_lost {
            RobotLost::Abort | RobotLost::Note => lost.is_empty(),
            RobotLost::AbortUntilJudged => lost.iter().all(is_late),
        }
    }

    /// What must be the same for the run to be compared with a simulated cell.
    pub fn operator_conditions(&self) -> OperatorConditions {
        OperatorConditions::new(&self.conditions, self.duration_s)
    }
}

/// How a run ended, decided before anyone looked at what the swarm did.
#[derive(Clone, Debug, PartialEq)]
pub struct Ending {
    /// In a word.
    pub kind: EndingKind,
    /// Why, where it was not completed; else empty.
    pub reason: String,
    /// Robots that were lost on the way, in the order in which they were, whatever was done about it.
    pub lost: Vec<LostRobot>,
    /// When robots stood in the run because their leases had run out, and went on, in that order.
    pub paused: Vec<PausedRobot>,
}

/// A robot that stood in a run for a moment, because leases did not reach it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, thiserror::Error)]
#[error("{robot} stood for at most {stood_s:.1} s after {after_s:.1} s: lease ran out")]
pub struct PausedRobot {
    /// Its name.
    pub robot: String,
    /// How long after the start of the robots' movement it moved last before, in seconds.
    pub after_s: f64,
    /// How long it stood at most, in seconds.
    pub stood_s: f64,
}

/// A robot that took part in only the beginning of a run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, thiserror::Error)]
#[error("{robot} lost after {after_s:.1} s: {reason}")]
pub struct LostRobot {
    /// Its name.
    pub robot: String,
    /// How long after the start of the robots' movement it was given up, in seconds.
    pub after_s: f64,
    /// What was wrong with it.
    pub reason: String,
}

/// How a run ended, in a word.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(into = "&'static str")]
pub enum EndingKind {
    /// All of it was run and recorded: it counts.
    Completed,
    /// It is no evidence, for a cause that was established before its result.
    Void,
    /// It was stopped before its end.
    Aborted,
    /// It could not be started, or not be recorded.
    Failed,
}

impl EndingKind {
    const ALL: [Self; 4] = [Self::Completed, Self::Void, Self::Aborted, Self::Failed];

    /// The ending that is written so in bags; `None` if none is.
    pub fn from_key(key: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|kind| kind.key() == key)
    }

    /// As it is written in bags.
    pub fn key(self) -> &'static str {
        match self {
            Self::Completed => "completed",
            Self::Void => "void",
            Self::Aborted => "aborted",
            Self::Failed => "failed",
        }
    }
}

impl From<EndingKind> for &'static str {
    fn from(kind: EndingKind) -> Self {
        kind.key()
    }
}

/// Key of the run's id beside its ending.
const RUN_ID: &str = "run_id";

/// Why a text is no ending.
#[derive(Debug, thiserror::Error)]
pub enum InvalidEnding {
    /// It is no JSON of texts.
    #[error("expected a JSON object of texts")]
    Json(#[from] serde_json::Error),
    /// It names no run.
    #[error("names no `{RUN_ID}`")]
    NoRun,
    /// It names no ending.
    #[error("has {pairs:?}, which is no ending")]
    NoEnding {
        /// The value found.
        pairs: BTreeMap<String, String>,
    },
}

impl Ending {
    /// The ending of a run that lost no robot, without a reason.
    pub fn completed() -> Self {
        Self {
            kind: EndingKind::Completed,
            reason: String::new(),
            lost: Vec::new(),
            paused: Vec::new(),
        }
    }

    /// The ending as a bag's metadata holds it: `lost` and `paused` are JSON lists, left out where no
    /// robot was.
    ///
    /// # Panics
    ///
    /// Never: these robots are plain data.
    pub fn to_pairs(&self) -> BTreeMap<String, String> {
        let mut pairs = BTreeMap::from([
            ("ending".to_owned(), self.kind.key().to_owned()),
            ("reason".to_owned(), self.reason.clone()),
        ]);
        if !self.lost.is_empty() {
            let lost = serde_json::to_string(&self.lost).expect("lost robots are plain data");
            pairs.insert("lost".to_owned(), lost);
        }
        if !self.paused.is_empty() {
            let paused = serde_json::to_string(&self.paused).expect("pauses are plain data");
            pairs.insert("paused".to_owned(), paused);
        }
        pairs
    }

    /// The ending of a run as JSON, for a message of its own: the pairs of [`Self::to_pairs`] beside
    /// `run_id`.
    ///
    /// # Panics
    ///
    /// Never: pairs of texts are plain data.
    pub fn to_json(&self, run_id: &str) -> String {
        let mut pairs = self.to_pairs();
        pairs.insert(RUN_ID.to_owned(), run_id.to_owned());
        serde_json::to_string(&pairs).expect("pairs of texts are plain data")
    }

    /// Reads what [`Self::to_json`] has written: the ending, and the id of its run.
    pub fn from_json(text: &str) -> Result<(Self, String), InvalidEnding> {
        let mut pairs: BTreeMap<String, String> = serde_json::from_str(text)?;
        let run_id = pairs.remove(RUN_ID).ok_or(InvalidEnding::NoRun)?;
        Ok((Self::from_pairs(&pairs).ok_or(InvalidEnding::NoEnding { pairs })?, run_id))
    }

    /// Reads an ending back; `None` if it is none of ours, or contains what none of ours does.
    pub fn from_pairs(pairs: &BTreeMap<String, String>) -> Option<Self> {
        let key = pairs.get("ending")?;
        let kind = EndingKind::from_key(key)?;
        let reason = pairs.get("reason").cloned().unwrap_or_default();
        Some(Self { kind, reason, lost: list(pairs, "lost")?, paused: list(pairs, "paused")? })
    }
}

/// The list under a key, empty without one; `None` if it does not read.
fn list<T: serde::de::DeserializeOwned>(
    pairs: &BTreeMap<String, String>,
    key: &str,
) -> Option<Vec<T>> {
    pairs.get(key).map_or(Some(Vec::new()), |text| serde_json::from_str(text).ok())
}

#[cfg(test)]
pub(crate) mod tests {
    use rsrs_core::conditions::Placement;

    use super::*;
    use crate::experiment::ExperimentFile;
    use crate::runner::Outcome;

    const SHIPPED: &str = include_str!("../../../launch_configs/experiments/flockbot_milling.yaml");
    use rsrs_testing::conditions::flockbot;

    /// Of the shipped experiment, in lockstep.
    pub(crate) fn record() -> ExperimentRecord {
        let profile = flockbot();
        let experiment = ExperimentFile::parse("experiment.yaml", SHIPPED).unwrap();
        let settings = experiment.settings(experiment.cell.as_ref().unwrap()).unwrap();
        let conditions = Conditions::resolve(&profile, &settings).unwrap();
        ExperimentRecord {
            run_id: "run".to_owned(),
            robots: (1..=9).map(|robot| format!("robot_{robot}")).collect(),
            provenance: RecordProvenance::new(&profile.digest(), &conditions),
            conditions,
            duration_s: experiment.duration_s,
            seed: experiment.seed,
            replicate: 0,
            robot_lost: experiment.robot_lost,
            backend: Backend::Simulator,
            controller_only: Vec::new(),
            pose_source: Some(PoseSource::Odom),
            tracker: None,
            time: experiment.simulator.time,
            gates: BTreeMap::new(),
            own_profiles: BTreeMap::new(),
            fixed: None,
        }
    }

    #[test]
    fn a_record_reads_back_to_the_bit() {
        let record = record();

        let read = ExperimentRecord::from_json(&record.to_json()).unwrap();

        assert_eq!(read, record);
        assert_eq!(format!("{:016x}", read.conditions.digest()), read.provenance.conditions_digest);
    }

    #[test]
    fn a_record_of_what_no_run_can_have_had_is_refused() {
        let refusal = |change: fn(&mut ExperimentRecord)| {
            let mut record = record();
            change(&mut record);
            ExperimentRecord::from_json(&record.to_json()).unwrap_err().to_string()
        };

        let period = "conditions.period_s is -1, expected a number from 0.001 to 2";
        assert_eq!(refusal(|it| it.conditions.period_s = -1.0), period);
        assert!(refusal(|it| it.conditions.period_s = 1e300).contains("expected a number"));
        assert!(refusal(|it| it.conditions.period_s = 1e-9).contains("expected a number"));
        let duration =
            "duration_s is 1000000000000, expected a time above 0 s, and at most 604800 s";
        assert_eq!(refusal(|it| it.duration_s = 1e12), duration);
        let name = "`robot_8 yes\u{1b}[1A` is no name of a robot";
        assert_eq!(refusal(|it| it.robots[0] = "robot_8 yes\u{1b}[1A".to_owned()), name);
    }

    #[test]
    fn a_record_without_the_source_of_poses_reads_and_leaves_it_unknown() {
        let written = record().to_json().replace("\"pose_source\":\"odom\",", "");

        let read = ExperimentRecord::from_json(&written).unwrap();

        assert_eq!(read, ExperimentRecord { pose_source: None, ..record() });
        assert_eq!(read.to_json(), written, "and it is written as it was");
    }

    #[test]
    fn a_record_without_own_profiles_is_written_as_ever_and_one_with_them_reads_back() {
        let own = OwnProfile { digest: "3f".to_owned(), differs: vec!["a 1 (fleet 2)".to_owned()] };
        let own = ExperimentRecord {
            own_profiles: BTreeMap::from([("robot_3".to_owned(), own)]),
            ..record()
        };

        assert!(!record().to_json().contains("own_profiles"));
        assert_eq!(ExperimentRecord::from_json(&own.to_json()).unwrap(), own);
        assert_eq!(own.own_profiles["robot_3"].to_string(), "own profile: a 1 (fleet 2)");
    }

    #[test]
    fn the_shipped_experiment_is_the_papers_best_cell() {
        let operator_conditions = record().operator_conditions();

        assert_eq!(operator_conditions.robots, 9);
        assert_eq!(operator_conditions.placement, Placement::DiscFacingOut { radius_m: 0.825 });
        assert_eq!(operator_conditions.controller.digest(), {
            let best = rsrs_core::robot::controller::ControllerParameters::mirrored(0.15, 0.75);
            best.digest()
        });
    }

    #[test]
    fn a_run_that_lost_a_robot_counts_only_by_a_rule_that_was_fixed_beforehand() {
        let lost = |after_s: f64| {
            let (robot, reason) = ("robot_3".to_owned(), "silent".to_owned());
            vec![LostRobot { robot, after_s, reason }]
        };
        let record = |robot_lost| ExperimentRecord { robot_lost, ..record() };

        // It lasts 300 s, of which the last 60 are judged.
        let until_judged = record(RobotLost::AbortUntilJudged);
        assert!(until_judged.counts_without(&[]));
        assert!(until_judged.counts_without(&lost(240.0)));
        assert!(!until_judged.counts_without(&lost(239.9)));
        assert!(!until_judged.counts_without(&[lost(250.0), lost(20.0)].concat()));
        for robot_lost in [RobotLost::Abort, RobotLost::Note] {
            assert!(record(robot_lost).counts_without(&[]));
            assert!(!record(robot_lost).counts_without(&lost(299.0)));
        }
    }

    #[test]
    fn an_ending_reads_back() {
        let ending = Ending::new(&Outcome::Void { reason: "frozen".to_owned() }, &[], &[]);

        assert_eq!(Ending::from_pairs(&ending.to_pairs()), Some(ending.clone()));
        assert_eq!(Ending::from_json(&ending.to_json("r")).unwrap(), (ending, "r".to_owned()));
        assert_eq!(Ending::from_pairs(&BTreeMap::new()), None);
        for (text, expected) in [
            ("over", "expected a JSON object of texts"),
            ("{\"ending\": \"void\"}", "names no `run_id`"),
            ("{\"run_id\": \"r\", \"ending\": \"well\"}", "which is no ending"),
        ] {
            assert!(Ending::from_json(text).unwrap_err().to_string().contains(expected));
        }
    }

    #[test]
    fn an_ending_names_who_stood_for_a_moment() {
        let paused = PausedRobot { robot: "robot_3".to_owned(), after_s: 20.4, stood_s: 0.42 };
        let ending = Ending { paused: vec![paused.clone()], ..Ending::completed() };

        let read = Ending::from_json(&ending.to_json("r")).unwrap();

        assert_eq!(read, (ending, "r".to_owned()));
        let text = "robot_3 stood for at most 0.4 s after 20.4 s: lease ran out";
        assert_eq!(paused.to_string(), text);
    }

    #[test]
    fn an_ending_names_who_was_lost_and_when() {
        let lost = LostRobot {
            robot: "robot_3".to_owned(),
            after_s: 20.4,
            reason: "silent for more than 1 s".to_owned(),
        };
        let ending = Ending { lost: vec![lost.clone()], ..Ending::completed() };

        let pairs = ending.to_pairs();

        assert_eq!(Ending::from_pairs(&pairs), Some(ending));
        assert_eq!(lost.to_string(), "robot_3 lost after 20.4 s: silent for more than 1 s");
        let unreadable = BTreeMap::from([
            ("ending".to_owned(), "completed".to_owned()),
            ("lost".to_owned(), "yesterday".to_owned()),
        ]);
        assert_eq!(Ending::from_pairs(&unreadable), None, "it is not taken for a whole run");
    }

    #[test]
    fn a_record_of_another_version_is_refused_by_its_version() {
        let newer = record()
            .to_json()
            .replace("\"schema_version\":1", "\"schema_version\":2")
            .replacen('{', "{\"key_of_that_version\":true,", 1);

        let error = ExperimentRecord::from_json(&newer).unwrap_err();

        assert!(matches!(error, RecordError::Version { found: 2 }), "{error}");
    }
}
