use crate::effect::{Base, Effect, Moment, Seen, without_memory};
use crate::info::{Belongs, EffectBlock, EffectInfo, Presence, Smoothness};
use crate::{EffectParameter, EffectValues};

const fn coefficient() -> EffectParameter {
    EffectParameter::size("of the stroke", 0.003, [-0.1, 0.1]).unchecked(
        [0.0005, 0.005],
        "data sheets of displacement sensors: 0.05 to 0.5 % of full scale",
    )
}

parameters! {
    /// The sensor's scale is bent.
    ///
    /// ```text
    /// u = (y - offset)/gain
    /// y' = y + gain u(1 - u)(4 c_2 + 6√3 c_3 (1 - 2u))
    /// ```
    ///
    /// Zero at both ends of the stroke, which gain and offset fit. c_2 is the error in the middle of the
    /// stroke, c_3 the largest of the S-shaped part, both over the stroke. A function of the output alone:
    /// without gauge blocks it is not to be told from another shape of the loop.
    SensorNonlinearity {
        /// Quadratic part c_2, a share of the stroke; -0.1 to 0.1.
        sensor_nonlinearity_quadratic: coefficient(),
        /// Cubic part c_3, a share of the stroke; -0.1 to 0.1.
        sensor_nonlinearity_cubic: coefficient(),
    }
}

pub(super) const INFO: EffectInfo = EffectInfo {
    id: "sensor-nonlinearity",
    name: "nonlinearity of the sensor",
    block: EffectBlock::Displacement,
    flexible: false,
    smoothness: Smoothness::Smooth,
    needs: &[],
    parameters: PARAMETERS,
    equation: "y' = y + gain u (1 - u)(4 c_2 + 6√3 c_3 (1 - 2u)),  u the place in the stroke",
    sentence: "the displacement sensor is off by up to {value}",
    belongs_to: Belongs::Rig,
    presence: Presence::Seldom,
    acts_like: &[],
    needs_in_recording: &[],
    like_loop: true,
    ..EffectInfo::ORDINARY
};

#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Lanes<const L: usize> {
    /// 4 c_2 gain, 6√3 c_3 gain.
    quadratic: [f64; L],
    cubic: [f64; L],
    offset: [f64; L],
    /// 1/gain, 0 for no gain: nothing moves then.
    per_stroke: [f64; L],
}

impl<const L: usize> Effect<L> for Lanes<L> {
    without_memory!();
    const SHOWS: bool = true;

    fn new(values: &[EffectValues; L], base: &Base<'_, L>) -> Self {
        let six_root_three = 6.0 * 3f64.sqrt();
        let mut lanes = Self {
            quadratic: [0.0; L],
            cubic: [0.0; L],
            offset: base.params.each_ref().map(|lane| lane.offset),
            per_stroke: [0.0; L],
        };
        for l in 0..L {
            let gain = base.params[l].gain;
            let bent = &values[l].sensor_nonlinearity;
            lanes.quadratic[l] = 4.0 * bent.sensor_nonlinearity_quadratic * gain;
            lanes.cubic[l] = six_root_three * bent.sensor_nonlinearity_cubic * gain;
            lanes.per_stroke[l] = if gain.abs() > 0.0 { 1.0 / gain } else { 0.0 };
        }
        lanes
    }

    #[inline(always)]
    fn displacement(&self, _: &mut (), _: &Moment, _: &Seen<L>, displacement: &mut [f64; L]) {
        for l in 0..L {
            let u = (displacement[l] - self.offset[l]) * self.per_stroke[l];
            displacement[l] +=
                u * (1.0 - u) * (self.quadratic[l] + self.cubic[l] * (1.0 - 2.0 * u));
        }
    }
}
