use wiener::hysteresis::{Hysteresis, Memory};

use crate::effect::{Base, Before, Effect, Mapped, Trial, ZoneStart, without_memory_of_the_rod};
use crate::info::{Belongs, EffectBlock, EffectInfo, Occurrence, Presence, Smoothness};
use crate::{EffectId, EffectParameter, EffectValues};

parameters! {
    /// Part of the rod remembers reversals by the other rule.
    ///
    /// ```text
    /// ξ = (1 - w) ξ_rule + w ξ_other
    /// last reversal [Sadeghi, eqs 4-12], nested with wiping-out [Madelung1905]
    /// ```
    ///
    /// The rule is that of the setting, the other one the one it is not. Both operators see the same
    /// temperature, so they differ only after inner reversals.
    ReturnPointMemory {
        /// Share of the rod with the other rule w; 0 to 1.
        return_point_share: EffectParameter::size("1", 0.5, [0.0, 1.0])
            // The rod remembers by the other rule alone.
            .up_to_an_end(),
    }
}

pub(super) const INFO: EffectInfo = EffectInfo {
    id: "return-point-memory",
    name: "memory of inner reversals",
    block: EffectBlock::Transformation,
    flexible: false,
    smoothness: Smoothness::Smooth,
    needs: &[],
    parameters: PARAMETERS,
    equation: "ξ = (1 - w) ξ_rule + w ξ_other,  last reversal or all that enclose the loop",
    sentence: "{value} of the rod remembers inner reversals by another rule than assumed",
    belongs_to: Belongs::Rig,
    presence: Presence::Seldom,
    acts_like: &[],
    needs_in_recording: &[Occurrence::InnerReversals],
    like_loop: true,
    ..EffectInfo::ORDINARY
};

#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Lanes<const L: usize> {
    share: [f64; L],
    other: Option<Box<Hysteresis<L>>>,
}

impl<const L: usize> Effect<L> for Lanes<L> {
    without_memory_of_the_rod!();
    const STANDS_IN_ZONE: bool = true;
    /// Boxed: it is large, and most plants do without.
    type Zone = Option<Box<Memory<L>>>;
    const CHANGES_FRACTION: bool = true;

    fn new(values: &[EffectValues; L], base: &Base<'_, L>) -> Self {
        let active = base.setting.active.contains(EffectId::ReturnPointMemory);
        Self {
            share: values
                .each_ref()
                .map(|lane| lane.return_point_memory.return_point_share),
            other: active.then(|| Box::new(base.other_memory)),
        }
    }

    fn zone(&self, start: &ZoneStart<L>) -> Self::Zone {
        self.other.as_ref().map(|other| {
            let memory =
                other.since_reversal(start.driving_degc, start.share, start.since_reversal_k);
            Box::new(memory)
        })
    }

    #[inline(always)]
    fn fraction(&self, zone: &Self::Zone, driving_degc: &[f64; L], mapped: &mut Mapped<L>) {
        if let (Some(other), Some(memory)) = (&self.other, zone) {
            let sensed = other.peek(memory, *driving_degc);
            for l in 0..L {
                let difference = sensed.fraction[l] - mapped.fraction[l];
                mapped.fraction[l] += self.share[l] * difference;
                let difference_per_k = sensed.slope_per_k[l] - mapped.slope_per_k[l];
                mapped.slope_per_k[l] += self.share[l] * difference_per_k;
            }
        }
    }

    #[inline(always)]
    fn commit(&self, zone: &mut Self::Zone, _: &Before<L>, to: &Trial<L>) {
        if let (Some(other), Some(memory)) = (&self.other, zone) {
            let _fraction = other.commit(memory, to.driving_degc);
        }
    }
}
