//! Interface of every effect to the plant: the places where it may act.

use wiener::hysteresis::Hysteresis;
use wiener::{Drive, WienerParams};

use crate::{EffectValues, Setting};

/// The plant that an effect is added to, while both are made.
#[derive(Debug)]
pub(crate) struct Base<'a, const L: usize> {
    pub(crate) setting: &'a Setting,
    pub(crate) params: &'a [WienerParams; L],
    /// Hysteresis of the baseline, with the other rule of memory.
    pub(crate) other_memory: Hysteresis<L>,
}

impl<const L: usize> Base<'_, L> {
    pub(crate) fn drive(&self) -> Drive {
        self.setting.drive
    }

    /// h A, W/(m K).
    pub(crate) fn conductance_w_per_m_k(&self) -> [f64; L] {
        self.params
            .each_ref()
            .map(|lane| lane.heat.conductance_w_per_m_k)
    }

    /// Time constant, s.
    pub(crate) fn tau_s(&self) -> [f64; L] {
        self.params
            .each_ref()
            .map(|lane| lane.heat.heat_capacity_j_per_m_k / lane.heat.conductance_w_per_m_k)
    }
}

/// Where a zone of the rod starts.
#[derive(Debug)]
pub(crate) struct ZoneStart<const L: usize> {
    /// Temperature that drives the hysteresis, °C.
    pub(crate) driving_degc: [f64; L],
    /// Place between the limiting curves, 0 (heating) to 1 (cooling).
    pub(crate) share: [f64; L],
    /// By how much it was heated since it last turned, K.
    pub(crate) since_reversal_k: [f64; L],
}

/// One sample, or one sub-step of it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Moment {
    /// Its length, s.
    pub(crate) dt_s: f64,
    /// Share of the run that is over in its middle; 0 where the run's length is unknown.
    pub(crate) run_share_middle: f64,
    /// Share of the run that is over at its end; 0 where the run's length is unknown.
    pub(crate) run_share_end: f64,
}

/// Inputs that act on the zones of the rod in a part of a sample.
#[derive(Debug, Clone, Copy)]
#[repr(align(64))]
pub(crate) struct Acting<const L: usize> {
    /// 1/length of the part, 1/s, and 0 for no time: nothing happens in it.
    pub(crate) per_s: [f64; L],
    /// Temperature of the surroundings, °C.
    pub(crate) ambient_degc: [f64; L],
    /// Heating power at the resistance of the baseline, W/m.
    pub(crate) power_w_per_m: [f64; L],
}

/// A zone at the start of a sample.
#[derive(Debug, Clone, Copy)]
#[repr(align(64))]
pub(crate) struct Before<const L: usize> {
    pub(crate) temperature_degc: [f64; L],
    /// Transformed share of the zone, 0 cold to 1 hot.
    pub(crate) transformed: [f64; L],
    /// Transformed share of the whole rod.
    pub(crate) mean: [f64; L],
    /// Slope of the transformed share over the driving temperature, 1/K, and that temperature, °C.
    pub(crate) slope_per_k: [f64; L],
    pub(crate) driving_degc: [f64; L],
    /// dt/τ ≤ 1 of the zone's own heat balance.
    pub(crate) rate: [f64; L],
    /// Weight of a change of this zone's temperature in a flow into it that is taken as constant: [`counted`].
    pub(crate) counted: [f64; L],
}

/// Weight of a change over a sample in a flow that is taken as constant.
///
/// ```text
/// ½ + a/12 + a/12
/// ```
///
/// A change that fades with the rate a = dt/τ of a zone happens for the greater part early in the sample. Later
/// heat is less cooled away by the end of the sample.
#[inline(always)]
pub(crate) fn counted(rate: f64) -> f64 {
    0.5 + (rate + rate) * (1.0 / 12.0)
}

impl<const L: usize> Before<L> {
    /// Temperature that counts for a flow over the sample, °C.
    #[inline(always)]
    pub(crate) fn counted_degc(&self, to: &Trial<L>, l: usize) -> f64 {
        let change_k = to.temperature_degc[l] - self.temperature_degc[l];
        self.temperature_degc[l] + self.counted[l] * change_k
    }

    /// Transformed share of the zone that counts.
    #[inline(always)]
    pub(crate) fn counted_transformed(&self, to: &Trial<L>, l: usize) -> f64 {
        let change = to.transformed[l] - self.transformed[l];
        self.transformed[l] + self.counted[l] * change + to.bend[l]
    }

    /// Transformed share of the whole rod that counts.
    #[inline(always)]
    pub(crate) fn counted_mean(&self, to: &Trial<L>, l: usize) -> f64 {
        self.mean[l] + self.counted[l] * (to.mean[l] - self.mean[l]) + to.mean_bend[l]
    }
}

/// A zone at the end of a sample, as tried or as found.
#[derive(Debug, Clone, Copy)]
#[repr(align(64))]
pub(crate) struct Trial<const L: usize> {
    /// Temperature that drives the hysteresis: the rod's less what shifts the loop, °C.
    pub(crate) driving_degc: [f64; L],
    pub(crate) temperature_degc: [f64; L],
    /// Transformed share of the zone, and its slope over the driving temperature, 1/K.
    pub(crate) transformed: [f64; L],
    pub(crate) slope_per_k: [f64; L],
    /// Transformed share of the whole rod.
    pub(crate) mean: [f64; L],
    /// How far the mean of the transformed share over the sample lies above that of a straight course.
    ///
    /// ```text
    /// (p_0' - p_1') (θ_1 - θ_0)/12     (the trapezoid's correction by the slopes at its ends)
    /// ```
    pub(crate) bend: [f64; L],
    /// `bend` of the whole rod.
    pub(crate) mean_bend: [f64; L],
}

/// Fraction at a driving temperature, and its slope, 1/K.
#[derive(Debug, Clone, Copy)]
#[repr(align(64))]
pub(crate) struct Mapped<const L: usize> {
    pub(crate) fraction: [f64; L],
    pub(crate) slope_per_k: [f64; L],
}

/// By how much the loop is shifted upward, and how that changes with the trial.
#[derive(Debug, Clone, Copy)]
#[repr(align(64))]
pub(crate) struct Shift<const L: usize> {
    pub(crate) kelvin: [f64; L],
    /// Change per kelvin of driving temperature, the zone's own fraction included.
    pub(crate) per_k: [f64; L],
    /// Change with the transformed share of the whole rod, K.
    pub(crate) per_mean: [f64; L],
}

/// Mean heat flow into a zone over the sample beyond that of the baseline, W/m, and how it changes
/// with the trial.
#[derive(Debug, Clone, Copy)]
#[repr(align(64))]
pub(crate) struct Flow<const L: usize> {
    pub(crate) w_per_m: [f64; L],
    /// With the temperature at the end, W/(m K).
    pub(crate) per_k: [f64; L],
    /// With the zone's transformed share at the end, W/m.
    pub(crate) per_transformed: [f64; L],
    /// With that of the whole rod, W/m.
    pub(crate) per_mean: [f64; L],
}

/// Where a zone stands when its displacement is computed.
#[derive(Debug)]
#[repr(align(64))]
pub(crate) struct Standing<const L: usize> {
    pub(crate) temperature_degc: [f64; L],
    /// Transformed share of the zone.
    pub(crate) transformed: [f64; L],
}

/// Inputs of the displacement, beside the fraction.
#[derive(Debug)]
#[repr(align(64))]
pub(crate) struct Seen<const L: usize> {
    /// Mean over the rod of the warming by which it expands, K.
    pub(crate) expanded_k: [f64; L],
    /// When.
    pub(crate) instant: Instant,
}

/// Point of a sample at which the displacement is computed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Instant {
    /// Where the power changes, if it does within a sample: the displacement may turn there.
    Turn,
    /// In the middle of the sample, for those who need to know how the displacement bends.
    Middle,
    /// At its end: what is shown.
    End,
}

impl<const L: usize> Before<L> {
    pub(crate) const ZERO: Self = Self {
        temperature_degc: [0.0; L],
        transformed: [0.0; L],
        mean: [0.0; L],
        slope_per_k: [0.0; L],
        driving_degc: [0.0; L],
        rate: [0.0; L],
        counted: [0.0; L],
    };
}

impl<const L: usize> Trial<L> {
    pub(crate) const ZERO: Self = Self {
        driving_degc: [0.0; L],
        temperature_degc: [0.0; L],
        transformed: [0.0; L],
        slope_per_k: [0.0; L],
        mean: [0.0; L],
        bend: [0.0; L],
        mean_bend: [0.0; L],
    };
}

impl<const L: usize> Shift<L> {
    pub(crate) const ZERO: Self = Self {
        kelvin: [0.0; L],
        per_k: [0.0; L],
        per_mean: [0.0; L],
    };
}

impl<const L: usize> Flow<L> {
    pub(crate) const ZERO: Self = Self {
        w_per_m: [0.0; L],
        per_k: [0.0; L],
        per_transformed: [0.0; L],
        per_mean: [0.0; L],
    };
}

/// An effect in `L` lanes: its coefficients, and what it does at the places where effects may act.
///
/// Every hook adds a term that is exactly 0, or multiplies by exactly 1, where the sizes are 0. All
/// of them are plain loops over lanes.
pub(crate) trait Effect<const L: usize>: Sized {
    /// Memory of the effect, one for the rod.
    type Rod: Clone + core::fmt::Debug + PartialEq;
    /// Memory of the effect, one for each zone.
    type Zone: Clone + core::fmt::Debug + PartialEq;
    /// True if it changes the heating power.
    const CHANGES_POWER: bool = false;
    /// True if it adds heat: the heat balance of a sample must then be solved for its end.
    const FLOWS: bool = false;
    /// True if it changes the fraction at a temperature.
    const CHANGES_FRACTION: bool = false;
    /// True if it shifts the loop: the heat balance of a sample must then be solved for its end.
    const SHIFTS: bool = false;
    /// True if it must know the displacement in the middle of a sample.
    const WANTS_MIDDLE: bool = false;
    /// True if it changes the temperature of the surroundings.
    const CHANGES_AMBIENT: bool = false;
    /// True if it remembers something in the zones, or acts on the stroke of one.
    const STANDS_IN_ZONE: bool = false;
    /// True if it changes the displacement.
    const SHOWS: bool = false;
    /// True if it changes the recorded temperature.
    const RECORDS: bool = false;

    fn new(values: &[EffectValues; L], base: &Base<'_, L>) -> Self;
    fn rod(&self) -> Self::Rod;
    fn zone(&self, start: &ZoneStart<L>) -> Self::Zone;

    /// Prepares for samples of another length.
    fn over(&self, _rod: &mut Self::Rod, _dt_s: f64) {}

    /// Takes the power that was on before the first sample: what holds the rod at its start.
    fn hold(&self, _rod: &mut Self::Rod, _power_w_per_m: &[f64; L]) {}

    /// Changes the heating power.
    #[inline(always)]
    fn power(&self, _rod: &mut Self::Rod, _moment: &Moment, _power_w_per_m: &mut [f64; L]) {}

    /// Changes the temperature of the surroundings.
    #[inline(always)]
    fn ambient(&self, _moment: &Moment, _ambient_degc: &mut [f64; L]) {}

    /// Adds heat.
    #[inline(always)]
    fn flow(&self, _acting: &Acting<L>, _from: &Before<L>, _to: &Trial<L>, _flow: &mut Flow<L>) {}

    /// Changes the fraction at a driving temperature, without going there.
    #[inline(always)]
    fn fraction(&self, _zone: &Self::Zone, _driving_degc: &[f64; L], _mapped: &mut Mapped<L>) {}

    /// Shifts the loop.
    #[inline(always)]
    fn shift(&self, _zone: &Self::Zone, _from: &Before<L>, _to: &Trial<L>, _shift: &mut Shift<L>) {}

    /// Goes to the end of the sample.
    #[inline(always)]
    fn commit(&self, _zone: &mut Self::Zone, _from: &Before<L>, _to: &Trial<L>) {}

    /// Changes the fraction that moves the output, but not the one that takes up heat.
    #[inline(always)]
    fn stroke(&self, _zone: &Self::Zone, _at: &Standing<L>, _fraction: &mut [f64; L]) {}

    /// Changes the displacement.
    #[inline(always)]
    fn displacement(
        &self,
        _rod: &mut Self::Rod,
        _moment: &Moment,
        _seen: &Seen<L>,
        _displacement: &mut [f64; L],
    ) {
    }

    /// Changes the displacement at the start, where all is still; `share` as in [`ZoneStart`].
    fn settle(
        &self,
        rod: &mut Self::Rod,
        moment: &Moment,
        seen: &Seen<L>,
        _share: &[f64; L],
        displacement: &mut [f64; L],
    ) {
        self.displacement(rod, moment, seen, displacement);
    }

    /// Changes the recorded temperature at the end of the sample; that in the middle is the rod's. The surroundings
    /// have their temperature of the sample.
    #[inline(always)]
    fn temperature(
        &self,
        _rod: &mut Self::Rod,
        _middle_degc: &[f64; L],
        _ambient_degc: &[f64; L],
        _temperature_degc: &mut [f64; L],
    ) {
    }

    /// Changes the recorded temperature at the start, where all is still.
    fn settle_temperature(&self, _rod: &mut Self::Rod, _temperature_degc: &mut [f64; L]) {}
}

/// For an effect that remembers nothing.
macro_rules! without_memory {
    () => {
        type Rod = ();
        type Zone = ();
        fn rod(&self) {}
        fn zone(&self, _: &$crate::effect::ZoneStart<L>) {}
    };
}
/// For an effect that remembers nothing in the zones.
macro_rules! without_memory_in_zones {
    () => {
        type Zone = ();
        fn zone(&self, _: &$crate::effect::ZoneStart<L>) {}
    };
}
/// For an effect that remembers nothing for the rod as a whole.
macro_rules! without_memory_of_the_rod {
    () => {
        type Rod = ();
        fn rod(&self) {}
    };
}

pub(crate) use {without_memory, without_memory_in_zones, without_memory_of_the_rod};
