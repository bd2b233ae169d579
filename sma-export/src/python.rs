//! A model as a Python module.

use crate::source::Source;
use crate::{ExportError, Exported};

const MODEL: &str = include_str!("../templates/model.py");

/// The model as a Python 3 module that imports nothing but the standard library: plant and, if it has one, controller.
///
/// # Errors
///
/// As [`Exported::checked`]; [`ExportError::Range`] for a constant that is no finite number.
pub fn python_module(exported: &Exported) -> Result<String, ExportError> {
    exported.checked()?;
    let falls_on_heating = exported.member.params.gain < 0.0;
    let fallen = if falls_on_heating {
        "1.0 - share"
    } else {
        "share"
    };
    let source = Source {
        template: MODEL,
        mark: "#",
        // The shortest digits that read back to the bits.
        number: &|value| value.is_finite().then(|| format!("{value:?}")),
        coefficient: &|number| format!("    {number}"),
        harmless: in_docstring,
        precision: "float of Python",
    };
    source.of(exported, &[], &[("fallen", fallen.to_owned())])
}

/// A text that neither ends a docstring nor escapes in it.
fn in_docstring(text: &str) -> String {
    let harmless = |c: char| match c {
        '\\' => '/',
        '"' => '\'',
        c if c.is_control() => '?',
        c => c,
    };
    text.chars().map(harmless).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_files_do_not_end_the_docstring() {
        assert_eq!(in_docstring("a\"\"\"b\\n\u{1b}"), "a'''b/n?");
    }
}
