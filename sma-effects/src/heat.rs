//! The heat balance of a zone as far as it is linear.

use wiener::WienerError;
use wiener::thermal::{HeatBalance, HeatBalanceParams, Heating, Sample};

use crate::PhysicsError;
use crate::part::{Part, Stage, progress, unit};
use crate::state::Zone;

/// The linear heat balance of a zone: that of the baseline, and of the end zones with what they lose to
/// clamps and middle besides.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct ZoneHeat<const L: usize> {
    pub(crate) balance: HeatBalance<L>,
    conductance_w_per_m_k: [f64; L],
    per_tau_s: [f64; L],
    /// Rate at which a change of temperature fades, over 1/τ: 1 by itself, less for an end zone that
    /// the middle takes along.
    pub(crate) path_share: [f64; L],
}

/// What a part of a sample does to a zone without heat beyond the baseline's.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Reference<const L: usize> {
    /// Temperature at its end, °C.
    pub(crate) end_degc: [f64; L],
    /// Rise of it per heat flow over the part, K m/W.
    pub(crate) sensitivity_k_m_per_w: [f64; L],
}

impl<const L: usize> Reference<L> {
    pub(crate) const ZERO: Self = Self {
        end_degc: [0.0; L],
        sensitivity_k_m_per_w: [0.0; L],
    };
}

impl<const L: usize> ZoneHeat<L> {
    /// `loss_ratio` is κ of an end zone, 0 for the middle.
    pub(crate) fn new(
        mut lanes: [HeatBalanceParams; L],
        loss_ratio: [f64; L],
    ) -> Result<Self, PhysicsError> {
        for l in 0..L {
            lanes[l].conductance_w_per_m_k *= 1.0 + 2.0 * loss_ratio[l];
        }
        Ok(Self {
            balance: HeatBalance::new(lanes).map_err(WienerError::from)?,
            conductance_w_per_m_k: lanes.map(|lane| lane.conductance_w_per_m_k),
            per_tau_s: lanes.map(|lane| lane.conductance_w_per_m_k / lane.heat_capacity_j_per_m_k),
            path_share: loss_ratio.map(|ratio| (1.0 + ratio) / (1.0 + 2.0 * ratio)),
        })
    }

    /// The whole sample is the baseline's; a part of it is what [`progress`] makes of that, written so
    /// that a part of no length leaves the temperature, and one of full length is the whole, to the last bit.
    #[inline(always)]
    pub(crate) fn reference(
        &self,
        zone: &Zone<L>,
        stage: &Stage<L>,
        dt_s: f64,
        ambient_degc: f64,
    ) -> Reference<L> {
        let heating = Heating {
            power_w_per_m: stage.acting.power_w_per_m,
            ambient_degc,
        };
        let start_degc = &zone.temperature_degc;
        let mut end_degc = self.balance.step(*start_degc, &heating, &zone.sample);
        let mut sensitivity_k_m_per_w = self.balance.sensitivity_k_m_per_w(&zone.sample);
        if stage.part != Part::Whole {
            for l in 0..L {
                let done = progress(stage.share[l], self.rate(l, dt_s));
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

    /// dt/τ, at most 1.
    #[inline(always)]
    pub(crate) fn rate(&self, l: usize, dt_s: f64) -> f64 {
        unit(dt_s * self.per_tau_s[l])
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
