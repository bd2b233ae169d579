//! Verdict of the whole diagnosis.

/// Name of the whole diagnosis.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Verdict {
    /// Nothing is missing that these recordings could show.
    Adequate,
    /// The missing physics has a name.
    Explained,
    /// It is explained, and by more than one name.
    Ambiguous,
    /// The names hold, and something else is left.
    ExplainedInPart,
    /// Something is missing, and the catalogue does not account for it.
    Unexplained,
    /// The baseline is not fitted: nothing can be said.
    NotConverged,
}

impl Verdict {
    /// Name in files and reports.
    #[must_use]
    pub fn id(self) -> &'static str {
        match self {
            Verdict::Adequate => "adequate",
            Verdict::Explained => "explained",
            Verdict::Ambiguous => "ambiguous",
            Verdict::ExplainedInPart => "explained_in_part",
            Verdict::Unexplained => "unexplained",
            Verdict::NotConverged => "not_converged",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Verdict;

    #[test]
    fn a_verdict_has_its_own_name_in_files() {
        for verdict in [
            Verdict::Adequate,
            Verdict::Explained,
            Verdict::Ambiguous,
            Verdict::ExplainedInPart,
            Verdict::Unexplained,
            Verdict::NotConverged,
        ] {
            let words = verdict.id().split('_').map(|word| {
                let (first, rest) = word.split_at(1);
                first.to_uppercase() + rest
            });
            assert_eq!(words.collect::<String>(), format!("{verdict:?}"));
        }
    }
}
