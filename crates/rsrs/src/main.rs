//! The command line of RSRS.
fn main() {}
