use crate::effect::{Base, Effect, without_memory};
use crate::info::{Belongs, EffectBlock, EffectInfo, Occurrence, Presence, Smoothness};
use crate::{EffectParameter, EffectValues};

parameters! {
    /// The transformation takes a wider range of temperatures on cooling than on heating.
    ///
    /// ```text
    /// spread h_0 (1 - a) on heating, h_0 (1 + a) on cooling
    /// ```
    ///
    /// [`LimitingLoop::with_asymmetry`](wiener::hysteresis::LimitingLoop::with_asymmetry): branches after reversals
    /// near the one limiting curve or the other by the same proximity function.
    LoopAsymmetry {
        /// Relative difference of the spreads a; -0.8 to 0.8.
        loop_asymmetry: EffectParameter::size("1", 0.2, [-0.8, 0.8]),
    }
}

pub(super) const INFO: EffectInfo = EffectInfo {
    id: "loop-asymmetry",
    name: "asymmetry of heating and cooling",
    block: EffectBlock::Transformation,
    flexible: false,
    smoothness: Smoothness::Smooth,
    needs: &[],
    parameters: PARAMETERS,
    equation: "h_0 → h_0 (1 - a) on heating, h_0 (1 + a) on cooling",
    sentence: "the transformation is spread {value} wider on cooling, and as much narrower on heating, than assumed",
    belongs_to: Belongs::Rig,
    presence: Presence::Seldom,
    acts_like: &[],
    needs_in_recording: &[Occurrence::BothBranches],
    like_loop: true,
    ..EffectInfo::ORDINARY
};

/// Nothing is left to do in a sample: the loop itself has the asymmetry.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Lanes<const L: usize>;

impl<const L: usize> Effect<L> for Lanes<L> {
    without_memory!();

    fn new(_: &[EffectValues; L], _: &Base<'_, L>) -> Self {
        Self
    }
}
