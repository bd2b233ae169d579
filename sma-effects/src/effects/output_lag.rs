use crate::effect::{Base, Effect, Instant, Moment, Seen, without_memory_in_zones};
use crate::info::{Belongs, EffectBlock, EffectInfo, Presence, Smoothness};
use crate::lag::Lag;
use crate::{EffectId, EffectParameter, EffectValues};

parameters! {
    /// The mechanics or the filter of the sensor follow the rod with a time constant.
    ///
    /// ```text
    /// θ dy'/dt + y' = y
    /// ```
    ///
    /// Exact for a displacement whose course within a sample is a parabola; the hysteresis is asked for its
    /// middle. At the start it is still.
    OutputLag {
        /// Time constant θ, s; 0 to 5.
        output_lag_s: EffectParameter::size("s", 0.1, [0.0, 5.0])
            .unchecked([0.01, 0.2], "mechanics and filters"),
    }
}

pub(super) const INFO: EffectInfo = EffectInfo {
    id: "output-lag",
    name: "lag of the output",
    block: EffectBlock::Displacement,
    flexible: false,
    smoothness: Smoothness::Smooth,
    needs: &[],
    parameters: PARAMETERS,
    equation: "θ dy'/dt + y' = y",
    sentence: "the output follows the rod with a time constant of {value}",
    belongs_to: Belongs::Rig,
    presence: Presence::Seldom,
    acts_like: &[EffectId::SupplyLag, EffectId::DeadTime],
    needs_in_recording: &[],
    ..EffectInfo::ORDINARY
};

#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Lanes<const L: usize> {
    lag_s: [f64; L],
}

/// Lag of the displacement, and the displacement in the middle of the sample, which it passed last.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Following<const L: usize> {
    lag: Lag<L>,
    middle: [f64; L],
}

impl<const L: usize> Effect<L> for Lanes<L> {
    without_memory_in_zones!();
    type Rod = Following<L>;
    const WANTS_MIDDLE: bool = true;
    const SHOWS: bool = true;

    fn new(values: &[EffectValues; L], _: &Base<'_, L>) -> Self {
        Self {
            lag_s: values.each_ref().map(|lane| lane.output_lag.output_lag_s),
        }
    }

    fn rod(&self) -> Following<L> {
        Following {
            lag: Lag::still(),
            middle: [0.0; L],
        }
    }

    fn over(&self, rod: &mut Following<L>, dt_s: f64) {
        rod.lag.over(&self.lag_s, dt_s);
    }

    #[inline(always)]
    fn displacement(
        &self,
        rod: &mut Following<L>,
        _: &Moment,
        seen: &Seen<L>,
        displacement: &mut [f64; L],
    ) {
        match seen.instant {
            Instant::Turn => {}
            Instant::Middle => rod.middle = *displacement,
            Instant::End => rod.lag.follow(&rod.middle, displacement),
        }
    }

    fn settle(
        &self,
        rod: &mut Following<L>,
        _: &Moment,
        _: &Seen<L>,
        _: &[f64; L],
        displacement: &mut [f64; L],
    ) {
        rod.lag.settle(displacement);
    }
}
