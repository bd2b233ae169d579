use serde::{Deserialize, Serialize};

use crate::{Answer, CaseId, Competitors, Line, Oracle, Verdict};

/// Result of a case; no times, so that equal seeds give equal bytes.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CaseLine {
    /// Which case.
    pub case: CaseId,
    /// SHA-256 of the files that were diagnosed.
    pub files: String,
    /// Seal of the answer, where every case had its own: in the first published table.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub seal: Option<String>,
    /// Effects that the diagnosis had to do without.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub struck: Vec<String>,
    /// Verdict of the diagnosis.
    pub verdict: Verdict,
    /// Results of other methods on the same files, if they were run.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub competitors: Option<Competitors>,
    /// Answer of the case, and the visibility of its concealed effects.
    pub opened: Revealed,
}

/// Data of a case that are known after its diagnosis.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Revealed {
    /// Salt of its own seal, where it had one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub salt: Option<String>,
    /// The answer.
    pub answer: Answer,
    /// Standard deviation of the output's noise, mm.
    pub noise_mm: f64,
    /// True if the sizes of effects are in their true units: heat capacity and resistance are known.
    pub has_scale: bool,
    /// Visibility of each of the concealed effects; empty if none has a name.
    pub oracles: Vec<Oracle>,
    /// Effects that this recording cannot tell from each of them.
    pub aliases: Vec<Vec<String>>,
    /// Status of each of them in the catalogue of the diagnosis.
    pub said: Vec<Option<String>>,
    /// Sizes of each of them in the catalogue's unit, where truth and catalogue can be compared.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub sizes: Vec<Option<f64>>,
    /// Above which size the diagnosis excludes each of them, if it does.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub excluded_above: Vec<Option<f64>>,
    /// Of a single effect: share of the squares of what it leaves in the spans that are blamed, and share of the
    /// time that these take.
    pub spans: Option<[f64; 2]>,
    /// Outcome of an ambiguous set.
    pub next: Option<Next>,
}

/// Outcome of an ambiguous set after one more run.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Next {
    /// True if the truth was named, and alone, with the recommended run.
    pub recommended: bool,
    /// True if the truth was named, and alone, with a run of that length drawn from the drives of the trial.
    pub random: bool,
}

impl Line for CaseLine {
    type Key = CaseId;

    fn key(&self) -> CaseId {
        self.case
    }
}
