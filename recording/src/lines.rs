//! Text lines of bounded length, and the fields within a line.
//!
//! Not the `csv` crate, for three reasons: an error must name the very line (its positions are
//! those where the search for a record began, comments and all); a quote that is never closed must
//! not swallow the rest of a file into memory; and runs of spaces are one delimiter. A test holds
//! the splitting against that crate.

use std::io::{BufRead, BufReader, Read};
use std::ops::Range;

use crate::error::RecordingError;

/// Bytes in a line beyond which a file is not a recording: ten thousand columns of numbers fit.
const MAX_LINE_BYTES: usize = 1 << 20;

/// The lines of a file that mean something, with their numbers.
pub(crate) struct Lines<'a, R> {
    file: &'a str,
    reader: BufReader<R>,
    buffer: Vec<u8>,
    number: u64,
}

impl<'a, R: Read> Lines<'a, R> {
    pub(crate) fn new(reader: R, file: &'a str) -> Self {
        Self {
            file,
            reader: BufReader::new(reader),
            buffer: Vec::new(),
            number: 0,
        }
    }

    /// The next line that is neither blank nor a comment, with its number, counted from 1.
    pub(crate) fn advance(&mut self) -> Result<Option<(u64, &str)>, RecordingError> {
        loop {
            if !self.fill()? {
                return Ok(None);
            }
            let line = self.buffer.trim_ascii();
            if !line.is_empty() && !line.starts_with(b"#") {
                break;
            }
        }
        match std::str::from_utf8(&self.buffer) {
            Ok(line) => Ok(Some((self.number, line))),
            Err(fault) => Err(RecordingError::NotUtf8 {
                file: self.file.to_owned(),
                line: self.number,
                byte: fault.valid_up_to() + 1,
            }),
        }
    }

    /// Reads one line, without its end, into the buffer; false at the end of the file.
    fn fill(&mut self) -> Result<bool, RecordingError> {
        self.buffer.clear();
        let n_read = (&mut self.reader)
            .take(MAX_LINE_BYTES as u64 + 1)
            .read_until(b'\n', &mut self.buffer)
            .map_err(|source| RecordingError::Unreadable {
                file: self.file.to_owned(),
                source,
            })?;
        self.number += 1;
        if n_read > MAX_LINE_BYTES {
            return Err(RecordingError::LineTooLong {
                file: self.file.to_owned(),
                line: self.number,
                max_bytes: MAX_LINE_BYTES,
            });
        }
        if self.number == 1 && self.buffer.starts_with("\u{feff}".as_bytes()) {
            self.buffer.drain(.."\u{feff}".len());
        }
        // The spaces of a blank field stay: in a file with tabs they are the last field.
        while let Some(b'\n' | b'\r') = self.buffer.last() {
            self.buffer.pop();
        }
        Ok(n_read > 0)
    }
}

/// Separator of fields.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Delimiter {
    /// Exactly one of this character.
    Character(char),
    /// One or more white-space characters.
    WhiteSpace,
}

impl Delimiter {
    /// Tab, if `line` has one outside quotes; else semicolon; else comma; else white space.
    pub(crate) fn detect(line: &str) -> Self {
        // Every second piece between quotes is inside them; a doubled quote leaves an empty piece.
        let outside = || line.split('"').step_by(2);
        ['\t', ';', ',']
            .into_iter()
            .find(|&delimiter| outside().any(|piece| piece.contains(delimiter)))
            .map_or(Self::WhiteSpace, Self::Character)
    }

    /// Puts the places of the fields of `line` into `fields`: without quotes and surrounding space.
    pub(crate) fn split(self, line: &str, fields: &mut Vec<Range<usize>>) {
        fields.clear();
        match self {
            Self::WhiteSpace => {
                let place = |field: &str| offset(line, field)..offset(line, field) + field.len();
                fields.extend(line.split_whitespace().map(place));
            }
            Self::Character(delimiter) => {
                let mut start = 0;
                loop {
                    let (field, next) = field_at(line, start, delimiter);
                    fields.push(field);
                    match next {
                        Some(next) => start = next,
                        None => return,
                    }
                }
            }
        }
    }
}

/// Where `part`, a slice of `line`, starts in it.
fn offset(line: &str, part: &str) -> usize {
    part.as_ptr() as usize - line.as_ptr() as usize
}

/// The field that starts at `start`, and where the next one does.
fn field_at(line: &str, start: usize, delimiter: char) -> (Range<usize>, Option<usize>) {
    let rest = &line[start..];
    let blank = |c: char| c.is_whitespace() && c != delimiter;
    let lead = rest.len() - rest.trim_start_matches(blank).len();
    let (from, quoted) = match rest[lead..].strip_prefix('"') {
        Some(_) => (lead + 1, closing_quote(&rest[lead + 1..])),
        None => (lead, None),
    };
    // A quote that is never closed is text, so that it cannot hide the fields behind it.
    let (from, search) = match quoted {
        Some(length) => (from, from + length + 1),
        None => (lead, lead),
    };
    let end = rest[search..].find(delimiter).map(|place| search + place);
    let to = match quoted {
        Some(length) => from + length,
        None => from + rest[from..end.unwrap_or(rest.len())].trim_end().len(),
    };
    (
        start + from..start + to,
        end.map(|end| start + end + delimiter.len_utf8()),
    )
}

/// Where the quote is that closes a field; doubled quotes belong to the field.
fn closing_quote(text: &str) -> Option<usize> {
    let mut from = 0;
    loop {
        let quote = from + text[from..].find('"')?;
        if !text[quote + 1..].starts_with('"') {
            return Some(quote);
        }
        from = quote + 2;
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn split(line: &str) -> Vec<&str> {
        let mut fields = Vec::new();
        Delimiter::detect(line).split(line, &mut fields);
        fields.into_iter().map(|place| &line[place]).collect()
    }

    #[test]
    fn delimiter_is_found_in_the_first_line() {
        assert_eq!(split("time_s;a, b"), ["time_s", "a, b"]);
        assert_eq!(split("time_s\ta; b, c"), ["time_s", "a; b, c"]);
        assert_eq!(split("\"Time, s\";\"x\""), ["Time, s", "x"]);
        assert_eq!(split("  1   2\u{b}3 "), ["1", "2", "3"]);
        assert_eq!(split("a,,"), ["a", "", ""]);
        assert_eq!(split("\t1\t"), ["", "1", ""]);
    }

    #[test]
    fn unclosed_quote_is_text() {
        assert_eq!(split("\"a,b"), ["\"a,b"]);
        let mut fields = Vec::new();
        Delimiter::Character(',').split("1,\"2,3", &mut fields);
        assert_eq!(fields, [0..1, 2..4, 5..6]);
    }

    proptest! {
        #[test]
        fn fields_are_those_of_the_csv_crate(
            fields in prop::collection::vec("([!-~é]([ -~é]{0,6}[!-~é])?)?", 2..6),
        ) {
            let mut writer = csv::WriterBuilder::new().from_writer(Vec::new());
            writer.write_record(&fields).unwrap();
            let line = String::from_utf8(writer.into_inner().unwrap()).unwrap();
            let line = line.trim_end_matches('\n');
            let mut places = Vec::new();
            Delimiter::Character(',').split(line, &mut places);
            let found: Vec<String> =
                places.into_iter().map(|place| line[place].replace("\"\"", "\"")).collect();
            prop_assert_eq!(found, fields);
        }
    }
}
