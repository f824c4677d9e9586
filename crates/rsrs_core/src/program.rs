//! The program that makes results, which they name.

use std::sync::OnceLock;

/// Its version.
pub const VERSION: &str = env!("CARGO_PKG_VERSION");

static COMMIT: OnceLock<&str> = OnceLock::new();

/// Names the commit that the running program was built from, once, when it starts.
pub fn set_commit(commit: &'static str) {
    COMMIT.get_or_init(|| commit);
}

/// The commit that the running program was built from; `unknown` where no program has named it.
pub fn commit() -> &'static str {
    COMMIT.get().copied().unwrap_or("unknown")
}
