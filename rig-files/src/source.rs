//! Places in the text of a TOML file, for errors.

use std::path::Path;

use identify::Bounds;
use recording::read_text;
use toml::Spanned;

use crate::RigFileError;

/// Most bytes of a file that somebody writes, or that a model is kept in.
const MOST_BYTES: u64 = 1 << 24;

/// Name, as errors show it, and text of a file.
pub(crate) fn read_file(path: &Path) -> Result<(String, String), RigFileError> {
    let file = path.display().to_string();
    match read_text(path, MOST_BYTES) {
        Ok(text) => Ok((file, text)),
        Err(source) => Err(RigFileError::Unreadable { file, source }),
    }
}

/// Text of a file, to turn places into lines and columns.
pub(crate) struct Source<'a> {
    pub(crate) file: &'a str,
    pub(crate) text: &'a str,
}

impl Source<'_> {
    /// Line and column, from 1, of a byte.
    pub(crate) fn position(&self, byte: usize) -> (usize, usize) {
        let before = &self.text[..byte.min(self.text.len())];
        let line_start = before.rfind('\n').map_or(0, |newline| newline + 1);
        (
            before.matches('\n').count() + 1,
            before[line_start..].chars().count() + 1,
        )
    }

    pub(crate) fn toml(&self, error: &toml::de::Error, hint: &str) -> RigFileError {
        let (line, column) = self.position(error.span().map_or(0, |span| span.start));
        RigFileError::Toml {
            file: self.file.to_owned(),
            line,
            column,
            message: error
                .message()
                .replace('\n', " ")
                .replace("expected f64", "expected a number")
                + hint,
        }
    }

    /// Hint at the kind of a file that is no rod file; empty where the kind is not plain.
    pub(crate) fn not_a_rod_file(&self) -> &'static str {
        let is_model = self.text.contains("\n[[parameter]]");
        if self.file.ends_with(".csv") {
            "; this is a recording: recordings stand behind --train, --validate or --drive"
        } else if is_model {
            "; this is a model from --save-model"
        } else {
            ""
        }
    }

    pub(crate) fn value(
        &self,
        key: &str,
        value: &Spanned<f64>,
        accepted: impl Into<String>,
    ) -> RigFileError {
        let (line, column) = self.position(value.span().start);
        RigFileError::Value {
            file: self.file.to_owned(),
            line,
            column,
            key: key.to_owned(),
            value: *value.get_ref(),
            accepted: accepted.into(),
        }
    }

    pub(crate) fn positive(
        &self,
        key: &str,
        value: &Option<Spanned<f64>>,
    ) -> Result<Option<f64>, RigFileError> {
        match value {
            None => Ok(None),
            Some(spanned) if *spanned.get_ref() > 0.0 && spanned.get_ref().is_finite() => {
                Ok(Some(*spanned.get_ref()))
            }
            Some(spanned) => Err(self.value(key, spanned, "must be finite and > 0")),
        }
    }

    pub(crate) fn finite(
        &self,
        key: &str,
        value: &Option<Spanned<f64>>,
    ) -> Result<Option<f64>, RigFileError> {
        match value {
            Some(spanned) if !spanned.get_ref().is_finite() => {
                Err(self.value(key, spanned, "must be finite"))
            }
            other => Ok(other.as_ref().map(|spanned| *spanned.get_ref())),
        }
    }

    pub(crate) fn rising(
        &self,
        key: &str,
        range: &[Spanned<f64>; 2],
    ) -> Result<Bounds, RigFileError> {
        let [lower, upper] = [0, 1].map(|k| *range[k].get_ref());
        for end in range {
            if !end.get_ref().is_finite() {
                return Err(self.value(key, end, "must be finite"));
            }
        }
        if lower < upper {
            Ok(Bounds { lower, upper })
        } else {
            let accepted = format!("must be > {lower}, the lower end");
            Err(self.value(key, &range[1], accepted))
        }
    }
}
