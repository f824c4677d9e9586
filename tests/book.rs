//! The book: its chapters are all there, its links lead somewhere, and its commands are typed by a
//! test or marked with a reason.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Component, Path, PathBuf};

use crate::command::{repository, rsrs, stdout};
use crate::pages::{
    EXIT_3, IN_RCLPY, OF_CONTROLLERS, OF_OWN_SWARM, OF_SENSORS, OF_WORLDS, REASONS, WITHOUT_FLOOR,
    WITHOUT_ROBOTS, anchors_of, blocks_of, chapters, links_of, text_of,
};

/// Languages of blocks that nobody types.
const NOT_TYPED: [&str; 5] = ["text", "yaml", "json", "csv", "python"];
/// Pages outside the book whose links are looked at, too.
const BESIDE: [&str; 4] = ["README.md", "ARCHITECTURE.md", "CHANGELOG.md", "tests/README.md"];
/// Where chapters are.
const FOLDERS: [&str; 2] = ["docs", "docs/atlas"];
/// Files of `docs` that are no chapters.
const NO_CHAPTERS: [&str; 2] = ["docs/SUMMARY.md", "docs/REPRODUCTION.template.md"];

#[test]
fn every_page_is_a_chapter_once() {
    let listed = chapters();
    let files = FOLDERS.iter().flat_map(|folder| {
        let entries = fs::read_dir(repository().join(folder)).expect("it is there");
        entries.map(move |entry| Path::new(folder).join(entry.expect("readable").file_name()))
    });
    let pages: BTreeSet<String> = files
        .filter(|file| file.extension().is_some_and(|end| end == "md"))
        .map(|file| file.display().to_string())
        .filter(|path| !NO_CHAPTERS.contains(&path.as_str()))
        .collect();

    let unique: BTreeSet<String> = listed.iter().cloned().collect();

    assert_eq!(unique.len(), listed.len(), "a chapter is listed twice");
    assert_eq!(unique, pages, "docs/SUMMARY.md lists other pages than there are");
}

#[test]
fn every_link_leads_to_a_file_and_a_heading_that_exist() {
    let mut wrong = Vec::new();
    let mut n_links = 0;
    let book = chapters();
    for page in book.iter().map(String::as_str).chain(BESIDE) {
        for link in links_of(&text_of(page)) {
            if link.starts_with("https://") {
                continue;
            }
            n_links += 1;
            let (file, heading) = link.split_once('#').unwrap_or((link.as_str(), ""));
            let target = if file.is_empty() { page.to_owned() } else { joined(page, file) };
            let is_there = repository().join(&target).exists();
            // A chapter that is turned into HTML leaves the rest of the repository behind.
            let stays = !book.iter().any(|chapter| chapter == page) || target.starts_with("docs/");
            // Behind the address of the page that simulates is what it shows.
            let has_heading = heading.is_empty()
                || target == "docs/simulator.html"
                || (is_there && anchors_of(&target).contains(heading));
            if !(is_there && stays && has_heading) {
                wrong.push(format!("{page}: {link}"));
            }
        }
    }

    assert!(n_links > 100, "found only {n_links}");
    assert!(wrong.is_empty(), "links that lead nowhere, or out of the book: {wrong:#?}");
}

/// Where a link of a page leads to, from the root of the repository.
fn joined(page: &str, link: &str) -> String {
    let mut path = PathBuf::from(page);
    path.pop();
    for part in Path::new(link).components() {
        match part {
            Component::ParentDir => assert!(path.pop(), "{page}: {link} leaves the repository"),
            other => path.push(other),
        }
    }
    path.to_str().expect("links are text").to_owned()
}

#[test]
fn every_block_is_typed_by_a_test_or_states_why_not() {
    let stories = [
        &WITHOUT_ROBOTS[..],
        &OF_CONTROLLERS,
        &OF_OWN_SWARM,
        &OF_SENSORS,
        &OF_WORLDS,
        &IN_RCLPY,
        &WITHOUT_FLOOR,
    ]
    .concat();
    let book = chapters();
    let mut wrong = Vec::new();
    let mut n_typed = 0;
    for page in book.iter().map(String::as_str).chain(["README.md"]) {
        let n_stories = stories.iter().filter(|other| **other == page).count();
        let blocks = blocks_of(page);
        let n_here = blocks.iter().filter(|block| block.is_typed()).count();
        n_typed += n_here;
        if n_stories != usize::from(n_here > 0) {
            wrong.push(format!("{page}: {n_here} blocks to be typed, in {n_stories} tests"));
        }
        for block in blocks {
            let reason = |mark: &String| REASONS.iter().find(|(reason, _)| mark == reason);
            let is_reason = |mark: &String| {
                reason(mark)
                    .is_some_and(|(_, words)| words.iter().any(|word| block.text.contains(word)))
            };
            let is_right = match block.language.as_str() {
                "sh" => block.marks.iter().all(|mark| mark == EXIT_3 || is_reason(mark)),
                other => block.marks.is_empty() && NOT_TYPED.contains(&other),
            };
            if !is_right {
                wrong.push(format!("{}: `{}` {:?}", block.place, block.language, block.marks));
            }
        }
    }

    assert!(n_typed > 30, "found only {n_typed}");
    assert!(wrong.is_empty(), "blocks of no known kind, or with a wrong reason: {wrong:#?}");
}

#[test]
fn the_list_of_commands_is_the_one_that_the_program_prints() {
    let printed = rsrs(&repository(), &["schema", "--commands"]);

    assert!(
        text_of("docs/commands.md") == stdout(&printed),
        "docs/commands.md is not up to date: rsrs schema --commands > docs/commands.md"
    );
}

#[test]
fn the_page_of_what_can_go_wrong_is_the_one_that_the_program_prints() {
    let printed = rsrs(&repository(), &["schema", "--causes"]);

    assert!(
        text_of("docs/what_can_go_wrong.md") == stdout(&printed),
        "docs/what_can_go_wrong.md is not up to date: rsrs schema --causes > docs/what_can_go_wrong.md"
    );
}

#[test]
fn what_troubleshooting_quotes_is_what_the_program_prints() {
    let sources = sources();
    let page = text_of("docs/troubleshooting.md");
    let quoted = page.split('`').skip(1).step_by(2).filter(|code| code.contains(' '));
    // A message has words and what differs, or several words; a command begins with its program.
    let programs = ["rsrs ", "ros2 ", "chronyc ", "iw ", "sysctl ", "chmod ", "-r ", "--", "-p "];
    let messages: Vec<&str> =
        quoted.filter(|text| !programs.iter().any(|name| text.starts_with(name))).collect();

    let missing: Vec<&&str> = messages
        .iter()
        .filter(|text| {
            let parts = text.split('…').map(|part| part.trim_matches([' ', ':', ',', '`']));
            let mut parts = parts.filter(|part| !part.is_empty());
            !parts.all(|part| sources.contains(part))
        })
        .collect();

    assert!(messages.len() > 40, "found only {}", messages.len());
    assert!(missing.is_empty(), "the program prints none of these: {missing:#?}");
}

/// All code in Rust, with texts that go over several lines in one.
fn sources() -> String {
    let mut all = String::new();
    let mut folders: Vec<PathBuf> =
        ["crates", "bags", "nodes", "sim_node"].map(|folder| repository().join(folder)).into();
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(folder).expect("it can be listed") {
            let path = entry.expect("an entry can be read").path();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|end| end == "rs") {
                let text = fs::read_to_string(path).expect("sources are text");
                let lines: Vec<&str> = text.split("\\\n").collect();
                all += &lines.iter().map(|line| line.trim_start()).collect::<String>();
            }
        }
    }
    all
}
