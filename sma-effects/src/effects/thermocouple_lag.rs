use crate::effect::{Base, Effect, without_memory_in_zones};
use crate::info::{Belongs, EffectBlock, EffectInfo, Need, Presence, Smoothness};
use crate::lag::Lag;
use crate::{EffectParameter, EffectValues};

parameters! {
    /// The recorded temperature follows that of the rod with a time constant, and stays below it: what the rod heats
    /// through a contact the air cools.
    ///
    /// ```text
    /// dT'/dt = (T - T')/θ - g (T' - T_a)     so that T' is late by θ/(1 + θg), and low by the share θg/(1 + θg)
    /// ```
    ///
    /// Exact for a temperature whose course within a sample is a parabola, through its middle. The displacement does not
    /// change.
    ThermocoupleLag {
        /// Time constant θ, s; 0 to 30.
        thermocouple_lag_s: EffectParameter::size("s", 0.5, [0.0, 30.0])
            .unchecked([0.05, 10.0], "data sheets: beads of 0.1 to 1 mm, from water to still air"),
        /// Rate at which the air alone would cool it g, 1/s; 0 to 0.5. A partner: without a lag it does nothing.
        bead_cooling_per_s: EffectParameter::partner("1/s", 0.02, [0.0, 0.5], &[0.0, 0.01, 0.02, 0.05, 0.1]),
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
    equation: "dT'/dt = (T - T')/θ - g (T' - T_a)",
    sentence: "the thermocouple follows the rod with a time constant of {value}",
    belongs_to: Belongs::Rig,
    presence: Presence::Seldom,
    acts_like: &[],
    needs_in_recording: &[],
    ..EffectInfo::ORDINARY
};

#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Lanes<const L: usize> {
    /// θ/(1 + θg).
    lag_s: [f64; L],
    /// θg/(1 + θg).
    low: [f64; L],
}

impl<const L: usize> Effect<L> for Lanes<L> {
    without_memory_in_zones!();
    type Rod = Lag<L>;
    const WANTS_MIDDLE: bool = true;
    const RECORDS: bool = true;

    fn new(values: &[EffectValues; L], _: &Base<'_, L>) -> Self {
        let contact = values.each_ref().map(|lane| lane.thermocouple_lag);
        let leak = contact.map(|lane| lane.thermocouple_lag_s * lane.bead_cooling_per_s);
        Self {
            lag_s: core::array::from_fn(|l| contact[l].thermocouple_lag_s / (1.0 + leak[l])),
            low: leak.map(|leak| leak / (1.0 + leak)),
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
        ambient_degc: &[f64; L],
        temperature_degc: &mut [f64; L],
    ) {
        let mut middle_degc = *middle_degc;
        for l in 0..L {
            middle_degc[l] -= self.low[l] * (middle_degc[l] - ambient_degc[l]);
            temperature_degc[l] -= self.low[l] * (temperature_degc[l] - ambient_degc[l]);
        }
        rod.follow(&middle_degc, temperature_degc);
    }

    fn settle_temperature(&self, rod: &mut Lag<L>, temperature_degc: &mut [f64; L]) {
        rod.settle(temperature_degc);
    }
}
