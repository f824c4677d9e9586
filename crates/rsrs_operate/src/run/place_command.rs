//! Robots that a program places before they are used.

use std::io::Write as _;
use std::process::{ExitStatus, Stdio};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use anyhow::Context;
use rsrs_pipeline::error::with_help;
use serde::Serialize;
use tokio::io::{AsyncRead, AsyncReadExt as _};
use tokio::task::JoinHandle;

use super::operator::Operator;

/// Where robots are to stand, as the program gets it on its standard input: one line of JSON.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct WantedPlacement {
    /// What they are placed for: a run, by the folder of its bag, an experiment of a campaign, or a
    /// trial.
    pub purpose: String,
    /// Robots that take part; all others are to be out of their way and out of their sight.
    pub robots: Vec<PlacedRobot>,
}

/// Where one robot is to stand.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PlacedRobot {
    /// Its name.
    pub name: String,
    /// Ahead of the middle of the floor, in metres.
    pub x_m: f64,
    /// To the left of it, in metres.
    pub y_m: f64,
    /// Where it looks, counterclockwise from x, in radians.
    pub heading_rad: f64,
}

/// How long the rest of what a program printed is waited for when it has ended: its children may keep
/// what it printed to open for ever.
const REST: Duration = Duration::from_millis(200);

/// What is kept of what a program prints, in bytes.
const MOST_KEPT: usize = 64 * 1024;

/// Has a program, given as a shell takes it, place robots, and waits until it has ended; what it
/// has started and left running is not waited for.
///
/// # Errors
///
/// If it cannot be started, ends with another exit code than 0, or a signal comes meanwhile; the
/// error has what it printed.
pub async fn place(
    program: &str,
    wanted: &WantedPlacement,
    operator: &dyn Operator,
) -> anyhow::Result<()> {
    let mut line = serde_json::to_string(wanted).context("the placement as JSON")?;
    line.push('\n');
    let (input, mut given) = std::io::pipe().context("making a pipe")?;
    let mut child = {
        let mut command = tokio::process::Command::new("sh");
        command.args(["-c", program]).kill_on_drop(true);
        command.stdin(input).stdout(Stdio::piped()).stderr(Stdio::piped());
        command.spawn().with_context(|| format!("starting `{program}`"))?
    };
    // A program that does not read blocks nothing, and one that closes its input may do so.
    std::thread::spawn(move || drop(given.write_all(line.as_bytes())));
    let printed = [
        Printed::read(child.stdout.take().context("its output is a pipe")?),
        Printed::read(child.stderr.take().context("its errors are a pipe")?),
    ];
    let status = tokio::select! {
        status = child.wait() => status.with_context(|| format!("waiting for `{program}`"))?,
        reason = operator.stop_requested() => anyhow::bail!("{reason} while `{program}` placed robots"),
    };
    if status.success() {
        return Ok(());
    }
    let [output, errors] = printed;
    let printed = [output.by_now().await, errors.by_now().await];
    Err(refused(program, wanted, status, &printed))
}

/// What a program prints, read for as long as anybody may write to it: who writes to a pipe that nobody
/// reads is ended.
struct Printed {
    text: Arc<Mutex<Vec<u8>>>,
    reading: JoinHandle<()>,
}

impl Printed {
    fn read(mut pipe: impl AsyncRead + Unpin + Send + 'static) -> Self {
        let text = Arc::new(Mutex::new(Vec::new()));
        let kept = text.clone();
        let reading = tokio::spawn(async move {
            let mut piece = [0; 4096];
            while let Ok(n_bytes @ 1..) = pipe.read(&mut piece).await {
                let mut kept = kept.lock().unwrap_or_else(PoisonError::into_inner);
                let n_left = MOST_KEPT.saturating_sub(kept.len());
                kept.extend_from_slice(&piece[..n_bytes.min(n_left)]);
            }
        });
        Self { text, reading }
    }

    /// What it has printed when it has ended.
    async fn by_now(self) -> String {
        // Whether all has come or something still holds it open, this is what there is.
        drop(tokio::time::timeout(REST, self.reading).await);
        let text = self.text.lock().unwrap_or_else(PoisonError::into_inner);
        String::from_utf8_lossy(&text).into_owned()
    }
}

fn refused(
    program: &str,
    wanted: &WantedPlacement,
    status: ExitStatus,
    printed: &[String],
) -> anyhow::Error {
    let printed: Vec<&str> = printed.iter().flat_map(|text| text.lines()).collect();
    let printed = if printed.is_empty() { "nothing".to_owned() } else { printed.join("\n  ") };
    with_help(
        format!(
            "{}: `{program}` did not place the robots ({status}); it printed:\n  {printed}",
            wanted.purpose
        ),
        "it gets one line of JSON on its standard input, and is to end with exit code 0 when all \
         robots stand where that places them; docs/campaigns.md has the keys",
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::run::operator::Unattended;

    fn wanted() -> WantedPlacement {
        let robot =
            PlacedRobot { name: "robot_1".to_owned(), x_m: 0.5, y_m: -0.25, heading_rad: 0.0 };
        WantedPlacement { purpose: "001".to_owned(), robots: vec![robot] }
    }

    fn run(program: &str) -> anyhow::Result<()> {
        let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap();
        runtime.block_on(place(program, &wanted(), &Unattended))
    }

    #[test]
    fn a_program_gets_the_placement_as_one_line_of_json() {
        let folder = tempfile::tempdir().unwrap();
        let given = folder.path().join("received");

        run(&format!("cat > {}", given.display())).unwrap();

        let text = std::fs::read_to_string(given).unwrap();
        assert_eq!(
            text,
            "{\"purpose\":\"001\",\"robots\":[{\"name\":\"robot_1\",\"x_m\":0.5,\"y_m\":-0.25,\
             \"heading_rad\":0.0}]}\n"
        );
    }

    #[test]
    fn a_program_that_fails_is_repeated_with_what_it_printed() {
        let error = run("echo where is robot_7; echo lost >&2; exit 4").unwrap_err().to_string();

        assert!(error.contains("did not place the robots (exit status: 4)"), "{error}");
        assert!(error.contains("where is robot_7\n  lost"), "{error}");
        assert!(run("true").is_ok(), "it need not read");
    }

    #[test]
    fn what_a_program_leaves_running_is_not_waited_for() {
        let begun = std::time::Instant::now();
        // Both keep its output open.
        run("sleep 100 & echo done").unwrap();
        let error = run("sleep 100 & echo where is robot_7; exit 4").unwrap_err().to_string();

        assert!(begun.elapsed() < Duration::from_secs(50), "{:?}", begun.elapsed());
        assert!(error.contains("it printed:\n  where is robot_7"), "{error}");
    }
}
