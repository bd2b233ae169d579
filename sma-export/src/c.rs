//! A model as a C99 header.

use sma_effects::EffectId;

use crate::number::hexadecimal;
use crate::source::Source;
use crate::{ExportError, Exported};

const PLANT: &str = include_str!("../templates/plant.h");

/// Type of the numbers in a header.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum CNumbers {
    /// double: the bits of the program.
    #[default]
    Double,
    /// float: for processors that have nothing wider.
    Float,
}

/// First word of all names in a header, so that several models stand in one program.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct CPrefix(String);

impl CPrefix {
    /// Checks a prefix.
    ///
    /// # Errors
    ///
    /// [`ExportError::Prefix`] unless it is a lower-case letter followed by at most 30 lower-case letters, digits or
    /// underscores.
    pub fn new(text: &str) -> Result<Self, ExportError> {
        let is_inner = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '_';
        let starts = text.starts_with(|c: char| c.is_ascii_lowercase());
        if starts && text.len() <= 31 && text.chars().all(is_inner) {
            Ok(Self(text.to_owned()))
        } else {
            Err(ExportError::Prefix {
                text: text.to_owned(),
            })
        }
    }
}

impl Default for CPrefix {
    fn default() -> Self {
        Self("sma".to_owned())
    }
}

/// The model as a C99 header: plant and, if it has one, controller.
///
/// # Errors
///
/// As [`Exported::checked`]; [`ExportError::Range`] for a constant that is no finite number of the wanted type.
pub fn c_header(
    exported: &Exported,
    numbers: CNumbers,
    prefix: &CPrefix,
) -> Result<String, ExportError> {
    exported.checked()?;
    let is_float = numbers == CNumbers::Float;
    let upper = prefix.0.to_ascii_uppercase();
    let has_backlash = exported.setting.active.contains(EffectId::Backlash);
    let falls_on_heating = exported.member.params.gain < 0.0;
    let fallen = match falls_on_heating {
        true => format!("{upper}_R(1.0) - share"),
        false => "share".to_owned(),
    };
    let source = Source {
        template: PLANT,
        mark: "//",
        number: &|value| match numbers {
            CNumbers::Double => value.is_finite().then(|| hexadecimal(value)),
            CNumbers::Float => {
                let held = value as f32;
                held.is_finite().then(|| hexadecimal(f64::from(held)))
            }
        },
        coefficient: &|number| format!("        {upper}_R({number})"),
        harmless: in_comment,
        precision: if is_float { "float" } else { "double" },
    };
    source.of(
        exported,
        &[
            ("float", is_float),
            ("own_expm1", has_backlash && !is_float),
        ],
        &[
            ("p", prefix.0.clone()),
            ("P", upper.clone()),
            ("flat", if is_float { "1e30" } else { "1e300" }.to_owned()),
            ("fallen", fallen),
            (
                "tolerance_text",
                if is_float { FLOAT } else { DOUBLE }.to_owned(),
            ),
        ],
    )
}

const DOUBLE: &str = "Outputs have the bits of the program; with supply-lag they agree to 1e-12 of the\n * stroke, since logarithms are those of the C library.";
const FLOAT: &str = "Outputs agree with the program to 1e-4 of the stroke for time constants of up\n * to 1000 samples.";

/// A text that neither ends a comment nor begins one.
fn in_comment(text: &str) -> String {
    let text = text.replace("*/", "* /").replace("/*", "/ *");
    text.chars()
        .map(|c| if c.is_control() { '?' } else { c })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_files_do_not_end_the_comment() {
        assert_eq!(
            in_comment("runs/*.csv */ int x\n"),
            "runs/ *.csv * / int x?"
        );
    }

    #[test]
    fn prefixes_are_identifiers() {
        assert!(CPrefix::new("rod_2").is_ok());
        let long = "a".repeat(32);
        for text in ["", "2rod", "Rod", "rod-2", "_rod", long.as_str()] {
            let error = CPrefix::new(text).unwrap_err().to_string();
            assert!(error.contains("must be a lower-case letter"), "{error}");
        }
    }
}
