//! Tables of straight runs: read, and fitted to a measured robot.

use std::fmt::Write as _;

use divan::counter::ItemsCount;
use divan::{Bencher, black_box};
use rsrs_core::trials::fit::{Tables, Unmeasured, fit};
use rsrs_core::trials::trial::{MovedBy, detection_trials, speed_trials, turn_trials};

fn main() {
    divan::main();
}

/// Straight runs of 20 robots.
fn table(n_rows: usize) -> String {
    let mut text = "robot,commanded_m_s,distance_m,duration_s\n".to_owned();
    for row in 0..n_rows {
        let duration_s = 20.0 + (row * 7 % 1000) as f64 / 1000.0;
        writeln!(text, "robot_{},0.1,2,{duration_s}", row % 20).expect("a string takes any text");
    }
    text
}

#[divan::bench(args = [10_000, 1_000_000], sample_count = 10)]
fn read_and_fit(bencher: Bencher<'_, '_>, n_rows: usize) {
    let text = table(n_rows);
    let turn = turn_trials("turn.csv", "robot,commanded_rad_s,angle_rad,duration_s\na,1,6,6\n")
        .expect("a valid table");
    let detection = "robot,distance_m,bearing_rad,samples,detections\n\
                     a,0.2,-0.2,9,9\na,0.4,0.2,9,9\na,0.4,-0.2,9,9\na,,,9,1\n";
    let detection = detection_trials("detection.csv", detection).expect("a valid table");
    bencher.counter(ItemsCount::new(n_rows)).bench_local(|| {
        let speed = speed_trials("speed.csv", black_box(&text)).expect("a valid table");
        let (speed, turn, detection) = (&speed, &turn, &detection);
        let tables = Tables {
            speed,
            turn,
            detection,
            period: None,
            driven: &[],
            arc: None,
            from_rest: &[],
            moved_by: MovedBy::default(),
        };
        black_box(fit(tables, &Unmeasured::default()).expect("there is a region"))
    });
}
