//! The verdict.

use crate::CandidateSet;
use crate::decide::known::Known;
use crate::decide::leading::leading;
use crate::decide::names::{Belief, Named, names};
use crate::decide::rules::RuleId;
use crate::decide::said::Verdict;
use crate::decide::trace::Traces;
use crate::evidence::{Audit, Model, Population, UNLISTED, masses};
use crate::model::elsewhere::is_drift;

/// Decision on a population.
#[derive(Debug, Clone)]
pub(crate) struct Decided {
    pub(crate) verdict: Verdict,
    /// Verdict on the baseline model, without names.
    pub(crate) nameless: Verdict,
    pub(crate) named: Vec<Named>,
    /// Names that help and do not hold.
    pub(crate) suspects: Vec<Named>,
    /// Share of what could be explained that the leading model explains on blocks it has not seen.
    pub(crate) explained: Option<f64>,
    /// Part of the residual that a curve of any shape predicts: the leading model's, or the baseline's if nothing is named and a suspect
    /// is no drift.
    pub(crate) audit: Option<Audit>,
    pub(crate) traces: Traces,
}

impl Decided {
    /// True if the verdict is that something has a name.
    pub(crate) fn is_of_names(&self) -> bool {
        matches!(
            self.verdict,
            Verdict::Explained | Verdict::ExplainedInPart | Verdict::Ambiguous
        )
    }

    /// Moves names to the suspects. Without a name left the verdict is that on the baseline model; without an alternative left,
    /// ambiguous becomes explained.
    pub(crate) fn fall(&mut self, fallen: CandidateSet) {
        let (fallen, named): (Vec<Named>, Vec<Named>) = std::mem::take(&mut self.named)
            .into_iter()
            .partition(|one| fallen.contains(one.effect));
        self.named = named;
        self.suspects.extend(fallen);
        let is_ambiguous = self.named.iter().any(|one| !one.others.is_empty());
        if self.named.is_empty() && self.is_of_names() {
            self.verdict = self.nameless;
        } else if self.verdict == Verdict::Ambiguous && !is_ambiguous {
            self.verdict = Verdict::Explained;
        }
    }
}

/// Decides on a population.
pub(crate) fn decide(population: &Population, known: &Known, mut traces: Traces) -> Decided {
    let model = leading(population);
    let belief = Belief::of(population, model, known.seed);
    let mut of_names = traces.begun_again();
    let [mut named, mut suspects] = names(population, model, &belief, known, &mut of_names);
    let described = if named.is_empty() {
        described_plainly(population, known)
    } else {
        described(population, known)
    };
    let describes = traces.ask(RuleId::Describes, "", described);
    let is_missing = traces.ask(
        RuleId::Missing,
        "",
        plain(population, model, &belief, known.seed),
    );
    traces.steps.append(&mut of_names.steps);
    // What a suspect would explain is not explained. But what a curve of time explains is slow, as noise may be: of that `own` and
    // `slow` judge.
    let is_slow_at_most = suspects.iter().all(|one| is_drift(one.effect));
    let judged = if named.is_empty() && !is_slow_at_most {
        population.plain()
    } else {
        model
    };
    let more_is_left = is_left(population, judged, known, &mut traces);
    let slip = slip(known, named.iter().chain(&suspects), &traces);
    let Odd { is_odd, slips } = odd(known, slip, named.is_empty(), &mut traces);
    let verdict = if !describes {
        Verdict::Unexplained
    } else if named.is_empty() {
        let is_found = is_missing && suspects.iter().any(|one| is_found(&traces, one));
        if more_is_left || is_odd || is_found {
            Verdict::Unexplained
        } else {
            Verdict::Adequate
        }
    } else if slips {
        Verdict::Unexplained
    } else if more_is_left || is_odd {
        Verdict::ExplainedInPart
    } else if named.iter().any(|named| !named.others.is_empty()) {
        Verdict::Ambiguous
    } else {
        Verdict::Explained
    };
    if verdict == Verdict::Unexplained {
        suspects.append(&mut named);
    }
    let mut aside = traces.begun_again();
    let nameless = nameless(population, known, &mut aside);
    traces.set_aside(aside);
    let with = model.evidence.squares();
    let without = population.plain().evidence.squares();
    Decided {
        verdict,
        nameless,
        named,
        suspects,
        explained: (!model.names.is_empty()).then(|| population.share(with, without)),
        audit: judged.anonymous.as_ref().map(|one| one.audit),
        traces,
    }
}

/// Verdict on the baseline model.
fn nameless(population: &Population, known: &Known, aside: &mut Traces) -> Verdict {
    let describes = aside.ask(RuleId::Describes, "", described_plainly(population, known));
    let more_is_left = is_left(population, population.plain(), known, aside);
    let Odd { is_odd, .. } = odd(known, None, true, aside);
    if !describes || more_is_left || is_odd {
        Verdict::Unexplained
    } else {
        Verdict::Adequate
    }
}

/// Error of the leading model's drift of the zero over that of a slip, if the drift goes with the recordings: where there is neither,
/// both fit noise as well.
fn slip<'a>(
    known: &Known,
    mut names: impl Iterator<Item = &'a Named>,
    traces: &Traces,
) -> Option<f64> {
    let (drift, over) = known.slip?;
    let is_found = names.any(|one| one.effect == drift && is_found(traces, one));
    is_found.then_some(over)
}

/// True if the contribution of a suspect goes with the recordings, and matters.
fn is_found(traces: &Traces, suspect: &Named) -> bool {
    let id = suspect.effect.id();
    traces.has(RuleId::Own, id, true) && !traces.has(RuleId::Matters, id, false)
}

/// Share of the output's variance that is predicted on blocks which were left out, by any model or with the curve on top. Drifts
/// do not count: a curve of time goes along with any output.
fn described(population: &Population, known: &Known) -> f64 {
    let driven = population.models.iter();
    let driven = driven.filter(|model| !model.names.iter().any(is_drift));
    let squares = driven.map(|model| {
        let own = model.evidence.squares()[0];
        let with_curve = model.anonymous.as_ref();
        with_curve.map_or(own, |curve| curve.evidence.squares()[0].min(own))
    });
    share_described(squares.fold(f64::INFINITY, f64::min), known)
}

/// Share of the output's variance that the baseline model predicts on blocks which were left out: if nothing is named, that
/// model is said to describe the rig.
fn described_plainly(population: &Population, known: &Known) -> f64 {
    share_described(population.plain().evidence.squares()[0], known)
}

fn share_described(left: f64, known: &Known) -> f64 {
    if known.output_squares > 0.0 {
        1.0 - left / known.output_squares
    } else {
        0.0
    }
}

/// Probability of the baseline model.
fn plain(population: &Population, model: &Model, belief: &Belief, seed: u64) -> f64 {
    if !model.names.is_empty() {
        return belief.plain();
    }
    1.0 - with_curve(population.plain(), seed)
}

/// Probability that a model needs the anonymous curve.
fn with_curve(model: &Model, seed: u64) -> f64 {
    let Some(anonymous) = &model.anonymous else {
        return 0.0;
    };
    let asked: [(f64, &[f64]); 2] = [
        (0.0, &model.evidence.nats),
        (UNLISTED, &anonymous.evidence.nats),
    ];
    masses(&asked, seed)[1]
}

/// True if a curve finds more than the model has, and more than its formulas' own error.
fn is_left(population: &Population, model: &Model, known: &Known, traces: &mut Traces) -> bool {
    let Some(anonymous) = &model.anonymous else {
        return false;
    };
    let [left, with] = [&model.evidence, &anonymous.evidence].map(|one| one.squares());
    let is_needed = traces.ask(RuleId::Remainder, "", with_curve(model, known.seed));
    let is_predicted = traces.ask(RuleId::Predicted, "", anonymous.audit.p_value);
    let share = if model.names.iter().all(is_drift) {
        anonymous.audit.share
    } else {
        population.share_beside_drifts(model, with, left)
    };
    let is_large = traces.ask(RuleId::Form, "", share);
    let gained = (left[0] - with[0]) / model.evidence.n_outputs as f64;
    let gained = (gained, left[1] - with[1]);
    let is_material = known.is_material(traces, "", gained, model.evidence.n_outputs);
    is_needed && is_predicted && is_large && is_material
}

/// A residual that nothing predicts.
struct Odd {
    /// True if it is no noise of a sensor.
    is_odd: bool,
    /// True if what was taken for a drift of the sensor is a mount that slips.
    slips: bool,
}

/// Judges a residual that nothing predicts.
fn odd(known: &Known, slip: Option<f64>, is_nameless: bool, traces: &mut Traces) -> Odd {
    let is_disturbed = is_nameless && traces.ask(RuleId::Disturbed, "", known.disturbed);
    let left = if is_nameless {
        known.left_by_plain
    } else {
        known.left
    };
    let has_tone = traces.ask(RuleId::Tone, "", left.tone);
    let is_slow = traces.ask(RuleId::Slow, "", left.slowness);
    let slips = slip.is_some_and(|slip| traces.ask(RuleId::Slip, "", slip));
    Odd {
        is_odd: is_disturbed || has_tone || is_slow || slips,
        slips,
    }
}
