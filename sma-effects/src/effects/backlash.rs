use crate::EffectValues;
use crate::effect::{Base, Effect, Moment, Seen, without_memory_in_zones};
use crate::info::{EffectBlock, EffectInfo, EffectParameter, Smoothness};
use crate::play::{play, play_at};

parameters! {
    /// Play between rod and sensor, or friction against a spring: after a reversal the output waits.
    ///
    /// ```text
    /// z = max(y - g/2, min(y + g/2, z_0)),   g = ψ |gain|
    /// ```
    ///
    /// A slider with the friction F_c on a spring k is the same operator with g = 2 F_c/k. At the start the
    /// output stands as after a long way along the branch that the rod came on. The width is a share of the
    /// stroke, so that gain and offset of the model stay linear.
    Backlash {
        /// Width of the play over the stroke ψ; 0 to 0.3.
        backlash_share: EffectParameter::size("of the stroke", 0.015, [0.0, 0.3])
            .unchecked([0.005, 0.03], "linkages and bearings"),
    }
}

pub(super) const INFO: EffectInfo = EffectInfo {
    id: "backlash",
    name: "backlash or friction",
    block: EffectBlock::Displacement,
    flexible: false,
    smoothness: Smoothness::CornersAtReversals,
    needs: &[],
    parameters: PARAMETERS,
    sentence: "after each reversal the output waits for {value}",
};

#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Lanes<const L: usize> {
    half_width: [f64; L],
    falls_on_heating: [bool; L],
}

impl<const L: usize> Effect<L> for Lanes<L> {
    without_memory_in_zones!();
    type Rod = [f64; L];
    const SHOWS: bool = true;

    fn new(values: &[EffectValues; L], base: &Base<'_, L>) -> Self {
        let mut half_width = [0.0; L];
        for l in 0..L {
            half_width[l] = 0.5 * values[l].backlash.backlash_share * base.params[l].gain.abs();
        }
        Self {
            half_width,
            falls_on_heating: base.params.map(|lane| lane.gain < 0.0),
        }
    }

    fn rod(&self) -> [f64; L] {
        [0.0; L]
    }

    #[inline(always)]
    fn displacement(
        &self,
        rod: &mut [f64; L],
        _: &Moment,
        _: &Seen<L>,
        displacement: &mut [f64; L],
    ) {
        for l in 0..L {
            rod[l] = play(rod[l], displacement[l], self.half_width[l]);
        }
        *displacement = *rod;
    }

    fn settle(
        &self,
        rod: &mut [f64; L],
        _: &Moment,
        _: &Seen<L>,
        share: &[f64; L],
        displacement: &mut [f64; L],
    ) {
        for l in 0..L {
            let fallen = if self.falls_on_heating[l] {
                1.0 - share[l]
            } else {
                share[l]
            };
            rod[l] = play_at(displacement[l], self.half_width[l], fallen);
        }
        *displacement = *rod;
    }
}
