//! Flags that say what is used of recordings; they go before what the rod file says of them.

use std::path::{Path, PathBuf};

use anyhow::bail;
use clap::Args;
use identify::Rod;

/// Selection and preprocessing of recordings.
#[derive(Debug, Clone, Default, PartialEq, Args)]
pub(crate) struct UseArgs {
    /// Use only this span of a recording, s: run3.csv:20..140.
    #[arg(long, value_name = "FILE:A..B", value_parser = Span::parse)]
    window: Vec<Span>,
    /// Leave this span of a recording out, s; may be given several times. What is before and behind a span in the middle is fitted as
    /// two recordings.
    #[arg(long, value_name = "FILE:A..B", value_parser = Span::parse)]
    exclude: Vec<Span>,
    /// Use every Nth row of all recordings, with the means of those around it.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(2..))]
    decimate: Option<u32>,
    /// Take the straight line that the output follows from rest to rest off all recordings.
    #[arg(long)]
    detrend: bool,
}

/// A span of a recording.
#[derive(Debug, Clone, PartialEq)]
struct Span {
    file: String,
    /// Start and end, s; rising.
    span_s: [f64; 2],
}

impl Span {
    fn parse(text: &str) -> Result<Self, String> {
        let parsed = || {
            let (file, span) = text.rsplit_once(':')?;
            let (start, end) = span.split_once("..")?;
            let span_s: [f64; 2] = [start.parse().ok()?, end.parse().ok()?];
            let rises = span_s[0] < span_s[1] && span_s.iter().all(|end_s| end_s.is_finite());
            (rises && !file.is_empty()).then(|| Self {
                file: file.to_owned(),
                span_s,
            })
        };
        parsed().ok_or_else(|| {
            "expected a recording and two rising times in seconds: run3.csv:20..140".to_owned()
        })
    }

    /// The recording that is meant, by its path or by the name of its file.
    fn among<'a>(&self, flag: &str, recordings: &'a [PathBuf]) -> anyhow::Result<&'a Path> {
        let has_path = |path: &&PathBuf| path.to_str() == Some(self.file.as_str());
        let has_name = |path: &&PathBuf| path.file_name().is_some_and(|name| *name == *self.file);
        let found = recordings.iter().find(has_path);
        match found.or_else(|| recordings.iter().find(has_name)) {
            Some(path) => Ok(path),
            None => {
                let names = recordings.iter().map(|path| path.display().to_string());
                bail!(
                    "--{flag} {}: no such recording in this call; expected one of {}",
                    self.file,
                    names.collect::<Vec<_>>().join(", ")
                )
            }
        }
    }
}

impl UseArgs {
    /// Puts the flags in place of what the rod file says.
    ///
    /// # Errors
    ///
    /// For a file that is none of the recordings.
    pub(crate) fn apply(&self, rod: &mut Rod, recordings: &[PathBuf]) -> anyhow::Result<()> {
        let mut change = |path: &Path, change: &dyn Fn(&mut identify::RecordingUse)| {
            let mut wish = rod.use_of(path);
            change(&mut wish);
            rod.uses.insert(path.display().to_string(), wish);
        };
        for span in &self.window {
            let path = span.among("window", recordings)?;
            change(path, &|wish| wish.window_s = Some(span.span_s));
        }
        for span in &self.exclude {
            let path = span.among("exclude", recordings)?;
            change(path, &|wish| wish.exclude_s.push(span.span_s));
        }
        for path in recordings {
            if let Some(n) = self.decimate {
                change(path, &|wish| wish.decimate = Some(n as usize));
            }
            if self.detrend {
                change(path, &|wish| wish.detrend = true);
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use rig_files::rod_file;

    use super::*;

    fn span(text: &str) -> Span {
        Span::parse(text).unwrap()
    }

    #[test]
    fn spans_are_read_and_what_is_none_is_refused() {
        assert_eq!(span("a:b.csv:0.5..12").file, "a:b.csv");
        let read = span("run.csv:-1..1e2");
        assert_eq!(format!("{:?}", read.span_s), "[-1.0, 100.0]");
        for text in [
            "run.csv",
            "run.csv:1",
            "run.csv:2..1",
            "run.csv:1..1",
            ":1..2",
            "run.csv:nan..2",
            "run.csv:1..inf",
        ] {
            let fault = Span::parse(text).unwrap_err();
            assert!(
                fault.starts_with("expected a recording and two rising times"),
                "{text}"
            );
        }
    }

    #[test]
    fn flags_go_before_the_rod_file_and_name_recordings_of_the_call() {
        let mut rod = rod_file::parse(
            "rod.toml",
            "[recordings.\"a.csv\"]\nwindow_s = [1, 9]\nexclude_s = [[8, 10]]\ndecimate = 3\n",
        )
        .unwrap();
        let recordings = [PathBuf::from("runs/a.csv"), PathBuf::from("runs/b.csv")];
        let args = UseArgs {
            window: vec![span("a.csv:2..5")],
            exclude: vec![span("runs/b.csv:0..1"), span("b.csv:9..12")],
            decimate: None,
            detrend: true,
        };
        args.apply(&mut rod, &recordings).unwrap();
        let a = rod.use_of(&recordings[0]);
        assert_eq!(a.window_s, Some([2.0, 5.0]));
        assert_eq!(
            (a.exclude_s, a.decimate, a.detrend),
            (vec![[8.0, 10.0]], Some(3), true)
        );
        let b = rod.use_of(&recordings[1]);
        assert_eq!(
            (b.window_s, b.exclude_s),
            (None, vec![[0.0, 1.0], [9.0, 12.0]])
        );
        let other = UseArgs {
            window: vec![span("c.csv:2..5")],
            ..UseArgs::default()
        };
        assert_eq!(
            other.apply(&mut rod, &recordings).unwrap_err().to_string(),
            "--window c.csv: no such recording in this call; expected one of runs/a.csv, runs/b.csv"
        );
    }
}
