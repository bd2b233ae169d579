use crate::effect::{Base, Effect, Moment, without_memory};
use crate::info::{ActsAs, Belongs, EffectBlock, EffectInfo, Need, Presence, Smoothness};
use crate::spline::Spline;
use crate::{EffectId, EffectParameter, EffectValues};

/// Knots after the start.
const KNOTS: usize = 8;

const fn knot() -> EffectParameter {
    EffectParameter::size("K", 2.0, [-15.0, 15.0])
        .unchecked([1.0, 5.0], "rooms over a day")
        .scaled_by_heat(-1)
}

parameters! {
    /// The surroundings become warmer or colder during the run.
    ///
    /// ```text
    /// T_a(t) = T_a + v(s),   v smooth through knots at s = ⅛, ¼, … 1,   v(0) = 0
    /// s = (start + t)/run length
    /// ```
    ///
    /// A flexible shape, since real drifts are not straight: it follows what is slower than some eighths of the run. The
    /// sample takes the drift in its middle.
    AmbientDrift {
        /// Change of the ambient temperature after an eighth of the run, K; -15 to 15.
        ambient_drift_1_k: knot(),
        /// After a quarter of the run, K; -15 to 15.
        ambient_drift_2_k: knot(),
        /// After three eighths of the run, K; -15 to 15.
        ambient_drift_3_k: knot(),
        /// After half of the run, K; -15 to 15.
        ambient_drift_4_k: knot(),
        /// After five eighths of the run, K; -15 to 15.
        ambient_drift_5_k: knot(),
        /// After three quarters of the run, K; -15 to 15.
        ambient_drift_6_k: knot(),
        /// After seven eighths of the run, K; -15 to 15.
        ambient_drift_7_k: knot(),
        /// At the end of the run, K; -15 to 15.
        ambient_drift_8_k: knot(),
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
    equation: "T_a(t) = T_a + v(t),  v smooth through eight values",
    sentence: "the surroundings drift by up to {value} during the run",
    belongs_to: Belongs::Recording,
    presence: Presence::Seldom,
    acts_like: &[EffectId::FunctionalFatigue],
    needs_in_recording: &[],
    settled_by_ambient_record: true,
    // Warmer surroundings are as a loop that lies lower.
    mean_acts_as: Some(ActsAs {
        parameter: "loop_center_degc",
        per_unit: -1.0,
    }),
    ..EffectInfo::ORDINARY
};

#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Lanes<const L: usize> {
    spline: Spline<L, KNOTS>,
}

impl<const L: usize> Effect<L> for Lanes<L> {
    without_memory!();
    const CHANGES_AMBIENT: bool = true;

    fn new(values: &[EffectValues; L], _: &Base<'_, L>) -> Self {
        let mut value = [[0.0; L]; KNOTS];
        for (l, lane) in values.iter().enumerate() {
            let AmbientDrift {
                ambient_drift_1_k: v1,
                ambient_drift_2_k: v2,
                ambient_drift_3_k: v3,
                ambient_drift_4_k: v4,
                ambient_drift_5_k: v5,
                ambient_drift_6_k: v6,
                ambient_drift_7_k: v7,
                ambient_drift_8_k: v8,
            } = lane.ambient_drift;
            for (knot, v) in value.iter_mut().zip([v1, v2, v3, v4, v5, v6, v7, v8]) {
                knot[l] = v;
            }
        }
        Self {
            spline: Spline { value },
        }
    }

    #[inline(always)]
    fn ambient(&self, moment: &Moment, ambient_degc: &mut [f64; L]) {
        self.spline.add(moment.run_share_middle, ambient_degc);
    }
}
