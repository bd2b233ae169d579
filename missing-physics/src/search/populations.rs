//! A second population of relays, where the recordings tell of one.

use std::ops::ControlFlow;

use identify::{
    Fit, FitConfig, ForwardModel, IdentifyError, ParameterVector, SECOND_POPULATION_PARAMETERS, fit,
};

use crate::model::case::Case;
use crate::model::extended_model::LoopFreedom;
use crate::search::families::{OtherBaseline, is_told};
use crate::{CandidateSet, LoopFamily};

/// Second populations from which a fit starts: a quarter of the relays, hotter with a narrower loop, colder with a wider one, and about
/// the same middle with a larger spread. What else is possible lies downhill from one of these.
const SECOND_STARTS: [[f64; 5]; 3] = [
    [0.25, 1.0, -0.3, 0.0, 0.0],
    [0.25, -1.0, 0.3, -0.3, 0.0],
    [0.25, 0.0, 0.0, 0.5, 0.0],
];

/// A second population that hardly differs from the first, almost as if there were none. Of one that does not differ the share would
/// not act.
const NEARLY_ALIKE: [f64; 5] = [0.25, 0.0, 0.0, 0.1, 0.0];

impl OtherBaseline {
    /// The baseline model with a second population of relays, if the recordings tell of one by Schwarz's criterion; itself if not.
    pub(super) fn populated(&self, case: &Case<'_>, seed: u64) -> Result<Self, IdentifyError> {
        if self.family != LoopFamily::Relays {
            return Ok(self.clone());
        }
        let freedom = LoopFreedom::TwoPopulations;
        let of_two = case.of_family(self.family, &self.base, &self.fit, freedom);
        let model = of_two.model(CandidateSet::EMPTY);
        let vector = ParameterVector::new(model.parameters(), case.training.len());
        let starts = SECOND_STARTS.map(|second| self.starting(second).coordinates(&vector));
        let near = of_two.refined(&of_two.baseline()?, CandidateSet::EMPTY, &starts)?;
        let config = FitConfig {
            from: vec![near.coordinates],
            starts: 0,
            ..case.fit_config(&self.fit.noise, seed)
        };
        let go_on = &mut |_: &_| ControlFlow::Continue(());
        let with = fit(&case.watched(&model), case.training, &config, go_on)?;
        let simulations = near.simulations + with.simulations;
        let (freedom, found) = if is_told(&self.fit, &with, SECOND_POPULATION_PARAMETERS.len()) {
            // A second population bends to what else is missing as any loop does: effects are tried from where there was none, too.
            let other_minima = vec![self.starting(NEARLY_ALIKE).points()];
            (
                freedom,
                Fit {
                    other_minima,
                    ..with
                },
            )
        } else {
            (self.freedom, self.fit.clone())
        };
        let found = Fit {
            simulations,
            ..found
        };
        Ok(self.followed_by(self.base.clone(), freedom, found))
    }

    /// The fit with such a second population beside the first.
    fn starting(&self, second: [f64; 5]) -> Fit {
        let mut fit = self.fit.clone();
        for (name, value) in SECOND_POPULATION_PARAMETERS.into_iter().zip(second) {
            for parameter in &mut fit.parameters {
                if parameter.info.name == name {
                    parameter.values = vec![value; parameter.values.len()];
                }
            }
        }
        fit
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::synthetic::{NOISE_MM, Synthetic};
    use crate::search::families::{Near, formulas, plain_fits, shaped};
    use crate::{EffectSet, EffectValues, Effort};
    use wiener::hysteresis::SecondPopulation;

    const SECOND: SecondPopulation = SecondPopulation {
        share: 0.3,
        shift: 1.5,
        log_half_width: -0.5,
        log_spread: -0.3,
        zeta_difference: 0.2,
    };

    /// The baseline model of relays with its shape free, and what a second population makes of it.
    fn fitted(second: SecondPopulation) -> [OtherBaseline; 2] {
        let mut values = EffectValues::default();
        values.family.second = second;
        let synthetic = Synthetic::with_loop(LoopFamily::Relays, EffectSet::EMPTY, values, 1);
        let case = synthetic.case();
        let relays = plain_fits(&case, 1, 1)
            .unwrap()
            .into_iter()
            .find(|one| one.family == LoopFamily::Relays)
            .unwrap();
        let shaped = relays.shaped(&case, case.base.clone(), 1).unwrap();
        let populated = shaped.populated(&case, 1).unwrap();
        [shaped, populated]
    }

    #[test]
    fn a_second_population_is_found_where_there_is_one() {
        let [shaped, populated] = fitted(SECOND);
        assert!(shaped.fit.train_rmse > 1.5 * NOISE_MM);
        assert!(populated.fit.train_rmse < 1.1 * NOISE_MM);
        assert_eq!(populated.freedom, LoopFreedom::TwoPopulations);
        // From where there is none every effect is tried as well.
        assert_eq!(populated.fit.other_minima.len(), 1);
    }

    #[test]
    fn a_thorough_search_alone_frees_it() {
        let mut values = EffectValues::default();
        values.family.second = SECOND;
        let synthetic = Synthetic::with_loop(LoopFamily::Relays, EffectSet::EMPTY, values, 1);
        let case = synthetic.case();
        let freedom_of = |effort| {
            let formulas = formulas(&case, 1).unwrap();
            let fits = shaped(&case, formulas, Near::Nearer, (effort, 1)).unwrap();
            let relays = fits.iter().find(|one| one.family == LoopFamily::Relays);
            relays.unwrap().freedom
        };
        assert_eq!(freedom_of(Effort::Normal), LoopFreedom::Shape);
        assert_eq!(freedom_of(Effort::Thorough), LoopFreedom::TwoPopulations);
    }

    #[test]
    fn relays_of_one_population_stay_so() {
        let [shaped, populated] = fitted(SecondPopulation::default());
        assert_eq!(populated.freedom, LoopFreedom::Shape);
        assert_eq!(
            populated.fit.train_rmse.to_bits(),
            shaped.fit.train_rmse.to_bits()
        );
        assert!(populated.fit.simulations > shaped.fit.simulations);
    }
}
