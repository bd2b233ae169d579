use crate::effect::{Base, Effect, Moment, Seen, without_memory};
use crate::info::{Belongs, EffectBlock, EffectInfo, Presence, Smoothness};
use crate::{EffectParameter, EffectValues};

parameters! {
    /// The moving part runs into a stop.
    ///
    /// ```text
    /// u = sign(gain) (y - offset)/|gain|     place in the stroke
    /// y' = y - b gain max(0, u - u_s)
    /// ```
    ///
    /// b = 1 is a hard stop, y' = min(y, y_s); less is a soft one. The output is linear in b, so its
    /// column of sensitivity, max(0, u - u_s), is that of the hard stop; it is zero in a run that does
    /// not reach u_s.
    EndStop {
        /// Share of the movement beyond the stop that it holds back b; 0 to 1. A contact less stiff than the rod, b < ½, is
        /// no stop.
        end_stop_share: EffectParameter::size("1", 1.0, [0.0, 1.0])
            .at_least(0.5)
            // A hard stop.
            .up_to_an_end(),
        /// Place of the stop in the stroke u_s; 0.05 to 1. A partner: where nothing is held back it does
        /// nothing.
        end_stop_position: EffectParameter::partner("1", 0.85, [0.05, 1.0], &[0.5, 0.6, 0.7, 0.8, 0.85, 0.9, 0.95]),
    }
}

pub(super) const INFO: EffectInfo = EffectInfo {
    id: "end-stop",
    name: "end stop",
    block: EffectBlock::Displacement,
    flexible: false,
    smoothness: Smoothness::Smooth,
    needs: &[],
    parameters: PARAMETERS,
    equation: "y' = y - b gain max(0, u - u_s),  u the place in the stroke",
    sentence: "a stop at {partner} of the stroke holds back {value} of what lies beyond",
    belongs_to: Belongs::Rig,
    presence: Presence::Seldom,
    acts_like: &[],
    needs_in_recording: &[],
    like_loop: true,
    ..EffectInfo::ORDINARY
};

#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Lanes<const L: usize> {
    share: [f64; L],
    /// u_s |gain|.
    stop: [f64; L],
    /// sign(gain).
    sign: [f64; L],
    offset: [f64; L],
}

impl<const L: usize> Effect<L> for Lanes<L> {
    without_memory!();
    const SHOWS: bool = true;

    fn new(values: &[EffectValues; L], base: &Base<'_, L>) -> Self {
        let mut stop = [0.0; L];
        for l in 0..L {
            stop[l] = values[l].end_stop.end_stop_position * base.params[l].gain.abs();
        }
        Self {
            share: values.each_ref().map(|lane| lane.end_stop.end_stop_share),
            stop,
            sign: base.params.each_ref().map(|lane| 1f64.copysign(lane.gain)),
            offset: base.params.each_ref().map(|lane| lane.offset),
        }
    }

    #[inline(always)]
    fn displacement(&self, _: &mut (), _: &Moment, _: &Seen<L>, displacement: &mut [f64; L]) {
        for l in 0..L {
            let beyond = self.sign[l] * (displacement[l] - self.offset[l]) - self.stop[l];
            let beyond = if beyond > 0.0 { beyond } else { 0.0 };
            displacement[l] -= self.share[l] * (self.sign[l] * beyond);
        }
    }
}
