//! What the page that simulates has of this source, for `page/build`: keys, digests
//! of states, and the sweep that it shows first.

#![expect(clippy::print_stdout, reason = "it is what the program is for")]

mod states;

fn main() {
    let mut facts = rsrs_view::simulator::keys();
    facts["states"] = states::states();
    facts["source"] = states::source().into();
    println!("{facts}");
}
