//! A folder of rigs.

use std::collections::BTreeSet;
use std::ffi::{OsStr, OsString};
use std::fs;
use std::path::{Path, PathBuf};

use super::{Fleet, FleetError, Listed, RigFiles};

/// Name of a rod file.
const ROD: &str = "rod.toml";

/// Beginnings of the names of unseen recordings.
const UNSEEN: [&str; 3] = ["validate", "held", "unseen"];

/// Finds the rigs in a folder and in those below it.
pub(super) fn read(root: &Path, without: &[&Path]) -> Result<Fleet, FleetError> {
    let without = without.iter().filter_map(|path| path.canonicalize().ok());
    let mut search = Search {
        root,
        without: without.collect(),
        above: Vec::new(),
        found: Vec::new(),
        left_out: Vec::new(),
    };
    search.visit(root, None)?;
    let Search {
        mut found,
        left_out,
        ..
    } = search;
    if found.is_empty() {
        return Err(FleetError::NoRig {
            path: root.to_owned(),
            expected: "rod.toml with train*.csv in folders, or rod.toml and one CSV a rig",
        });
    }
    found.sort_by(|(a, _), (b, _)| a.as_encoded_bytes().cmp(b.as_encoded_bytes()));
    Ok(Fleet {
        rigs: found.into_iter().map(|(_, listed)| listed).collect(),
        left_out,
    })
}

/// Search through folders.
#[derive(Debug)]
struct Search<'a> {
    root: &'a Path,
    /// Folders that do not belong to the fleet.
    without: BTreeSet<PathBuf>,
    /// Folders from the root to the present one: a link back to one of them is not followed.
    above: Vec<PathBuf>,
    found: Vec<(OsString, Listed)>,
    left_out: Vec<String>,
}

/// CSV files of one folder.
#[derive(Debug, Default)]
struct Recordings {
    train: Vec<PathBuf>,
    unseen: Vec<PathBuf>,
    others: Vec<PathBuf>,
}

impl Search<'_> {
    /// Lists the rigs of a folder. One below the root that cannot be read is a row of the result, as its neighbors are.
    fn visit(&mut self, folder: &Path, rod_above: Option<&Path>) -> Result<(), FleetError> {
        match self.read(folder, rod_above) {
            Err(FleetError::Unreadable { path, source }) if path == folder && path != self.root => {
                let why = format!("the folder cannot be read: {source}");
                self.keep_as(folder, Err(why), true);
                Ok(())
            }
            read => read,
        }
    }

    fn read(&mut self, folder: &Path, rod_above: Option<&Path>) -> Result<(), FleetError> {
        let unreadable = |source| FleetError::Unreadable {
            path: folder.to_owned(),
            source,
        };
        let whole = folder.canonicalize().map_err(unreadable)?;
        // Results may be kept in the folder of the fleet itself.
        let are_results = self.without.contains(&whole) || super::Units::are_in(folder);
        let is_left_out = self.above.contains(&whole) || are_results && folder != self.root;
        if is_left_out {
            return Ok(());
        }
        let mut names = fs::read_dir(folder)
            .map_err(unreadable)?
            .map(|entry| entry.map(|entry| entry.file_name()))
            .collect::<Result<Vec<_>, _>>()
            .map_err(unreadable)?;
        names.retain(|name| !name.as_encoded_bytes().starts_with(b"."));
        names.sort_by(|a, b| a.as_encoded_bytes().cmp(b.as_encoded_bytes()));
        let own = folder.join(ROD);
        let has_own = own.is_file();
        let rod = if has_own { Some(&*own) } else { rod_above };
        let n_before = self.found.len();
        let mut recordings = Recordings::default();
        self.above.push(whole);
        for name in names {
            let path = folder.join(&name);
            if path.is_dir() {
                self.visit(&path, rod)?;
            } else if is_csv(&name) {
                recordings.take(&name, path);
            }
        }
        self.above.pop();
        let is_empty = self.found.len() == n_before;
        self.list(folder, rod, recordings);
        // A rod file alone is that of the rigs below it.
        if is_empty && self.found.len() == n_before && has_own && folder != self.root {
            let why = format!("no recording beside {ROD}; expected train*.csv");
            self.keep(folder, Err(why));
        }
        Ok(())
    }

    /// Lists the rigs that the recordings of a folder make.
    fn list(&mut self, folder: &Path, rod: Option<&Path>, recordings: Recordings) {
        let Recordings {
            train,
            unseen,
            others,
        } = recordings;
        if !train.is_empty() {
            self.left_out.extend(others.iter().map(|path| {
                format!(
                    "{}: is left out: beside train*.csv, only validate*.csv, held*.csv and unseen*.csv count",
                    path.display()
                )
            }));
            self.keep(folder, files(rod, train, unseen));
            return;
        }
        for path in others {
            let files = files(rod, vec![path.clone()], Vec::new());
            self.keep(&path, files);
        }
        if let Some(first) = unseen.first() {
            let name = first.file_name().unwrap_or_default().to_string_lossy();
            let why = format!("{name}: no training recording beside it; expected train*.csv");
            self.keep(folder, Err(why));
        }
    }

    fn keep(&mut self, place: &Path, files: Result<RigFiles, String>) {
        self.keep_as(place, files, false);
    }

    fn keep_as(&mut self, place: &Path, files: Result<RigFiles, String>, is_unread: bool) {
        let within = place.strip_prefix(self.root).unwrap_or(place).as_os_str();
        let key = if within.is_empty() {
            OsStr::new(".")
        } else {
            within
        };
        let name = key.to_string_lossy().into_owned();
        let listed = Listed {
            name,
            files,
            is_unread,
        };
        self.found.push((key.to_owned(), listed));
    }
}

impl Recordings {
    fn take(&mut self, name: &OsStr, path: PathBuf) {
        let begins = |with: &str| {
            let begin = name.as_encoded_bytes().get(..with.len());
            begin.is_some_and(|begin| begin.eq_ignore_ascii_case(with.as_bytes()))
        };
        if begins("train") {
            self.train.push(path);
        } else if UNSEEN.into_iter().any(begins) {
            self.unseen.push(path);
        } else {
            self.others.push(path);
        }
    }
}

fn is_csv(name: &OsStr) -> bool {
    let extension = Path::new(name).extension();
    extension.is_some_and(|extension| extension.eq_ignore_ascii_case("csv"))
}

fn files(
    rod: Option<&Path>,
    train: Vec<PathBuf>,
    validate: Vec<PathBuf>,
) -> Result<RigFiles, String> {
    match rod {
        Some(rod) => Ok(RigFiles {
            rod: rod.to_owned(),
            train,
            validate,
        }),
        None => Err(format!(
            "no {ROD} in its folder, nor above it up to the folder of the fleet"
        )),
    }
}
