//! What was saved of a damaged bag, and what was lost.

use std::fmt::Write;

use rsrs_bags::{Loss, LossKind, Recovered};
use rsrs_core::numerals::{count, counted, size};

use crate::wording::moment;

/// What is in the new bag, with `n_labels` by people; what is missing; and where the old one is damaged.
pub fn text(recovered: &Recovered, n_labels: usize) -> String {
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
