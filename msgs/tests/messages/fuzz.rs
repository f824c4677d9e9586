//! Fuzzing of all types of messages.

use std::error::Error;

use rsrs_testing::fuzz::{self, Harness};

use crate::all_types::all_types;

#[test]
fn fuzzed_messages_are_decoded_for_good_or_refused() {
    let types = all_types();
    // An input begins with the place of its type.
    let seeds = types.iter().enumerate().flat_map(|(place, message_type)| {
        let place = u8::try_from(place).expect("there are fewer than 256 types");
        (0..3).map(move |seed| [vec![place], (message_type.sample)(seed).1].concat())
    });
    let harness = Harness {
        corpus: concat!(env!("CARGO_MANIFEST_DIR"), "/tests/corpus/messages"),
        seeds: seeds.collect(),
        mutation: &fuzz::behind(1, fuzz::cdr),
    };

    let n_outcomes = harness.run(|input| {
        let message_type = &types[usize::from(input[0]) % types.len()];
        match (message_type.recode)(&input[1..]) {
            Ok(bytes) => {
                let again = (message_type.recode)(&bytes).expect("what was encoded decodes");
                assert_eq!(again, bytes, "{}", message_type.name);
                format!("{} {}", message_type.name, if input[2] == 0 { "big" } else { "little" })
            }
            Err(error) => {
                let cause = error.source().map(ToString::to_string);
                format!("{error}: {}", cause.unwrap_or_default())
            }
        }
    });

    assert!(n_outcomes > types.len(), "{n_outcomes} outcomes");
}
