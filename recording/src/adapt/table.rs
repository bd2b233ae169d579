//! Where in a file the table is: its delimiter, its decimal mark, its header, and its rows.

use std::collections::BTreeMap;
use std::ops::Range;

use crate::adapt::Done;
use crate::adapt::number::{Number, could_be_thousands, is_missing, number};
use crate::adapt::stamp::is_stamp;
use crate::columns::Columns;
use crate::lines::Delimiter;
use crate::unit::{Unit, split_name};

/// Lines behind the rows that may be a footer.
const LONGEST_FOOTER: usize = 20;

/// Lines at the head of a file, and of the others, that tell how it is written.
const LOOKED_AT: usize = 2000;

/// Delimiters, the likelier first.
const DELIMITERS: [Delimiter; 5] = [
    Delimiter::Character('\t'),
    Delimiter::Character(';'),
    Delimiter::Character(','),
    Delimiter::Character('|'),
    Delimiter::WhiteSpace,
];

/// The rows of a file.
#[derive(Debug)]
pub(crate) struct Table {
    pub(crate) names: Option<Vec<String>>,
    pub(crate) header_line: usize,
    pub(crate) rows: Vec<Row>,
}

/// A row, and its line, counted from 1.
#[derive(Debug)]
pub(crate) struct Row {
    pub(crate) line: usize,
    pub(crate) fields: Vec<String>,
    /// Units that stood behind its numbers.
    units: Vec<Option<String>>,
}

/// How fields are set apart and numbers written.
#[derive(Debug, Clone, Copy)]
struct Style {
    delimiter: Delimiter,
    decimal: char,
    n_fields: usize,
}

impl Style {
    /// That in which most of the lines are rows; `None` if none are.
    fn of(lines: &[String], columns: &Columns) -> Option<Self> {
        let decimals: &[char] = match columns.decimal {
            Some(',') => &[','],
            Some(_) => &['.'],
            None => &['.', ','],
        };
        let styles = DELIMITERS.into_iter().flat_map(|delimiter| {
            let is_apart = move |decimal: &&char| delimiter != Delimiter::Character(**decimal);
            let own = decimals.iter().filter(is_apart);
            own.map(move |&decimal| (delimiter, decimal))
        });
        // White space stands between fields only where nothing else does.
        let weight = |delimiter: Delimiter| match delimiter {
            Delimiter::WhiteSpace => 9,
            Delimiter::Character(_) => 10,
        };
        let mut best: Option<(usize, Self)> = None;
        for (delimiter, decimal) in styles {
            // Rows and numbers in them, for each number of fields.
            let mut counts: BTreeMap<usize, usize> = BTreeMap::new();
            for line in looked_at(lines) {
                let fields = split(line, delimiter);
                let n_numbers = fields
                    .iter()
                    .filter(|field| is_value(field, decimal))
                    .count();
                if n_numbers >= 2 {
                    *counts.entry(fields.len()).or_default() += weight(delimiter) * n_numbers;
                }
            }
            let most = counts.into_iter().max_by_key(|(_, n_numbers)| *n_numbers);
            if let Some((n_fields, score)) = most
                && best.as_ref().is_none_or(|(highest, _)| score > *highest)
            {
                let style = Self {
                    delimiter,
                    decimal,
                    n_fields,
                };
                best = Some((score, style));
            }
        }
        best.map(|(_, style)| style)
    }

    /// True if the commas in the numbers could be decimal marks as well as marks between thousands.
    fn is_in_doubt(&self, rows: &[&String]) -> bool {
        let mut has_commas = false;
        for line in rows {
            for field in split(line, self.delimiter) {
                if number(field, self.decimal).is_none() {
                    continue;
                }
                if field.contains('.') || !could_be_thousands(field) {
                    return false;
                }
                has_commas |= field.contains(',');
            }
        }
        has_commas
    }
}

fn split(line: &str, delimiter: Delimiter) -> Vec<&str> {
    let mut places: Vec<Range<usize>> = Vec::new();
    delimiter.split(line, &mut places);
    places.into_iter().map(|place| &line[place]).collect()
}

/// The lines from which the style is taken: the first, and some of all others.
fn looked_at(lines: &[String]) -> impl Iterator<Item = &String> {
    let (first, rest) = lines.split_at(lines.len().min(LOOKED_AT));
    first
        .iter()
        .chain(rest.iter().step_by(rest.len() / LOOKED_AT + 1))
}

/// Which columns hold numbers, in most of the rows.
fn columns_of_numbers(lines: &[String], style: Style) -> Vec<bool> {
    let mut counts = vec![0_usize; style.n_fields];
    let mut n_rows = 0;
    for line in looked_at(lines) {
        let fields = split(line, style.delimiter);
        if fields.len() == style.n_fields {
            n_rows += 1;
            for (count, field) in counts.iter_mut().zip(&fields) {
                *count += usize::from(is_value(field, style.decimal));
            }
        }
    }
    counts
        .into_iter()
        .map(|count| 5 * count >= 4 * n_rows)
        .collect()
}

/// True if a field is a number, a date with a time, or a time of day.
fn is_value(field: &str, decimal: char) -> bool {
    number(field, decimal).is_some() || is_stamp(field)
}

impl Table {
    /// The table in some lines; `None` if there is none that could be meant.
    pub(crate) fn of(lines: &[String], columns: &Columns, done: &mut Done) -> Option<Self> {
        let skipped = columns.skip.min(lines.len());
        let style = Style::of(&lines[skipped..], columns)?;
        let Style {
            delimiter,
            decimal,
            n_fields,
        } = style;
        let holds_numbers = columns_of_numbers(&lines[skipped..], style);
        let is_row = |line: &String| {
            let fields = split(line, delimiter);
            let is_value = |field: &str| is_value(field, decimal);
            fields.len() == n_fields
                && fields.iter().filter(|field| is_value(field)).count() >= 2
                && fields
                    .iter()
                    .zip(&holds_numbers)
                    .all(|(field, is_number)| !is_number || is_value(field) || is_missing(field))
        };
        // A row by itself, before others, is a remnant.
        let first = (skipped..lines.len())
            .find(|&k| is_row(&lines[k]) && lines.get(k + 1).is_none_or(is_row))?;
        let last = (first..lines.len()).rfind(|&k| is_row(&lines[k]))?;
        let data: Vec<&String> = lines[first..=last]
            .iter()
            .filter(|line| is_row(line))
            .collect();
        if columns.decimal.is_none() && style.is_in_doubt(&data) {
            return None;
        }
        if decimal == ',' {
            done.of_file("numbers have a decimal comma");
        }
        if delimiter == Delimiter::Character('|') {
            done.of_file("a bar stands between fields");
        }
        let (names, header_line) = header(&lines[skipped..first], skipped, style, done)?;
        for (k, line) in lines[skipped..first].iter().enumerate() {
            let line_number = skipped + k + 1;
            let is_used = names.is_some() && line_number >= header_line;
            if !(is_used || line.trim().is_empty() || line.trim_start().starts_with('#')) {
                done.at_line("left out before the table", line_number);
            }
        }
        let mut table = Self {
            names,
            header_line,
            rows: Vec::new(),
        };
        table.take_rows(lines, first..last + 1, style, done);
        table.leave_out_the_end(lines, last, done)?;
        Some(table)
    }

    /// Takes the rows of some lines, numbers as the reader takes them; what is no row stays as it is.
    fn take_rows(&mut self, lines: &[String], places: Range<usize>, style: Style, done: &mut Done) {
        for k in places {
            let line = lines[k].trim();
            if line.is_empty() || line.starts_with('#') {
                continue;
            }
            let mut row = Row {
                line: k + 1,
                fields: Vec::new(),
                units: Vec::new(),
            };
            for field in split(&lines[k], style.delimiter) {
                let found = number(field, style.decimal);
                if let Some(what) = found.as_ref().and_then(|found| found.done) {
                    done.at_line(what, k + 1);
                }
                let (text, unit) = match found {
                    Some(Number { text, unit, .. }) => (text, unit),
                    None => (field.replace(['\t', '"'], " "), None),
                };
                row.fields.push(text);
                row.units.push(unit);
            }
            self.rows.push(row);
        }
    }

    /// Leaves out what stands behind the rows: a line that was cut off, and a footer. `None` if that is too much.
    fn leave_out_the_end(&mut self, lines: &[String], last: usize, done: &mut Done) -> Option<()> {
        let behind: Vec<usize> = (last + 1..lines.len())
            .filter(|&k| !lines[k].trim().is_empty())
            .collect();
        if behind.len() > LONGEST_FOOTER {
            return None;
        }
        for &k in &behind {
            done.at_line("left out behind the table", k + 1);
        }
        // Without an end of the line the last number may have lost digits: it has fewer than all before it.
        let is_open = last + 1 == lines.len();
        if let [others @ .., end] = &self.rows[..]
            && is_open
            && others.len() >= 2
        {
            let n_digits = |row: &Row| row.fields.last().map_or(0, String::len);
            let is_cut = others.iter().all(|row| n_digits(row) > n_digits(end));
            if is_cut {
                done.at_line("left out: the last line was cut off", end.line);
                self.rows.pop();
            }
        }
        Some(())
    }

    /// Takes the unit that stands behind the numbers of a column into its name. Where numbers have several, or another than the name
    /// says, they are none: an instrument that changes its range writes 350 mA after 0.4 A.
    pub(crate) fn take_units_from_values(&mut self, done: &mut Done) {
        let n_columns = self.rows.first().map_or(0, |row| row.fields.len());
        for k in 0..n_columns {
            let unit_of = |row: &'_ Row| row.units.get(k).cloned().flatten();
            let Some(first) = self.rows.iter().find_map(unit_of) else {
                continue;
            };
            let name = self.names.as_ref().and_then(|names| names.get(k)).cloned();
            let named = name.as_deref().and_then(|name| split_name(name).1);
            let is_same = |one: &str, other: &str| match (Unit::parse(one), Unit::parse(other)) {
                (Some(one), Some(other)) => one == other,
                _ => one == other,
            };
            let is_zero = |row: &Row| row.value(k).is_none_or(|value| value.abs() <= 0.0);
            let is_one = self.rows.iter().all(|row| match unit_of(row) {
                Some(unit) => is_same(&unit, &first),
                None => is_zero(row),
            });
            if !is_one || named.is_some_and(|named| !is_same(named, &first)) {
                for row in &mut self.rows {
                    if let Some(unit) = row.units.get_mut(k).and_then(Option::take) {
                        row.fields[k] = format!("{} {unit}", row.fields[k]);
                    }
                }
                continue;
            }
            if let (None, Some(name)) = (named, &name) {
                done.of_file(format!("\"{name}\" is in {first}, as its values say"));
                if let Some(names) = &mut self.names {
                    names[k] = format!("{name} [{first}]");
                }
            }
        }
    }

    /// True if a column holds stamps, judged by its first rows.
    pub(crate) fn holds_stamps(&self, column: usize) -> bool {
        let mut first = self.rows.iter().take(3);
        first.all(|row| row.fields.get(column).is_some_and(|field| is_stamp(field)))
    }

    /// The table as text, with as many lines as the file.
    pub(crate) fn text(&self, n_lines: usize) -> String {
        let mut lines = vec![String::new(); n_lines];
        if let Some(names) = &self.names {
            lines[self.header_line - 1] = names.join("\t");
        }
        for row in &self.rows {
            lines[row.line - 1] = row.fields.join("\t");
        }
        lines.join("\n")
    }
}

/// The names above the rows, with the units of a row of their own, and the line in which they stand; `None` if they are fewer
/// than the fields.
fn header(
    above: &[String],
    n_before: usize,
    style: Style,
    done: &mut Done,
) -> Option<(Option<Vec<String>>, usize)> {
    let names_in = |line: &str| -> Option<Vec<String>> {
        let fields = split(line, style.delimiter);
        let n_filled = fields.iter().rposition(|field| !field.is_empty())? + 1;
        let is_value = |field: &&str| is_value(field, style.decimal);
        let fits = n_filled >= style.n_fields && !fields.iter().any(is_value);
        let clean = |field: &&str| field.replace(['\t', '"'], " ").trim().to_owned();
        fits.then(|| fields.iter().take(style.n_fields).map(clean).collect())
    };
    // Fewer names than fields: commas stand in numbers, too.
    let in_words = above.iter().rev().map(|line| split(line, style.delimiter));
    let in_words =
        in_words.filter(|fields| !fields.iter().any(|field| is_value(field, style.decimal)));
    let n_names = in_words
        .map(|fields| fields.len())
        .find(|&n_names| n_names >= 2);
    let is_short = n_names.is_some_and(|n_names| (n_names..2 * n_names).contains(&style.n_fields));
    if style.delimiter == Delimiter::Character(',') && is_short && n_names != Some(style.n_fields) {
        return None;
    }
    let mut units: Option<Vec<String>> = None;
    for (k, line) in above.iter().enumerate().rev() {
        let line = line.trim();
        let commented = line.trim_start_matches(['#', '%', '/', ' ']);
        if commented.is_empty() {
            continue;
        }
        let Some(names) = names_in(commented) else {
            break;
        };
        if units.is_none() && names.iter().all(|name| is_unit(name)) {
            done.at_line("a row of units", n_before + k + 1);
            units = Some(names);
            continue;
        }
        let names = names.into_iter().enumerate().map(|(k, name)| {
            let unit = units.as_ref().map(|units| units[k].as_str());
            let unit = unit.map(|unit| unit.trim_matches(['(', ')', '[', ']', ' ']));
            match unit.filter(|unit| !unit.is_empty() && split_name(&name).1.is_none()) {
                Some(unit) => format!("{name} [{unit}]"),
                None => name,
            }
        });
        return Some((Some(names.collect()), n_before + k + 1));
    }
    Some((None, 0))
}

/// True if a field of a header is a unit and nothing else, or blank.
fn is_unit(field: &str) -> bool {
    let bare = field.trim_matches(['(', ')', '[', ']', ' ']);
    bare.is_empty() || Unit::parse(bare).is_some()
}

impl Row {
    /// The number in a column.
    pub(crate) fn value(&self, column: usize) -> Option<f64> {
        self.fields
            .get(column)?
            .parse()
            .ok()
            .filter(|value: &f64| value.is_finite())
    }

    /// True if the field in a column marks a missing number.
    pub(crate) fn lacks(&self, column: usize) -> bool {
        self.fields
            .get(column)
            .is_some_and(|field| is_missing(field))
    }
}
