//! Writes the made-up trials of `launch_configs/profiles/`, and the profiles that are fitted to
//! them: `cargo run -p rsrs_core --example make_trials`.

use std::path::Path;

mod generate;

fn main() -> std::io::Result<()> {
    let profiles = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../launch_configs/profiles");
    for (name, text) in generate::files() {
        let path = profiles.join(name);
        if let Some(folder) = path.parent() {
            std::fs::create_dir_all(folder)?;
        }
        std::fs::write(path, text)?;
    }
    Ok(())
}
