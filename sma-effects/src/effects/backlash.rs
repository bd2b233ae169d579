use crate::effect::{Base, Effect, Moment, Seen, without_memory_in_zones};
use crate::elementary::expm1;
use crate::info::{Belongs, EffectBlock, EffectInfo, Occurrence, Presence, Smoothness};
use crate::play::play_at;
use crate::{EffectParameter, EffectValues};

parameters! {
    /// Play between rod and sensor, or friction against a spring: after a reversal the output lags.
    ///
    /// ```text
    /// z = y - w u,   w = ψ |gain|/2,   du/d|y| = min(1, (1 - u)/q)/w        u toward the movement, -1 to 1
    /// ```
    ///
    /// With q = 0 it waits and then follows at once: a play, and just as well a slider with the friction F_c on a spring
    /// k, w = F_c/k. With q it comes after ever more, as friction does whose contacts give way before they slide
    /// (Dahl's, from q = 2 in all of the way). At the start u = 1 - s: s = 0 as after a long way along the branch that the
    /// rod came on, 1 without a force. The width is a share of the stroke, so that gain and offset of the model stay
    /// linear.
    Backlash {
        /// Width of the play over the stroke ψ; 0 to 0.3.
        backlash_share: EffectParameter::size("of the stroke", 0.015, [0.0, 0.3])
            .unchecked([0.005, 0.03], "linkages and bearings"),
        /// Over how many half widths the output catches up q; 0 (a play) to 5. A partner: without a width it does
        /// nothing.
        backlash_softness: EffectParameter::partner("half widths", 0.0, [0.0, 5.0], &[0.0, 0.5, 1.0, 2.0, 4.0]),
        /// How far it had come back at the start s; 0 to 2. A partner: without a width it does nothing.
        backlash_relaxed: EffectParameter::partner("half widths", 0.0, [0.0, 2.0], &[])
            // The other side of the play.
            .up_to_an_end(),
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
    equation: "z = y - w u,  du/d|y| = min(1, (1 - u)/q)/w,  -1 ≤ u ≤ 1",
    sentence: "after each reversal the output lags by {value}, and catches up over {partner}",
    belongs_to: Belongs::Rig,
    presence: Presence::Seldom,
    acts_like: &[],
    needs_in_recording: &[Occurrence::Reversal],
    like_loop: true,
    ..EffectInfo::ORDINARY
};

/// Below it, a play: keeps a quotient finite.
const SMALLEST_SOFTNESS: f64 = 1e-6;

/// Ways beyond it, in units of the softness, are a long way.
const LONG_WAY: f64 = 700.0;

#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Lanes<const L: usize> {
    half_width: [f64; L],
    /// 1/w; 0 without a width.
    per_half_width: [f64; L],
    softness: [f64; L],
    relaxed: [f64; L],
    falls_on_heating: [bool; L],
}

/// Where driving and driven side stand.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Coupling<const L: usize> {
    driver: [f64; L],
    driven: [f64; L],
}

impl<const L: usize> Effect<L> for Lanes<L> {
    without_memory_in_zones!();
    type Rod = Coupling<L>;
    const SHOWS: bool = true;

    fn new(values: &[EffectValues; L], base: &Base<'_, L>) -> Self {
        let mut half_width = [0.0; L];
        for l in 0..L {
            half_width[l] = 0.5 * values[l].backlash.backlash_share * base.params[l].gain.abs();
        }
        Self {
            per_half_width: half_width.map(|width| if width > 0.0 { 1.0 / width } else { 0.0 }),
            half_width,
            softness: values
                .each_ref()
                .map(|lane| lane.backlash.backlash_softness),
            relaxed: values.each_ref().map(|lane| lane.backlash.backlash_relaxed),
            falls_on_heating: base.params.each_ref().map(|lane| lane.gain < 0.0),
        }
    }

    fn rod(&self) -> Coupling<L> {
        Coupling {
            driver: [0.0; L],
            driven: [0.0; L],
        }
    }

    #[inline(always)]
    fn displacement(
        &self,
        rod: &mut Coupling<L>,
        _: &Moment,
        _: &Seen<L>,
        displacement: &mut [f64; L],
    ) {
        for l in 0..L {
            let way = displacement[l] - rod.driver[l];
            let sign = if way < 0.0 { -1.0 } else { 1.0 };
            let way = way.abs() * self.per_half_width[l];
            let lag = sign * (rod.driver[l] - rod.driven[l]) * self.per_half_width[l];
            // It waits until 1 - u = q, and then comes after.
            let waits = 1.0 - self.softness[l] - lag;
            let waits = if waits > 0.0 { waits } else { 0.0 };
            let waited = if way < waits { way } else { waits };
            let softness = if self.softness[l] > SMALLEST_SOFTNESS {
                self.softness[l]
            } else {
                SMALLEST_SOFTNESS
            };
            let rest = (way - waited) / softness;
            let rest = if rest < LONG_WAY { rest } else { LONG_WAY };
            let lag = lag + waited;
            let lag = lag - (1.0 - lag) * expm1(-rest);
            let follows = displacement[l] - self.half_width[l] * (sign * lag);
            let stays = self.half_width[l] > 0.0 && way < waits;
            rod.driven[l] = if stays { rod.driven[l] } else { follows };
            rod.driver[l] = displacement[l];
        }
        *displacement = rod.driven;
    }

    fn settle(
        &self,
        rod: &mut Coupling<L>,
        _: &Moment,
        _: &Seen<L>,
        share: &[f64; L],
        displacement: &mut [f64; L],
    ) {
        rod.driver = *displacement;
        for l in 0..L {
            let fallen = if self.falls_on_heating[l] {
                1.0 - share[l]
            } else {
                share[l]
            };
            let relaxed = fallen + self.relaxed[l] * (0.5 - fallen);
            rod.driven[l] = play_at(displacement[l], self.half_width[l], relaxed);
        }
        *displacement = rod.driven;
    }
}
