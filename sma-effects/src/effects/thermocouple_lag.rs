use crate::EffectValues;
use crate::effect::{Base, Effect, without_memory_in_zones};
use crate::info::{EffectBlock, EffectInfo, EffectParameter, Need, Smoothness};
use crate::lag::Lag;

parameters! {
    /// The recorded temperature follows that of the rod with a time constant.
    ///
    /// ```text
    /// θ dT'/dt + T' = T
    /// ```
    ///
    /// Exact for a temperature whose course within a sample is a parabola, through its middle. The displacement does not
    /// change.
    ThermocoupleLag {
        /// Time constant θ, s; 0 to 30.
        thermocouple_lag_s: EffectParameter::size("s", 0.5, [0.0, 30.0]),
    }
}

pub(super) const INFO: EffectInfo = EffectInfo {
    id: "thermocouple-lag",
    name: "lag of the thermocouple",
    block: EffectBlock::Sensor,
    flexible: false,
    smoothness: Smoothness::Smooth,
    needs: &[Need::TemperatureChannel],
    parameters: PARAMETERS,
    sentence: "the thermocouple follows the rod with a time constant of {value}",
};

#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Lanes<const L: usize> {
    lag_s: [f64; L],
}

impl<const L: usize> Effect<L> for Lanes<L> {
    without_memory_in_zones!();
    type Rod = Lag<L>;
    const WANTS_MIDDLE: bool = true;
    const RECORDS: bool = true;

    fn new(values: &[EffectValues; L], _: &Base<'_, L>) -> Self {
        Self {
            lag_s: values.map(|lane| lane.thermocouple_lag.thermocouple_lag_s),
        }
    }

    fn rod(&self) -> Lag<L> {
        Lag::still()
    }

    fn over(&self, rod: &mut Lag<L>, dt_s: f64) {
        rod.over(&self.lag_s, dt_s);
    }

    #[inline(always)]
    fn temperature(
        &self,
        rod: &mut Lag<L>,
        middle_degc: &[f64; L],
        temperature_degc: &mut [f64; L],
    ) {
        rod.follow(middle_degc, temperature_degc);
    }

    fn settle_temperature(&self, rod: &mut Lag<L>, temperature_degc: &mut [f64; L]) {
        rod.settle(temperature_degc);
    }
}
