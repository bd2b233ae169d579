use crate::effect::{Base, Effect, Moment, Seen, without_memory};
use crate::info::{Belongs, EffectBlock, EffectInfo, Need, Presence, Smoothness};
use crate::knots::Knots;
use crate::{EffectParameter, EffectValues};

const fn knot() -> EffectParameter {
    EffectParameter::size("of the stroke", 0.01, [-0.3, 0.3]).unchecked(
        [0.001, 0.02],
        "0.01 to 0.05 % of full scale per kelvin, over some kelvins",
    )
}

parameters! {
    /// The zero of the sensor moves during the run.
    ///
    /// ```text
    /// y' = y + |gain| v(s),   v of degree 4 through knots at s = ¼, ½, ¾, 1,   v(0) = 0
    /// s = (start + t)/run length
    /// ```
    ///
    /// A flexible shape. It shows at rest and in the cold as everywhere else.
    SensorDrift {
        /// Drift after a quarter of the run, a share of the stroke; -0.3 to 0.3.
        sensor_drift_1: knot(),
        /// After half of the run, a share of the stroke; -0.3 to 0.3.
        sensor_drift_2: knot(),
        /// After three quarters of the run, a share of the stroke; -0.3 to 0.3.
        sensor_drift_3: knot(),
        /// At the end of the run, a share of the stroke; -0.3 to 0.3.
        sensor_drift_4: knot(),
    }
}

pub(super) const INFO: EffectInfo = EffectInfo {
    id: "sensor-drift",
    name: "drift of the sensor",
    block: EffectBlock::Displacement,
    flexible: true,
    smoothness: Smoothness::Smooth,
    needs: &[Need::RunLength],
    parameters: PARAMETERS,
    equation: "y' = y + |gain| v(t),  v smooth through four values",
    sentence: "the sensor's zero drifts by up to {value} during the run",
    belongs_to: Belongs::Recording,
    presence: Presence::Seldom,
    acts_like: &[],
    needs_in_recording: &[],
    ..EffectInfo::ORDINARY
};

#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Lanes<const L: usize> {
    knots: Knots<L>,
}

impl<const L: usize> Effect<L> for Lanes<L> {
    without_memory!();
    const SHOWS: bool = true;

    fn new(values: &[EffectValues; L], base: &Base<'_, L>) -> Self {
        let mut value = [
            values
                .each_ref()
                .map(|lane| lane.sensor_drift.sensor_drift_1),
            values
                .each_ref()
                .map(|lane| lane.sensor_drift.sensor_drift_2),
            values
                .each_ref()
                .map(|lane| lane.sensor_drift.sensor_drift_3),
            values
                .each_ref()
                .map(|lane| lane.sensor_drift.sensor_drift_4),
        ];
        for knot in &mut value {
            for l in 0..L {
                knot[l] *= base.params[l].gain.abs();
            }
        }
        Self {
            knots: Knots { value },
        }
    }

    #[inline(always)]
    fn displacement(&self, _: &mut (), moment: &Moment, _: &Seen<L>, displacement: &mut [f64; L]) {
        self.knots.add(moment.run_share_end, displacement);
    }
}
