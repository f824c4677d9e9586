//! A phase diagram, judged: by the reference, one world after the other, and by the sweep.
//!
//! Cells are 4 × 4 and not 20 × 20, so that a run ends while one waits; the item rate is the same.

fn main() {
    divan::main();
}

const N_PER_AXIS: usize = 4;
const REPLICATES: u64 = 100;

mod diagram {
    use std::sync::atomic::AtomicBool;

    use divan::counter::ItemsCount;
    use divan::{Bencher, black_box};
    use rsrs_benches::plain::PlainWorld;
    use rsrs_benches::{STEPS, diagram};
    use rsrs_core::judge::phase;
    use rsrs_core::judge::trajectory::Trajectory;
    use rsrs_core::robot::controller::decide;
    use rsrs_sim::batch::{Batch, VectorUnit};
    use rsrs_sim::draw::Seed;
    use rsrs_sim::episode::run_episode;
    use rsrs_sim::sweep::{Runs, Watch, sweep};

    use super::{N_PER_AXIS, REPLICATES};

    fn items(replicates: u64) -> ItemsCount {
        ItemsCount::new((N_PER_AXIS * N_PER_AXIS) as u64 * replicates * STEPS * 9)
    }

    /// The loop that one would write first, and the judge; one replicate of each cell.
    #[divan::bench(sample_count = 10)]
    fn plain(bencher: Bencher<'_, '_>) {
        let cells = diagram(N_PER_AXIS);
        bencher.counter(items(1)).bench_local(|| {
            for conditions in &cells {
                let mut world = PlainWorld::new(conditions, Seed { seed: 1, replicate: 0 });
                let mut trajectory = Trajectory::new(conditions.period_s, conditions.robots);
                let command =
                    decide(true, conditions.controller.parameters().expect("two commands"));
                for _ in 0..STEPS {
                    trajectory.poses.extend(world.poses());
                    trajectory.commands.extend((0..conditions.robots).map(|_| command));
                    world.step();
                }
                black_box(phase::label(&trajectory, &conditions.bodies()).expect("long enough"));
            }
        });
    }

    /// The reference world and the judge; one replicate of each cell.
    #[divan::bench(sample_count = 10)]
    fn reference(bencher: Bencher<'_, '_>) {
        let cells = diagram(N_PER_AXIS);
        bencher.counter(items(1)).bench_local(|| {
            for conditions in &cells {
                let seed = Seed { seed: 1, replicate: 0 };
                let trajectory = run_episode(conditions, seed, 300.0).expect("the robots fit");
                black_box(phase::label(&trajectory, &conditions.bodies()).expect("long enough"));
            }
        });
    }

    /// The batch on one thread.
    #[divan::bench(args = VectorUnit::available(), sample_count = 10)]
    fn batch(bencher: Bencher<'_, '_>, unit: VectorUnit) {
        let cells = diagram(N_PER_AXIS);
        let mut batch = Batch::on(unit).expect("an available unit");
        let replicates = 2 * batch.lanes() as u64;
        bencher.counter(items(replicates)).bench_local(|| {
            for conditions in &cells {
                black_box(batch.judge(conditions, 1, 0..replicates, 300.0).expect("they fit"));
            }
        });
    }

    /// The sweep as the command line runs it, without its files; by number of threads.
    #[divan::bench(args = [1, 2], sample_count = 10)]
    fn sweep_on_threads(bencher: Bencher<'_, '_>, n_threads: usize) {
        let cells = diagram(N_PER_AXIS);
        let cancel = AtomicBool::new(false);
        let runs = Runs { seed: 1, replicates: REPLICATES, duration_s: 300.0, n_threads };
        bencher.counter(items(REPLICATES)).bench_local(|| {
            let watch = Watch { progress: &|_| {}, cancel: &cancel };
            sweep(&cells, runs, watch).expect("the robots fit")
        });
    }
}
