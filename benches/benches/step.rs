//! Steps of one cell's worlds: the loop that one would write first, the reference world, and the
//! batch on every vector unit of this machine. Nothing is judged here.

use divan::counter::ItemsCount;
use divan::{Bencher, black_box};
use rsrs_benches::flockbots;
use rsrs_benches::plain::PlainWorld;
use rsrs_core::conditions::Conditions;
use rsrs_core::robot::controller::{Command, decide};
use rsrs_sim::batch::{Batch, VectorUnit};
use rsrs_sim::draw::Seed;
use rsrs_sim::world::World;

fn main() {
    divan::main();
}

const SEED: Seed = Seed { seed: 1, replicate: 0 };

fn plain(bencher: Bencher<'_, '_>, robots: usize, n_steps: u64) {
    let conditions = flockbots(robots);
    bencher
        .counter(ItemsCount::new(n_steps * robots as u64))
        .with_inputs(|| PlainWorld::new(&conditions, SEED))
        .bench_local_refs(|world| {
            for _ in 0..n_steps {
                world.step();
            }
            black_box(world.poses().next())
        });
}

fn reference(bencher: Bencher<'_, '_>, robots: usize, n_steps: u64) {
    let conditions = flockbots(robots);
    bencher
        .counter(ItemsCount::new(n_steps * robots as u64))
        .with_inputs(|| World::new(&conditions, SEED).expect("the robots fit"))
        .bench_local_refs(|world| {
            let mut commands: Vec<Command> = Vec::with_capacity(robots);
            for _ in 0..n_steps {
                commands.clear();
                commands.extend(world.sense().iter().map(|seen| {
                    decide(*seen, conditions.controller.parameters().expect("two commands"))
                }));
                world.advance(&commands);
            }
            black_box(world.digest())
        });
}

/// With placement: it is part of what a sweep pays for each replicate.
fn batch(bencher: Bencher<'_, '_>, unit: VectorUnit, robots: usize, n_steps: u64) {
    let conditions: Conditions = flockbots(robots);
    let mut batch = Batch::on(unit).expect("an available unit");
    let lanes = batch.lanes() as u64;
    bencher
        .counter(ItemsCount::new(lanes * n_steps * robots as u64))
        .bench_local(|| batch.step_only(&conditions, 1, 0..lanes, n_steps).expect("they fit"));
}

macro_rules! sizes {
    ($($name:ident: $robots:literal, $n_steps:literal;)*) => {$(
        mod $name {
            use super::{Bencher, VectorUnit};

            #[divan::bench]
            fn plain(bencher: Bencher<'_, '_>) {
                super::plain(bencher, $robots, $n_steps);
            }

            #[divan::bench]
            fn reference(bencher: Bencher<'_, '_>) {
                super::reference(bencher, $robots, $n_steps);
            }

            #[divan::bench(args = VectorUnit::available())]
            fn batch(bencher: Bencher<'_, '_>, unit: VectorUnit) {
                super::batch(bencher, unit, $robots, $n_steps);
            }
        }
    )*};
}

sizes! {
    n9: 9, 2307;
    n30: 30, 1000;
    n100: 100, 300;
}

mod n1000 {
    use super::Bencher;

    #[divan::bench]
    fn plain(bencher: Bencher<'_, '_>) {
        super::plain(bencher, 1000, 10);
    }

    #[divan::bench]
    fn reference(bencher: Bencher<'_, '_>) {
        super::reference(bencher, 1000, 100);
    }
}

/// Whole runs in the reference world: nine Flockbots, and twenty robots with two sensors among twenty objects.
mod runs {
    use divan::counter::ItemsCount;
    use rsrs_sim::episode::run_episode;

    use super::{Bencher, Conditions, SEED, black_box};

    const DURATION_S: f64 = 60.0;

    fn run(bencher: Bencher<'_, '_>, conditions: &Conditions) {
        let n_steps = conditions.steps(DURATION_S);
        bencher.counter(ItemsCount::new(n_steps * conditions.robots as u64)).bench_local(|| {
            black_box(run_episode(conditions, SEED, DURATION_S).expect("they fit"))
        });
    }

    #[divan::bench]
    fn nine_flockbots(bencher: Bencher<'_, '_>) {
        run(bencher, &rsrs_benches::flockbots(9));
    }

    #[divan::bench]
    fn twenty_robots_and_objects(bencher: Bencher<'_, '_>) {
        run(bencher, &rsrs_benches::pushers());
    }
}

mod n100000 {
    use super::Bencher;

    #[divan::bench(sample_count = 3)]
    fn reference(bencher: Bencher<'_, '_>) {
        super::reference(bencher, 100_000, 10);
    }
}
