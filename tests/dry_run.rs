//! The whole loop, as a newcomer runs it.

use std::f64::consts::TAU;
use std::io::BufRead;
use std::path::Path;
use std::sync::atomic::AtomicBool;

use crate::command::{code, repository, rsrs, stderr};
use crate::processes::{Process, confined_rsrs, nodes_of};
use rsrs_bags::Bag;
use rsrs_core::comparison::{Verdict, decide};
use rsrs_core::diagram::choice::Choice;
use rsrs_core::judge::phase::Phase;
use rsrs_core::robot::other_profile::OtherProfile;
use rsrs_core::statistics::e_value::TestedCell;
use rsrs_core::statistics::pooled::PooledTest;
use rsrs_core::statistics::share::Share;
use rsrs_experiment_runner::plan::{Plan, Request};
use rsrs_fleet::placement::PlaceCheck;
use rsrs_fleet::record::{ATTACHMENT, Backend, Ending, ExperimentRecord};
use rsrs_msgs::cdr;
use rsrs_msgs::geometry_msgs::TwistStamped;
use rsrs_msgs::nav_msgs::Odometry;
use rsrs_msgs::rsrs::WorldDigest;
use rsrs_msgs::std_msgs;
use rsrs_msgs::topics;
use rsrs_sim::draw::Seed;
use rsrs_sim::episode::{episode_digests, run_episode};
use rsrs_sim::sweep::{Runs, Watch, sweep};
use rsrs_testing::environment::number;

#[test]
fn the_whole_loop_leaves_bags_that_pass_through_the_states_of_the_replicates() {
    for _ in 0..number("RSRS_DRY_RUNS").unwrap_or(1) {
        let folder = tempfile::tempdir().unwrap();
        let mut command = confined_rsrs();
        command.current_dir(&folder).args(["dry-run", "--experiments", "2", "-o", "loop"]);
        let mut process = Process::start(command.args(["--format", "json"]));
        let pid = process.0.id();
        let stdout = process.0.stdout.take().unwrap();
        let reading = std::thread::spawn(move || std::io::read_to_string(stdout).unwrap());

        let (status, errors) = process.wait();

        assert!(status.success(), "{errors}");
        assert_eq!(nodes_of(pid), Vec::<u32>::new());
        let summary: serde_json::Value = serde_json::from_str(&reading.join().unwrap()).unwrap();
        let loop_folder = folder.path().join("loop");
        for file in ["sweep/cells.csv", "sweep/choice.json", "diagram.png", "comparison.json"] {
            assert!(loop_folder.join(file).is_file(), "{file}");
        }
        assert_eq!(summary["comparison"]["bags"].as_array().unwrap().len(), 2);
        let records: Vec<ExperimentRecord> = ["experiment_1", "experiment_2"]
            .map(|bag| check_bag(&loop_folder.join("bags").join(bag)))
            .into();
        assert_ne!(records[0].seed, records[1].seed);
        assert_eq!(records[0].conditions, records[1].conditions);
    }
}

/// A folder of robots of one's own.
const INIT: &str = "init mine --name epuck --robots 6 --radius 0.035 --speed 0.12 --turn-rate 2 \
                    --range 0.5 --half-angle 0.25 --period 0.2 --arena 3";

#[test]
fn how_many_experiments_are_run_at_a_time_changes_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let output = rsrs(folder.path(), &INIT.split_whitespace().collect::<Vec<_>>());
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    let comparison = |threads: &str| {
        let name = format!("by_{threads}");
        let mut command = confined_rsrs();
        let arguments = ["dry-run", "mine", "--experiments", "2", "--threads", threads];
        command.current_dir(&folder).args(arguments).args(["-o", &name]);
        let (status, errors) = Process::start(&mut command).wait();
        assert!(status.success(), "{errors}");
        let page = std::fs::read_to_string(folder.path().join(&name).join("report.html")).unwrap();
        assert!(page.contains("experiment_2"), "the report shows every run");
        let text = std::fs::read_to_string(folder.path().join(&name).join("comparison.json"));
        text.unwrap().replace(&name, "out")
    };

    assert_eq!(comparison("1"), comparison("2"));
}

#[test]
fn a_folder_that_is_none_of_ones_own_robots_is_refused() {
    let folder = tempfile::tempdir().unwrap();

    let output = rsrs(folder.path(), &["dry-run", "here"]);

    assert_eq!(code(&output), 1);
    assert!(stderr(&output).contains("here/sweep.yaml is missing"), "{}", stderr(&output));
    assert!(!folder.path().join("results").exists());
}

#[test]
fn an_experiment_of_a_dry_run_that_fails_before_the_first_step_is_tried_again() {
    let folder = tempfile::tempdir().unwrap();
    let mut command = confined_rsrs();
    command.current_dir(&folder).args(["dry-run", "--experiments", "1", "-o", "loop"]);
    let mut process = Process::start(&mut command);
    let mut stdout = std::io::BufReader::new(process.0.stdout.take().unwrap());
    let mut printed = String::new();
    let mut until = |what: &str| {
        while !printed.contains(what) {
            let n_bytes = stdout.read_line(&mut printed).unwrap();
            assert!(n_bytes > 0, "it never printed {what:?}: {printed}");
        }
    };

    // The sweep goes on meanwhile, and nobody publishes such a topic.
    until("profile: ");
    let file = folder.path().join("loop/launch_configs/experiments/flockbot_milling.yaml");
    let whole = std::fs::read_to_string(&file).unwrap();
    std::fs::write(&file, format!("{whole}\nrecord: {{topics: [/nobodys]}}\n")).unwrap();
    until("experiment 1 of 1: seed 1: failed: /nobodys");
    // The program may read it at any moment.
    let beside = file.with_extension("whole");
    std::fs::write(&beside, whole).unwrap();
    std::fs::rename(&beside, &file).unwrap();
    until("comparison.json");
    let (status, errors) = process.wait();

    assert!(status.success(), "{errors}");
    assert!(printed.contains("it does not count, and is tried again"), "{printed}");
    let record = check_bag(&folder.path().join("loop/bags/experiment_1"));
    assert_eq!(record.seed, 1, "the same world");
}

/// What `dry-run` does unless it is asked for a number of experiments.
const MOST_EXPERIMENTS: usize = 60;
const MARGIN: f64 = 0.25;

#[test]
fn the_default_dry_run_ends_with_a_verdict() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let file = repository().join("launch_configs/sweeps/flockbot_speed_turn.yaml");
    let out = folder.path().join("out");
    let choice = out.join("choice.json");
    let text = |path: &Path| path.to_str().expect("it is UTF-8").to_owned();
    for arguments in
        [["sweep", &text(&file), "-o", &text(&out)], ["choose", &text(&out), "-o", &text(&choice)]]
    {
        let output = rsrs(folder.path(), &arguments);
        assert_eq!(code(&output), 0, "{}", stderr(&output));
    }
    let chosen = std::fs::read_to_string(&choice).expect("it was written");
    let chosen: Choice = serde_json::from_str(&chosen).expect("it is a choice");
    let simulated = Share::milling(&chosen.phases.expect("a new choice has them"));
    let plan = Plan::read(&Request {
        experiment: repository().join("launch_configs/experiments/flockbot_milling.yaml"),
        cell: None,
        from: Some(out),
        backend: Backend::Simulator,
        bag: Some(folder.path().join("none")),
        seed: Some(1),
        place_check: PlaceCheck::Off,
        other_profile: OtherProfile::Refused,
    })
    .expect("it is the experiment of the dry run");

    // A hundred dry runs, without DDS: the same world, the same judge.
    let n_campaigns = 100;
    let runs = Runs {
        seed: 1,
        replicates: (n_campaigns * MOST_EXPERIMENTS) as u64,
        duration_s: plan.record.duration_s,
        n_threads: 2,
    };
    let watch = Watch { progress: &|_| (), cancel: &AtomicBool::new(false) };
    let conditions = std::slice::from_ref(&plan.record.conditions);
    let swept = sweep(conditions, runs, watch).expect("it can be simulated");
    let campaigns = swept.outcomes.chunks(MOST_EXPERIMENTS).map(|campaign| {
        let mut real = Share::default();
        let mut decided = campaign.iter().zip(1..).filter_map(|(run, n)| {
            real.n += 1;
            real.hits += u64::from(run.phase == Phase::STABLE_MILLING);
            let test = PooledTest::new(&[TestedCell { real, simulated, part: 0.5 }], MARGIN);
            let verdict = decide(test.log_e());
            (verdict != Verdict::Undecided).then_some((n, verdict))
        });
        decided.next()
    });
    let ends: Vec<(usize, Verdict)> = campaigns.flatten().collect();

    // Eighteen of twenty at least; and robots that mill as often or more are not called worse.
    assert!(ends.len() >= 90, "{} of {n_campaigns} ended with a verdict: {ends:?}", ends.len());
    let n_violated = ends.iter().filter(|(_, verdict)| *verdict == Verdict::Violated).count();
    assert!(n_violated <= 5, "{n_violated} violated: {ends:?}");
    let mean = ends.iter().map(|(n, _)| *n).sum::<usize>() as f64 / ends.len() as f64;
    assert!(mean <= 25.0, "{mean} experiments on average: {ends:?}");
}

/// Checks that a bag lost nothing and that its states are those of the replicate with its seed.
fn check_bag(path: &Path) -> ExperimentRecord {
    let bag = Bag::open(path).expect("the bag is whole");
    assert_eq!(bag.damage().len(), 0);
    let record = bag.attachment(ATTACHMENT).expect("a bag of ours has a record");
    let record = std::str::from_utf8(&record.data).expect("JSON is text");
    let record = ExperimentRecord::from_json(record).expect("the record reads back");
    let [on_topic] = &messages(&bag, topics::EXPERIMENT.name)[..] else { panic!("one record") };
    let on_topic: std_msgs::String = cdr::decode(&on_topic.1).expect("it is a text");
    assert_eq!(ExperimentRecord::from_json(&on_topic.data).expect("it reads"), record);
    let [ending] = &messages(&bag, topics::ENDING.name)[..] else { panic!("one ending") };
    let ending: std_msgs::String = cdr::decode(&ending.1).expect("it is a text");
    let (ending, run_id) = Ending::from_json(&ending.data).expect("it reads");
    assert_eq!((ending, run_id), (Ending::completed(), record.run_id.clone()));
    let seed = Seed { seed: record.seed, replicate: record.replicate };
    let expected =
        episode_digests(&record.conditions, seed, record.duration_s).expect("the robots fit");
    let n_steps = expected.len();

    let digests: Vec<WorldDigest> = messages(&bag, "/swarm/world_digest")
        .into_iter()
        .map(|(_, data)| cdr::decode(&data).expect("it is a digest"))
        .collect();
    let steps: Vec<u64> = digests.iter().map(|digest| digest.step).collect();
    assert_eq!(steps, (1..=n_steps as u64).collect::<Vec<_>>());
    assert!(digests.iter().map(|digest| digest.digest).eq(expected), "{}", path.display());

    let times: Vec<u64> = (1..=n_steps as u64).map(|step| step * 130_000_000).collect();
    for robot in &record.robots {
        for topic in ["detection", "cmd_vel", "odom"] {
            let recorded = messages(&bag, &format!("/{robot}/{topic}"));
            let found: Vec<u64> = recorded.iter().map(|(time_ns, _)| *time_ns).collect();
            assert!(found == times, "{robot} {topic}: {} of {n_steps}", found.len());
        }
    }
    check_poses_and_commands(&bag, &record, seed);
    check_pictures(&bag, n_steps);
    record
}

/// What viewers show when the bag is played: frames at nearly every step, and markers.
fn check_pictures(bag: &Bag, n_steps: usize) {
    let times = |topic: &str| -> Vec<u64> {
        messages(bag, topic).into_iter().map(|(time_ns, _)| time_ns).collect()
    };
    let (frames, markers) = (times(topics::TF.name), times(topics::MARKERS.name));
    // The world does not wait for them: a busy machine leaves some out.
    assert!(frames.len() > n_steps / 3, "{} frames in {n_steps} steps", frames.len());
    assert!(markers.len() > n_steps / 20, "{} markers in {n_steps} steps", markers.len());
    let between = markers.windows(2).map(|pair| pair[1] - pair[0]);
    assert!(between.clone().all(|ns| ns >= 450_000_000), "{:?}", between.min());
}

fn check_poses_and_commands(bag: &Bag, record: &ExperimentRecord, seed: Seed) {
    let expected =
        run_episode(&record.conditions, seed, record.duration_s).expect("the robots fit");
    for (index, robot) in record.robots.iter().enumerate() {
        let of_robot = |row: usize| row * record.robots.len() + index;
        let poses = messages(bag, &format!("/{robot}/odom"));
        for (step, (_, bytes)) in poses.into_iter().enumerate() {
            let found = cdr::decode::<Odometry>(&bytes).expect("it is a pose").pose.pose;
            let pose = expected.poses[of_robot(step)];
            assert_eq!((found.position.x, found.position.y), (pose.x_m, pose.y_m));
            let heading_rad = 2.0 * libm::atan2(found.orientation.z, found.orientation.w);
            let apart_rad = libm::remainder(heading_rad - pose.heading_rad, TAU);
            // A quaternion in f64 keeps more of an angle than this.
            assert!(apart_rad.abs() < 1e-9, "{robot}, step {step}: {apart_rad} rad apart");
        }
        let commands = messages(bag, &format!("/{robot}/cmd_vel"));
        for (step, (_, bytes)) in commands.into_iter().enumerate() {
            let found = cdr::decode::<TwistStamped>(&bytes).expect("it is a command").twist;
            let command = expected.commands[of_robot(step)];
            assert_eq!(
                (found.linear.x, found.angular.z),
                (command.speed_m_s, command.turn_rate_rad_s)
            );
        }
    }
}

/// Log time and bytes of every message on a topic.
fn messages(bag: &Bag, topic: &str) -> Vec<(u64, Vec<u8>)> {
    bag.messages_on([topic])
        .map(|message| message.map(|message| (message.log_time_ns, message.bytes)))
        .collect::<Result<_, _>>()
        .expect("the bag is whole")
}
