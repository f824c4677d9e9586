//! The committed page that simulates is that of this source: `page/build` makes it anew.

#[path = "../examples/simulator_facts/states.rs"]
mod states;

use rsrs_view::simulator::{PAGE, keys};
use serde_json::Value;

/// What lies in one element of the page.
fn inlined(name: &str) -> &'static str {
    let (_, rest) = PAGE.split_once(&format!("id=\"{name}\">")).expect("the page has it");
    rest.split_once("</script>").expect("it ends").0
}

#[test]
fn the_page_has_the_keys_the_sweep_and_the_states_of_this_source() {
    let found: Value = serde_json::from_str(inlined("facts")).expect("it is JSON");

    let mut expected = keys();
    expected["states"] = states::states();
    expected["source"] = states::source().into();

    for (name, expected) in expected.as_object().expect("facts have names") {
        assert_eq!(&found[name], expected, "{name}: run page/build");
    }
}

#[test]
fn the_page_has_the_script_and_the_style_of_this_source_and_asks_for_nothing() {
    let parts = [
        include_str!("../../../page/simulator.js"),
        include_str!("../../../page/simulator.css"),
        include_str!("../../../page/worker.js"),
        include_str!("../../../page/calls.js"),
        include_str!("../assets/canvas.js"),
        include_str!("../assets/page.css"),
    ];

    for part in parts {
        assert!(PAGE.contains(part), "run page/build --same-simulator: {part:.200}");
    }
    for elsewhere in ["http:", "https:", "src=", "<link", "@import", "url(", "fetch(", "import("] {
        assert!(!PAGE.contains(elsewhere), "{elsewhere}");
    }
    assert!(PAGE.len() < 1_500_000, "{} bytes", PAGE.len());
}
