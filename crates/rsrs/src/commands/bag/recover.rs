//! `rsrs bag recover`: a whole bag out of a damaged one.

use std::fmt::Write;
use std::path::PathBuf;

use rsrs_bags::{Loss, LossKind, Recovered, recover_into, recovered_name};
use serde::Serialize;

use crate::commands::{Format, report};
use crate::failure::Outcome;
use rsrs_core::numerals::{count, counted, size};
use rsrs_pipeline::error::helped;
use rsrs_pipeline::label::human_labels;
use rsrs_render::wording::moment;

/// Save what can be saved of a bag that was cut, damaged or never closed.
///
/// The damaged bag is left as it is; a new one is written. Nothing is made up: what fails its
/// checksum is left out and listed. Exit code 3 means that something was lost, or may have been.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  rsrs bag recover results/run_1
  rsrs bag recover crashed_0.mcap -o saved")]
pub struct Arguments {
    /// Bag: a rosbag2 folder or a single .mcap file.
    bag: PathBuf,
    /// Folder of the new bag; it must not exist (default: BAG with `_recovered` behind its name).
    #[arg(short, long, value_name = "DIR")]
    output: Option<PathBuf>,
    /// To how many bytes a file that was compressed as a whole may unpack (default: 64 times its
    /// size, and 64 MiB in any case).
    #[arg(long, value_name = "BYTES")]
    unpack_limit: Option<u64>,
    /// How to report.
    #[arg(long, value_enum, default_value = "text")]
    format: Format,
}

/// What was saved, with the sums that a reader would make.
#[derive(Serialize)]
struct Report<'a> {
    #[serde(flatten)]
    recovered: &'a Recovered,
    /// Whether everything that was recorded is in the new bag.
    is_complete: bool,
    /// Messages that are certainly lost.
    n_messages_lost: u64,
    /// Bytes of the old bag of which nothing was saved.
    n_bytes_lost: u64,
    /// Labels of people that lay beside the old bag, and now lie beside the new one, too.
    n_labels: usize,
}

pub fn run(arguments: &Arguments) -> anyhow::Result<Outcome> {
    // Labels that do not read are refused before anything is written.
    human_labels::read(&arguments.bag)?;
    let folder = match &arguments.output {
        Some(folder) => folder.clone(),
        None => recovered_name(&arguments.bag).map_err(helped)?,
    };
    let recovered =
        recover_into(&arguments.bag, &folder, arguments.unpack_limit).map_err(helped)?;
    let n_labels = human_labels::carry(&arguments.bag, &recovered.folder)?;
    let result = Report {
        is_complete: recovered.is_complete(),
        n_messages_lost: recovered.lost.total(),
        n_bytes_lost: recovered.n_bytes_lost(),
        n_labels,
        recovered: &recovered,
    };
    report(arguments.format, &result, text(&recovered, n_labels))?;
    Ok(if recovered.is_complete() { Outcome::Done } else { Outcome::NegativeAnswer })
}

fn text(recovered: &Recovered, n_labels: usize) -> String {
    let mut text = format!(
        "{}: {} saved{}{}\n",
        recovered.folder.display(),
        counted(recovered.n_messages, "message"),
        span(recovered.bounds_ns),
        besides(recovered, n_labels)
    );
    let mut line = |printed: String| writeln!(text, "{printed}").expect("a string takes any text");
    line(format!("lost: {}", lost(recovered)));
    for (topic, n) in &recovered.lost.of_topic {
        line(format!("  {topic}: {}", counted(*n, "message")));
    }
    for loss in &recovered.losses {
        line(damaged(loss));
    }
    text
}

fn span(bounds_ns: Option<(u64, u64)>) -> String {
    bounds_ns.map_or_else(String::new, |(first_ns, last_ns)| {
        format!(", {} to {}", moment(first_ns), moment(last_ns))
    })
}

fn besides(recovered: &Recovered, n_labels: usize) -> String {
    let kinds = [
        (recovered.n_attachments, "attachment"),
        (recovered.n_metadata, "metadata record"),
        (n_labels as u64, "label"),
    ];
    let besides: Vec<String> =
        kinds.into_iter().filter(|(n, _)| *n > 0).map(|(n, what)| counted(n, what)).collect();
    if besides.is_empty() { String::new() } else { format!(", with {}", besides.join(", ")) }
}

/// What is missing, and how sure that is.
fn lost(recovered: &Recovered) -> String {
    let n = recovered.lost.total();
    if recovered.is_complete() {
        return "nothing that was recorded".to_owned();
    }
    match (recovered.lost.is_exact, n) {
        (true, 0) => "no message; see below for what else".to_owned(),
        (true, n) => format!("exactly {}", counted(n, "message")),
        (false, 0) => {
            "what stood in the places below; how many messages is not recorded".to_owned()
        }
        (false, n) => {
            format!("at least {}; how many more is not recorded", counted(n, "message"))
        }
    }
}

fn damaged(loss: &Loss) -> String {
    let what = match loss.kind {
        LossKind::Chunk => "a chunk",
        LossKind::EndOfChunk => "the end of a chunk",
        LossKind::Garbage => "bytes that are no records",
        LossKind::Record => "an attachment or metadata record",
        LossKind::Messages => "messages of a channel without definition",
        LossKind::EndOfFile => "the end of the file",
        LossKind::TableOfContents => "the file's table of contents (made anew)",
        LossKind::Unlocated => "somewhere",
        LossKind::File => "the whole file",
    };
    let messages = loss.n_messages.map_or_else(String::new, |n| {
        format!(", {}{}", counted(n, "message"), span(loss.bounds_ns))
    });
    format!(
        "damage: {} from byte {} on, {}: {what}{messages} ({})",
        loss.path.display(),
        count(loss.at_byte),
        size(loss.n_bytes),
        loss.reason
    )
}
