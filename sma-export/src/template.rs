//! Source text with places for constants, and lines that only some models have.

use std::collections::BTreeMap;

/// Choices and texts of one export.
#[derive(Debug, Default)]
pub(crate) struct Filling {
    /// Conditions of the lines between `@if` and `@end`.
    pub(crate) flags: BTreeMap<&'static str, bool>,
    /// Texts in place of `{{name}}`.
    pub(crate) texts: BTreeMap<String, String>,
}

impl Filling {
    /// Puts a text in its place.
    pub(crate) fn put(&mut self, name: &str, text: String) {
        self.texts.insert(name.to_owned(), text);
    }

    /// Fills a template.
    ///
    /// A line of `mark` and `@if a|b` begins lines that stand if a or b is set, `@else` those that stand if neither is,
    /// `@end` ends them. They nest.
    ///
    /// # Panics
    ///
    /// On a name that the filling does not have, or lines that do not end: the templates are part of the program, and
    /// tests fill all of them.
    pub(crate) fn fill(&self, template: &str, mark: &str) -> String {
        let mut filled = String::with_capacity(template.len());
        let mut stands = vec![true];
        for line in template.lines() {
            match line.strip_prefix(mark) {
                Some("@end") => {
                    stands.pop();
                }
                Some("@else") => {
                    let here = stands.pop().unwrap_or(true);
                    stands.push(!here);
                }
                Some(condition) if condition.starts_with("@if ") => {
                    let names = condition["@if ".len()..].split('|');
                    stands.push(names.map(|name| self.flag(name)).fold(false, |a, b| a | b));
                }
                _ if stands.iter().all(|&one| one) => {
                    self.substitute(line, &mut filled);
                    filled.push('\n');
                }
                _ => {}
            }
        }
        assert_eq!(stands.len(), 1, "each @if of a template has its @end");
        filled
    }

    fn flag(&self, name: &str) -> bool {
        *self
            .flags
            .get(name)
            .unwrap_or_else(|| unreachable!("the template asks for the condition {name}"))
    }

    fn substitute(&self, line: &str, filled: &mut String) {
        let mut rest = line;
        while let Some((before, after)) = rest.split_once("{{") {
            let Some((name, behind)) = after.split_once("}}") else {
                unreachable!("each place of a template is closed: {line}");
            };
            let text = self
                .texts
                .get(name)
                .unwrap_or_else(|| unreachable!("the template has a place for {name}"));
            filled.push_str(before);
            filled.push_str(text);
            rest = behind;
        }
        filled.push_str(rest);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_stand_by_their_conditions_and_places_are_filled() {
        let filling = Filling {
            flags: BTreeMap::from([("a", true), ("b", false)]),
            texts: BTreeMap::from([("x".to_owned(), "1".to_owned())]),
        };
        let template =
            "{{x}} and {{x}}\n//@if b\nno\n//@else\nyes\n//@if b|a\nboth\n//@end\n//@end\nlast\n";
        assert_eq!(filling.fill(template, "//"), "1 and 1\nyes\nboth\nlast\n");
    }
}
