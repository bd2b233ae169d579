//! The heat balance of a zone as far as it is linear.

use wiener::WienerError;
use wiener::thermal::{HeatBalance, HeatBalanceParams, Heating, Sample};

use crate::PhysicsError;
use crate::part::{Part, Stage, progress, unit};

/// The linear heat balance of a zone: that of the baseline.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(align(64))]
pub(crate) struct ZoneHeat<const L: usize> {
    pub(crate) balance: HeatBalance<L>,
    conductance_w_per_m_k: [f64; L],
    pub(crate) per_tau_s: [f64; L],
    /// 1/C, K m/J.
    pub(crate) per_capacity_k_m_per_j: [f64; L],
}

/// Response of a zone to a part of a sample, without heat beyond the baseline's.
#[derive(Debug)]
#[repr(align(64))]
pub(crate) struct Reference<const L: usize> {
    /// Temperature at its end, °C.
    pub(crate) end_degc: [f64; L],
    /// Rise of it per heat flow over the part, K m/W.
    pub(crate) sensitivity_k_m_per_w: [f64; L],
}

impl<const L: usize> ZoneHeat<L> {
    pub(crate) fn new(lanes: [HeatBalanceParams; L]) -> Result<Self, PhysicsError> {
        Ok(Self {
            balance: HeatBalance::new(lanes).map_err(WienerError::from)?,
            conductance_w_per_m_k: lanes.each_ref().map(|lane| lane.conductance_w_per_m_k),
            per_tau_s: lanes
                .each_ref()
                .map(|lane| lane.conductance_w_per_m_k / lane.heat_capacity_j_per_m_k),
            per_capacity_k_m_per_j: lanes
                .each_ref()
                .map(|lane| 1.0 / lane.heat_capacity_j_per_m_k),
        })
    }

    /// Heat loss of the baseline at a temperature, W/m; 0 below the temperature of the surroundings.
    #[inline(always)]
    pub(crate) fn lost(&self, temperature_degc: &[f64; L], ambient_degc: f64) -> [f64; L] {
        core::array::from_fn(|l| {
            let above_k = temperature_degc[l] - ambient_degc;
            self.conductance_w_per_m_k[l] * if above_k > 0.0 { above_k } else { 0.0 }
        })
    }

    /// The whole sample is the baseline's; a part of it is what [`progress`] makes of that, written so
    /// that a part of no length leaves the temperature, and one of full length is the whole, to the last bit.
    #[inline(always)]
    pub(crate) fn reference(
        &self,
        start_degc: &[f64; L],
        sample: &Sample<L>,
        stage: &Stage<L>,
        dt_s: f64,
        ambient_degc: f64,
    ) -> Reference<L> {
        let heating = Heating {
            power_w_per_m: stage.acting.power_w_per_m,
            ambient_degc,
        };
        let mut end_degc = self.balance.step(*start_degc, &heating, sample);
        let mut sensitivity_k_m_per_w = self.balance.sensitivity_k_m_per_w(sample);
        if stage.part != Part::Whole {
            for l in 0..L {
                let rate = unit(dt_s * self.per_tau_s[l]);
                let done = progress(stage.share[l], rate);
                sensitivity_k_m_per_w[l] *= done;
                let change_k = end_degc[l] - start_degc[l];
                end_degc[l] = if stage.part == Part::Earlier {
                    start_degc[l] + change_k * done
                } else {
                    end_degc[l] - change_k * (1.0 - done)
                };
            }
        }
        for l in 0..L {
            let warmer_k = stage.acting.ambient_degc[l] - ambient_degc;
            end_degc[l] += sensitivity_k_m_per_w[l] * (self.conductance_w_per_m_k[l] * warmer_k);
        }
        Reference {
            end_degc,
            sensitivity_k_m_per_w,
        }
    }

    /// Adds to the temperature at the end of a sample what a heat flow does, W/m.
    #[inline(always)]
    pub(crate) fn heat(
        &self,
        end_degc: &mut [f64; L],
        sample: &Sample<L>,
        flow_w_per_m: &[f64; L],
    ) {
        let sensitivity_k_m_per_w = self.balance.sensitivity_k_m_per_w(sample);
        for l in 0..L {
            end_degc[l] += sensitivity_k_m_per_w[l] * flow_w_per_m[l];
        }
    }

    /// Adds to the temperature at the end of a sample what warmer surroundings do.
    #[inline(always)]
    pub(crate) fn warm(&self, end_degc: &mut [f64; L], sample: &Sample<L>, warmer_k: &[f64; L]) {
        let sensitivity_k_m_per_w = self.balance.sensitivity_k_m_per_w(sample);
        for l in 0..L {
            let flow_w_per_m = self.conductance_w_per_m_k[l] * warmer_k[l];
            end_degc[l] += sensitivity_k_m_per_w[l] * flow_w_per_m;
        }
    }
}
