//! Numbers as loggers write them.

/// Marks of a missing number, in lower case.
const MISSING: [&str; 11] = [
    "", "-", "--", "---", "nan", "n/a", "na", "null", "none", "?", "#n/a",
];

/// A field as the reader takes it, and what was done to it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Number {
    pub(super) text: String,
    /// A unit that stood behind it.
    pub(super) unit: Option<String>,
    pub(super) done: Option<&'static str>,
}

/// True if a field marks a missing number.
pub(super) fn is_missing(field: &str) -> bool {
    MISSING.contains(&field.trim().to_lowercase().as_str())
}

/// The finite number of a field with this decimal mark.
pub(super) fn number(field: &str, decimal: char) -> Option<Number> {
    let field = field.trim();
    plain(field, decimal).or_else(|| {
        let behind_label = field.rsplit_once(['=', ':']).filter(|(label, _)| {
            let label = label.trim();
            !label.is_empty() && label.chars().all(|c| c.is_alphabetic() || c == '_')
        });
        let (rest, mut done) = match behind_label {
            Some((_, rest)) => (rest.trim(), Some("a label before the number is left out")),
            None => (field, None),
        };
        let end = rest
            .char_indices()
            .rfind(|(_, c)| c.is_ascii_digit() || *c == '.' || *c == ',')
            .map_or(0, |(k, c)| k + c.len_utf8());
        let (value, unit) = rest.split_at(end);
        let unit = unit.trim();
        let is_unit = !unit.is_empty()
            && unit.chars().count() <= 6
            && unit
                .chars()
                .all(|c| c.is_alphabetic() || "°%/²".contains(c));
        if !(unit.is_empty() || is_unit) {
            return None;
        }
        let found = plain(value, decimal)?;
        if is_unit {
            done = Some("the unit stands behind each number");
        }
        Some(Number {
            unit: is_unit.then(|| unit.to_owned()),
            done: done.or(found.done),
            ..found
        })
    })
}

/// A number and nothing else.
fn plain(field: &str, decimal: char) -> Option<Number> {
    let mut text = field.to_owned();
    let mut done = None;
    if text.contains('\u{2212}') {
        text = text.replace('\u{2212}', "-");
        done = Some("the minus is a typographic one");
    }
    let other = if decimal == ',' { '.' } else { ',' };
    if text.contains(other) {
        text = without_thousands(&text, other, decimal)?;
        done = Some("thousands are set apart");
    }
    if decimal == ',' && text.contains(',') {
        text = text.replacen(',', ".", 1);
    }
    if text.contains(['D', 'd']) {
        text = text.replacen(['D', 'd'], "e", 1);
        done = Some("the exponent is Fortran's");
    }
    let is_written_as_one = text
        .chars()
        .all(|c| c.is_ascii_digit() || "+-.eE".contains(c));
    let value: f64 = text.parse().ok()?;
    (is_written_as_one && value.is_finite()).then_some(Number {
        text,
        unit: None,
        done,
    })
}

/// A number whose thousands are set apart by a mark: `1,234,567.8`.
fn without_thousands(text: &str, mark: char, decimal: char) -> Option<String> {
    let (whole, _) = text.split_once(decimal).unwrap_or((text, ""));
    let mut groups = whole.trim_start_matches(['+', '-']).split(mark);
    let is_first = groups
        .next()
        .is_some_and(|first| (1..=3).contains(&first.len()));
    let are_groups = groups.all(|group| group.len() == 3);
    let is_behind = text
        .find(decimal)
        .is_some_and(|point| text.rfind(mark) > Some(point));
    (is_first && are_groups && !is_behind).then(|| text.replace(mark, ""))
}

/// True if a number without a point has no comma, or if its comma may set thousands apart as well as be a decimal mark.
pub(super) fn could_be_thousands(field: &str) -> bool {
    let field = field.trim().trim_start_matches(['+', '-']);
    match field.split_once(',') {
        None => true,
        Some((whole, rest)) => {
            (1..=3).contains(&whole.len()) && !whole.starts_with('0') && rest.len() == 3
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(field: &str, decimal: char) -> Option<f64> {
        number(field, decimal).map(|number| number.text.parse().unwrap())
    }

    #[test]
    fn numbers_of_loggers_are_read() {
        for (field, decimal, expected) in [
            ("1.5", '.', 1.5),
            ("-1,5", ',', -1.5),
            ("\u{2212}2.7", '.', -2.7),
            ("1.2D-03", '.', 1.2e-3),
            ("149,600", '.', 149_600.0),
            ("1,234,567.25", '.', 1_234_567.25),
            ("1.234,5", ',', 1234.5),
            ("1,234.5", '.', 1234.5),
            ("0.35 A", '.', 0.35),
            ("24°C", '.', 24.0),
            ("I=0.5", '.', 0.5),
            ("temp: 24.5 degC", '.', 24.5),
        ] {
            assert_eq!(read(field, decimal), Some(expected), "{field}");
        }
        for field in [
            "1.5,234", "", "abc", "1,23", "12:30", "1 2", "inf", "nan", "1e999", "=", "a1",
            "1,2345",
        ] {
            assert_eq!(read(field, '.'), None, "{field}");
        }
    }
}
