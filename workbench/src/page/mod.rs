//! Pages: one HTML file each, that needs no network and no script.

mod diagnosed;
mod fleet;
mod identified;
mod since;
mod trial;
mod tuned;

use std::fmt::Write;

use comfy_table::Table;
use identify::{InputFile, Provenance};

pub use diagnosed::diagnosed;
pub use fleet::fleet;
pub use identified::identified;
pub use since::since;
pub use trial::trial;
pub use tuned::tuned;

use crate::WorkbenchError;
use crate::figure::{Figure, inline};
use crate::report::table::table;

const STYLE: &str = include_str!("style.css");
const CURSOR: &str = include_str!("cursor.js");
const SORT: &str = include_str!("sort.js");

/// A page in the making.
#[derive(Debug)]
pub struct Page {
    text: String,
    n_figures: usize,
}

impl Page {
    /// With a title for the browser, and what to read first: its first line is the heading.
    #[must_use]
    pub fn new(title: &str, said: &str) -> Self {
        let (heading, others) = said.split_once('\n').unwrap_or((said, ""));
        let text = format!(
            "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"/>\n\
             <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"/>\n<title>{}</title>\n\
             <style>\n{STYLE}</style></head><body>\n<h1>{}</h1>\n",
            escaped(title),
            escaped(heading)
        );
        let mut page = Self { text, n_figures: 0 };
        page.paragraphs(others);
        page
    }

    /// A heading.
    pub fn section(&mut self, title: &str) {
        self.line(&format!("<h2>{}</h2>", escaped(title)));
    }

    /// Lines of text, a paragraph each; those that begin with a blank are remarks on the one before.
    pub fn paragraphs(&mut self, text: &str) {
        for line in text.lines().filter(|line| !line.trim().is_empty()) {
            let class = if line.starts_with(' ') {
                " class=\"soft remark\""
            } else {
                ""
            };
            self.line(&format!("<p{class}>{}</p>", escaped(line.trim())));
        }
    }

    /// A remark in a softer color, such as how to read the table below it.
    pub fn note(&mut self, text: &str) {
        self.line(&format!("<p class=\"soft\">{}</p>", escaped(text)));
    }

    /// Instructions for reading the figures.
    pub fn how_to_read(&mut self) {
        self.note("Move over a figure to read values; drag to enlarge, double-click to return. With the keyboard: Tab to a figure, arrows to move, + and - to enlarge, \
             Escape to return.");
    }

    /// A line of HTML markup, not escaped.
    pub fn line(&mut self, markup: &str) {
        self.text += markup;
        self.text.push('\n');
    }

    /// A table as the terminal has it.
    pub fn table(&mut self, table: &Table) {
        self.text += "<div class=\"scroll\"><table>\n";
        if let Some(header) = table.header() {
            let cells = header.cell_iter().map(|cell| escaped(&cell.content()));
            let cells: Vec<String> = cells
                .map(|cell| format!("<th scope=\"col\">{cell}</th>"))
                .collect();
            self.line(&format!("<thead><tr>{}</tr></thead>", cells.concat()));
        }
        self.text += "<tbody>\n";
        for row in table.row_iter() {
            let mut cells = String::new();
            for cell in row.cell_iter() {
                let content = cell.content();
                let is_number = !content.is_empty() && content.chars().all(of_number);
                let class = if is_number { " class=\"number\"" } else { "" };
                // Writing to a string does not fail.
                let _ = write!(cells, "<td{class}>{}</td>", escaped(&content));
            }
            self.line(&format!("<tr>{cells}</tr>"));
        }
        self.text += "</tbody></table></div>\n";
    }

    /// A figure with its caption above, and a cursor where the page may run its script.
    ///
    /// # Errors
    ///
    /// [`WorkbenchError`] if a figure cannot be drawn.
    pub fn figure(&mut self, figure: &Figure) -> Result<(), WorkbenchError> {
        self.n_figures += 1;
        let inline = inline(figure)?;
        let plot = inline.plot.map_or(String::new(), |plot| {
            format!(" data-plot=\"{}\"", escaped(&plot.to_string()))
        });
        let output = if plot.is_empty() {
            ""
        } else {
            "<output></output>"
        };
        self.line(&format!(
            "<figure id=\"figure-{}\"{plot}><figcaption>{}</figcaption>\n{}{output}</figure>",
            self.n_figures,
            escaped(&figure.caption),
            inline.svg
        ));
        Ok(())
    }

    /// Section of notes, a paragraph each.
    pub fn notes(&mut self, notes: &[String]) {
        self.section("Notes");
        self.paragraphs(&notes.join("\n"));
    }

    /// How it was made, and the end.
    #[must_use]
    pub fn made_by(self, made: &Provenance) -> String {
        self.made(&made.command, &made.seed.to_string(), &made.input)
    }

    /// How it was made, by a call whose seed is any text, and the end.
    #[must_use]
    pub fn made(mut self, command: &str, seed: &str, inputs: &[InputFile]) -> String {
        self.section("How this was made");
        self.line(&format!(
            "<pre>{}</pre>\n<p class=\"soft\">sma {}, seed {}. The same inputs and the same seed give the same result.</p>",
            escaped(command),
            env!("CARGO_PKG_VERSION"),
            escaped(seed)
        ));
        let mut files = table(["input", "SHA-256"]);
        for input in inputs {
            files.add_row([&input.file, &input.sha256]);
        }
        if !inputs.is_empty() {
            self.table(&files);
        }
        if self.n_figures > 0 {
            self.line(&format!("<script>\n{CURSOR}</script>"));
        }
        self.line(&format!("<script>\n{SORT}</script>"));
        self.text + "</body></html>\n"
    }
}

/// True for the characters of numbers, percentages and intervals.
fn of_number(c: char) -> bool {
    c.is_ascii_digit() || "+-.,e% …≥<>".contains(c)
}

/// Text in HTML, in an attribute or beside it.
#[must_use]
pub fn escaped(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
        .replace('"', "&quot;")
}
