//! One loop, and what its search comes to.

use identify::IdentifyError;

use crate::case::{Case, Node};
use crate::choice::visited;
use crate::diagnosis::{Floor, NoiseClass, Verdict};
use crate::elsewhere::is_rigid;
use crate::floor::Measured;
use crate::judge::{Judged, LARGE, judge, without_effects};
use crate::names::Named;
use crate::prune::is_crowd;
use crate::search::Search;
use crate::slip::is_slip;
use crate::{CandidateSet, EffectId};

/// Factor by which a drift must lower the mean square to be told from noise with a memory, and any effect where that grows
/// toward low frequencies.
const LOWERED: f64 = 2.0;

/// Mean square over that of the noise at rest from which a law from cycle to cycle leaves too much to be it.
const MUCH: f64 = 5.0;

/// Factor by which no noise is lowered by a law.
const ALL: f64 = 30.0;

/// A search and what is said of it.
#[derive(Debug)]
pub(crate) struct Attempt<'a> {
    pub(crate) search: Search<'a>,
    pub(crate) judged: Judged,
    pub(crate) floor: Floor,
}

impl Attempt<'_> {
    /// The chosen model.
    pub(crate) fn chosen(&self) -> &Node {
        visited(&self.search, self.judged.effects)
    }
}

/// What all searches of a diagnosis have in common.
#[derive(Debug)]
pub(crate) struct Terms<'a> {
    pub(crate) noise: &'a Measured,
    pub(crate) tau_s: f64,
    /// What may be found.
    pub(crate) catalogue: CandidateSet,
    pub(crate) seed: u64,
}

impl Terms<'_> {
    /// The models of a case with one effect at most.
    pub(crate) fn begun<'c>(&self, case: &'c Case<'c>) -> Result<Search<'c>, IdentifyError> {
        let highest = self.noise.highest();
        let mut search = Search::new(case, case.baseline()?, self.catalogue, highest, self.seed)?;
        search.grow_by_one()?;
        Ok(search)
    }

    /// What they come to, and the noise.
    pub(crate) fn judged(&self, search: &mut Search<'_>) -> Result<(Judged, Floor), IdentifyError> {
        let judged = judge(search, self.noise, self.tau_s)?;
        let is_crowd = is_crowd(judged.named.iter().map(|named| named.effect));
        let best = visited(search, judged.effects);
        let slips = !judged.named.is_empty() && is_slip(search.case, best)?;
        let judged = if is_crowd || slips {
            judged.demoted(Verdict::Unexplained)
        } else {
            judged
        };
        Ok(licensed(search, judged, self.noise))
    }
}

/// What the noise lets be said of what was judged, and the noise.
fn licensed(search: &Search<'_>, judged: Judged, noise: &Measured) -> (Judged, Floor) {
    let plain = search.baseline();
    let best = search.get(judged.effects).unwrap_or(plain);
    let floor = noise.floor(search.case, best);
    let gained = plain.mean_square() - best.mean_square();
    // The zero of a sensor moves slowly and smoothly, a loop by the same law from cycle to cycle: what leaves noise that
    // grows toward low frequencies, or in the second case much of it, is not that, and repeated cycles do not tell noise
    // from what tells them apart. And whatever is flexible follows noise with a memory for a part of the way.
    let is_far = plain.mean_square() > LOWERED * best.mean_square();
    let leaves_much = best.mean_square() > MUCH * noise.gate;
    let is_all = plain.mean_square() > ALL * best.mean_square();
    // Nor does a smooth curve follow the surroundings all the way: that looks like such noise, too.
    let beside_ambient = (judged.named.iter()).any(|named| named.effect == EffectId::AmbientDrift);
    // What has a form of its own and halves the error is no noise: rigid effects lower noise by a few percent.
    let is_form = is_far && judged.named.iter().all(|named| is_rigid(named.effect));
    let may_be_noise = |named: &Named| match floor.class {
        NoiseClass::OneOverF => {
            (named.effect == EffectId::SensorDrift && !beside_ambient)
                || (named.effect == EffectId::FunctionalFatigue && leaves_much && !is_all)
        }
        NoiseClass::Colored => named.effect.info().flexible && !is_far,
        NoiseClass::White | NoiseClass::Quantized => false,
    };
    if judged.named.iter().any(may_be_noise) {
        let is_large = plain.mean_square() > LARGE * best.mean_square();
        let verdict = if is_large {
            Verdict::Unexplained
        } else {
            without_effects(search, noise, 1.0)
        };
        return (judged.demoted(verdict), floor);
    }
    if is_all || is_form || !noise.forbids(floor.class, gained) {
        return (judged, floor);
    }
    // In such noise tests cry wolf: only the size of the error tells.
    let verdict = without_effects(search, noise, 1.0);
    (judged.demoted(verdict), floor)
}
