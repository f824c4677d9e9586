//! The programs of others that tests need, for who wants to have them before any test does.

use rsrs_testing::{chromium::chromium, python};

#[test]
fn what_others_wrote_can_be_installed() {
    python::install_all();
    chromium();
}
