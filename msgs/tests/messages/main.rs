//! All types of messages, against an independent implementation and against bytes that are no message.

mod all_types;
mod fuzz;
mod oracle;
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_possible_wrap,
    reason = "made-up numbers are bits of a draw, and which bits does not matter"
)]
mod sampler;
