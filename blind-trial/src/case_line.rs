use serde::{Deserialize, Serialize};

use crate::{Answer, CaseId, Competitors, Line, Oracle, Verdict};

/// What came out of a case; no times, so that equal seeds give equal bytes.
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
    /// What the diagnosis says.
    pub verdict: Verdict,
    /// What others say of the same files, where they were asked.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub competitors: Option<Competitors>,
    /// What was concealed, and what there was to be seen.
    pub opened: Revealed,
}

/// What is known of a case after its diagnosis.
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
    /// Whether the sizes of effects are in their true units: heat capacity and resistance are known.
    pub has_scale: bool,
    /// What each of the concealed effects left to be seen; empty where none has a name.
    pub oracles: Vec<Oracle>,
    /// Effects that this recording cannot tell from each of them.
    pub aliases: Vec<Vec<String>>,
    /// What the catalogue of the diagnosis says of each of them.
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
    /// What became of an ambiguous set.
    pub next: Option<Next>,
}

/// What one more run made of an ambiguous set.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Next {
    /// Whether the truth was named, and alone, with the run that was recommended.
    pub recommended: bool,
    /// The same with a run of that length drawn from the drives of the trial.
    pub random: bool,
}

impl Line for CaseLine {
    type Key = CaseId;

    fn key(&self) -> CaseId {
        self.case
    }
}
