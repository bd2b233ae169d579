//! The page of `sma diagnose --reference`.

#![allow(clippy::unwrap_used, reason = "helpers of tests")]

use std::fs;
use std::path::Path;

use roxmltree::Document;

use crate::another_each_run::{ROD, late, ran};
use crate::folder::sma;

/// A recording whose name is markup.
const HOSTILE: &str = "late<b>&'.csv";

/// A reference of two runs, and one since whose output is shown half a second late.
pub(crate) fn rig(folder: &Path, since: &str) {
    fs::write(folder.join("rod.toml"), ROD).unwrap();
    ran(folder, "a.csv", [2.3, 1.9], [0.0, 0.0]);
    ran(folder, "b.csv", [2.1, 2.4], [0.05, -0.01]);
    ran(folder, "today.csv", [2.0, 2.2], [-0.05, 0.01]);
    late(folder, "today.csv", since);
}

fn call(rest: &str) -> String {
    format!("diagnose rod.toml --reference a.csv b.csv --train {HOSTILE} --quiet {rest}")
}

#[cfg(unix)]
#[test]
fn a_page_says_what_has_changed_since_a_reference() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    rig(folder, HOSTILE);
    let (code, text, said) = sma(
        folder,
        &call("--threads 1 --report page.html --json one.json"),
    );
    assert_eq!(code, 0, "{said}");
    let page = fs::read_to_string(folder.join("page.html")).unwrap();
    let tree = Document::parse(page.trim_start_matches("<!DOCTYPE html>")).unwrap();
    let all = |name: &str| -> Vec<String> {
        let nodes = tree.descendants().filter(|node| node.has_tag_name(name));
        nodes
            .filter_map(|node| node.text())
            .map(str::to_owned)
            .collect()
    };
    let verdict = &all("h1")[0];
    assert!(
        verdict.starts_with(
            "CHANGED: since the reference, dead time has appeared: dead_time_s by 0.50 ± "
        ),
        "{verdict}"
    );
    let one_line = text.replace('\n', " ");
    assert!(one_line.starts_with(verdict.as_str()), "{one_line}");
    // Its name is text, never markup.
    assert!(all("b").is_empty());
    assert!(page.contains("late&lt;b&gt;&amp;") && !page.contains("late<b>"));
    for attribute in ["src", "href"] {
        let mut nodes = tree.descendants();
        assert!(nodes.all(|node| node.attribute(attribute).is_none()));
    }
    let captions = all("figcaption");
    let of = |start: &str| captions.iter().filter(|one| one.starts_with(start)).count();
    assert_eq!([HOSTILE, "a.csv: ", "b.csv: "].map(of), [2, 2, 2]);
    assert_eq!(page.matches("<polygon").count(), 3, "bands");
    for wanted in [
        "What has changed",
        "How the runs of the reference differ from one another",
        "heat loss, over the laws",
        "no change keeps less than 5 % (here &lt; 0.1 %)",
        "<td>named</td>",
        "The runs that were compared",
        "SHA-256",
    ] {
        assert!(page.contains(wanted), "{wanted}");
    }

    // On two threads the page and all else have the same bytes.
    let rest = "--threads 2 --report two.html --json two.json";
    let (code, again, said) = sma(folder, &call(rest));
    assert_eq!((code, &again), (0, &text), "{said}");
    let read = |name: &str| fs::read_to_string(folder.join(name)).unwrap();
    let result = |page: &str| page.split("How this was made").next().unwrap().to_owned();
    assert!(result(&read("two.html")) == result(&page));
    assert!(read("two.json") == read("one.json"));

    // A page that cannot be written costs nothing else.
    let rest = "--report /dev/full --json three.json";
    let (code, again, said) = sma(folder, &call(rest));
    assert_eq!((code, &again), (1, &text));
    assert!(
        said.starts_with("sma: /dev/full: cannot be written"),
        "{said}"
    );
    assert!(read("three.json") == read("one.json"));
}

#[test]
fn other_results_of_a_diagnosis_are_refused_beside_a_reference() {
    let folder = tempfile::tempdir().unwrap();
    for rest in [
        "--series series.json",
        "--plots figures",
        "--save-model m.toml",
    ] {
        let (code, _, said) = sma(folder.path(), &call(rest));
        assert_eq!(code, 2, "{said}");
    }
}
