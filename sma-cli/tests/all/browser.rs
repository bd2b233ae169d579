//! Every kind of report in a browser: nothing is complained of, figures are drawn, the cursor reads values, and nothing
//! runs off the page on a phone or on a desk. Needs Chromium (`CHROMIUM`, or on the path), and says so where there is none.

#![allow(
    clippy::unwrap_used,
    clippy::panic,
    clippy::print_stderr,
    reason = "helpers of tests"
)]

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command as Program;

use assert_cmd::Command;
use serde_json::Value;

use crate::demo::demonstrated;
use crate::reference_page::rig;

/// Widths of a phone and of a desk, px.
const WIDTHS: [u32; 2] = [400, 1400];

/// Collects what the page complains of; stands first in it.
const LISTEN: &str =
    "<script>window.faults = []; addEventListener('error', (event) => faults.push(event.message));
console.error = console.warn = (...words) => faults.push(words.join(' '));</script>";

/// Uses the page as a reader would, and writes down what came of it.
const USE: &str = r#"<script>
addEventListener("load", () => {
  for (const folded of document.querySelectorAll("details")) folded.open = true;
  const figures = [...document.querySelectorAll("figure")].map((figure) => {
    const svg = figure.querySelector("svg"), box = svg.getBoundingClientRect();
    const at = { clientX: box.x + 0.5 * box.width, clientY: box.y + 0.5 * box.height, bubbles: true };
    svg.dispatchEvent(new PointerEvent("pointermove", at));
    const curves = [...svg.querySelectorAll("polyline, rect")].filter((part) => {
      const own = part.getBBox();
      return own.width + own.height > 1 && part.getAttribute("fill") !== "var(--ink)";
    });
    const before = svg.innerHTML;
    svg.dispatchEvent(new PointerEvent("pointerdown", { ...at, clientX: box.x + 0.4 * box.width }));
    svg.dispatchEvent(new PointerEvent("pointerup", { ...at, clientX: box.x + 0.7 * box.width }));
    const zoomed = svg.innerHTML !== before;
    svg.dispatchEvent(new MouseEvent("dblclick", at));
    const press = (key) => svg.dispatchEvent(new KeyboardEvent("keydown", { key, bubbles: true, cancelable: true }));
    const said = () => figure.querySelector("output")?.textContent ?? null;
    const first = said();
    press("ArrowRight");
    const moved = said() !== first, whole = svg.innerHTML;
    press("+");
    const enlarged = svg.innerHTML !== whole;
    press("Escape");
    return {
      keyboard: moved && enlarged && svg.getAttribute("tabindex") === "0",
      plot: figure.dataset.plot ? JSON.parse(figure.dataset.plot).labels.length : null,
      curves: curves.length,
      said: figure.querySelector("output")?.textContent ?? null,
      zoomed,
    };
  });
  const wide = document.documentElement.scrollWidth - document.documentElement.clientWidth;
  const tables = [...document.querySelectorAll("table")].filter((table) => table.querySelector("th button")).map((table) => {
    const of = (column) => [...table.tBodies[0].rows].map((row) => row.cells[column]?.textContent.trim() ?? "");
    return [...table.querySelectorAll("th button")].map((button, column) => {
      const first = of(column), heading = button.closest("th");
      const pressed = [0, 1, 2].map(() => {
        button.focus();
        // As the Enter key does.
        document.activeElement.click();
        return [heading.getAttribute("aria-sort"), of(column)];
      });
      return { first, pressed };
    });
  });
  const found = { faults, figures, tables, wide, dark: getComputedStyle(document.body).backgroundColor };
  const text = document.createElement("pre");
  text.id = "found";
  text.textContent = JSON.stringify(found);
  document.body.append(text);
});
</script>"#;

fn chromium() -> Option<PathBuf> {
    if let Some(named) = std::env::var_os("CHROMIUM") {
        return Some(PathBuf::from(named));
    }
    let path = std::env::var_os("PATH")?;
    let folders: Vec<PathBuf> = std::env::split_paths(&path).collect();
    let names = ["chromium", "chromium-browser", "google-chrome"];
    let places = names
        .iter()
        .flat_map(|name| folders.iter().map(move |folder| folder.join(name)));
    places.into_iter().find(|place| place.is_file())
}

/// Cells as numbers, if all that have one do.
fn numbers(cells: &[&str]) -> Option<Vec<f64>> {
    let number = |cell: &&str| {
        // Names with digits in them are no numbers.
        let digits = cell.trim_start_matches(|c: char| "<>≤≥±≈".contains(c) || c.is_whitespace());
        let digits = digits.replace(',', "");
        let number = |end: usize| digits.get(..end)?.parse::<f64>().ok();
        (1..=digits.len()).rev().find_map(number)
    };
    cells.iter().map(number).collect()
}

/// Presses on the headings of a table sort it by their columns: rising, falling, as it was.
fn assert_sorts(table: &Value, case: &str) {
    let strings = |cells: &'_ Value| -> Vec<String> {
        let cells = cells.as_array().unwrap().iter();
        cells
            .map(|cell| cell.as_str().unwrap().to_owned())
            .collect()
    };
    for column in table.as_array().unwrap() {
        let first = strings(&column["first"]);
        let [(rising, up), (falling, down), (none, last)] = [0, 1, 2].map(|k| {
            let pressed = &column["pressed"][k];
            (pressed[0].as_str(), strings(&pressed[1]))
        });
        assert_eq!(
            [rising, falling, none],
            [Some("ascending"), Some("descending"), None],
            "{case}"
        );
        assert_eq!(last, first, "{case}");
        let filled = |cells: &[String]| cells.iter().take_while(|cell| !cell.is_empty()).count();
        let n_filled = filled(&up);
        assert_eq!(n_filled, filled(&down), "{case}");
        assert!(up[n_filled..].iter().all(String::is_empty), "{case}");
        let up: Vec<&str> = up[..n_filled].iter().map(String::as_str).collect();
        let down: Vec<&str> = down[..n_filled].iter().rev().map(String::as_str).collect();
        let mut all = first.clone();
        all.retain(|cell| !cell.is_empty());
        all.sort();
        let mut kept = up.clone();
        kept.sort_unstable();
        assert_eq!(kept, all, "{case}");
        assert_eq!(up, down, "{case}");
        if let Some(up) = numbers(&up) {
            assert!(up.is_sorted(), "{up:?}, {case}");
        }
    }
}

/// Content of a page of some width, as a reader finds it.
fn read(chromium: &Path, page: &str, folder: &Path, width: u32) -> Value {
    let used = page
        .replacen("<head>", &format!("<head>{LISTEN}"), 1)
        .replacen("</body>", &format!("{USE}</body>"), 1);
    let file = folder.join("used.html");
    fs::write(&file, used).unwrap();
    let run = Program::new(chromium)
        .args([
            "--headless",
            "--no-sandbox",
            "--disable-gpu",
            "--disable-quic",
            "--no-first-run",
        ])
        .args([
            "--disable-background-networking",
            "--disable-component-update",
            "--disable-sync",
        ])
        .arg(format!(
            "--user-data-dir={}",
            folder.join("profile").display()
        ))
        .arg(format!("--window-size={width},900"))
        .args(["--virtual-time-budget=20000", "--dump-dom"])
        .arg(format!("file://{}", file.display()))
        .output()
        .unwrap();
    let dom = String::from_utf8_lossy(&run.stdout);
    let found = dom
        .split_once("<pre id=\"found\">")
        .and_then(|(_, rest)| rest.split_once("</pre>"));
    let (found, _) = found.unwrap_or_else(|| panic!("{}", String::from_utf8_lossy(&run.stderr)));
    let found = found
        .replace("&lt;", "<")
        .replace("&gt;", ">")
        .replace("&amp;", "&");
    serde_json::from_str(&found).unwrap()
}

/// Makes every kind of report: its name and text.
fn reports(folder: &Path) -> Vec<(&'static str, String)> {
    let bundled = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("bundled")
        .display()
        .to_string();
    let calls = [
        (
            "identify",
            "identify {}/rod.toml --train {}/train.csv --validate {}/validate.csv --save-model model.toml \
                      --report identify.html",
        ),
        (
            "tune",
            "tune model.toml --step-output 2.5 --drive-max 5.5 --draws 8 --report tune.html",
        ),
        (
            "diagnose",
            "diagnose {}/rod.toml --train {}/train.csv --validate {}/validate.csv --report diagnose.html",
        ),
        (
            "reference",
            "diagnose rod.toml --reference a.csv b.csv --train late.csv --report reference.html",
        ),
        (
            "trial",
            "trial --family clean-white --cases 1 --report trial.html",
        ),
    ];
    rig(folder, "late.csv");
    let demo = ("demo", demonstrated().report.clone());
    let others = calls.into_iter().map(|(name, call)| {
        let call = call.replace("{}", &bundled);
        let mut sma = Command::cargo_bin("sma").unwrap();
        sma.args(call.split_whitespace())
            .current_dir(folder)
            .assert()
            .success();
        let page = folder.join(name).with_extension("html");
        (name, fs::read_to_string(page).unwrap())
    });
    std::iter::once(demo).chain(others).collect()
}

#[test]
fn every_report_can_be_read_and_used() {
    let Some(chromium) = chromium() else {
        eprintln!("SKIPPED: no Chromium on the path; CHROMIUM names one elsewhere");
        return;
    };
    let folder = tempfile::tempdir().unwrap();
    for (name, page) in reports(folder.path()) {
        for width in WIDTHS {
            let found = read(&chromium, &page, folder.path(), width);
            let case = format!("{name} at {width} px: {found:#}");
            assert_eq!(found["faults"].as_array().unwrap().len(), 0, "{case}");
            assert_eq!(found["wide"], 0, "{case}");
            let tables = found["tables"].as_array().unwrap();
            assert!(!tables.is_empty(), "{case}");
            for table in tables {
                assert_sorts(table, &case);
            }
            let figures = found["figures"].as_array().unwrap();
            assert_eq!(figures.len(), page.matches("<figure").count(), "{case}");
            assert!(!figures.is_empty(), "{case}");
            for figure in figures {
                let curves = figure["curves"].as_u64().unwrap();
                assert!(curves > 0, "{case}");
                let Some(n_labels) = figure["plot"].as_u64() else {
                    continue;
                };
                assert!(curves >= n_labels, "{case}");
                let said = figure["said"].as_str().unwrap();
                assert_eq!(
                    said.split(", ").count() as u64,
                    n_labels + said.split(':').next().unwrap().matches(", ").count() as u64,
                    "{case}"
                );
                assert_eq!(figure["zoomed"], true, "{case}");
                assert_eq!(figure["keyboard"], true, "{case}");
            }
        }
    }
}
