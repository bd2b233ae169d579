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
