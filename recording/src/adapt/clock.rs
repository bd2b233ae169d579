//! Time as loggers write it: stamps, clocks that wrap, stamps that stand twice.

use crate::adapt::Done;
use crate::adapt::guess::Roles;
use crate::adapt::stamp::{Stamp, stamp};
use crate::adapt::table::{Row, Table};
use crate::unit::split_name;

const NANOSECONDS_A_DAY: i128 = 86_400_000_000_000;

/// A clock from which seconds are counted, not from the start of a recording: none runs for three years.
const EPOCH: f64 = 1e8;

/// Counters that loggers let run over.
const WRAPS: [f64; 2] = [4_294_967_296.0, 65_536.0];

/// Share of a counter's range from which it may have run over.
const NEARLY_FULL: f64 = 0.99;

/// Rows by which one may stand too late.
const FARTHEST: usize = 10;

/// Share of the rows that may stand out of order.
const MOST_UNSORTED: f64 = 0.01;

/// Share of the rows that may stand twice.
const MOST_TWICE: f64 = 0.05;

/// Makes of what stands in the column of time seconds that rise, where it is clear how.
pub(super) fn set(table: &mut Table, roles: &Roles, done: &mut Done) {
    let Some(column) = roles.time else { return };
    if table.holds_stamps(column) {
        count_stamps(table, column, done);
    } else {
        count_from_the_start(table, column, done);
        unwrap(table, column, done);
    }
    sort(table, column, done);
    spread(table, column, done);
}

/// Seconds since the first stamp, in place of stamps.
fn count_stamps(table: &mut Table, column: usize, done: &mut Done) {
    let mut first = None;
    let mut days = 0;
    let mut last: Option<i128> = None;
    for row in &mut table.rows {
        let Some(stamp) = row.fields.get(column).and_then(|field| stamp(field)) else {
            continue;
        };
        let since = match stamp {
            Stamp::Dated(since) => since,
            Stamp::OfDay(of_day) => {
                let so_far = of_day + days * NANOSECONDS_A_DAY;
                if last.is_some_and(|last| so_far < last - NANOSECONDS_A_DAY / 2) {
                    days += 1;
                    done.at_line("midnight passes", row.line);
                }
                of_day + days * NANOSECONDS_A_DAY
            }
        };
        last = Some(since);
        let elapsed = since - *first.get_or_insert(since);
        row.fields[column] = (elapsed as f64 / 1e9).to_string();
    }
    if let Some(name) = table.names.as_mut().and_then(|names| names.get_mut(column)) {
        done.of_file(format!(
            "\"{name}\" holds stamps: time is counted in s from the first"
        ));
        *name = format!("{} [s]", split_name(name).0);
    }
}

/// Takes a clock's count at the first row from all of them, digit by digit, where it is that of no recording.
fn count_from_the_start(table: &mut Table, column: usize, done: &mut Done) {
    let parts = |row: &Row| -> Option<(i64, f64)> {
        let text = row.fields.get(column)?;
        let (whole, fraction) = text.split_once('.').unwrap_or((text, "0"));
        let fraction: f64 = format!("0.{fraction}").parse().ok()?;
        Some((whole.parse().ok()?, fraction))
    };
    let Some((start, fraction)) = table.rows.first().and_then(parts) else {
        return;
    };
    if (start as f64) < EPOCH {
        return;
    }
    for row in &mut table.rows {
        if let Some((whole, own)) = parts(row) {
            row.fields[column] = ((whole - start) as f64 + (own - fraction)).to_string();
        }
    }
    done.of_file(format!("time is counted from its first value, {start}"));
}

/// Lets a counter that ran over go on.
fn unwrap(table: &mut Table, column: usize, done: &mut Done) {
    let values: Vec<Option<f64>> = table.rows.iter().map(|row| row.value(column)).collect();
    let start = values.iter().flatten().copied().next().unwrap_or(0.0);
    let mut added = 0.0;
    let mut before = f64::NEG_INFINITY;
    for (row, value) in table.rows.iter_mut().zip(values) {
        let Some(value) = value else { continue };
        // What was counted from the start ran over as much earlier.
        let wrap = WRAPS.into_iter().find(|wrap| {
            let fall = before - value;
            (NEARLY_FULL * wrap..=*wrap).contains(&fall) && (start..=*wrap).contains(&before)
        });
        if let Some(wrap) = wrap {
            added += wrap;
            done.at_line(
                "the counter of the clock ran over, and is let go on",
                row.line,
            );
        }
        before = value;
        if added > 0.0 {
            row.fields[column] = (value + added).to_string();
        }
    }
}

/// Puts a few rows that stand out of order where they belong.
fn sort(table: &mut Table, column: usize, done: &mut Done) {
    let times: Option<Vec<f64>> = table.rows.iter().map(|row| row.value(column)).collect();
    let Some(times) = times else { return };
    let late: Vec<usize> = (1..times.len())
        .filter(|&k| times[k] < times[k - 1])
        .collect();
    let is_few = late.len() as f64 <= MOST_UNSORTED * times.len() as f64;
    let is_near = |&k: &usize| k <= FARTHEST || times[k] > times[k - FARTHEST - 1];
    if late.is_empty() || !is_few || !late.iter().all(is_near) {
        return;
    }
    for k in late {
        done.at_line(
            "a row stood too late, and is put where its time is",
            table.rows[k].line,
        );
    }
    let lines: Vec<usize> = table.rows.iter().map(|row| row.line).collect();
    table.rows.sort_by(|a, b| {
        let [a, b] = [a, b].map(|row| row.value(column).unwrap_or_default());
        a.total_cmp(&b)
    });
    for (row, line) in table.rows.iter_mut().zip(lines) {
        row.line = line;
    }
}

/// Leaves out rows that stand twice, and spreads different ones of one stamp up to the next.
fn spread(table: &mut Table, column: usize, done: &mut Done) {
    let pairs = table.rows.windows(2);
    let n_of_one_stamp = pairs
        .filter(|pair| pair[0].value(column) == pair[1].value(column))
        .count();
    // A clock that is slower than the rows: equal ones are samples of their own.
    let is_slow = n_of_one_stamp as f64 > MOST_TWICE * table.rows.len() as f64;
    table.rows.dedup_by(|row, before| {
        let is_same = !is_slow && row.fields == before.fields;
        if is_same {
            done.at_line("left out: the row stands twice", row.line);
        }
        is_same
    });
    let times: Option<Vec<f64>> = table.rows.iter().map(|row| row.value(column)).collect();
    let Some(times) = times else { return };
    let mut first = 0;
    let mut length = 0.0;
    while first < times.len() {
        let is_same = |time: &&f64| time.total_cmp(&times[first]).is_eq();
        let n = times[first..].iter().take_while(is_same).count();
        length = times
            .get(first + n)
            .map_or(length, |next| next - times[first]);
        if n > 1 && length > 0.0 {
            for k in 1..n {
                let spread = times[first] + length * k as f64 / n as f64;
                let row = &mut table.rows[first + k];
                row.fields[column] = spread.to_string();
                done.at_line("rows of one stamp are spread up to the next", row.line);
            }
        }
        first += n;
    }
}
