//! Words and lists in sentences.

use missing_physics::Candidate;
use sma_effects::EffectBlock;

/// Columns of a line of text.
const WIDTH: usize = 100;

/// A block of the cascade in a sentence.
#[must_use]
pub fn block_name(block: EffectBlock) -> &'static str {
    match block {
        EffectBlock::Drive => "drive",
        EffectBlock::HeatBalance => "heat balance",
        EffectBlock::Transformation => "transformation",
        EffectBlock::Displacement => "displacement",
        EffectBlock::Sensor => "thermometer",
    }
}

/// Names of effects in a sentence: "a, b and c".
#[must_use]
pub fn named(effects: &[Candidate], word: &str) -> String {
    let names: Vec<&str> = effects.iter().map(|effect| effect.info().name).collect();
    listed(&names, word)
}

/// "a, b and c".
#[must_use]
pub fn listed<S: AsRef<str>>(names: &[S], word: &str) -> String {
    match names {
        [] => String::new(),
        [one] => one.as_ref().to_owned(),
        [first @ .., last] => {
            let first: Vec<&str> = first.iter().map(AsRef::as_ref).collect();
            format!("{} {word} {}", first.join(", "), last.as_ref())
        }
    }
}

/// A text that begins a sentence.
#[must_use]
pub fn capitalized(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or(String::new(), |first| {
        first.to_uppercase().to_string() + letters.as_str()
    })
}

/// A sentence with one stop at its end.
#[must_use]
pub fn full_stop(text: &str) -> String {
    text.trim_end_matches('.').to_owned() + "."
}

/// "recording", or "recordings".
#[must_use]
pub fn recordings(count: usize) -> &'static str {
    if count == 1 {
        "recording"
    } else {
        "recordings"
    }
}

/// A paragraph in lines of 100 columns; those after the first are indented as its number or its blanks are.
#[must_use]
pub fn wrapped(paragraph: &str) -> String {
    let text = paragraph.trim_start_matches(' ');
    let blanks = paragraph.len() - text.len();
    let number = text
        .split_once(". ")
        .filter(|(number, _)| number.chars().all(|c| c.is_ascii_digit()))
        .map_or(0, |(number, _)| number.len() + 2);
    let indent = " ".repeat(blanks + number);
    let options = textwrap::Options::new(WIDTH)
        .initial_indent(&indent[..blanks])
        .subsequent_indent(&indent)
        .break_words(false);
    // A number stays with its percent sign.
    let text = text.replace(" %", "\u{a0}%");
    textwrap::fill(&text, options).replace('\u{a0}', " ")
}

#[cfg(test)]
mod tests {
    use super::{listed, wrapped};

    #[test]
    fn lists_end_with_their_word() {
        assert_eq!(listed(&["a"], "and"), "a");
        assert_eq!(listed(&["a", "b"], "and"), "a and b");
        assert_eq!(listed(&["a", "b", "c"], "or"), "a, b or c");
    }

    #[test]
    fn lines_are_indented_as_their_paragraph_begins() {
        let words = "word ".repeat(30);
        let numbered = wrapped(&format!("12. {words}"));
        let lines: Vec<&str> = numbered.lines().collect();
        assert!(lines[0].starts_with("12. word"), "{numbered}");
        assert!(lines[1].starts_with("    word"), "{numbered}");
        assert!(lines.iter().all(|line| line.chars().count() <= 100));
        let indented = wrapped(&format!("   {words}"));
        assert!(indented.lines().all(|line| line.starts_with("   word")));
    }
}
