//! Fleets as folders and as manifests, and kept units.

#![allow(clippy::unwrap_used, reason = "a test may end in a panic")]

use std::fs;
use std::path::Path;

use serde_json::json;
use tempfile::TempDir;

use super::*;

/// A folder of files that hold their own names.
fn folder(files: &[&str]) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    for file in files {
        let path = folder.path().join(file);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, file).unwrap();
    }
    folder
}

/// Rigs as `name: rod < training < unseen`, paths from the folder, or `name: reason`.
fn shown(fleet: &Fleet, folder: &Path) -> Vec<String> {
    let all = |paths: &[std::path::PathBuf]| {
        let names = paths.iter().map(|path| path.strip_prefix(folder).unwrap());
        let names: Vec<String> = names.map(|name| name.display().to_string()).collect();
        names.join(" ")
    };
    let rigs = fleet.rigs.iter().map(|rig| match &rig.files {
        Ok(files) => format!(
            "{}: {} < {} < {}",
            rig.name,
            all(std::slice::from_ref(&files.rod)),
            all(&files.train),
            all(&files.validate)
        ),
        Err(why) => format!("{}: {why}", rig.name),
    });
    rigs.collect()
}

fn found(files: &[&str], without: &[&str]) -> (Vec<String>, Vec<String>) {
    let folder = folder(files);
    let without: Vec<_> = without
        .iter()
        .map(|name| folder.path().join(name))
        .collect();
    let without: Vec<&Path> = without.iter().map(|path| path.as_path()).collect();
    let fleet = Fleet::read(folder.path(), &without).unwrap();
    (shown(&fleet, folder.path()), fleet.left_out)
}

/// The error of a manifest, from its name on.
fn refused(name: &str, text: &str) -> String {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    fs::write(&path, text).unwrap();
    let error = Fleet::read(&path, &[]).unwrap_err().to_string();
    let place = folder.path().display().to_string() + "/";
    error.strip_prefix(&place).unwrap().to_owned()
}

#[test]
fn a_folder_with_training_recordings_is_one_rig() {
    let (rigs, left_out) = found(
        &[
            "rod.toml",
            "b/train2.csv",
            "b/train10.csv",
            "b/unseen.csv",
            "b/Held-1.CSV",
            "b/validate.csv",
            "b/notes.csv",
            "b/notes.txt",
            "a/rod.toml",
            "a/train.csv",
            "a/.train-old.csv",
            ".git/train.csv",
        ],
        &[],
    );
    assert_eq!(
        rigs,
        [
            "a: a/rod.toml < a/train.csv < ",
            "b: rod.toml < b/train10.csv b/train2.csv < b/Held-1.CSV b/unseen.csv b/validate.csv",
        ]
    );
    let [left_out] = &left_out[..] else {
        unreachable!("one file is left out")
    };
    assert!(
        left_out.ends_with(
            "b/notes.csv: is left out: beside train*.csv, only validate*.csv, held*.csv and unseen*.csv count"
        ),
        "{left_out}"
    );
}

#[test]
fn in_any_other_folder_each_recording_is_a_rig() {
    let (rigs, _) = found(&["rod.toml", "w2.csv", "w10.csv", "may/w1.csv"], &[]);
    assert_eq!(
        rigs,
        [
            "may/w1.csv: rod.toml < may/w1.csv < ",
            "w10.csv: rod.toml < w10.csv < ",
            "w2.csv: rod.toml < w2.csv < ",
        ]
    );
}

#[test]
fn the_root_may_be_a_rig() {
    let (rigs, _) = found(&["rod.toml", "train.csv", "held.csv"], &[]);
    assert_eq!(rigs, [".: rod.toml < train.csv < held.csv"]);
}

#[test]
fn a_rig_that_lacks_a_file_is_listed_with_the_reason() {
    let (rigs, _) = found(
        &["a/rod.toml", "b/train.csv", "c/rod.toml", "c/held.csv"],
        &[],
    );
    assert_eq!(
        rigs,
        [
            "a: no recording beside rod.toml; expected train*.csv",
            "b: no rod.toml in its folder, nor above it up to the folder of the fleet",
            "c: held.csv: no training recording beside it; expected train*.csv",
        ]
    );
}

#[test]
fn results_are_no_recordings() {
    let unit = format!("night/units/{}.json", "0a".repeat(32));
    let files = [
        "rod.toml",
        "a.csv",
        &unit,
        "night/table.csv",
        "out/table.csv",
    ];
    let (rigs, _) = found(&files, &["out"]);
    assert_eq!(rigs, ["a.csv: rod.toml < a.csv < "]);
    // They may lie in the folder of the fleet itself.
    let unit = format!("units/{}.json", "0a".repeat(32));
    let (rigs, _) = found(&["rod.toml", "a.csv", &unit], &[""]);
    assert_eq!(rigs, ["a.csv: rod.toml < a.csv < "]);
}

#[cfg(unix)]
#[test]
fn a_link_back_is_not_followed() {
    use std::os::unix::fs::symlink;
    let folder = folder(&["rod.toml", "a/train.csv"]);
    symlink("..", folder.path().join("a/back")).unwrap();
    let fleet = Fleet::read(folder.path(), &[]).unwrap();
    assert_eq!(
        shown(&fleet, folder.path()),
        ["a: rod.toml < a/train.csv < "]
    );
}

#[test]
fn places_that_are_no_fleet_are_refused() {
    let folder = folder(&["notes.txt"]);
    let said = |name: &str| {
        let error = Fleet::read(&folder.path().join(name), &[]).unwrap_err();
        error.to_string()
    };
    assert!(said("").ends_with(
        ": holds no rig; expected rod.toml with train*.csv in folders, or rod.toml and one CSV a rig"
    ));
    assert!(said("notes.txt").ends_with(
        "notes.txt: is no folder and no manifest; expected a folder of rigs, or a file that ends in .csv or .toml"
    ));
    assert!(said("none").ends_with("none: cannot be read"));
    assert!(said("none.toml").ends_with("none.toml: cannot be read"));
    let path = "rigs/table.csv".into();
    assert_eq!(
        FleetError::AmongRecordings { path }.to_string(),
        "rigs/table.csv: lies among the recordings, and the next call would take it for one; give another folder"
    );
}

#[test]
fn manifests_name_rigs_in_their_order() {
    let folder = tempfile::tempdir().unwrap();
    let csv = folder.path().join("fleet.csv");
    let text = "# of May\nname,rod,train,validate\n\nb,rods/b.toml,b1.csv; b2.csv,\n\"a, old\",rod.toml,a.csv,u.csv\n";
    fs::write(&csv, text).unwrap();
    let toml = folder.path().join("fleet.toml");
    let text = "rod = \"rod.toml\"\n[[rig]]\nname = \"b\"\nrod = \"rods/b.toml\"\ntrain = [\"b1.csv\", \"b2.csv\"]\n\
                [[rig]]\nname = \"a, old\"\ntrain = [\"a.csv\"]\nvalidate = [\"u.csv\"]\n";
    fs::write(&toml, text).unwrap();
    for path in [csv, toml] {
        let fleet = Fleet::read(&path, &[]).unwrap();
        assert_eq!(
            shown(&fleet, folder.path()),
            [
                "b: rods/b.toml < b1.csv b2.csv < ",
                "a, old: rod.toml < a.csv < u.csv"
            ]
        );
    }
}

#[test]
fn faults_of_a_manifest_name_their_line() {
    for (text, expected) in [
        (
            "",
            "f.csv:1: columns none; expected name, rod, train and perhaps validate",
        ),
        (
            "name,train\n",
            "f.csv:1: columns name, train; expected name, rod, train and perhaps validate",
        ),
        (
            "\nname,rod,train,unseen\n",
            "f.csv:2: columns name, rod, train, unseen; expected name, rod, train and perhaps validate",
        ),
        (
            "name,rod,train,name\n",
            "f.csv:1: columns name, rod, train, name; expected name, rod, train and perhaps validate",
        ),
        (
            "name,rod,train\na,b\n",
            "f.csv:2: fields: 2; expected 3, as in the header",
        ),
        (
            "name,rod,train\n,r,t\n",
            "f.csv:2: name is empty; expected a name for its row",
        ),
        (
            "name,rod,train\na,,t\n",
            "f.csv:2: rod is empty; expected the path of a rod file",
        ),
        (
            "name,rod,train\na,r,\n",
            "f.csv:2: train is empty; expected the path of a recording, or several",
        ),
        (
            "name,rod,train,validate\na,r,t,u;;v\n",
            "f.csv:2: validate is empty; expected the path of a recording, several, or none",
        ),
        (
            "name,rod,train\na,r,t\n# again\na,r,u\n",
            "f.csv:4: name = \"a\": another rig has it; expected a name of its own for each",
        ),
        (
            "name,rod,train\n",
            "f.csv: holds no rig; expected a row or a [[rig]] for each, with name, rod and train",
        ),
    ] {
        let said = refused("f.csv", text);
        assert_eq!(said, expected);
    }
    for (text, expected) in [
        (
            "[[rig]]\nname = \"a\"\ntrain = [\"t\"]\nunseen = []\n",
            "f.toml:4:1: unknown field `unseen`, expected one of `name`, `rod`, `train`, `validate`",
        ),
        (
            "rod = \"r\"\n[[rig]]\nname = \"a\"\ntrain = []\n",
            "f.toml:2: train is empty; expected the path of a recording, or several",
        ),
        (
            "[[rig]]\nname = \"a\"\ntrain = [\"t\"]\n",
            "f.toml:1: rod is empty; expected the path of a rod file",
        ),
    ] {
        assert_eq!(refused("f.toml", text), expected);
    }
}

/// A task on files of a folder.
fn task(folder: &Path, train: &str, seed: &str) -> Task {
    let files = RigFiles {
        rod: folder.join("rod.toml"),
        train: vec![folder.join(train)],
        validate: Vec::new(),
    };
    Task::of(["0.1.0", "0a"], "diagnose", vec![seed.to_owned()], &files).unwrap()
}

#[test]
fn a_unit_is_named_by_what_its_result_depends_on() {
    let [here, there] = [(); 2].map(|()| folder(&["rod.toml", "a.csv", "b.csv"]));
    let name = task(here.path(), "a.csv", "1").name();
    assert_eq!(name.len(), 64);
    assert_eq!(
        name,
        task(there.path(), "a.csv", "1").name(),
        "of its place"
    );
    assert_ne!(name, task(here.path(), "a.csv", "2").name());
    assert_ne!(name, task(here.path(), "b.csv", "1").name());
    fs::write(there.path().join("a.csv"), "changed").unwrap();
    assert_ne!(name, task(there.path(), "a.csv", "1").name());
    let mut other = task(here.path(), "a.csv", "1");
    other.version = "0.2.0".to_owned();
    assert_ne!(name, other.name());
}

#[test]
fn a_file_that_is_no_result_of_its_unit_is_told() {
    let folder = folder(&["rod.toml", "a.csv", "b.csv"]);
    let units = Units::make(&folder.path().join("out")).unwrap();
    let [a, b] = ["a.csv", "b.csv"].map(|train| task(folder.path(), train, "1"));
    let (name, other) = (a.name(), b.name());
    assert_eq!(units.read(&name).unwrap(), None);
    let unit = Unit::done(a, 0, json!({"verdict": "adequate"}));
    units.keep(&unit, folder.path()).unwrap();
    assert_eq!(units.read(&name).unwrap(), Some(unit));
    assert_eq!(units.names().unwrap(), std::slice::from_ref(&name));
    let [path, moved] =
        [&name, &other].map(|name| folder.path().join(format!("out/units/{name}.json")));
    fs::copy(&path, &moved).unwrap();
    let said = units.read(&other).unwrap_err().to_string();
    assert!(
        said.ends_with(
            ".json: holds the result of another unit, or of another version of the document"
        ),
        "{said}"
    );
    let text = fs::read_to_string(&path).unwrap();
    fs::write(&path, &text[..text.len() / 2]).unwrap();
    let said = units.read(&name).unwrap_err().to_string();
    assert!(said.ends_with(": no result of a unit"), "{said}");
    fs::remove_file(&path).unwrap();
    fs::create_dir(&path).unwrap();
    let said = units.read(&name).unwrap_err().to_string();
    assert!(said.ends_with(".json: cannot be read"), "{said}");
}

#[test]
fn of_two_folders_a_result_goes_before_a_failure() {
    let folder = folder(&["rod.toml", "a.csv"]);
    let units = |name: &str| Units::make(&folder.path().join(name)).unwrap();
    let (one, other) = (units("one"), units("other"));
    let task = task(folder.path(), "a.csv", "1");
    let failed = Unit::failed(task.clone(), None, "the program crashed");
    let done = Unit::done(task.clone(), 0, json!({}));
    one.keep(&failed, folder.path()).unwrap();
    other.keep(&done, folder.path()).unwrap();
    for (into, from) in [(&one, &other), (&other, &one)] {
        assert!(into.take(from, folder.path(), "0a").unwrap().is_empty());
        assert_eq!(into.read(&task.name()).unwrap(), Some(done.clone()));
    }
}
