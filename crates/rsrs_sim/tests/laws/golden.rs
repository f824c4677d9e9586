//! States that the world always had, feature by feature: every vector unit and the reference must
//! pass through them on every machine.
//!
//! A digest here changes only when the world does, and then the changelog lists it.

use rsrs_core::conditions::{Conditions, GainDistribution, Placement, Walls};
use rsrs_core::digest::Digest;
use rsrs_core::judge::phase::{Verdict, converged_s};
use rsrs_core::robot::profile::Sees;
use rsrs_core::robot::region::Region;
use rsrs_sim::batch::{Batch, VectorUnit};
use rsrs_sim::draw::Seed;
use rsrs_sim::episode::{episode_digests, run_episode};

use crate::support::{HARSHER, flockbots};

const N_STEPS: u64 = 500;
const SEED: u64 = 1;

/// A change to nine harsher Flockbots, and their state after 500 steps in two replicates.
type Golden = (&'static str, fn(&mut Conditions), [u64; 2]);

const GOLDEN: [Golden; 16] = [
    ("nothing", |_| {}, [0xdb65_8c60_c7c9_83c8, 0x2945_e5dd_0485_ab19]),
    (
        "2 robots",
        |conditions| conditions.robots = 2,
        [0x9904_67c3_7062_9899, 0x40c5_a437_893c_e984],
    ),
    (
        "3 robots",
        |conditions| conditions.robots = 3,
        [0x9886_9553_095d_b93a, 0xcf6f_4632_3826_8aed],
    ),
    (
        "30 robots",
        |conditions| crowd(conditions, 30, 1.5),
        [0xbd5a_bb3f_b433_1902, 0xafd8_cedd_eaeb_d129],
    ),
    (
        "100 robots",
        |conditions| crowd(conditions, 100, 2.75),
        [0x9618_8c90_68b8_96f6, 0xe4fb_8a6d_bcfb_f89f],
    ),
    (
        "centres in a cone",
        |conditions| conditions.robot.sees = Sees::Centre,
        [0x51d2_4cbf_750c_db1a, 0x281e_4453_3aad_e682],
    ),
    (
        "bodies in a polygon",
        |conditions| conditions.robot.region = hexagon(),
        [0x182a_3f08_3ff6_c977, 0x97eb_8c17_5be5_f57e],
    ),
    ("centres in a polygon", centres_in_a_polygon, [0xec5f_7207_a3c7_c95b, 0xaed4_17ae_e807_f383]),
    (
        "gusts",
        |conditions| conditions.robot.gust_sd_m_s = 0.02,
        [0x66f0_9dd7_56fe_67b9, 0x5dc7_4929_ab91_aaaa],
    ),
    (
        "yaw lag",
        |conditions| conditions.robot.yaw_lag_s = 0.5,
        [0x6fcf_69a4_d636_f8ed, 0xf0c8_22fc_7ed6_078f],
    ),
    (
        "latency",
        |conditions| conditions.robot.latency_steps = 3,
        [0xc1c8_9bd1_791b_665e, 0x3766_3efd_56ae_7365],
    ),
    (
        "walls that stop",
        |conditions| confine(conditions, Walls::Stop),
        [0x6f8f_85fd_05b9_9f0e, 0x2746_9b8a_8a37_c415],
    ),
    (
        "walls that clamp",
        |conditions| confine(conditions, Walls::Clamp),
        [0x865c_39be_efda_0983, 0x5a69_9a9d_22b1_8bb8],
    ),
    (
        "no walls",
        |conditions| confine(conditions, Walls::None),
        [0x0771_fbcc_94e9_4dab, 0x834b_3e36_724e_ec5c],
    ),
    ("noise from step to step", noise, [0x2687_71a8_9d13_e28f, 0x4bb2_da1d_0d9c_46c8]),
    ("everything", everything, [0xeaf0_32e7_f2f6_cb8d, 0xf1a0_9ecb_4656_6c58]),
];

fn crowd(conditions: &mut Conditions, robots: usize, radius_m: f64) {
    conditions.robots = robots;
    conditions.placement = Placement::DiscFacingOut { radius_m };
}

fn hexagon() -> Region {
    let corners_m =
        vec![[0.05, -0.05], [0.4, -0.3], [0.75, -0.1], [0.75, 0.1], [0.4, 0.3], [0.05, 0.05]];
    Region::Polygon { corners_m }
}

fn centres_in_a_polygon(conditions: &mut Conditions) {
    conditions.robot.region = hexagon();
    conditions.robot.sees = Sees::Centre;
}

fn confine(conditions: &mut Conditions, walls: Walls) {
    (conditions.arena.walls, conditions.arena.side_m) = (walls, 2.0);
}

fn noise(conditions: &mut Conditions) {
    let robot = &mut conditions.robot;
    robot.speed_gain = GainDistribution { mean: 0.97, robot_sd: 0.05, step_sd: 0.05 };
    robot.turn_gain = GainDistribution { mean: 0.97, robot_sd: 0.05, step_sd: 0.05 };
    robot.turn_bias_sd_rad_s = 0.05;
    robot.heading_noise_sd_rad = 0.02;
}

fn everything(conditions: &mut Conditions) {
    crowd(conditions, 12, 0.9);
    noise(conditions);
    confine(conditions, Walls::Clamp);
    conditions.robot.region = hexagon();
    conditions.robot.gust_sd_m_s = 0.02;
    conditions.robot.yaw_lag_s = 0.5;
    conditions.robot.latency_steps = 3;
    conditions.robot.rotates_while_blocked = false;
}

/// The last of the digests of two replicates.
fn on_unit(unit: VectorUnit, conditions: &Conditions) -> [u64; 2] {
    let mut batch = Batch::on(unit).expect("an available unit");
    let digests = batch.digests(conditions, SEED, 0..2, N_STEPS + 1).expect("the robots fit");
    [0, 1].map(|replicate: usize| *digests[replicate].last().expect("some steps"))
}

fn of_reference(conditions: &Conditions) -> [u64; 2] {
    // Half a period more, so that no rounding takes a step away.
    let duration_s = (N_STEPS as f64 + 1.5) * conditions.period_s;
    [0, 1].map(|replicate| {
        let seed = Seed { seed: SEED, replicate };
        let digests = episode_digests(conditions, seed, duration_s).expect("the robots fit");
        *digests.last().expect("some steps")
    })
}

fn golden_conditions(change: fn(&mut Conditions)) -> Conditions {
    let mut conditions = flockbots(0.15, 0.75, &HARSHER);
    change(&mut conditions);
    conditions
}

#[test]
fn every_feature_has_the_bits_that_it_always_had_on_every_unit() {
    let mut differences = Vec::new();

    for (name, change, golden) in GOLDEN {
        let conditions = golden_conditions(change);
        let reference = ("reference".to_owned(), of_reference(&conditions));
        let units = VectorUnit::available()
            .into_iter()
            .map(|unit| (format!("{unit:?}"), on_unit(unit, &conditions)));
        for (who, found) in std::iter::once(reference).chain(units) {
            if found != golden {
                differences.push(format!("{name} on {who}: {found:#018x?}"));
            }
        }
    }

    assert_eq!(differences, Vec::<String>::new());
}

#[test]
fn every_feature_is_another_world() {
    let digests: Vec<u64> = GOLDEN.iter().flat_map(|(_, _, golden)| *golden).collect();

    for (index, digest) in digests.iter().enumerate() {
        assert!(!digests[..index].contains(digest), "{:?}", GOLDEN[index / 2].0);
    }
}

/// What is found about a replicate.
#[derive(Debug)]
#[expect(dead_code, reason = "its text is what counts")]
struct Judged {
    verdict: Verdict,
    /// By the reference.
    converged_s: Option<f64>,
}

/// What the judge finds in 16 replicates of 150 s, blocks of the window included, all numbers to the bit.
const GOLDEN_VERDICTS: u64 = 0x8968_c053_e18b_3add;

#[test]
fn replicates_are_judged_as_they_always_were_on_every_unit() {
    let conditions = golden_conditions(|_| {});

    for unit in VectorUnit::available() {
        let mut batch = Batch::on(unit).expect("an available unit");
        let verdicts = batch.judge(&conditions, SEED, 0..16, 150.0).expect("fit and long");
        let judged: Vec<Judged> = (0..)
            .zip(verdicts)
            .map(|(replicate, verdict)| {
                let seed = Seed { seed: SEED, replicate };
                let run = run_episode(&conditions, seed, 150.0).expect("the robots fit");
                let converged_s = converged_s(&run, &conditions.bodies(), verdict.phase);
                Judged { verdict, converged_s }
            })
            .collect();
        let mut digest = Digest::new("verdicts");
        digest.text(&format!("{judged:?}"));

        let found = digest.value();
        assert_eq!(found, GOLDEN_VERDICTS, "{unit:?}: found {found:#018x}");
    }
}
