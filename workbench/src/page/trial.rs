//! A blind trial as a page.

use blind_trial::scores::{Calibration, Confusion, Power};

use super::{Page, escaped};
use crate::WorkbenchError;
use crate::figure::{Figure, Series, Style};
use crate::report::trial::Tried;

/// The page but for how it was made: the targets, then names, power and calibration.
///
/// # Errors
///
/// [`WorkbenchError`] if a figure cannot be drawn.
pub fn trial(tried: &Tried<'_>) -> Result<Page, WorkbenchError> {
    let mut page = Page::new("Blind trial", &tried.head());
    if tried.is_own {
        page.section("What the experiment would reveal");
        page.table(&tried.reach());
    } else {
        page.section("The targets");
        page.table(&tried.table());
    }
    page.section("What was concealed, and what was named");
    page.line(&matrix(&tried.scores.confusion));
    for figure in [
        power(&tried.scores.power),
        calibration(&tried.scores.calibration),
    ] {
        if figure.series.iter().any(|series| !series.points.is_empty()) {
            page.figure(&figure)?;
        }
    }
    if let Some(others) = tried.others() {
        page.section("Other methods on the same files");
        page.table(&others);
    }
    Ok(page)
}

/// Counts, the darker the larger the share of the row.
fn matrix(confusion: &Confusion) -> String {
    let columns = confusion.columns.iter();
    let header: String = columns
        .map(|column| format!("<th><span>{}</span></th>", escaped(column)))
        .collect();
    let rows = confusion.rows.iter().zip(&confusion.counts);
    let rows: String = rows
        .map(|(row, counts)| {
            let all = counts.iter().sum::<usize>().max(1);
            let cells = counts.iter().zip(&confusion.columns);
            let cells: String = cells
                .map(|(&count, column)| {
                    if count == 0 {
                        return "<td></td>".to_owned();
                    }
                    let class = if column == row { "right" } else { "wrong" };
                    format!(
                        "<td class=\"{class}\" style=\"--share:{}%\" title=\"{count} of {all}: {} named {}\">{count}</td>",
                        100 * count / all,
                        escaped(row),
                        escaped(column)
                    )
                })
                .collect();
            format!("<tr><th>{}</th>{cells}</tr>\n", escaped(row))
        })
        .collect();
    format!(
        "<div class=\"scroll\"><table class=\"matrix\">\n<thead><tr><th></th>{header}</tr></thead>\n<tbody>{rows}</tbody></table></div>\n\
         <p class=\"soft\">Visible single effects: a row for each that was concealed, a column for the strongest name that was given, or \
         the verdict where there was none. The diagonal is right.</p>"
    )
}

fn power(power: &Power) -> Figure {
    let bins = power.bins.iter().filter(|bin| bin.stated.n > 0);
    let shares = bins.clone().enumerate();
    let stated = shares
        .clone()
        .map(|(k, bin)| [k as f64, 100.0 * bin.stated.share()]);
    let top = shares.map(|(k, bin)| [k as f64, 100.0 * bin.top.share()]);
    Figure {
        name: "power",
        caption: "Single effects that are in the stated set, and named first, by how many standard deviations an oracle sees of \
                  them that knows the effect's trace and the noise"
            .to_owned(),
        across: "oracle score from".to_owned(),
        up: "of the cases, %".to_owned(),
        series: vec![
            Series::new("in the stated set", Style::Training, stated),
            Series::new("named first", Style::Unseen, top),
        ],
        words: bins.map(|bin| bin.from_t.to_string()).collect(),
        ..Figure::default()
    }
}

fn calibration(calibration: &Calibration) -> Figure {
    let bins = calibration.bins.iter();
    let right = bins.map(|bin| [100.0 * bin.stated, 100.0 * bin.right]);
    Figure {
        name: "calibration",
        caption: "How often names are right, by their stated probability; on the thin line a probability means what it says"
            .to_owned(),
        across: "stated probability, %".to_owned(),
        up: "right, %".to_owned(),
        series: vec![
            Series::new("names", Style::Extended, right),
            Series::new("as stated", Style::Noise, [[0.0, 0.0], [100.0, 100.0]]),
        ],
        ..Figure::default()
    }
}
