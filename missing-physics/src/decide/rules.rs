//! The rules that decide, all of them.

/// Number of a rule in [`RULES`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum RuleId {
    /// The model says something of the recordings at all.
    Describes,
    /// Something is left that a curve or a name predicts.
    Missing,
    /// The prediction goes with the recordings beyond chance.
    Predicted,
    /// A name is no matter of how exact another effect's formula is.
    Form,
    /// A set of names holds all that would do.
    Set,
    /// The contribution of a name goes with the residual without it, beyond chance.
    Own,
    /// Something is left beside the names.
    Remainder,
    /// The error is larger than rounding, and more than the formulas themselves are exact to.
    Matters,
    /// The size of the residual follows the drive.
    Disturbed,
    /// The residual has a tone.
    Tone,
    /// The residual is slower than the noise of a sensor.
    Slow,
    /// An apparent drift of the zero is a slip of the mount.
    Slip,
    /// The size of a name is told from none.
    Told,
    /// A name helps on recordings that were not used.
    UnseenGain,
    /// The explained error is also explained on recordings that were not used.
    UnseenShare,
}

impl RuleId {
    /// The rule of this number.
    #[must_use]
    pub fn rule(self) -> &'static Rule {
        let found = RULES.iter().find(|rule| rule.id == self);
        let Some(found) = found else {
            unreachable!("each has a row");
        };
        found
    }
}

/// How a statistic is compared with a threshold.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Comparison {
    /// Passed if the statistic is at least the threshold.
    AtLeast,
    /// Passed if it is at most the threshold.
    AtMost,
    /// Passed if it is off 1 by the threshold at most.
    NearOne,
}

impl Comparison {
    /// Sign before the threshold where a rule is written down.
    #[must_use]
    pub fn sign(self) -> &'static str {
        match self {
            Self::AtLeast => "≥",
            Self::AtMost => "≤",
            Self::NearOne => "1 ±",
        }
    }
}

/// Where a threshold comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Basis {
    /// A probability of being wrong by chance.
    Quantile,
    /// Odds.
    Odds,
    /// It follows from something else, which the rule says.
    Derivation,
    /// Chosen; the trial tells what a quarter more or less would change.
    Chosen,
}

/// A rule: what is compared with what, and why.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rule {
    /// Its number.
    pub id: RuleId,
    /// Its name in files and reports.
    pub name: &'static str,
    /// Statistic that is compared.
    pub statistic: &'static str,
    /// Direction of the comparison.
    pub comparison: Comparison,
    /// Threshold of the statistic.
    pub threshold: f64,
    /// Where the threshold comes from.
    pub basis: Basis,
    /// The reason, in a sentence.
    pub reason: &'static str,
}

impl Rule {
    /// True if a value passes; NaN does not.
    #[must_use]
    pub fn passes(&self, value: f64) -> bool {
        self.passes_at(value, self.threshold)
    }

    /// True if a value would pass with another threshold; NaN does not.
    #[must_use]
    pub fn passes_at(&self, value: f64, threshold: f64) -> bool {
        match self.comparison {
            Comparison::AtLeast => value >= threshold,
            Comparison::AtMost => value <= threshold,
            Comparison::NearOne => (value - 1.0).abs() <= threshold,
        }
    }

    /// The threshold times a factor; of a share or a probability above a half, what it lacks of 1 is multiplied.
    #[must_use]
    pub fn threshold_times(&self, factor: f64) -> f64 {
        if self.threshold > 0.5 && self.threshold < 1.0 {
            1.0 - factor * (1.0 - self.threshold)
        } else {
            factor * self.threshold
        }
    }
}

/// All rules, in the order in which they are asked.
pub const RULES: [Rule; 15] = [
    Rule {
        id: RuleId::Describes,
        name: "describes",
        statistic: "share of the output's variance that is predicted on blocks left out: by the baseline model if nothing is named, else by the best without drifts",
        comparison: Comparison::AtLeast,
        threshold: 0.8,
        basis: Basis::Chosen,
        reason: "a model that leaves more than a fifth of what happens describes another rig",
    },
    Rule {
        id: RuleId::Missing,
        name: "missing",
        statistic: "probability of the baseline model against all names and the anonymous curve",
        comparison: Comparison::AtMost,
        threshold: 0.05,
        basis: Basis::Odds,
        reason: "19 to 1 that something is missing",
    },
    Rule {
        id: RuleId::Predicted,
        name: "predicted",
        statistic: "probability that noise of the same spectrum is met as well by what the curve predicts",
        comparison: Comparison::AtMost,
        threshold: 0.01,
        basis: Basis::Quantile,
        reason: "noise cannot be predicted from what drove the rig",
    },
    Rule {
        id: RuleId::Form,
        name: "form",
        statistic: "share of the explainable error that comes back without it",
        comparison: Comparison::AtLeast,
        threshold: 0.01,
        basis: Basis::Derivation,
        reason: "a formula is exact to about a tenth of what it does: a hundredth of its square may be its own error",
    },
    Rule {
        id: RuleId::Set,
        name: "set",
        statistic: "probability that one of a set of names is there, times the probability that all names leave no more than an anonymous curve, alone or in its place",
        comparison: Comparison::AtLeast,
        threshold: 0.95,
        basis: Basis::Odds,
        reason: "19 to 1 against everything else, the unlisted included: where a curve does better, there is no name",
    },
    Rule {
        id: RuleId::Own,
        name: "own",
        statistic: "probability that noise of the same spectrum is met as well by what any of the names tried in its place adds",
        comparison: Comparison::AtMost,
        threshold: 0.01,
        basis: Basis::Quantile,
        reason: "what it adds must be in the recordings, whatever the noise is like",
    },
    Rule {
        id: RuleId::Remainder,
        name: "remainder",
        statistic: "probability that the anonymous curve is needed beside the names",
        comparison: Comparison::AtLeast,
        threshold: 0.95,
        basis: Basis::Odds,
        reason: "19 to 1 that something else is left",
    },
    Rule {
        id: RuleId::Matters,
        name: "matters",
        statistic: "root mean square that is predicted, of the training or of recordings that were not used, over a thousandth of the output's standard deviation, or over the converter's rounding or what noise of the drive may leave, if that is more; of recorded temperatures over 1.5 % of their standard deviation; whichever is larger",
        comparison: Comparison::AtLeast,
        threshold: 1.0,
        basis: Basis::Chosen,
        reason: "no formula of a loop, and hardly a sensor, is exact to a thousandth of what it shows, and rounding follows the output, and an error of the drive the drive, as physics does",
    },
    Rule {
        id: RuleId::Disturbed,
        name: "disturbed",
        statistic: "share of what the size of the rest varies by that the rig's state predicts, beyond 1 in 1000 by chance",
        comparison: Comparison::AtLeast,
        threshold: 0.05,
        basis: Basis::Derivation,
        reason: "a sensor's noise does not know the drive, draughts do: it grows and shrinks by a sixth with the state",
    },
    Rule {
        id: RuleId::Tone,
        name: "tone",
        statistic: "correlation of what is left with itself at eight of 64 long lags, standard deviations",
        comparison: Comparison::AtLeast,
        threshold: 6.0,
        basis: Basis::Quantile,
        reason: "no noise repeats itself after so many samples: by chance in less than 1 of ten million recordings",
    },
    Rule {
        id: RuleId::Slow,
        name: "slow",
        statistic: "what the error has in common with itself two samples later, over the noise between neighbors: of the output, or of a temperature that is missed by more than a thermometer's error",
        comparison: Comparison::AtLeast,
        threshold: 5.0,
        basis: Basis::Derivation,
        reason: "noise with a memory of 25 samples is five times as large as between neighbors, noise of 1/f three times: what is slower is no sensor's",
    },
    Rule {
        id: RuleId::Slip,
        name: "slip",
        statistic: "error of a drift of the zero over that of a mount that slips, while the rod is out or once in each recording",
        comparison: Comparison::AtLeast,
        threshold: 1.0,
        basis: Basis::Derivation,
        reason: "a drift of the sensor knows nothing of the rod, and is slow",
    },
    Rule {
        id: RuleId::Told,
        name: "told",
        statistic: "size of a name over half of its 95 % interval; of several sizes the largest, by an interval that holds all of them; of a drift all its changes within recordings together; of what is no drift, the same of its change of recordings that were not used, if that is more and comes true; 0 of a drift that turns back three times in a recording, or goes most of its way within an eighth of one, and of another name that ends at a bound which is no physical end",
        comparison: Comparison::AtLeast,
        threshold: 1.0,
        basis: Basis::Quantile,
        reason: "what may have no size is no finding; what turns back again and again is not slow, and what comes within an eighth of a recording is an event or a level",
    },
    Rule {
        id: RuleId::UnseenGain,
        name: "unseen-gain",
        statistic: "share of what a name changes in the unseen recordings that comes true",
        comparison: Comparison::NearOne,
        threshold: 0.5,
        basis: Basis::Derivation,
        reason: "what is right comes true as it is: below a half it makes them worse, and beyond one and a half they ask for another size than the training by more than half of it",
    },
    Rule {
        id: RuleId::UnseenShare,
        name: "unseen-share",
        statistic: "share of what could be explained of the unseen recordings that the names alone explain, and share of their error that twice the training's and the uncertainty of the parameters make, whichever is less; without a name the latter",
        comparison: Comparison::AtLeast,
        threshold: 0.8,
        basis: Basis::Chosen,
        reason: "what is explained is explained by what is named, on recordings that were not used",
    },
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_comes_true_is_neither_half_nor_half_as_much_again() {
        let rule = RuleId::UnseenGain.rule();
        for value in [0.5, 0.97, 1.0, 1.5] {
            assert!(rule.passes(value), "{value}");
        }
        for value in [0.49, 1.51, -1.0, f64::NAN] {
            assert!(!rule.passes(value), "{value}");
        }
    }

    #[test]
    fn a_threshold_may_be_a_quarter_more_or_less() {
        let times = |id: RuleId, factor: f64| id.rule().threshold_times(factor);
        // What a probability lacks of 1 is multiplied, and whatever is no share near 1 itself.
        assert!((times(RuleId::Set, 1.25) - 0.9375).abs() < 1e-12);
        assert!((times(RuleId::Set, 0.75) - 0.9625).abs() < 1e-12);
        assert!((times(RuleId::UnseenShare, 1.25) - 0.75).abs() < 1e-12);
        assert!((times(RuleId::UnseenGain, 1.25) - 0.625).abs() < 1e-12);
        assert!((times(RuleId::Own, 1.25) - 0.0125).abs() < 1e-12);
        assert!((times(RuleId::Told, 0.75) - 0.75).abs() < 1e-12);
        assert!((times(RuleId::Tone, 0.75) - 4.5).abs() < 1e-12);
    }
}
