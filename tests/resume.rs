//! Sweeps that are interrupted: killed, called off, out of disk. Whatever happens, the finished folder
//! is the same byte for byte, and nothing that was finished is lost.
//!
//! `RSRS_KILLS=200 cargo test -p rsrs --test rsrs resume::` kills more often than the default.

mod shards;

use std::os::unix::process::ExitStatusExt;
use std::path::PathBuf;
use std::process::{Command, Stdio};
use std::time::{Instant, SystemTime};

use rsrs_testing::environment::number;

use crate::command::{code, stderr};
use crate::work::{RSRS, SweepFolder, bytes, contents};

/// Moments at which sweeps are killed, where nothing else is asked for.
const KILLS: usize = 20;

/// Numbers from 0 to 1 that look random; where they come from is of no importance here.
struct Moments(u64);

impl Moments {
    fn next(&mut self) -> f64 {
        self.0 =
            self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }
}

/// Kills sweeps until it has done so as often as asked for; every one of them is then finished, and
/// compared with one that was left alone.
fn kill_and_compare(place: &SweepFolder, arguments: &[&str]) {
    let begun = Instant::now();
    let whole = place.rsrs(&[&["sweep", "sweep.yaml", "-o", "whole"], arguments].concat());
    let takes = begun.elapsed();
    assert_eq!(code(&whole), 0, "{}", stderr(&whole));
    let expected = contents(&place.path("whole"));
    let kills = number("RSRS_KILLS").unwrap_or(KILLS);
    let mut moments = Moments(7);

    let mut killed = 0;
    while killed < kills {
        loop {
            // Later than a whole run takes: its end, too, is a moment to be killed at.
            let moment = takes.mul_f64(1.2 * moments.next() * moments.next());
            let threads = if killed % 2 == 0 { "1" } else { "2" };
            let sweep = ["sweep", "sweep.yaml", "-o", "out", "--threads", threads];
            let mut child = place.spawn(&[&sweep, arguments].concat());
            std::thread::sleep(moment);
            child.kill().expect("the child can be killed");
            let status = child.wait().expect("the child ends");
            if status.success() {
                break;
            }
            assert_eq!(status.signal(), Some(9), "it fails by itself: {status}");
            killed += 1;
        }
        // Also the end of a run that nobody killed any more may have left something behind.
        let last = place.rsrs(&[&["sweep", "sweep.yaml", "-o", "out"], arguments].concat());
        assert_eq!(code(&last), 0, "{}", stderr(&last));
        let found = contents(&place.path("out"));
        assert!(found == expected, "after {killed} kills: {:?}", found.keys());
        assert_eq!(place.entries(), ["flockbot.yaml", "out", "sweep.yaml", "whole"]);
        std::fs::remove_dir_all(place.path("out")).expect("the folder is there");
    }
}

#[test]
fn a_sweep_that_is_killed_at_any_moment_ends_in_the_same_bytes() {
    kill_and_compare(&SweepFolder::with_sweep(2000), &[]);
}

#[test]
fn an_adaptive_sweep_that_is_killed_at_any_moment_ends_in_the_same_bytes() {
    kill_and_compare(
        &SweepFolder::with_sweep(600),
        &["--adaptive", "--width", "0.04", "--most-replicates", "4000"],
    );
}

#[test]
fn after_ctrl_c_the_command_that_goes_on_is_printed() {
    // Which takes so long that it cannot be over before the signal comes.
    let place = SweepFolder::with_sweep(12_000);
    place.sweep_into("whole");

    let mut child = place.spawn(&["sweep", "sweep.yaml", "-o", "out"]);
    place.wait_for_blocks("out", 1);
    let pid = child.id().to_string();
    let sent = Command::new("kill").args(["-INT", &pid]).status().expect("kill starts");
    assert!(sent.success());
    let output = {
        let status = child.wait().expect("the child ends");
        let mut printed = String::new();
        let mut pipe = child.stderr.take().expect("it is piped");
        std::io::Read::read_to_string(&mut pipe, &mut printed).expect("messages are UTF-8");
        (status.code(), printed)
    };

    // As shells expect it.
    assert_eq!(output.0, Some(130), "{}", output.1);
    assert!(output.1.contains("error: interrupted; "), "{}", output.1);
    assert!(output.1.contains(" of 96000 runs are kept in out"), "{}", output.1);
    let command = "go on with `rsrs sweep out/sweep.yaml -o out`";
    assert!(output.1.contains(command), "{}", output.1);
    let resumed = place.rsrs(&["sweep", "out/sweep.yaml", "-o", "out"]);
    assert_eq!(code(&resumed), 0, "{}", stderr(&resumed));
    assert!(contents(&place.path("out")) == contents(&place.path("whole")));
}

#[test]
fn what_is_finished_is_not_made_again() {
    let place = SweepFolder::with_sweep(6000);
    place.interrupt("out", 3);
    let blocks = place.blocks("out");
    let made = |path: &PathBuf| {
        std::fs::metadata(path).and_then(|block| block.modified()).expect("the block is there")
    };
    let before: Vec<SystemTime> = blocks.iter().map(made).collect();

    place.interrupt("out", blocks.len() + 2);

    let after: Vec<SystemTime> = blocks.iter().map(made).collect();
    assert_eq!(before, after);
}

#[test]
fn blocks_that_are_torn_damaged_or_half_written_are_made_again() {
    let place = SweepFolder::with_sweep(6000);
    place.sweep_into("whole");
    place.interrupt("out", 4);
    let blocks = place.blocks("out");

    let torn = bytes(&blocks[0]);
    std::fs::write(&blocks[0], &torn[..torn.len() / 2]).expect("the folder is writable");
    let mut damaged = bytes(&blocks[1]);
    damaged[1000] ^= 1;
    std::fs::write(&blocks[1], damaged).expect("the folder is writable");
    std::fs::write(&blocks[2], b"").expect("the folder is writable");
    std::fs::rename(&blocks[3], blocks[3].with_extension("new")).expect("the folder is writable");
    place.sweep_into("out");

    assert!(contents(&place.path("out")) == contents(&place.path("whole")));
}

#[test]
fn an_unfinished_folder_is_reported_with_how_to_finish_it() {
    let place = SweepFolder::with_sweep(6000);
    place.interrupt("out", 1);

    for reader in [
        &["choose", "out"][..],
        &["diagram", "out", "-o", "p.svg"],
        &["compare", "out", "--bags", "bag"],
    ] {
        let output = place.rsrs(reader);

        assert_eq!(code(&output), 1);
        let expected = "error: the sweep in out is unfinished\n\
                        help: finish it with `rsrs sweep out/sweep.yaml -o out`, or put shards \
                        together with `rsrs merge`\n";
        assert_eq!(stderr(&output), expected, "{reader:?}");
    }
}

#[test]
fn another_sweep_is_refused_with_the_first_difference_and_the_folder_left_alone() {
    let place = SweepFolder::with_sweep(6000);
    place.interrupt("out", 1);
    let before = contents(&place.path("out/unfinished"));

    for (from, to, difference) in [
        ("replicates: 6000", "replicates: 6001", "replicates is 6000 there, and 6001 here"),
        ("[0.15, 0.30]", "[0.15, 0.25]", "axes.speed_m_s[1] is 0.3 there, and 0.25 here"),
        ("[0.15, 0.30]", "[0.15]", "axes.speed_m_s has 2 values there, and 1 here"),
        ("seed: 7", "seed: 8", "seed is 7 there, and 8 here"),
        ("robots: 9", "robots: 8", "fixed.robots is 9.0 there, and 8.0 here"),
        (
            "arena_m: 15",
            "arena_m: 15, range_m: 1",
            "fixed.range_m is not given there, and 1.0 here",
        ),
        (
            "seed: 7",
            "seed: 7\nbehaviour: aggregation",
            "behaviour is not given there, and \"aggregation\" here",
        ),
    ] {
        place.change("sweep.yaml", "other.yaml", from, to);

        let other = place.rsrs(&["sweep", "other.yaml", "-o", "out"]);

        assert_eq!(code(&other), 1);
        let expected = format!(
            "error: out exists and holds another sweep: {difference}\n\
             help: give another folder with `-o`, or remove this one\n"
        );
        assert_eq!(stderr(&other), expected);
    }
    let adaptive = ["sweep", "sweep.yaml", "-o", "out", "--adaptive", "--most-replicates", "9000"];
    let adaptive = place.rsrs(&adaptive);
    let difference = "adaptive is not given there, and given here";
    assert!(stderr(&adaptive).contains(difference), "{}", stderr(&adaptive));
    assert!(contents(&place.path("out/unfinished")) == before);
}

#[test]
fn a_sweep_that_another_program_began_is_not_mixed_with_this_one() {
    let place = SweepFolder::with_sweep(6000);
    place.interrupt("out", 1);
    let text = String::from_utf8(bytes(&place.path("out/sweep.yaml"))).expect("YAML is UTF-8");
    let older = text.replace("version: \"0.1.0\"", "version: \"0.0.9\"");
    assert_ne!(text, older);
    std::fs::write(place.path("out/sweep.yaml"), older).expect("the folder is writable");

    let output = place.rsrs(&["sweep", "sweep.yaml", "-o", "out"]);

    assert_eq!(code(&output), 1);
    let expected = "the sweep in out was begun by another program: rsrs 0.0.9 of commit ";
    assert!(stderr(&output).contains(expected), "{}", stderr(&output));
}

#[test]
fn two_processes_do_not_sweep_into_one_folder() {
    let place = SweepFolder::with_sweep(60_000);
    let mut first = place.spawn(&["sweep", "sweep.yaml", "-o", "out"]);
    place.wait_for_blocks("out", 1);

    let second = place.rsrs(&["sweep", "sweep.yaml", "-o", "out"]);

    assert!(first.try_wait().expect("it can be asked").is_none(), "the first ended too early");
    first.kill().expect("the child can be killed");
    first.wait().expect("the child ends");
    assert_eq!(code(&second), 1);
    let expected = "another process is sweeping into out";
    assert!(stderr(&second).contains(expected), "{}", stderr(&second));
}

#[test]
fn a_file_that_cannot_grow_and_a_full_disk_lose_nothing() {
    let place = SweepFolder::with_sweep(6000);
    place.sweep_into("whole");

    // A block has 200 kB; the table of all replicates has more than 1 MB. A shell counts in units of
    // 512 bytes, or bash in 1,024 where it is not asked to be a plain shell: either will do.
    for (kilobytes, file) in
        [(50, "unfinished/block_00000"), (300, "unfinished/replicates.parquet")]
    {
        let limited = format!(
            "trap '' XFSZ; ulimit -f {}; exec \"$0\" sweep sweep.yaml -o out --threads 1",
            kilobytes * 2
        );
        let output = Command::new("sh")
            .args(["-c", &limited, RSRS])
            .current_dir(place.folder())
            .output()
            .expect("a shell is there");

        assert_eq!(code(&output), 1, "{}", stderr(&output));
        let errors = stderr(&output);
        assert!(
            errors.contains("the sweep in out cannot go on; what is finished is kept"),
            "{errors}"
        );
        assert!(errors.contains(&format!("cannot write out/{file}")), "{errors}");
        assert!(errors.contains("go on with `rsrs sweep out/sweep.yaml -o out`"), "{errors}");
    }
    assert_eq!(place.blocks("out").len(), 24, "all blocks of both worlds are there");
    place.sweep_into("out");

    assert!(contents(&place.path("out")) == contents(&place.path("whole")));

    // A disk of 1 MB, in a namespace of its own: five blocks fit. Then it gets larger.
    let script = "set -e; mkdir disk seen; mount -t tmpfs -o size=1m tmpfs disk
        \"$0\" sweep sweep.yaml -o disk/out --threads 1 2> seen/full && exit 9
        ls disk/out/unfinished | grep -c '^block_' > seen/blocks
        mount -o remount,size=100m disk
        \"$0\" sweep sweep.yaml -o disk/out > seen/printed
        cp -r disk/out seen/result";
    let output = Command::new("unshare")
        .args(["--map-root-user", "--mount", "--", "sh", "-c", script, RSRS])
        .current_dir(place.folder())
        .output()
        .expect("unshare is there");

    assert_eq!(code(&output), 0, "{}", stderr(&output));
    let errors = String::from_utf8(bytes(&place.path("seen/full"))).expect("messages are UTF-8");
    assert!(errors.contains("No space left on device"), "{errors}");
    assert!(errors.contains("what is finished is kept"), "{errors}");
    let blocks = String::from_utf8(bytes(&place.path("seen/blocks"))).expect("a number");
    let n_blocks: usize = blocks.trim().parse().expect("a number");
    assert!((3..12).contains(&n_blocks), "{n_blocks} blocks were kept");
    assert!(contents(&place.path("seen/result")) == contents(&place.path("whole")));
}

#[test]
fn of_sweeps_that_start_into_one_new_folder_at_once_one_makes_it() {
    let place = SweepFolder::with_sweep(16);
    place.sweep_into("whole");

    for round in 0..10 {
        let arguments = ["sweep", "sweep.yaml", "-o", "out", "--threads", "1"];
        let children: Vec<_> = (0..6).map(|_| place.spawn(&arguments)).collect();
        let outputs = children.into_iter().map(|child| child.wait_with_output().expect("it ends"));

        let (done, refused): (Vec<_>, Vec<_>) = outputs.partition(|output| code(output) == 0);

        assert!(!done.is_empty(), "round {round}: {refused:?}");
        for output in refused {
            let printed = stderr(&output);
            assert!(
                printed.starts_with("error: another process is sweeping into out"),
                "{printed}"
            );
        }
        assert!(contents(&place.path("out")) == contents(&place.path("whole")), "round {round}");
        assert_eq!(place.entries(), ["flockbot.yaml", "out", "sweep.yaml", "whole"]);
        std::fs::remove_dir_all(place.path("out")).expect("the folder is there");
    }
}

#[test]
fn memory_does_not_grow_with_the_number_of_replicates() {
    let place = SweepFolder::with_sweep(2000);
    let peak_kilobytes = |replicates: u64| {
        let sweep = format!("replicates: {replicates}");
        place.change("sweep.yaml", "two.yaml", "replicates: 2000", &sweep);
        place.change("two.yaml", "two.yaml", "robots: 9", "robots: 2");
        place.change("two.yaml", "two.yaml", "[0.25, 0.75]", "[0.75]");
        let script = "import resource, subprocess, sys\n\
                      subprocess.run(sys.argv[1:], check=True, stdout=subprocess.DEVNULL)\n\
                      print(resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss)";
        let folder = format!("of_{replicates}");
        let output = Command::new("python3")
            .args(["-c", script, RSRS, "sweep", "two.yaml", "-o", &folder, "--threads", "2"])
            .current_dir(place.folder())
            .stdin(Stdio::null())
            .output()
            .expect("python3 is there");
        assert_eq!(code(&output), 0, "{}", stderr(&output));
        String::from_utf8_lossy(&output.stdout).trim().parse::<f64>().expect("a number")
    };

    let (few, many) = (peak_kilobytes(2000), peak_kilobytes(200_000));

    // 400,000 rows would be 45 MB; of the table, one group of 65,536 is held.
    assert!(many < few + 40_000.0 && many < 2.0 * few, "{few} kB and {many} kB");
}
