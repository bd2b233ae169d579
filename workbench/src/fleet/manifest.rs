//! A manifest: a file that names the rigs of a fleet and their files.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use recording::read_text;
use serde::Deserialize;
use toml::Spanned;

use super::{Fleet, FleetError, Listed, RigFiles};

/// Most bytes of a manifest: a hundred thousand rigs fit.
const MOST_BYTES: u64 = 1 << 26;

/// Columns of a CSV manifest.
const COLUMNS: [&str; 4] = ["name", "rod", "train", "validate"];

/// Separates the recordings of one field.
const BETWEEN: char = ';';

/// A rig as it is written.
#[derive(Debug, Default)]
struct Entry {
    line: usize,
    name: String,
    rod: String,
    train: Vec<String>,
    validate: Vec<String>,
}

/// Reads `name,rod,train,validate`: a rig a row, its recordings divided by semicolons, paths from the manifest's folder.
/// Blank lines and those that begin with `#` do not count.
pub(super) fn read_csv(path: &Path) -> Result<Fleet, FleetError> {
    let text = text(path)?;
    let text = text.strip_prefix('\u{feff}').unwrap_or(&text);
    let lines = (1..).zip(text.lines());
    let mut rows = lines
        .filter(|(_, line)| !line.trim().is_empty() && !line.starts_with('#'))
        .map(|(number, line)| (number, fields(line)));
    let (line, header) = rows.next().unwrap_or((1, Vec::new()));
    let place = |column: &str| header.iter().position(|own| own == column);
    let is_known = |own: &String| COLUMNS.contains(&own.as_str());
    let has_twice = header.iter().collect::<BTreeSet<_>>().len() < header.len();
    let places = [place("name"), place("rod"), place("train")];
    let ([Some(name), Some(rod), Some(train)], true, false) =
        (places, header.iter().all(is_known), has_twice)
    else {
        return Err(FleetError::Columns {
            path: path.to_owned(),
            line,
            found: match &header[..] {
                [] => "none".to_owned(),
                header => header.join(", "),
            },
        });
    };
    let validate = place("validate");
    let entries = rows.map(|(line, fields)| {
        if fields.len() != header.len() {
            return Err(FleetError::Fields {
                path: path.to_owned(),
                line,
                found: fields.len(),
                expected: header.len(),
            });
        }
        Ok(Entry {
            line,
            name: fields[name].clone(),
            rod: fields[rod].clone(),
            train: divided(&fields[train]),
            validate: validate.map_or(Vec::new(), |column| divided(&fields[column])),
        })
    });
    listed(path, entries.collect::<Result<_, _>>()?)
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Manifest {
    /// Of all rigs that name none.
    rod: Option<String>,
    #[serde(default)]
    rig: Vec<Spanned<RigTable>>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct RigTable {
    name: String,
    rod: Option<String>,
    train: Vec<String>,
    #[serde(default)]
    validate: Vec<String>,
}

/// Reads `[[rig]]` tables of `name`, `rod`, `train` and `validate`; a `rod` above them is that of all rigs that name none.
pub(super) fn read_toml(path: &Path) -> Result<Fleet, FleetError> {
    let text = text(path)?;
    let position = |byte: usize| {
        let before = &text[..byte.min(text.len())];
        let line_start = before.rfind('\n').map_or(0, |end| end + 1);
        let line = before.matches('\n').count() + 1;
        (line, before[line_start..].chars().count() + 1)
    };
    let manifest: Manifest = toml::from_str(&text).map_err(|error| {
        let (line, column) = position(error.span().map_or(0, |span| span.start));
        FleetError::Toml {
            path: path.to_owned(),
            line,
            column,
            message: error.message().replace('\n', " "),
        }
    })?;
    let entries = manifest.rig.into_iter().map(|rig| {
        let (line, _) = position(rig.span().start);
        let rig = rig.into_inner();
        Entry {
            line,
            name: rig.name,
            rod: rig.rod.or_else(|| manifest.rod.clone()).unwrap_or_default(),
            train: rig.train,
            validate: rig.validate,
        }
    });
    listed(path, entries.collect())
}

fn text(path: &Path) -> Result<String, FleetError> {
    read_text(path, MOST_BYTES).map_err(|source| FleetError::Unreadable {
        path: path.to_owned(),
        source,
    })
}

fn listed(path: &Path, entries: Vec<Entry>) -> Result<Fleet, FleetError> {
    let folder = path.parent().unwrap_or(Path::new(""));
    let mut names = BTreeSet::new();
    let mut rigs = Vec::new();
    for entry in entries {
        entry.check(path)?;
        if !names.insert(entry.name.clone()) {
            return Err(FleetError::NameTwice {
                path: path.to_owned(),
                line: entry.line,
                name: entry.name,
            });
        }
        let paths = |files: Vec<String>| -> Vec<PathBuf> {
            files.into_iter().map(|file| folder.join(file)).collect()
        };
        rigs.push(Listed {
            is_unread: false,
            name: entry.name,
            files: Ok(RigFiles {
                rod: folder.join(entry.rod),
                train: paths(entry.train),
                validate: paths(entry.validate),
            }),
        });
    }
    if rigs.is_empty() {
        return Err(FleetError::NoRig {
            path: path.to_owned(),
            expected: "a row or a [[rig]] for each, with name, rod and train",
        });
    }
    Ok(Fleet {
        rigs,
        left_out: Vec::new(),
    })
}

impl Entry {
    fn check(&self, path: &Path) -> Result<(), FleetError> {
        let has_empty = |files: &[String]| files.iter().any(|file| file.trim().is_empty());
        let checks = [
            ("name", self.name.trim().is_empty(), "a name for its row"),
            ("rod", self.rod.trim().is_empty(), "the path of a rod file"),
            (
                "train",
                self.train.is_empty() || has_empty(&self.train),
                "the path of a recording, or several",
            ),
            (
                "validate",
                has_empty(&self.validate),
                "the path of a recording, several, or none",
            ),
        ];
        match checks.into_iter().find(|(_, is_empty, _)| *is_empty) {
            None => Ok(()),
            Some((key, _, expected)) => Err(FleetError::Empty {
                path: path.to_owned(),
                line: self.line,
                key,
                expected,
            }),
        }
    }
}

/// Recordings of one field.
fn divided(field: &str) -> Vec<String> {
    if field.trim().is_empty() {
        return Vec::new();
    }
    let files = field.split(BETWEEN).map(|file| file.trim().to_owned());
    files.collect()
}

/// Fields of a line, without the quotes around them and the spaces beside them.
fn fields(line: &str) -> Vec<String> {
    let mut fields = vec![String::new()];
    let (mut is_quoted, mut was_quoted) = (false, false);
    let mut characters = line.trim_end().chars().peekable();
    while let Some(character) = characters.next() {
        let last = fields.len() - 1;
        match character {
            '"' if is_quoted && characters.peek() == Some(&'"') => {
                characters.next();
                fields[last].push('"');
            }
            '"' if is_quoted => is_quoted = false,
            '"' if fields[last].trim().is_empty() && !was_quoted => {
                fields[last].clear();
                (is_quoted, was_quoted) = (true, true);
            }
            ',' if !is_quoted => {
                was_quoted = false;
                fields.push(String::new());
            }
            other => fields[last].push(other),
        }
    }
    fields
        .into_iter()
        .map(|field| field.trim().to_owned())
        .collect()
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test may end in a panic")]
mod tests {
    use super::*;

    #[test]
    fn fields_may_be_quoted() {
        for (line, expected) in [
            ("a,b,c", vec!["a", "b", "c"]),
            ("a, b ,", vec!["a", "b", ""]),
            (r#""a, ""b""",c"#, vec![r#"a, "b""#, "c"]),
            ("", vec![""]),
        ] {
            assert_eq!(fields(line), expected, "{line}");
        }
    }
}
