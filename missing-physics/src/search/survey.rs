//! The search at few samples: which models are worth a look at enough to judge them.

use identify::IdentifyError;

use crate::config::{DiagnoseConfig, Effort, Part};
use crate::decide::leading;
use crate::evidence::Block;
use crate::model::case::Case;
use crate::noise::floor::{Measured, measured};
use crate::search::complete::Completing;
use crate::search::families::{
    self, Near, OtherBaseline, is_anything, is_described, may_be_the_loop,
};
use crate::search::growth::grow;
use crate::search::roads::Search;
use crate::{Candidate, CandidateSet};

/// The searches at few samples, the paper's loop first.
#[derive(Debug)]
pub(crate) struct Survey<'c> {
    case: &'c Case<'c>,
    catalogue: CandidateSet,
    noise: Measured,
    pub(crate) config: &'c DiagnoseConfig,
    pub(crate) completing: Completing<'c>,
    pub(crate) searches: Vec<Search<'c>>,
}

/// Loops of other families that are searched beside the paper's.
#[derive(Debug)]
pub(crate) struct Loops {
    pub(crate) fits: Vec<OtherBaseline>,
    /// So many of them, the first, are rivals of what has a name.
    n_rivals: usize,
    /// True if all are searched for all that is missing, and not only the rivals as such.
    goes_on: bool,
}

impl Loops {
    /// No other loop, and no more than one effect.
    const NONE: Self = Self {
        fits: Vec::new(),
        n_rivals: 0,
        goes_on: false,
    };
}

impl<'c> Survey<'c> {
    /// The models of the paper's loop with one effect at most. `blocks` are those of the case.
    pub(crate) fn begun(
        case: &'c Case<'c>,
        blocks: &'c [Block],
        catalogue: CandidateSet,
        config: &'c DiagnoseConfig,
    ) -> Result<Self, IdentifyError> {
        let noise = measured(case.training, case.fit.tau_s());
        let search = with_one(case, catalogue, &noise, config.seed)?;
        Ok(Self {
            case,
            catalogue,
            noise,
            config,
            completing: Completing::new(blocks, config.seed),
            searches: vec![search],
        })
    }

    /// The loops that are to be searched beside the paper's. `stand_ins` are fitted because the paper's loop has no single minimum; else
    /// there are none.
    ///
    /// A loop of another family bends what is found of the rest: it comes before more effects do. Where not even a curve on top of the
    /// paper's loop describes the output, neither does another loop, nor do more effects.
    pub(crate) fn loops(&mut self, stand_ins: Vec<OtherBaseline>) -> Result<Loops, IdentifyError> {
        let stands_in = !stand_ins.is_empty();
        let mut fits = stand_ins;
        let searched = (self.config.effort, self.config.seed);
        let mut formulas = Vec::new();
        if !stands_in {
            let population = self.completing.audited(&self.searches)?;
            // Any loop is near to any other beside an output that none describes.
            if !is_described(&population, self.case.output_squares()) {
                return Ok(Loops::NONE);
            }
            if self.catalogue.contains(Candidate::other_loop())
                && (self.searches[0].is_misfit() || is_anything(&population))
                && !self.case.leaves_out(Part::OtherLoops)
            {
                formulas = families::formulas(self.case, self.config.seed)?;
                fits = families::shaped(self.case, formulas.clone(), Near::Nearer, searched)?;
            }
        }
        let mut goes_on =
            self.is_thorough(&fits) || stands_in || families::is_another(&fits, &self.searches[0]);
        let mut n_rivals = fits.len();
        if !goes_on {
            // More effects than one are worth their search where a curve finds more than one has.
            let population = self.completing.completed(&mut self.searches)?;
            goes_on = may_be_the_loop(&population);
            let named = self.searches[0].get(leading(&population).names);
            n_rivals = families::rivals(&fits, named);
            if self.searches[0].is_misfit() {
                let is_there = |family| fits.iter().any(|fit| fit.family == family);
                formulas.retain(|formula| !is_there(formula.family));
                let further = families::shaped(self.case, formulas, Near::About, searched)?;
                fits.extend(further);
            } else if !goes_on {
                fits.truncate(n_rivals);
            }
        }
        Ok(Loops {
            fits,
            n_rivals,
            goes_on,
        })
    }

    /// Searches beside these loops, too; `cases` are the rig with each of them.
    pub(crate) fn go_on(
        &mut self,
        cases: &'c [Case<'c>],
        loops: &Loops,
    ) -> Result<(), IdentifyError> {
        for case in cases {
            let beside = families::beside(case.setting.loop_family, self.catalogue);
            let search = with_one(case, beside, &self.noise, self.config.seed)?;
            self.searches.push(search);
        }
        if !loops.goes_on && !families::is_far_nearer(&self.searches) {
            self.searches.truncate(1 + loops.n_rivals);
            return Ok(());
        }
        // Where a loop leaves nothing that a curve finds, and no more than noise, by itself or with one effect, more effects are in vain;
        // and where not even a curve describes the output.
        let population = self.completing.audited(&self.searches)?;
        let is_in_vain = leading(&population).is_whole()
            && !self.searches.iter().all(Search::is_misfit)
            || !is_described(&population, self.case.output_squares());
        if self.is_thorough(&loops.fits) || !is_in_vain {
            grow(&mut self.searches, &mut self.completing)?;
        }
        self.completing.completed(&mut self.searches)?;
        Ok(())
    }

    fn is_thorough(&self, fits: &[OtherBaseline]) -> bool {
        self.config.effort == Effort::Thorough && !fits.is_empty()
    }
}

/// The models of a case with one effect at most.
fn with_one<'c>(
    case: &'c Case<'c>,
    catalogue: CandidateSet,
    noise: &Measured,
    seed: u64,
) -> Result<Search<'c>, IdentifyError> {
    let mut search = Search::new(case, case.baseline()?, catalogue, noise.highest(), seed)?;
    search.grow_by_one()?;
    Ok(search)
}
