//! Verdict and finding on changes since the reference.

use crate::Candidate;

/// Verdict on what has changed since the reference.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ChangeVerdict {
    /// Nothing that would show.
    Unchanged,
    /// Something has changed: [`Change::finding`] names it.
    Changed,
    /// Something has, and neither a known effect nor a law accounts for it; or the runs go where the reference did not.
    Unexplained,
    /// The reference is one run alone, or cools too seldom: its laws, and how far it repeats, are not known.
    ReferenceTooShort,
}

impl ChangeVerdict {
    /// Name in files.
    #[must_use]
    pub fn id(self) -> &'static str {
        match self {
            Self::Unchanged => "unchanged",
            Self::Changed => "changed",
            Self::Unexplained => "unexplained",
            Self::ReferenceTooShort => "reference_too_short",
        }
    }
}

/// Candidate change since the reference.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Changing {
    /// An effect that the reference does not have has appeared.
    Appeared(Candidate),
    /// An effect that the reference has is of another size.
    Grown(Candidate),
    /// A parameter of the baseline model is another.
    Law(&'static str),
}

impl Changing {
    /// Id of the effect, or name of the parameter.
    #[must_use]
    pub fn id(self) -> &'static str {
        match self {
            Self::Appeared(effect) | Self::Grown(effect) => effect.id(),
            Self::Law(parameter) => parameter,
        }
    }

    /// The effect, if it is one.
    #[must_use]
    pub fn effect(self) -> Option<Candidate> {
        match self {
            Self::Appeared(effect) | Self::Grown(effect) => Some(effect),
            Self::Law(_) => None,
        }
    }
}

/// One change that was considered.
#[derive(Debug, Clone, PartialEq)]
pub struct Considered {
    /// Candidate change.
    pub what: Changing,
    /// The parameter by which it is measured.
    pub parameter: &'static str,
    /// Its unit; of a parameter that is searched by its logarithm "1": the change is a logarithm.
    pub unit: String,
    /// By how much.
    pub change: f64,
    /// 95 % interval; `None` where these runs do not fix it.
    pub ci95: Option<[f64; 2]>,
    /// Probability against no change and against all others that were considered.
    pub probability: f64,
    /// Logarithm of its density over that of no change, nats.
    pub nats: f64,
}

/// A finding.
#[derive(Debug, Clone, PartialEq)]
pub struct Changed {
    /// The likeliest.
    pub leading: Considered,
    /// Alternatives that explain the runs as well: with the leading change, they hold 95 % of the probability, or what they leave more is
    /// less than formulas are off, or they act like it and have four fifths of its evidence.
    pub could_also_be: Vec<Changing>,
}

/// How a run of the reference is met by laws from the others.
#[derive(Debug, Clone, PartialEq)]
pub struct LeftOut {
    /// Name of the run.
    pub name: String,
    /// Root mean square of what is left, its own state known, in the unit of the output.
    pub rmse: f64,
    /// Logarithm of the density of the likeliest change in this run over that of no change, before the discrepancy is
    /// enlarged, nats.
    pub nats: f64,
}

/// The answer of [`Reference::changed`](crate::Reference::changed).
#[derive(Debug, Clone, PartialEq)]
pub struct Change {
    /// The verdict.
    pub verdict: ChangeVerdict,
    /// Leading change and its alternatives; `None` unless the verdict is [`ChangeVerdict::Changed`].
    pub finding: Option<Changed>,
    /// All changes that were considered, the likeliest first.
    pub considered: Vec<Considered>,
    /// Probability that nothing has changed.
    pub unchanged: f64,
    /// Coolings of the reference through its loop.
    pub coolings: usize,
    /// Runs of the reference, each left out.
    pub left_out: Vec<LeftOut>,
    /// Effects that the reference has.
    pub laws: Vec<Candidate>,
    /// Names of the runs that were asked about, and root mean squares of what the laws of the reference leave of each without a change
    /// and with the likeliest, in the unit of the output; each run's own state is known in both.
    pub runs: Vec<(String, [f64; 2])>,
    /// Ratio of the mean square that these runs leave to the largest that a run of the reference left when left out:
    /// without a change and with the likeliest.
    pub excess: [f64; 2],
    /// Share of the samples of these runs that were compared, 0 to 1: those in loops inside that no run of the reference makes were not.
    pub share_compared: f64,
    /// Unit of the output.
    pub output_unit: String,
}

/// Fewest coolings of a reference from which a name is given.
pub const FEWEST_COOLINGS: usize = 2;

/// Fewest runs of a reference: how far one repeats nobody knows.
pub const FEWEST_RUNS: usize = 2;

/// Probability of no change from which nothing is said to have changed.
pub const LEAST_UNCHANGED: f64 = 0.05;

/// Probability that a set of names holds.
const SET: f64 = 0.95;

/// Mean square that runs leave at least where something has changed, over the largest that a run of the reference left: its own runs
/// differ by as much.
pub const LEAST_EXCESS: f64 = 1.0;

/// Largest mean square that runs may leave, over the same: twice as much.
pub const MOST_EXCESS: f64 = 2.0;

/// Share of what is more than [`LEAST_EXCESS`] which a finding accounts for at least, where runs leave more. A flexible effect has to account for
/// all: it takes much of whatever has changed.
pub const LEAST_EXPLAINED: f64 = 0.8;

/// Share of its evidence by which a change must be better than another to be told from it: a formula of an effect is ideal, and
/// leaves a hundredth of the squares where it is off by a tenth.
const IDEAL: f64 = 0.01;

/// Prior probability of no change; what may have changed shares the rest alike.
const PRIOR: f64 = 0.5;

/// Probabilities of no change and of each change, from the logarithms of their densities over that of no change.
pub(super) fn probabilities(nats: &[f64]) -> (f64, Vec<f64>) {
    let share = (1.0 - PRIOR) / nats.len().max(1) as f64;
    let highest = nats.iter().copied().fold(0.0, f64::max);
    let none = PRIOR * (-highest).exp();
    let each: Vec<f64> = nats
        .iter()
        .map(|nats| share * (nats - highest).exp())
        .collect();
    let sum = none + each.iter().sum::<f64>();
    (none / sum, each.iter().map(|one| one / sum).collect())
}

/// The verdict and the finding; `excess` is over the runs of the reference without a change and with the likeliest.
pub(super) fn decided(
    considered: &[Considered],
    unchanged: f64,
    excess: [f64; 2],
    (runs, coolings): (usize, usize),
) -> (ChangeVerdict, Option<Changed>) {
    if runs < FEWEST_RUNS || coolings < FEWEST_COOLINGS {
        return (ChangeVerdict::ReferenceTooShort, None);
    }
    let shows = unchanged < LEAST_UNCHANGED && excess[0] > LEAST_EXCESS;
    let Some(leading) = considered.first().filter(|_| shows) else {
        let verdict = if excess[0] > MOST_EXCESS {
            ChangeVerdict::Unexplained
        } else {
            ChangeVerdict::Unchanged
        };
        return (verdict, None);
    };
    let explained = (excess[0] - excess[1]) / (excess[0] - LEAST_EXCESS);
    let effect = leading.what.effect();
    let is_flexible = effect.is_some_and(|effect| effect.info().flexible);
    if excess[1] > MOST_EXCESS && (is_flexible || explained < LEAST_EXPLAINED) {
        return (ChangeVerdict::Unexplained, None);
    }
    let mut held = leading.probability;
    let mut could_also_be: Vec<Changing> = Vec::new();
    for other in &considered[1..] {
        let is_as_likely = other.nats >= (1.0 - IDEAL) * leading.nats
            || acts_like(leading.what, other.what) && other.nats >= LEAST_EXPLAINED * leading.nats;
        if !is_as_likely && held >= SET * (1.0 - unchanged) {
            continue;
        }
        held += other.probability;
        let is_new = other.what.id() != leading.what.id();
        if is_new && !could_also_be.contains(&other.what) {
            could_also_be.push(other.what);
        }
    }
    let finding = Changed {
        leading: leading.clone(),
        could_also_be,
    };
    (ChangeVerdict::Changed, Some(finding))
}

/// True if a change acts like another in every rig: formulas alone tell them apart, which are ideal, beside laws that are not known well.
fn acts_like(one: Changing, other: Changing) -> bool {
    let both = one.effect().zip(other.effect());
    both.is_some_and(|(one, other)| one.acts_like(other))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::EffectId;

    fn considered(effect: EffectId, probability: f64) -> Considered {
        Considered {
            what: Changing::Appeared(effect.into()),
            parameter: effect.info().parameters[0].name,
            unit: String::new(),
            change: 1.0,
            ci95: None,
            probability,
            nats: 400.0 * probability,
        }
    }

    #[test]
    fn what_is_as_likely_as_not_is_no_change() {
        let (none, each) = probabilities(&[0.0, 0.0]);
        assert!((none - 0.5).abs() < 1e-12 && (each[0] - 0.25).abs() < 1e-12);
        let (none, each) = probabilities(&[800.0, 790.0]);
        assert!(none < 1e-300 && each[0] > 0.9999 && each[1] > 0.0);
    }

    #[test]
    fn a_set_holds_95_percent_and_what_fits_worse_than_the_reference_has_no_name() {
        let all = [
            considered(EffectId::OutputLag, 0.8),
            considered(EffectId::DeadTime, 0.17),
            considered(EffectId::Backlash, 0.03),
        ];
        let (verdict, finding) = decided(&all, 1e-9, [30.0, 1.1], (2, 2));
        assert_eq!(verdict, ChangeVerdict::Changed);
        let others = finding.unwrap().could_also_be;
        assert_eq!(others, [Changing::Appeared(EffectId::DeadTime.into())]);
        // A hundredth of the evidence tells formulas, not causes.
        let told = |nats: [f64; 2]| {
            let mut two = [all[0].clone(), all[2].clone()];
            two[0].probability = 1.0;
            (two[0].nats, two[1].nats) = (nats[0], nats[1]);
            decided(&two, 1e-9, [30.0, 1.1], (2, 2))
                .1
                .unwrap()
                .could_also_be
                .is_empty()
        };
        assert!(told([1000.0, 980.0]) && !told([1000.0, 995.0]));
        // What acts like another is told from it by its formula alone.
        let alike = |nats: f64| {
            let mut two = [all[0].clone(), all[1].clone()];
            two[0].probability = 1.0;
            (two[0].nats, two[1].nats) = (1000.0, nats);
            let finding = decided(&two, 1e-9, [30.0, 1.1], (2, 2)).1.unwrap();
            finding.could_also_be.len()
        };
        assert_eq!([790.0, 810.0].map(alike), [0, 1]);
        let of = |unchanged, excess, reference| decided(&all, unchanged, excess, reference).0;
        assert_eq!(of(1e-9, [4.0, 2.5], (2, 2)), ChangeVerdict::Unexplained);
        // What it does not account for is no reason against what it does.
        assert_eq!(of(1e-9, [30.0, 2.5], (2, 2)), ChangeVerdict::Changed);
        let drift = [considered(EffectId::AmbientDrift, 1.0)];
        let verdict = |excess| decided(&drift, 1e-9, excess, (2, 2)).0;
        assert_eq!(verdict([30.0, 2.5]), ChangeVerdict::Unexplained);
        assert_eq!(verdict([30.0, 1.1]), ChangeVerdict::Changed);
        assert_eq!(of(0.5, [2.5, 2.4], (2, 2)), ChangeVerdict::Unexplained);
        assert_eq!(of(0.5, [1.5, 1.4], (2, 2)), ChangeVerdict::Unchanged);
        // Runs of the reference differ as much.
        assert_eq!(of(1e-9, [0.98, 0.9], (2, 2)), ChangeVerdict::Unchanged);
        assert_eq!(of(1e-9, [1.02, 0.9], (2, 2)), ChangeVerdict::Changed);
        for reference in [(1, 5), (3, 1)] {
            let verdict = of(1e-9, [30.0, 1.1], reference);
            assert_eq!(verdict, ChangeVerdict::ReferenceTooShort);
        }
    }
}
