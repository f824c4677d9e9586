//! The pages of the book, and what they have their readers type.

use std::collections::BTreeSet;
use std::fs;

use crate::command::repository;

/// Pages whose commands are typed one after the other, by one reader in one folder: without robots.
pub const WITHOUT_ROBOTS: [&str; 10] = [
    "README.md",
    "docs/getting_started.md",
    "docs/answers.md",
    "docs/diagnose.md",
    "docs/behaviours.md",
    "docs/clusters.md",
    "docs/security.md",
    "docs/campaigns.md",
    "docs/reading_results.md",
    "docs/file_formats.md",
];
/// The same of controllers in files.
pub const OF_CONTROLLERS: [&str; 1] = ["docs/controllers.md"];
/// The same of a swarm that is written from nothing.
pub const OF_OWN_SWARM: [&str; 1] = ["docs/your_own_swarm.md"];
/// The same of robots with several sensors.
pub const OF_SENSORS: [&str; 1] = ["docs/sensors.md"];
/// The same for objects and goals.
pub const OF_WORLDS: [&str; 1] = ["docs/worlds.md"];
/// The same for robots in rclpy.
pub const IN_RCLPY: [&str; 2] = ["docs/your_robots_in_rclpy.md", "docs/measure_them.md"];
/// The same for a fleet without robots.
pub const WITHOUT_FLOOR: [&str; 1] = ["docs/fleet_without_robots.md"];

/// Why a command is not typed by a test, and of which words a block with this mark has at least one.
pub const REASONS: [(&str, &[&str]); 7] = [
    ("on-a-robot", &["wlan0", "robot_3.local", "ansible-playbook"]),
    ("with-ros", &["ros2 "]),
    ("as-root", &["systemctl ", "ip link ", "nft "]),
    ("installs", &["cargo install ", "pip install ", "rustup target "]),
    ("on-a-cluster", &["SBATCH", "rsrs merge "]),
    (
        "takes-long",
        &[
            "cargo run ",
            "cargo test ",
            "reproduce.py",
            "mujoco/run.sh",
            "floors/compare.py",
            "floors/discovery.py",
            "floors/pushing.py",
            ".ci/atlas ",
        ],
    ),
    ("publishes", &["twine upload ", "cargo publish ", "podman build "]),
];

/// Marks a block whose last command answers with a no.
pub const EXIT_3: &str = "exit-3";

/// A fenced block of a page.
pub struct Block {
    /// Page and line, for people.
    pub place: String,
    /// Its language, empty if it names none.
    pub language: String,
    /// What stands behind the language.
    pub marks: Vec<String>,
    /// What is in it.
    pub text: String,
}

impl Block {
    /// Whether a test types it.
    pub fn is_typed(&self) -> bool {
        self.language == "sh" && self.marks.iter().all(|mark| mark == EXIT_3)
    }

    /// It as a part of a script that ends at the first failure, and shows which block that was.
    fn script(&self) -> String {
        let Self { place, marks, text, .. } = self;
        let shown = format!("echo '== {place}' >&2\n");
        if marks.iter().any(|mark| mark == EXIT_3) {
            format!("{shown}code=0\n{} || code=$?\n[ \"$code\" -eq 3 ]\n", text.trim_end())
        } else {
            format!("{shown}{text}")
        }
    }
}

/// The text of a file of the repository.
pub fn text_of(path: &str) -> String {
    fs::read_to_string(repository().join(path)).unwrap_or_else(|error| panic!("{path}: {error}"))
}

/// The chapters of the book, in order.
pub fn chapters() -> Vec<String> {
    let links = links_of(&text_of("docs/SUMMARY.md"));
    links.into_iter().map(|link| format!("docs/{link}")).collect()
}

/// The fenced blocks of a page.
pub fn blocks_of(page: &str) -> Vec<Block> {
    let mut blocks: Vec<Block> = Vec::new();
    let mut is_open = false;
    for (row, line) in text_of(page).lines().enumerate() {
        let trimmed = line.trim_start();
        if let Some(info) = trimmed.strip_prefix("```") {
            is_open = !is_open;
            if is_open {
                let mut words = info.split(',').map(str::to_owned);
                let language = words.next().expect("a split has a first part");
                let place = format!("{page}:{}", row + 1);
                let (marks, text) = (words.collect(), String::new());
                blocks.push(Block { place, language, marks, text });
            }
        } else if is_open {
            blocks.last_mut().expect("one is open").text.extend([line, "\n"]);
        }
    }
    assert!(!is_open, "a block of {page} does not end");
    blocks
}

/// What the reader of some pages types, in their order.
pub fn script_of(pages: &[&str]) -> String {
    let blocks = pages.iter().flat_map(|page| blocks_of(page));
    blocks.filter(Block::is_typed).map(|block| block.script()).collect()
}

/// What stands outside blocks and code.
fn prose(text: &str) -> String {
    let outside = text.split("\n```").step_by(2).collect::<Vec<_>>().join("\n");
    outside.split('`').step_by(2).collect()
}

/// Where the links and pictures of a page lead to, as they are written.
pub fn links_of(text: &str) -> Vec<String> {
    let prose = prose(text);
    let starts = prose.split("](").skip(1);
    starts.filter_map(|rest| Some(rest.split_once(')')?.0.to_owned())).collect()
}

/// What the headings of a page are called in links.
pub fn anchors_of(page: &str) -> BTreeSet<String> {
    let text = text_of(page);
    let outside = text.split("\n```").step_by(2).collect::<Vec<_>>().join("\n");
    let headings = outside.lines().filter(|line| line.starts_with('#'));
    headings.map(|heading| anchor(heading.trim_start_matches('#').trim())).collect()
}

/// As mdBook and the usual hosts of repositories make it.
fn anchor(heading: &str) -> String {
    let kept = heading.chars().filter_map(|letter| match letter {
        ' ' => Some('-'),
        letter if letter.is_alphanumeric() || letter == '-' || letter == '_' => Some(letter),
        _ => None,
    });
    kept.collect::<String>().to_lowercase()
}
