use crate::EffectValues;
use crate::effect::{Base, Effect, Moment, without_memory};
use crate::info::{EffectBlock, EffectInfo, EffectParameter, Need, Smoothness};
use crate::knots::Knots;

const fn knot() -> EffectParameter {
    EffectParameter::size("K", 2.0, [-15.0, 15.0]).unchecked([1.0, 5.0], "rooms over a day")
}

parameters! {
    /// The surroundings become warmer or colder during the run.
    ///
    /// ```text
    /// T_a(t) = T_a + v(s),   v of degree 4 through knots at s = ¼, ½, ¾, 1,   v(0) = 0
    /// s = (start + t)/run length
    /// ```
    ///
    /// A flexible shape, since real drifts are not straight: it follows any slow change. The sample takes
    /// the drift in its middle.
    AmbientDrift {
        /// Change of the ambient temperature after a quarter of the run, K; -15 to 15.
        ambient_drift_1_k: knot(),
        /// After half of the run, K; -15 to 15.
        ambient_drift_2_k: knot(),
        /// After three quarters of the run, K; -15 to 15.
        ambient_drift_3_k: knot(),
        /// At the end of the run, K; -15 to 15.
        ambient_drift_4_k: knot(),
    }
}

pub(super) const INFO: EffectInfo = EffectInfo {
    id: "ambient-drift",
    name: "drift of the ambient temperature",
    block: EffectBlock::HeatBalance,
    flexible: true,
    smoothness: Smoothness::Smooth,
    needs: &[Need::RunLength],
    parameters: PARAMETERS,
    equation: "T_a(t) = T_a + v(t),  v smooth through four values",
    sentence: "the surroundings drift by up to {value} during the run",
};

#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Lanes<const L: usize> {
    knots: Knots<L>,
}

impl<const L: usize> Effect<L> for Lanes<L> {
    without_memory!();
    const CHANGES_AMBIENT: bool = true;

    fn new(values: &[EffectValues; L], _: &Base<'_, L>) -> Self {
        Self {
            knots: Knots {
                value: [
                    values.map(|lane| lane.ambient_drift.ambient_drift_1_k),
                    values.map(|lane| lane.ambient_drift.ambient_drift_2_k),
                    values.map(|lane| lane.ambient_drift.ambient_drift_3_k),
                    values.map(|lane| lane.ambient_drift.ambient_drift_4_k),
                ],
            },
        }
    }

    #[inline(always)]
    fn ambient(&self, moment: &Moment, ambient_degc: &mut [f64; L]) {
        self.knots.add(moment.run_share_middle, ambient_degc);
    }
}
