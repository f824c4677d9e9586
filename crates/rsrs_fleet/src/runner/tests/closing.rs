//! Bags that are closed slowly, or never.

use super::*;

/// A run that is over, whose bag is being closed.
fn closing() -> Bench {
    let mut bench = Bench::real_time(RobotLost::Abort);
    bench.disk = Disk::Slow;
    bench.run();
    for _ in 0..100 {
        if bench.closed {
            return bench;
        }
        bench.beat();
    }
    panic!("the bag is never closed");
}

impl Bench {
    /// Beats for so long, while the disk writes so much between two of them.
    fn close_for(&mut self, duration_s: u64, step: u64) {
        for beat in 0..10 * duration_s {
            let left_bytes = 120_000_000_u64.saturating_sub(beat * step * 100_000);
            self.give(Event::RecorderCloses { done: beat * step, left_bytes });
            self.beat();
        }
    }

    fn interrupt(&mut self) {
        self.give(Event::Interrupt { reason: "interrupted".to_owned() });
    }
}

#[test]
fn a_bag_is_waited_for_as_long_as_it_is_written_and_what_is_left_is_noted() {
    let mut bench = closing();

    bench.close_for(90, 1);
    assert!(bench.finish.is_none(), "{:?}", bench.finish);
    bench.give(Event::RecorderClosed);
    let (outcome, _) = bench.end();

    assert_eq!(outcome, Outcome::Completed);
    let notes: Vec<_> = bench.notes.iter().filter(|note| note.contains(" left")).collect();
    assert_eq!(notes[0], "closing the bag, 118 MB left");
    assert_eq!(notes.len(), 44, "{notes:?}");
}

#[test]
fn a_disk_on_which_nothing_is_written_for_ten_seconds_ends_the_run() {
    let mut bench = closing();

    bench.close_for(9, 0);
    assert!(bench.finish.is_none());
    bench.close_for(2, 0);

    assert_eq!(bench.problems(), ["recorder: nothing was written for 10 s, 120 MB left"]);
}

#[test]
fn the_second_interrupt_gives_the_bag_up_and_the_first_does_not() {
    let mut bench = closing();
    bench.close_for(1, 1);

    bench.interrupt();
    bench.close_for(1, 1);
    assert!(bench.finish.is_none());
    let asked = "closing the bag, 120 MB left; once more gives it up";
    assert!(bench.notes.iter().any(|note| note == asked), "{:?}", bench.notes);
    bench.interrupt();

    assert_eq!(bench.problems(), ["recorder: given up when asked to, 120 MB left"]);
}

#[test]
fn after_a_run_that_was_interrupted_one_more_interrupt_gives_the_bag_up() {
    let mut bench = Bench::real_time(RobotLost::Abort);
    bench.disk = Disk::Slow;
    bench.run();
    bench.interrupt();
    for _ in 0..30 {
        bench.beat();
    }
    assert!(bench.closed && bench.finish.is_none());

    bench.interrupt();

    let (outcome, _) = bench.end();
    assert_eq!(outcome, Outcome::Aborted { reason: "interrupted".to_owned() });
}
