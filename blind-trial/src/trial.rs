use std::collections::{BTreeMap, BTreeSet};
use std::fs::{self, OpenOptions};
use std::io::{self, Write};
use std::ops::ControlFlow;
use std::panic::catch_unwind;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use crate::journal::beside;
use crate::{
    Answer, Case, CaseId, CaseLine, Journal, Like, Plan, Ran, TrialError, in_order, run_case, seal,
};

/// Which trial a folder holds.
const TRIAL: &str = "trial.json";
/// A seal a plan, published before the first diagnosis.
const SEALS: &str = "seals.csv";
/// Results, a line a case.
const CASES: &str = "cases.jsonl";
/// How long each diagnosis took.
const TIMES: &str = "times.csv";
/// Every run of the program on the folder.
const RUNS: &str = "runs.csv";
/// Files of cases, where they are kept.
const KEPT: &str = "cases";
/// Files of cases under way, where they are not kept.
const UNDER_WAY: &str = ".under-way";

/// A trial: a folder with the seal of its answers and what came out.
#[derive(Debug)]
pub struct Trial {
    folder: PathBuf,
    head: Head,
    like: Option<Like>,
    journal: Journal<CaseLine>,
}

/// Identity of a trial: two trials with equal heads are one.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Head {
    seed: String,
    version: String,
    /// Digest of the rig around which the cases are drawn.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    like: Option<String>,
}

/// How a trial is run.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RunConfig {
    /// Cases under way at a time.
    pub jobs: usize,
    /// True if the files of the cases stay in the folder.
    pub keep_files: bool,
    /// True if other methods are run as well.
    pub asks_others: bool,
}

/// How far a trial is.
#[derive(Debug)]
pub struct Progress<'a> {
    /// Cases that are done.
    pub done: usize,
    /// Cases of the plan.
    pub of: usize,
    /// Result of the last one.
    pub last: Result<&'a CaseLine, &'a TrialError>,
}

impl Trial {
    /// Opens the folder of a trial, or makes it; its cases are drawn around a user's own rig, or as the published ones.
    ///
    /// # Errors
    ///
    /// [`TrialError::OtherTrial`] if the folder holds one of another seed or rig or of another version of the program,
    /// and what [`Journal::open`] refuses.
    pub fn open(folder: &Path, seed: &str, like: Option<Like>) -> Result<Self, TrialError> {
        fs::create_dir_all(folder).map_err(|source| TrialError::file(folder, source))?;
        let head = Head {
            seed: seed.to_owned(),
            version: env!("CARGO_PKG_VERSION").to_owned(),
            like: like.as_ref().map(Like::digest),
        };
        let path = folder.join(TRIAL);
        match fs::read_to_string(&path) {
            Ok(text) => head.check(&path, &text)?,
            Err(_) => put(&path, &format!("{}\n", head.text()))?,
        }
        let trial = Self {
            folder: folder.to_owned(),
            head,
            like,
            journal: Journal::open(&folder.join(CASES))?,
        };
        trial.tidy()?;
        Ok(trial)
    }

    /// Removes what a run left behind that was killed. The journal is locked, so that no other one is under way here.
    fn tidy(&self) -> Result<(), TrialError> {
        let there = |result: io::Result<()>| match result {
            Err(error) if error.kind() != io::ErrorKind::NotFound => Err(error),
            _ => Ok(()),
        };
        let path = self.folder.join(UNDER_WAY);
        there(fs::remove_dir_all(&path)).map_err(|source| TrialError::file(&path, source))?;
        for name in [TRIAL, SEALS, TIMES, CASES] {
            let path = beside(&self.folder.join(name));
            there(fs::remove_file(&path)).map_err(|source| TrialError::file(&path, source))?;
        }
        for name in [TIMES, RUNS] {
            let path = self.folder.join(name);
            cut_off(&path).map_err(|source| TrialError::file(&path, source))?;
        }
        Ok(())
    }

    /// Runs the cases of a plan that are not in the folder yet; returns how many failed.
    ///
    /// The seal of the whole plan, whatever its shard, is written before the first diagnosis.
    ///
    /// # Errors
    ///
    /// [`TrialError::File`], [`TrialError::OtherAnswers`]. A case that fails stops no other; `progress` hears of it, and another run tries it again.
    pub fn run(
        &mut self,
        plan: &Plan,
        config: RunConfig,
        progress: &mut dyn FnMut(Progress<'_>),
    ) -> Result<usize, TrialError> {
        self.publish(plan)?;
        let cases = plan.cases();
        let of = cases.len();
        let missing: Vec<CaseId> = cases
            .into_iter()
            .filter(|&id| !self.journal.contains(id))
            .collect();
        let (mut done, mut n_failed, mut broken) = (of - missing.len(), 0, None);
        let folder = self.folder.clone();
        let (like, seed) = (self.like.clone(), self.head.seed.clone());
        in_order(
            &missing,
            config.jobs,
            |&id| {
                let case = Case::around(like.as_ref(), &seed, id);
                sound(&case, &folder, config)
            },
            |ran| {
                done += 1;
                let kept = match ran {
                    Ok(ran) => {
                        let last = Ok(&ran.line);
                        progress(Progress { done, of, last });
                        self.keep(ran, config.jobs)
                    }
                    Err(error) => {
                        n_failed += 1;
                        let last = Err(&error);
                        progress(Progress { done, of, last });
                        Ok(())
                    }
                };
                match kept {
                    Ok(()) => ControlFlow::Continue(()),
                    Err(error) => {
                        broken = Some(error);
                        ControlFlow::Break(())
                    }
                }
            },
        );
        let tidied = self.tidy();
        match broken {
            Some(error) => Err(error),
            None => tidied.map(|()| n_failed),
        }
    }

    /// Takes in the cases of another folder of the same trial.
    ///
    /// # Errors
    ///
    /// As [`Trial::open`].
    pub fn merge(&mut self, folder: &Path) -> Result<(), TrialError> {
        let other = Self::open(folder, &self.head.seed, self.like.clone())?;
        for name in [SEALS, TIMES] {
            let mut rows = self.rows(name)?;
            rows.extend(other.rows(name)?);
            self.write_rows(name, &rows)?;
        }
        self.journal.merge(other.journal)
    }

    /// Brings the cases into their order and gives them out, each with its answer checked against the seed, and the answers
    /// of each plan against the seal that was published.
    ///
    /// # Errors
    ///
    /// [`TrialError::BrokenSeal`], [`TrialError::NotSealed`], [`TrialError::OtherAnswers`], [`TrialError::File`].
    pub fn finished(self) -> Result<Vec<CaseLine>, TrialError> {
        let mut sealed: BTreeSet<CaseId> = BTreeSet::new();
        for (text, published) in self.rows(SEALS)? {
            // Folders of the first published table have a row a case.
            let Some(plan) = Plan::parse(&text) else {
                continue;
            };
            self.check_seal(&plan, &published)?;
            sealed.extend(plan.whole());
        }
        for line in self.journal.lines() {
            let case = line.case;
            if line.seal.is_none() && !sealed.contains(&case) {
                return Err(TrialError::NotSealed { case });
            }
            if self.case(case).answer() != &line.opened.answer {
                return Err(TrialError::BrokenSeal { case });
            }
        }
        Ok(self.journal.sorted()?.lines().cloned().collect())
    }

    /// Wall times of the diagnoses that ran alone on the machine, s.
    ///
    /// # Errors
    ///
    /// [`TrialError::File`].
    pub fn times_alone_s(&self) -> Result<Vec<f64>, TrialError> {
        let alone = |row: &String| {
            let (time_s, jobs) = row.split_once(',')?;
            (jobs == "1").then(|| time_s.parse().ok())?
        };
        Ok(self.rows(TIMES)?.values().filter_map(alone).collect())
    }

    /// Writes down that the program was run on the folder.
    ///
    /// # Errors
    ///
    /// [`TrialError::File`].
    pub fn log(&self, what: &str) -> Result<(), TrialError> {
        append(&self.folder.join(RUNS), &format!("{what}\n"))
    }

    fn keep(&mut self, ran: Ran, jobs: usize) -> Result<(), TrialError> {
        let row = format!("{},{:.3},{jobs}\n", ran.line.case, ran.diagnosis_s);
        append(&self.folder.join(TIMES), &row)?;
        self.journal.append(ran.line)
    }

    fn case(&self, id: CaseId) -> Case {
        Case::around(self.like.as_ref(), &self.head.seed, id)
    }

    /// Writes the seal of a plan, beside those that are there.
    fn publish(&self, plan: &Plan) -> Result<(), TrialError> {
        let mut rows = self.rows(SEALS)?;
        if let Some(published) = rows.get(&plan.to_string()) {
            return self.check_seal(plan, published);
        }
        rows.insert(plan.to_string(), self.seal(plan));
        self.write_rows(SEALS, &rows)
    }

    fn seal(&self, plan: &Plan) -> String {
        let answers: Vec<Answer> = plan.whole().map(|id| self.case(id).into_answer()).collect();
        seal(&answers)
    }

    fn check_seal(&self, plan: &Plan, published: &str) -> Result<(), TrialError> {
        let found = self.seal(plan);
        if found == published {
            return Ok(());
        }
        Err(TrialError::OtherAnswers {
            plan: plan.to_string(),
            found,
            published: published.to_owned(),
        })
    }

    /// The rows of a table, by what stands first in them.
    fn rows(&self, name: &str) -> Result<BTreeMap<String, String>, TrialError> {
        let path = self.folder.join(name);
        if !path.exists() {
            return Ok(BTreeMap::new());
        }
        let text = fs::read_to_string(&path).map_err(|source| TrialError::file(&path, source))?;
        let rows = text.lines().filter_map(|line| line.split_once(','));
        Ok(rows
            .map(|(first, rest)| (first.to_owned(), rest.to_owned()))
            .collect())
    }

    fn write_rows(&self, name: &str, rows: &BTreeMap<String, String>) -> Result<(), TrialError> {
        let text: String = rows
            .iter()
            .map(|(first, rest)| format!("{first},{rest}\n"))
            .collect();
        put(&self.folder.join(name), &text)
    }
}

impl Head {
    fn text(&self) -> String {
        // Two texts are always an object.
        serde_json::to_string(self).unwrap_or_default()
    }

    fn check(&self, path: &Path, text: &str) -> Result<(), TrialError> {
        let found: Self = serde_json::from_str(text).map_err(|source| TrialError::Line {
            path: path.to_owned(),
            line: 1,
            source,
        })?;
        let rig = |like: &Option<String>| like.clone().unwrap_or_else(|| "drawn".to_owned());
        let pairs = [
            ("seed", found.seed, self.seed.clone()),
            ("version", found.version, self.version.clone()),
            ("rig", rig(&found.like), rig(&self.like)),
        ];
        match pairs.into_iter().find(|(_, found, own)| found != own) {
            None => Ok(()),
            Some((what, found, expected)) => Err(TrialError::OtherTrial {
                path: path.to_owned(),
                what,
                found,
                expected,
            }),
        }
    }
}

/// Runs a case in a folder of its own; a fault of the program in one leaves the others alone.
fn sound(case: &Case, folder: &Path, config: RunConfig) -> Result<Ran, TrialError> {
    let id = case.id;
    let place = if config.keep_files { KEPT } else { UNDER_WAY };
    let folder = folder.join(place).join(id.to_string());
    let run = || {
        fs::create_dir_all(&folder).map_err(|source| TrialError::file(&folder, source))?;
        run_case(case, &folder, config.asks_others)
    };
    let ran = catch_unwind(run).unwrap_or(Err(TrialError::Panicked { case: id }));
    if !config.keep_files {
        // What cannot be removed now is removed at the end.
        let _ = fs::remove_dir_all(&folder);
    }
    ran
}

/// Removes a last line without its end, from a run that was killed.
fn cut_off(path: &Path) -> io::Result<()> {
    if !path.exists() {
        return Ok(());
    }
    let bytes = fs::read(path)?;
    let whole = bytes.iter().rposition(|byte| *byte == b'\n');
    let whole = whole.map_or(0, |end| end + 1);
    if whole < bytes.len() {
        let file = OpenOptions::new().write(true).open(path)?;
        file.set_len(whole as u64)?;
    }
    Ok(())
}

/// Writes a file whole or not at all.
fn put(path: &Path, text: &str) -> Result<(), TrialError> {
    let beside = beside(path);
    fs::write(&beside, text)
        .and_then(|()| fs::rename(&beside, path))
        .map_err(|source| TrialError::file(path, source))
}

fn append(path: &Path, text: &str) -> Result<(), TrialError> {
    OpenOptions::new()
        .append(true)
        .create(true)
        .open(path)
        .and_then(|mut file| file.write_all(text.as_bytes()))
        .map_err(|source| TrialError::file(path, source))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Family;

    /// Of the first published table.
    const PUBLISHED_SEED: &str = "78df37d2691ed14051715e501e38ee6bccfd9fc6";

    #[test]
    fn one_seal_is_published_a_plan_whatever_the_shard() {
        let folder = tempfile::tempdir().unwrap();
        let trial = Trial::open(folder.path(), "a seed", None).unwrap();
        let plan = Plan::of_about(3, &[Family::Single]);
        trial.publish(&plan.clone().shard(1, 2)).unwrap();
        trial.publish(&plan).unwrap();
        let rows = trial.rows(SEALS).unwrap();
        assert_eq!(rows.len(), 1);
        assert_eq!(rows[&plan.to_string()], trial.seal(&plan));
        let other = Trial::open(&folder.path().join("other"), "another", None).unwrap();
        let error = other.check_seal(&plan, &rows[&plan.to_string()]);
        let text = error.unwrap_err().to_string();
        assert!(text.starts_with("plan lab single=3: its answers have the seal "));
    }

    #[test]
    fn what_a_killed_run_left_behind_is_removed_by_the_next() {
        let folder = tempfile::tempdir().unwrap();
        let place = |name: &str| folder.path().join(name);
        let left = place(UNDER_WAY).join("lab-single-0000");
        fs::create_dir_all(&left).unwrap();
        fs::write(left.join("rod.toml"), "[rod]").unwrap();
        fs::write(place("seals.new"), "half a li").unwrap();
        fs::write(place("cases.jsonl.new"), "half a li").unwrap();
        fs::write(place(TIMES), "lab-single-0000,1.5,1\nlab-sing").unwrap();
        drop(Trial::open(folder.path(), "a seed", None).unwrap());
        let names = fs::read_dir(folder.path()).unwrap();
        let mut names: Vec<_> = names.map(|one| one.unwrap().file_name()).collect();
        names.sort();
        assert_eq!(names, [CASES, TIMES, TRIAL]);
        let times = fs::read_to_string(place(TIMES)).unwrap();
        assert_eq!(times, "lab-single-0000,1.5,1\n");
    }

    #[test]
    fn shards_put_together_are_a_trial_whose_seal_holds() {
        let folder = tempfile::tempdir().unwrap();
        let place = |name: &str| folder.path().join(name);
        let config = RunConfig {
            jobs: 2,
            keep_files: false,
            asks_others: false,
        };
        let plan = Plan::of_about(1, &[Family::CleanWhite]);
        let open = |name: &str| Trial::open(&place(name), "a seed", None).unwrap();
        let mut last = Vec::new();
        let mut one = open("one");
        let failed = one.run(&plan.clone().shard(0, 2), config, &mut |progress| {
            last.push((progress.done, progress.of));
        });
        assert_eq!((failed.unwrap(), last), (0, vec![(1, 1)]));
        drop(one);
        let mut whole = open("whole");
        whole.merge(&place("one")).unwrap();
        let lines = whole.finished().unwrap();
        assert_eq!(lines.len(), 1);
        assert_eq!(lines[0].case, CaseId::lab(Family::CleanWhite, 0));
        fs::remove_file(place("whole").join(SEALS)).unwrap();
        let text = open("whole").finished().unwrap_err().to_string();
        assert_eq!(
            text,
            "lab-clean-white-0000: of no plan whose answers were sealed"
        );
    }

    #[test]
    fn the_first_published_table_is_still_read_and_its_answers_are_drawn_again() {
        let folder = tempfile::tempdir().unwrap();
        let results = Path::new(env!("CARGO_MANIFEST_DIR")).join("results");
        let place = |name: &str| folder.path().join(name);
        for name in [TRIAL, SEALS] {
            fs::copy(results.join(name), place(name)).unwrap();
        }
        let lines = fs::read_to_string(results.join(CASES)).unwrap();
        // One in twenty: every family is among them.
        let some: String = lines.split_inclusive('\n').step_by(20).collect();
        fs::write(place(CASES), &some).unwrap();
        let trial = Trial::open(folder.path(), PUBLISHED_SEED, None).unwrap();
        assert_eq!(trial.finished().unwrap().len(), some.lines().count());
        fs::write(place(CASES), some.replace("\"l2p\"", "\"preisach\"")).unwrap();
        let trial = Trial::open(folder.path(), PUBLISHED_SEED, None).unwrap();
        let text = trial.finished().unwrap_err().to_string();
        assert_eq!(
            text,
            "clean-white-0000: the answer is not the one that was sealed"
        );
    }
}
