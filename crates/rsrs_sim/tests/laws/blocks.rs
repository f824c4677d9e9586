//! Laws of a sweep's blocks: they hold all of the work once, and who does them does not matter.

use std::collections::BTreeMap;
use std::convert::Infallible;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};

use proptest::prelude::*;
use rsrs_core::conditions::{Conditions, Placement};

use rsrs_sim::sweep::{
    Block, BlockError, CellReplicates, Completion, MOST_ROWS, Progress, ReplicateOutcome, Runs,
    SweepError, Watch, Work, blocks, check, run_blocks,
};
use rsrs_testing::conditions::objects_anywhere;

use crate::support::{HARSHER, flockbots, quietly};

/// Cells of few robots, of many, and of more than a vector runs.
fn cells() -> Vec<Conditions> {
    let cell = |robots: usize| {
        let placement = Placement::DiscFacingOut { radius_m: 0.3 * (robots as f64).sqrt() };
        Conditions { robots, placement, ..flockbots(0.15, 0.75, &HARSHER) }
    };
    [2, 9, 200, 300, 5000].map(cell).to_vec()
}

fn pieces() -> impl Strategy<Value = Vec<CellReplicates>> {
    let piece = (0..5_usize, 0..100_u64, 0..6000_u64);
    let piece =
        piece.prop_map(|(cell, first, n)| CellReplicates { cell, replicates: first..first + n });
    proptest::collection::vec(piece, 0..6)
}

proptest! {
    #[test]
    fn blocks_hold_all_of_the_work_once_and_in_order(work in pieces(), duration_s in 60.0..600.0) {
        let cells = cells();
        let rows = |pieces: &[CellReplicates]| Block { pieces: pieces.to_vec() }.rows().collect::<Vec<_>>();

        let blocks: Vec<Block> = blocks(&cells, duration_s, work.clone()).collect();

        let held: Vec<_> = blocks.iter().flat_map(Block::rows).collect();
        prop_assert_eq!(held, rows(&work));
        for block in &blocks {
            prop_assert!((1..=MOST_ROWS).contains(&block.n_rows()), "{} rows", block.n_rows());
            prop_assert!(block.pieces.iter().all(|piece| piece.n_rows() > 0));
        }
    }

    #[test]
    fn cells_that_run_in_vectors_are_cut_where_those_of_any_machine_are_full(work in pieces()) {
        let cells = cells();

        let blocks: Vec<Block> = blocks(&cells, 300.0, work.clone()).collect();

        let ends = |piece: &CellReplicates| work.iter().any(|whole| {
            whole.cell == piece.cell && whole.replicates.end == piece.replicates.end
        });
        for piece in blocks.iter().flat_map(|block| &block.pieces).filter(|piece| piece.cell < 3) {
            prop_assert!(piece.n_rows() % 16 == 0 || ends(piece), "{piece:?}");
        }
    }
}

#[test]
fn little_work_is_cut_as_well_and_by_what_it_takes() {
    let plain = flockbots(0.15, 0.75, &HARSHER);
    let mut with_objects = plain.clone();
    with_objects.world.objects = vec![objects_anywhere(20, 0.05, 0.0)];
    let cells = [plain, with_objects];
    let of = |cell: usize, n: u64| -> Vec<u64> {
        let work = [CellReplicates { cell, replicates: 0..n }];
        blocks(&cells, 300.0, work).map(|block| block.n_rows()).collect()
    };

    assert_eq!(of(0, 64), [16; 4], "full vectors stay together");
    assert_eq!(of(0, 40), [16, 24], "and what is less than one is no block of its own");
    assert_eq!(of(1, 32), [2; 16]);
    assert_eq!(of(1, 3), [1; 3]);
    let (most, most_with_objects) = (of(0, 100_000)[0], of(1, 100_000)[0]);
    assert!(most > 50 * most_with_objects, "{most} {most_with_objects}");
}

const DURATION_S: f64 = 60.0;

/// Two cells with 3,000 replicates each, in 17 blocks.
fn two_cells() -> (Vec<Conditions>, Vec<(u64, Block)>) {
    let cells = [0.10, 0.20].map(|speed_m_s| flockbots(speed_m_s, 0.75, &HARSHER)).to_vec();
    let work: Vec<CellReplicates> =
        (0..2).map(|cell| CellReplicates { cell, replicates: 0..3000 }).collect();
    let blocks = (0..).zip(blocks(&cells, DURATION_S, work)).collect();
    (cells, blocks)
}

type Kept = BTreeMap<u64, Vec<ReplicateOutcome>>;

fn work(conditions: &[Conditions], n_threads: usize) -> Work<'_> {
    let start = Progress { done: 0, total: 6000 };
    Work { conditions, seed: 7, duration_s: DURATION_S, n_threads, start, also: &[] }
}

#[test]
fn blocks_that_are_done_in_any_order_at_any_time_make_the_sweep() {
    let (cells, blocks) = two_cells();
    let runs = Runs { seed: 7, replicates: 3000, duration_s: DURATION_S, n_threads: 2 };
    let kept: Mutex<Kept> = Mutex::default();
    let keep = |number, _: &Block, outcomes| -> Result<(), Infallible> {
        kept.lock().expect("no panic").insert(number, outcomes);
        Ok(())
    };
    let watch = Watch { progress: &|_| {}, cancel: &AtomicBool::new(false) };

    let (last, first) = (blocks[2..].iter().cloned(), blocks[..2].iter().cloned());
    run_blocks(work(&cells, 2), last, watch, &keep).expect("the robots fit");
    run_blocks(work(&cells, 1), first, watch, &keep).expect("the robots fit");

    let kept = kept.into_inner().expect("no panic");
    assert_eq!(blocks.len(), 17);
    let outcomes: Vec<_> = kept.into_values().flatten().collect();
    assert!(outcomes == quietly(&cells, runs).outcomes);
}

#[test]
fn what_is_called_off_has_kept_whole_blocks() {
    let (cells, blocks) = two_cells();
    let (cancel, n_kept) = (AtomicBool::new(false), Mutex::new(0));
    let keep = |_, block: &Block, outcomes: Vec<ReplicateOutcome>| -> Result<(), Infallible> {
        assert_eq!(outcomes.len() as u64, block.n_rows());
        *n_kept.lock().expect("no panic") += 1;
        Ok(())
    };
    let progress = |progress: Progress| cancel.store(progress.done > 400, Ordering::Relaxed);
    let watch = Watch { progress: &progress, cancel: &cancel };

    let ending = run_blocks(work(&cells, 1), blocks.into_iter(), watch, &keep);

    assert_eq!(ending, Ok(Completion::CalledOff));
    assert_eq!(n_kept.into_inner().expect("no panic"), 1);
}

#[test]
fn what_cannot_be_kept_ends_the_work() {
    let (cells, blocks) = two_cells();
    let watch = Watch { progress: &|_| {}, cancel: &AtomicBool::new(false) };

    let ending =
        run_blocks(work(&cells, 2), blocks.into_iter(), watch, &|number, _, _| Err(number));

    assert!(matches!(ending, Err(BlockError::KeepBlock(_))), "{ending:?}");
}

#[test]
fn what_can_never_be_run_is_seen_before_anything_is() {
    let runs = Runs { seed: 7, replicates: 1, duration_s: 300.0, n_threads: 1 };
    let good = flockbots(0.15, 0.75, &HARSHER);
    let second = |changed: Conditions| check(&[good.clone(), changed], runs).unwrap_err();

    let no_robots = second(Conditions { robots: 0, ..good.clone() });
    let crowd = second(Conditions { robots: 500, ..good.clone() });
    let short = check(std::slice::from_ref(&good), Runs { duration_s: 30.0, ..runs }).unwrap_err();

    assert_eq!(check(std::slice::from_ref(&good), runs), Ok(()));
    assert!(matches!(no_robots, SweepError::Judge { cell: 1, .. }), "{no_robots}");
    assert!(matches!(crowd, SweepError::Placement { cell: 1, .. }), "{crowd}");
    assert!(matches!(short, SweepError::Judge { cell: 0, .. }), "{short}");
}
