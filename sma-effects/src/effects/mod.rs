//! The catalogue: one effect a file, and its line in the table at the end of this one.

use core::fmt;

use wiener::hysteresis::SecondPopulation;
use wiener::widest_vectors;

use crate::effect::{
    Acting, Base, Before, Effect, Flow, Mapped, Moment, Seen, Shift, Standing, Trial, ZoneStart,
};
use crate::hypothesis::{MOST_HYPOTHESES, MOST_PARAMETERS};
use crate::info::EffectInfo;
use crate::{EffectSet, PhysicsError};

/// Declares the parameters of an effect: a struct with one field each, and the table of what is known
/// of them.
macro_rules! parameters {
    (
        $(#[$doc:meta])*
        $name:ident {
            $($(#[$field_doc:meta])* $field:ident: $parameter:expr,)+
        }
    ) => {
        $(#[$doc])*
        #[derive(Debug, Clone, Copy, PartialEq)]
        pub struct $name {
            $($(#[$field_doc])* pub $field: f64,)+
        }

        const PARAMETERS: &[$crate::EffectParameter] =
            &[$($parameter.named(stringify!($field))),+];

        impl Default for $name {
            /// Sizes 0, partners at their typical values.
            fn default() -> Self {
                Self { $($field: $parameter.neutral(),)+ }
            }
        }

        impl $name {
            pub(super) fn slot(&mut self, index: usize) -> Option<&mut f64> {
                [$(&mut self.$field),+].into_iter().nth(index)
            }
        }
    };
}

mod ambient_drift;
mod backlash;
mod dead_time;
mod end_conduction;
mod end_stop;
mod functional_fatigue;
mod latent_heat;
mod loop_asymmetry;
mod loop_shape;
mod natural_convection;
mod output_lag;
mod phase_dependent_resistance;
mod r_phase;
mod radiation;
mod return_point_memory;
mod sensor_drift;
mod sensor_nonlinearity;
mod stress_coupling;
mod supply_lag;
mod supply_limit;
mod thermal_expansion;
mod thermocouple_lag;

/// Shape of a loop of relays or kinetics; 0 is the family's own.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct FamilyShape {
    /// Bends c_1 to c_3 with |c_1| + max(-c_2, c_2/2) + |c_3| ≤ 1. See
    /// [`Hysteresis::with_bends`](wiener::hysteresis::Hysteresis::with_bends).
    pub bends: [f64; 3],
    /// Tails of relays, 0 to 4. See [`Hysteresis::with_tails`](wiener::hysteresis::Hysteresis::with_tails).
    pub tails: f64,
    /// Sharpness of the onset of kinetics, 0 to 1. See [`Hysteresis::with_onset`](wiener::hysteresis::Hysteresis::with_onset).
    pub onset: f64,
    /// A second population of relays.
    pub second: SecondPopulation,
}

/// Makes the closed set of effects, their values, and the calls of their hooks.
macro_rules! effects {
    ($($name:ident: $module:ident,)+) => {
        $(pub use $module::$name;)+

        /// An effect of the catalogue, in the order in which effects act.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
        pub enum EffectId {
            $(#[doc = concat!("See [`", stringify!($name), "`](struct@", stringify!($name), ").")] $name,)+
        }

        impl EffectId {
            /// Every effect.
            pub const ALL: [Self; [$(stringify!($name)),+].len()] = [$(Self::$name),+];

            /// Facts about it, known before any recording.
            #[must_use]
            pub const fn info(self) -> &'static EffectInfo {
                match self { $(Self::$name => &$module::INFO,)+ }
            }
        }

        /// Values of all parameters of all effects: the default is the baseline.
        #[derive(Debug, Clone, Copy, PartialEq, Default)]
        pub struct EffectValues {
            $(
                #[doc = concat!("Values of [`EffectId::", stringify!($name), "`].")]
                pub $module: $name,
            )+
            /// Shape of a loop of relays or kinetics; the paper's loop has none.
            pub family: FamilyShape,
            /// Values of the setting's own hypotheses, by hypothesis and parameter; see
            /// [`Hypothesis::values`](crate::Hypothesis::values).
            pub own: [[f64; MOST_PARAMETERS]; MOST_HYPOTHESES],
        }

        impl EffectValues {
            /// The parameter number `index` of an effect, to read or set; `None` if it has fewer.
            pub fn slot(&mut self, effect: EffectId, index: usize) -> Option<&mut f64> {
                match effect { $(EffectId::$name => self.$module.slot(index),)+ }
            }
        }

        /// All effects in `L` lanes: calls the hooks of those that are active.
        #[derive(Debug, Clone, PartialEq)]
        pub(crate) struct Effects<const L: usize> {
            pub(crate) active: EffectSet,
            $(pub(crate) $module: $module::Lanes<L>,)+
        }

        /// Memory of the effects for the rod as a whole.
        #[derive(Debug, Clone, PartialEq)]
        pub(crate) struct RodMemory<const L: usize> {
            $(pub(crate) $module: <$module::Lanes<L> as Effect<L>>::Rod,)+
        }

        /// Memory of the effects in a zone of the rod.
        #[derive(Debug, Clone, PartialEq)]
        pub(crate) struct ZoneMemory<const L: usize> {
            $($module: <$module::Lanes<L> as Effect<L>>::Zone,)+
        }

        impl<const L: usize> Effects<L> {
            pub(crate) fn new(values: &[EffectValues; L], base: &Base<'_, L>) -> Self {
                Self {
                    active: base.setting.active,
                    $($module: Effect::new(values, base),)+
                }
            }

            pub(crate) fn rod(&self) -> RodMemory<L> {
                RodMemory { $($module: self.$module.rod(),)+ }
            }

            pub(crate) fn zone(&self, start: &ZoneStart<L>) -> ZoneMemory<L> {
                ZoneMemory { $($module: self.$module.zone(start),)+ }
            }

            /// The effects that change the heating power.
            pub(crate) const CHANGE_POWER: EffectSet = EffectSet::EMPTY
                $(.with_if(<$module::Lanes<L> as Effect<L>>::CHANGES_POWER, EffectId::$name))+;
            /// Those that add heat.
            pub(crate) const FLOW: EffectSet = EffectSet::EMPTY
                $(.with_if(<$module::Lanes<L> as Effect<L>>::FLOWS, EffectId::$name))+;
            /// Those that change the fraction at a temperature.
            pub(crate) const CHANGE_FRACTION: EffectSet = EffectSet::EMPTY
                $(.with_if(<$module::Lanes<L> as Effect<L>>::CHANGES_FRACTION, EffectId::$name))+;
            /// Those that shift the loop.
            pub(crate) const SHIFT: EffectSet = EffectSet::EMPTY
                $(.with_if(<$module::Lanes<L> as Effect<L>>::SHIFTS, EffectId::$name))+;
            /// Those that must know the displacement in the middle of a sample.
            pub(crate) const WANT_MIDDLE: EffectSet = EffectSet::EMPTY
                $(.with_if(<$module::Lanes<L> as Effect<L>>::WANTS_MIDDLE, EffectId::$name))+;
            /// Those that change the temperature of the surroundings.
            pub(crate) const CHANGE_AMBIENT: EffectSet = EffectSet::EMPTY
                $(.with_if(<$module::Lanes<L> as Effect<L>>::CHANGES_AMBIENT, EffectId::$name))+;
            /// Those that change the displacement.
            pub(crate) const SHOW: EffectSet = EffectSet::EMPTY
                $(.with_if(<$module::Lanes<L> as Effect<L>>::SHOWS, EffectId::$name))+;
            /// Those that change the recorded temperature.
            pub(crate) const RECORD: EffectSet = EffectSet::EMPTY
                $(.with_if(<$module::Lanes<L> as Effect<L>>::RECORDS, EffectId::$name))+;
            /// Those that remember something in the zones, or act on the stroke of one.
            pub(crate) const STAND_IN_ZONE: EffectSet = EffectSet::EMPTY
                $(.with_if(<$module::Lanes<L> as Effect<L>>::STANDS_IN_ZONE, EffectId::$name))+;

            pub(crate) fn over(&self, rod: &mut RodMemory<L>, dt_s: f64) {
                $(if self.active.contains(EffectId::$name) {
                    self.$module.over(&mut rod.$module, dt_s);
                })+
            }

            pub(crate) fn hold(&self, rod: &mut RodMemory<L>, power_w_per_m: &[f64; L]) {
                $(if self.active.contains(EffectId::$name) {
                    self.$module.hold(&mut rod.$module, power_w_per_m);
                })+
            }

            #[inline(never)]
            pub(crate) fn power(
                &self,
                rod: &mut RodMemory<L>,
                moment: &Moment,
                power_w_per_m: &mut [f64; L],
            ) {
                widest_vectors(
                    #[inline(always)]
                    || {
                        let mut here = *power_w_per_m;
                        $(if self.active.contains(EffectId::$name) {
                            self.$module.power(&mut rod.$module, moment, &mut here);
                        })+
                        *power_w_per_m = here;
                    },
                );
            }

            #[inline(never)]
            pub(crate) fn ambient(&self, moment: &Moment, ambient_degc: &mut [f64; L]) {
                widest_vectors(
                    #[inline(always)]
                    || {
                        let mut here = *ambient_degc;
                        $(if self.active.contains(EffectId::$name) {
                            self.$module.ambient(moment, &mut here);
                        })+
                        *ambient_degc = here;
                    },
                );
            }

            #[inline(always)]
            pub(crate) fn flow(
                &self,
                acting: &Acting<L>,
                from: &Before<L>,
                to: &Trial<L>,
                flow: &mut Flow<L>,
            ) {
                $(if self.active.contains(EffectId::$name) {
                    self.$module.flow(acting, from, to, flow);
                })+
            }

            /// `flow` as a function call, not inlined.
            #[inline(never)]
            pub(crate) fn flow_apart(
                &self,
                acting: &Acting<L>,
                from: &Before<L>,
                to: &Trial<L>,
                flow: &mut Flow<L>,
            ) {
                widest_vectors(
                    #[inline(always)]
                    || {
                        let mut here = *flow;
                        self.flow(acting, from, to, &mut here);
                        *flow = here;
                    },
                );
            }

            #[inline(never)]
            pub(crate) fn fraction(
                &self,
                zone: &ZoneMemory<L>,
                driving_degc: &[f64; L],
                mapped: &mut Mapped<L>,
            ) {
                widest_vectors(
                    #[inline(always)]
                    || {
                        let mut here = *mapped;
                        $(if self.active.contains(EffectId::$name) {
                            self.$module.fraction(&zone.$module, driving_degc, &mut here);
                        })+
                        *mapped = here;
                    },
                );
            }

            #[inline(always)]
            pub(crate) fn shift(
                &self,
                zone: &ZoneMemory<L>,
                from: &Before<L>,
                to: &Trial<L>,
                shift: &mut Shift<L>,
            ) {
                $(if self.active.contains(EffectId::$name) {
                    self.$module.shift(&zone.$module, from, to, shift);
                })+
            }

            /// `shift` as a function call, not inlined.
            #[inline(never)]
            pub(crate) fn shift_apart(
                &self,
                zone: &ZoneMemory<L>,
                from: &Before<L>,
                to: &Trial<L>,
                shift: &mut Shift<L>,
            ) {
                widest_vectors(
                    #[inline(always)]
                    || {
                        let mut here = *shift;
                        self.shift(zone, from, to, &mut here);
                        *shift = here;
                    },
                );
            }

            #[inline(never)]
            pub(crate) fn commit(&self, zone: &mut ZoneMemory<L>, from: &Before<L>, to: &Trial<L>) {
                widest_vectors(
                    #[inline(always)]
                    || {
                        $(if self.active.contains(EffectId::$name) {
                            self.$module.commit(&mut zone.$module, from, to);
                        })+
                    },
                );
            }

            #[inline(never)]
            pub(crate) fn stroke(
                &self,
                zone: &ZoneMemory<L>,
                at: &Standing<L>,
                fraction: &mut [f64; L],
            ) {
                widest_vectors(
                    #[inline(always)]
                    || {
                        $(if self.active.contains(EffectId::$name) {
                            self.$module.stroke(&zone.$module, at, fraction);
                        })+
                    },
                );
            }

            #[inline(always)]
            pub(crate) fn displacement(
                &self,
                rod: &mut RodMemory<L>,
                moment: &Moment,
                seen: &Seen<L>,
                displacement: &mut [f64; L],
            ) {
                $(if self.active.contains(EffectId::$name) {
                    self.$module.displacement(&mut rod.$module, moment, seen, displacement);
                })+
            }

            pub(crate) fn settle(
                &self,
                rod: &mut RodMemory<L>,
                moment: &Moment,
                seen: &Seen<L>,
                share: &[f64; L],
                displacement: &mut [f64; L],
            ) {
                $(if self.active.contains(EffectId::$name) {
                    self.$module.settle(&mut rod.$module, moment, seen, share, displacement);
                })+
            }

            #[inline(never)]
            pub(crate) fn temperature(
                &self,
                rod: &mut RodMemory<L>,
                middle_degc: &[f64; L],
                ambient_degc: &[f64; L],
                temperature_degc: &mut [f64; L],
            ) {
                widest_vectors(
                    #[inline(always)]
                    || {
                        let mut here = *temperature_degc;
                        $(if self.active.contains(EffectId::$name) {
                            self.$module.temperature(
                                &mut rod.$module,
                                middle_degc,
                                ambient_degc,
                                &mut here,
                            );
                        })+
                        *temperature_degc = here;
                    },
                );
            }

            pub(crate) fn settle_temperature(
                &self,
                rod: &mut RodMemory<L>,
                temperature_degc: &mut [f64; L],
            ) {
                $(if self.active.contains(EffectId::$name) {
                    self.$module.settle_temperature(&mut rod.$module, temperature_degc);
                })+
            }
        }
    };
}

// One line an effect, in the order in which they act: a supply lags behind what it can give, the output passes the end stop before the
// backlash, and the lag before the sensor.
effects! {
    SupplyLimit: supply_limit,
    SupplyLag: supply_lag,
    DeadTime: dead_time,
    LatentHeat: latent_heat,
    Radiation: radiation,
    NaturalConvection: natural_convection,
    PhaseDependentResistance: phase_dependent_resistance,
    AmbientDrift: ambient_drift,
    EndConduction: end_conduction,
    ReturnPointMemory: return_point_memory,
    LoopShape: loop_shape,
    StressCoupling: stress_coupling,
    LoopAsymmetry: loop_asymmetry,
    FunctionalFatigue: functional_fatigue,
    RPhase: r_phase,
    ThermalExpansion: thermal_expansion,
    EndStop: end_stop,
    Backlash: backlash,
    OutputLag: output_lag,
    SensorNonlinearity: sensor_nonlinearity,
    SensorDrift: sensor_drift,
    ThermocoupleLag: thermocouple_lag,
}

impl EffectId {
    /// Its name in files, flags and reports.
    #[must_use]
    pub const fn id(self) -> &'static str {
        self.info().id
    }

    /// The effect of that name.
    ///
    /// # Errors
    ///
    /// [`PhysicsError::UnknownEffect`] with all names.
    pub fn parse(id: &str) -> Result<Self, PhysicsError> {
        Self::ALL
            .into_iter()
            .find(|effect| effect.id() == id)
            .ok_or_else(|| PhysicsError::UnknownEffect {
                id: id.to_owned(),
                known: Self::ALL.map(EffectId::id).join(" "),
            })
    }
}

impl fmt::Display for EffectId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.id())
    }
}
