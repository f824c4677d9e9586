//! The report of a sweep and its runs, as a person gets it: one file that needs no other.

use crate::command::{code, done, rsrs, stderr, text_in};
use crate::simulated_bags::{Part, Run, ended};
use rsrs_fleet::experiment::Time;
use rsrs_fleet::record::EndingKind;

/// A folder with a small sweep, its chosen cell, and four bags.
fn lab_folder() -> tempfile::TempDir {
    let place = crate::prepared_sweeps::chosen();
    let here = place.path();
    Run::new(1).record(here, "one");
    Run::new(2).record(here, "a<b>&c");
    Run { lacks: Some(Part::Poses), ..Run::new(3) }.record(here, "blind");
    let frozen = ended(EndingKind::Void, "the lease lapsed");
    Run { ending: frozen, ..Run::new(4) }.record(here, "frozen");
    place
}

#[test]
fn a_sweep_without_runs_has_a_report_of_its_cells() {
    let place = crate::prepared_sweeps::chosen();

    let report = rsrs(place.path(), &["report", "out", "-o", "report.html"]);

    assert_eq!(code(&report), 0, "{}", stderr(&report));
    let html = text_in(place.path(), "report.html");
    assert_well_formed(&html);
    assert_eq!(html.matches(" data-cell=").count(), 4, "the cells of the sweep");
    assert!(html.contains("Replicate 0 of seed 7") && !html.contains("Verdict"), "{html}");
}

/// Every tag that is opened is closed, in order.
fn assert_well_formed(html: &str) {
    let mut open: Vec<&str> = Vec::new();
    // In the script a `<` compares.
    let script = html.rfind("<script>").expect("it has a script");
    let end = html.rfind("</script>").expect("the script ends");
    let markup = [&html[..script], &html[end + "</script>".len()..]].concat();
    for tag in markup.split('<').skip(1) {
        let tag = &tag[..tag.find('>').unwrap_or_else(|| panic!("no end: {tag}"))];
        let name = tag.split([' ', '/']).next().unwrap_or_default();
        if let Some(closed) = tag.strip_prefix('/') {
            assert_eq!(open.pop(), Some(closed));
        } else if !tag.starts_with('!') && !tag.ends_with('/') && !["meta", "input"].contains(&name)
        {
            open.push(name);
        }
    }
    assert_eq!(open, [""; 0]);
}

#[test]
fn a_report_has_the_diagram_every_run_and_the_comparison() {
    let place = lab_folder();
    let here = place.path();
    done(here, &["label", "one", "--as", "unformed", "--by", "ana", "--note", "<hm>"]);

    let arguments = ["report", "out", "-o", "report.html", "--bags", "one", "a<b>&c", "frozen"];
    let report = rsrs(here, &arguments);

    assert_eq!(code(&report), 0, "{}", stderr(&report));
    let html = text_in(here, "report.html");
    assert_well_formed(&html);
    assert_eq!(html.matches(" data-cell=").count(), 4, "the cells of the sweep");
    assert_eq!(html.matches("<article").count(), 2, "the runs that count");
    // A diagram, and of each run the way and the order parameters.
    assert_eq!(html.matches("<svg width").count(), 1 + 2 * 2);
    for expected in [
        "chosen cell",
        "Verdict: <strong>undecided</strong>",
        "verdict: undecided",
        "speed 0.15 m/s, turning rate 0.75 rad/s",
        "Replicate 0 of seed 7",
        "sensing.cone.range_m",
        "100.0 % of 2 milled",
        "stable milling by judge",
        "by hand: unformed by ana",
        "&lt;hm&gt;",
        "a&lt;b&gt;&amp;c",
        "the lease lapsed",
    ] {
        assert!(html.contains(expected), "no {expected}");
    }
    for elsewhere in ["http:", "https:", "src=", "<link", "@import", "url(", "fetch(", "import("] {
        assert!(!html.contains(elsewhere), "{elsewhere}");
    }
    assert_eq!(html.matches("href=").count(), html.matches("href=\"#").count());
}

#[test]
fn real_runs_are_laid_over_a_diagram() {
    let place = lab_folder();

    let draw = ["diagram", "out", "-o", "runs.svg", "--bags", "one", "frozen"];
    done(place.path(), &draw);
    let svg = text_in(place.path(), "runs.svg");
    // The other one did not complete.
    assert!(svg.contains("Experiments") && svg.contains("stable milling: 1"), "{svg}");
}

#[test]
fn a_diagram_fits_a_column_of_a_journal_and_shows_both_worlds() {
    let place = lab_folder();
    let here = place.path();
    let draw = |name: &str, more: &[&str]| {
        done(here, &[&["diagram", "out", "-o", name], more].concat());
        std::fs::read(here.join(name)).expect("it was drawn")
    };

    let pdf = draw("column.pdf", &["--width", "88mm"]);
    let both = draw("both.svg", &["--world", "side-by-side", "--width", "18cm"]);
    let wrong = rsrs(here, &["diagram", "out", "-o", "wrong.svg", "--width", "88"]);

    // 88 mm are 249.45 points.
    let pdf = String::from_utf8_lossy(&pdf);
    assert!(pdf.starts_with("%PDF-") && pdf.contains("/MediaBox [0 0 249.4"), "{pdf:.300}");
    let both = String::from_utf8_lossy(&both);
    for text in ["robots made worse</text>", "robots as measured</text>", "width=\"680.31\""] {
        assert!(both.contains(text), "no {text} in {both:.300}");
    }
    assert_eq!(code(&wrong), 2);
    assert!(stderr(&wrong).contains("expected a number and mm, cm or in"), "{}", stderr(&wrong));
}

#[test]
fn for_a_paper_a_picture_has_neither_title_nor_facts_and_cells_and_verdict_are_tables() {
    let place = lab_folder();
    let here = place.path();
    let written = |name: &str, command: &[&str]| {
        done(here, &[command, &["-o", name]].concat());
        text_in(here, name)
    };
    let paper = ["--theme", "paper", "--width", "88mm"];

    for (name, command) in [("diagram.svg", ["diagram", "out"]), ("run.svg", ["draw", "one"])] {
        let svg = written(name, &[&command[..], &paper].concat());
        let drawn = svg.split_once("</desc>").expect("it is described").1;

        assert!(svg.contains("width=\"332.6"), "88 mm: {svg:.200}");
        for hidden in ["font-size=\"16\"", "9 robots, ", "not validated"] {
            assert!(!drawn.contains(hidden), "{name} shows {hidden}: {drawn}");
        }
        assert!(svg.contains("9 robots, "), "the file has it");
    }
    let cells = written("cells.tex", &["diagram", "out"]);
    assert_eq!(cells.matches(" \\\\\n").count(), 1 + 4, "a head and four cells: {cells}");
    assert!(cells.contains("speed (m/s) & turning rate (rad/s) & most frequent phase"), "{cells}");
    assert!(cells.contains("$0.15$ & $0.75$ & stable milling & 100.0\\,\\% & "), "{cells}");
    assert!(cells.starts_with("% Stable milling of flockbot, robots made worse, "), "{cells}");
    let verdict = written("verdict.tex", &["compare", "out", "--bags", "one", "a<b>&c"]);
    for expected in ["All runs: 2 of 2 milled, ", "$B_r \\ge B_s - 0.1$", "Verdict: undecided."] {
        assert!(verdict.contains(expected), "no {expected} in {verdict}");
    }
    Run { time: Time::Lockstep, ..Run::new(5) }.record(here, "simulated");
    let verdict = written("simulated.tex", &["compare", "out", "--bags", "simulated"]);
    assert!(verdict.contains("Note: in 1 of 1 run the simulator stood in"), "{verdict}");
    let wrong = rsrs(here, &["compare", "out", "--bags", "one", "-o", "verdict.pdf"]);
    assert!(stderr(&wrong).contains("name the table `-o verdict.tex`"), "{}", stderr(&wrong));
}

#[test]
fn a_run_without_poses_is_in_the_report_by_its_label_by_hand() {
    let place = lab_folder();
    let here = place.path();
    for bag in ["one", "blind"] {
        done(here, &["label", bag, "--as", "dispersion", "--by", "ana"]);
    }

    let by_ana = ["report", "out", "-o", "ana.html", "--labels", "human:ana", "--bags"];
    let by_ana = rsrs(here, &[&by_ana[..], &["one", "blind"]].concat());
    let by_judge = rsrs(here, &["report", "out", "-o", "judge.html", "--bags", "one", "blind"]);
    let no_html = rsrs(here, &["report", "out", "-o", "report.pdf", "--bags", "one"]);

    // Two runs that both dispersed, where simulated ones always mill, violate the claim.
    assert_eq!((code(&by_ana), code(&by_judge), code(&no_html)), (3, 3, 2), "{}", stderr(&by_ana));
    let html = text_in(here, "ana.html");
    assert_well_formed(&html);
    assert!(html.contains("dispersion by ana") && html.contains("not drawn: blind: "), "{html}");
    let html = text_in(here, "judge.html");
    assert!(html.contains("not labelled"), "{html}");
}
