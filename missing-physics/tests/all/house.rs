//! The house of the crate: folders are stages, and arrows go one way.

#![allow(
    clippy::unwrap_used,
    reason = "a test fails by panicking wherever it reads the sources"
)]

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

/// All sources below a folder, as paths from it.
fn sources(root: &Path, folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            sources(root, &path, found);
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            found.push(path.strip_prefix(root).unwrap().to_owned());
        }
    }
}

/// Text of a file without its tests.
fn code(text: &str) -> &str {
    text.split("#[cfg(test)]\nmod tests").next().unwrap()
}

/// Paths that begin with some words, such as `crate::`, each name of a list apart.
fn paths(text: &str, begin: &str) -> Vec<String> {
    let mut found = Vec::new();
    for part in text.split(begin).skip(1) {
        let end = part.find(|c: char| !(c.is_alphanumeric() || c == '_' || c == ':'));
        let (path, rest) = part.split_at(end.unwrap_or(part.len()));
        match rest.strip_prefix('{').and_then(|list| list.split_once('}')) {
            Some((list, _)) => {
                found.extend(list.split(',').map(|name| format!("{path}{}", name.trim())))
            }
            None => found.push(path.to_owned()),
        }
    }
    found
}

/// The file that a path of the crate ends in: of what a folder shows on, the file behind it.
fn file_of(root: &Path, path: &str) -> Option<PathBuf> {
    let names: Vec<&str> = path.split("::").filter(|name| !name.is_empty()).collect();
    for n in (1..=names.len()).rev() {
        let place: PathBuf = names[..n].iter().collect();
        if root.join(&place).with_extension("rs").is_file() {
            return Some(place.with_extension("rs"));
        }
        let shown = place.join("mod.rs");
        if root.join(&shown).is_file() {
            let text = fs::read_to_string(root.join(&shown)).unwrap();
            let wanted = names.get(n)?;
            let mut behind = paths(&text, "use ").into_iter();
            let found = behind.find(|path| path.ends_with(&format!("::{wanted}")))?;
            let own = names[..n].join("::");
            return file_of(root, &format!("{own}::{found}"));
        }
    }
    None
}

/// Which files a file needs.
fn arrows() -> BTreeMap<PathBuf, BTreeSet<PathBuf>> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut all = Vec::new();
    sources(&root, &root, &mut all);
    let of = |file: &PathBuf| {
        let text = fs::read_to_string(root.join(file)).unwrap();
        let needed = paths(code(&text), "crate::").into_iter();
        needed
            .filter_map(|path| file_of(&root, &path))
            .filter(|other| other != file)
            .collect()
    };
    all.into_iter()
        .map(|file| (file.clone(), of(&file)))
        .collect()
}

/// A way from a place back to itself.
fn circle<T: Ord + Clone>(arrows: &BTreeMap<T, BTreeSet<T>>) -> Option<Vec<T>> {
    fn visit<T: Ord + Clone>(
        at: &T,
        arrows: &BTreeMap<T, BTreeSet<T>>,
        way: &mut Vec<T>,
        done: &mut BTreeSet<T>,
    ) -> bool {
        if let Some(place) = way.iter().position(|one| one == at) {
            way.drain(..place);
            return true;
        }
        if done.contains(at) {
            return false;
        }
        way.push(at.clone());
        for next in arrows.get(at).into_iter().flatten() {
            if visit(next, arrows, way, done) {
                return true;
            }
        }
        way.pop();
        done.insert(at.clone());
        false
    }
    let (mut way, mut done) = (Vec::new(), BTreeSet::new());
    for at in arrows.keys() {
        if visit(at, arrows, &mut way, &mut done) {
            return Some(way);
        }
    }
    None
}

#[test]
fn arrows_go_one_way() {
    let files = arrows();
    assert!(files.len() > 40, "{}", files.len());
    assert!(files.values().map(BTreeSet::len).sum::<usize>() > 100);
    assert_eq!(circle(&files), None);
    let folder = |file: &PathBuf| file.iter().next().unwrap().to_owned();
    let mut folders: BTreeMap<_, BTreeSet<_>> = BTreeMap::new();
    for (file, needed) in &files {
        let own = folders.entry(folder(file)).or_default();
        own.extend(
            needed
                .iter()
                .map(folder)
                .filter(|other| *other != folder(file)),
        );
    }
    assert_eq!(circle(&folders), None);
}

#[test]
fn a_circle_is_found() {
    let one_way = BTreeMap::from([(1, BTreeSet::from([2, 3])), (2, BTreeSet::from([3]))]);
    assert_eq!(circle(&one_way), None);
    let round = BTreeMap::from([
        (1, BTreeSet::from([2])),
        (2, BTreeSet::from([3])),
        (3, BTreeSet::from([2])),
    ]);
    assert_eq!(circle(&round), Some(vec![2, 3]));
}

#[test]
fn no_stage_knows_an_effect_by_its_id() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    for file in arrows()
        .keys()
        .filter(|file| !file.ends_with("synthetic.rs") && !file.ends_with("tests.rs"))
    {
        let text = fs::read_to_string(root.join(file)).unwrap();
        for name in paths(code(&text), "EffectId::") {
            let is_constant = name.chars().all(|c| c.is_uppercase() || c == '_');
            let is_function = name.starts_with(char::is_lowercase);
            assert!(
                is_constant || is_function,
                "{}: EffectId::{name}",
                file.display()
            );
        }
    }
}

#[test]
fn every_rule_stands_in_the_method() {
    let method = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/method.md");
    let method = fs::read_to_string(method).unwrap();
    for rule in missing_physics::RULES {
        let row = format!("| `{}` |", rule.name);
        let line = method.lines().find(|line| line.starts_with(&row));
        let threshold = format!("| {} {} |", rule.comparison.sign(), rule.threshold);
        assert!(
            line.is_some_and(|line| line.contains(&threshold)),
            "{row} {threshold}"
        );
    }
}
