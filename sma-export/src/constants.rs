//! Constants and conditions of a model, common to all languages.

use std::collections::BTreeMap;
use std::f64::consts::{FRAC_1_PI, FRAC_2_PI, FRAC_PI_2, FRAC_PI_8, LOG2_E};

use pid_tune::{AntiWindup, DerivativeOf, GainSchedule, GainScheduleParams, SCHEDULE_LEVELS};
use sma_effects::EffectId;
use wiener::Drive;
use wiener::hysteresis::{NESTING_CAPACITY, REVERSAL_DEAD_BAND_K, Rule, TAN_FRAC_PI_8};

use crate::{Controller, Exported};

/// Samples that the dead time of a model may last at most: the memory of a small controller holds them.
pub(crate) const LONGEST_SAMPLES: usize = 2048;
/// Half of the width of the R-phase's own loop, K.
const R_PHASE_HALF_WIDTH_K: f64 = 1.5;
/// Expansion of martensite over that of austenite.
const OF_MARTENSITE: f64 = 0.6;
/// Stroke over the length of a rod that does not say its length.
const STRAIN: f64 = 0.04;
/// Softness of a backlash below which it is a play.
const SMALLEST_SOFTNESS: f64 = 1e-6;

/// Constants by their names in the templates, and conditions.
#[derive(Debug, Default)]
pub(crate) struct Constants {
    pub(crate) numbers: BTreeMap<&'static str, f64>,
    pub(crate) counts: BTreeMap<&'static str, usize>,
    pub(crate) flags: BTreeMap<&'static str, bool>,
}

/// Coefficients of a first-order lag over a sample: retained, trailing, bent.
///
/// ```text
/// a = dt/θ,   e^(-a),   (1 - e^(-a))/a,   4 ((1 + e^(-a))/a - 2 (1 - e^(-a))/a²)
/// ```
fn lag(lag_s: f64, dt_s: f64) -> [f64; 3] {
    const SMALL: f64 = 1e-2;
    let a = dt_s.max(f64::MIN_POSITIVE) / lag_s;
    let retained = libm::exp(-a);
    let trailing = mean_exponential(-a);
    let bent = if a < SMALL {
        a * (1.0 / 6.0 - a * (1.0 / 12.0 - a / 40.0))
    } else {
        ((1.0 + retained) - 2.0 * trailing) / a
    };
    [retained, trailing, 4.0 * bent]
}

/// (e^x - 1)/x.
fn mean_exponential(x: f64) -> f64 {
    const TINY: f64 = 1e-9;
    if x.abs() < TINY {
        1.0 + 0.5 * x
    } else {
        libm::expm1(x) / x
    }
}

impl Constants {
    /// The constants of a model that [`Exported::checked`] has accepted.
    pub(crate) fn of(exported: &Exported) -> Self {
        let mut constants = Self::default();
        constants.elementary();
        constants.plain(exported);
        constants.of_effects(exported);
        constants.late(exported);
        constants.controller(exported.controller.as_ref());
        constants
    }

    fn number(&mut self, name: &'static str, value: f64) {
        self.numbers.insert(name, value);
    }

    fn elementary(&mut self) {
        for (name, value) in [
            ("pi_2", FRAC_PI_2),
            ("pi_8", FRAC_PI_8),
            ("tan_pi_8", TAN_FRAC_PI_8),
            ("per_pi", FRAC_1_PI),
            ("log2_e", LOG2_E),
            ("ln_2_high", 0.693_147_180_369_123_8),
            ("ln_2_low", 1.908_214_929_270_587_7e-10),
            ("dead_band_k", REVERSAL_DEAD_BAND_K),
        ] {
            self.number(name, value);
        }
    }

    fn plain(&mut self, exported: &Exported) {
        let Exported {
            setting, member, ..
        } = exported;
        let params = &member.params;
        let heat = &params.heat;
        let limits = &params.limiting_loop;
        let tau_s = heat.heat_capacity_j_per_m_k / heat.conductance_w_per_m_k;
        let per_tau_s = heat.conductance_w_per_m_k / heat.heat_capacity_j_per_m_k;
        let part_s = exported.dt_s / setting.sub_steps as f64;
        for (name, value) in [
            ("dt_s_hex", exported.dt_s),
            ("part_s", part_s),
            ("start_rise_k", member.start.temperature_degc),
            ("start_share", member.start.share),
            ("tau_s", tau_s),
            ("conductance_w_per_m_k", heat.conductance_w_per_m_k),
            ("rise_k_m_per_w", 1.0 / heat.conductance_w_per_m_k),
            ("retained", libm::exp(-part_s / tau_s)),
            ("rate", (part_s * per_tau_s).clamp(0.0, 1.0)),
            ("loop_center_degc", limits.loop_center_degc),
            ("loop_half_width_k", limits.loop_half_width_k),
            ("loop_spread_k", limits.loop_spread_k),
            ("fraction_center", limits.fraction_center),
            ("fraction_per_radian", FRAC_2_PI * limits.fraction_swing),
            (
                "fraction_cold",
                limits.fraction_center - limits.fraction_swing,
            ),
            ("fraction_span", 2.0 * limits.fraction_swing),
            ("per_fraction_span", 0.5 / limits.fraction_swing),
            ("zeta", params.zeta),
            ("gain", params.gain),
            ("offset", params.offset),
            ("reference_degc", setting.reference_degc),
        ] {
            self.number(name, value);
        }
        let resistance_ohm_per_m = heat.resistance_ohm_per_m;
        // Products that the drive's formula begins with, so that its sums have the same bits.
        let (kind, given) = match setting.drive {
            Drive::Current => (
                "is_current",
                vec![("resistance_ohm_per_m", resistance_ohm_per_m)],
            ),
            Drive::Duty { supply_v, length_m } => (
                "is_duty",
                vec![
                    ("power_numerator", supply_v * supply_v),
                    ("power_divisor", resistance_ohm_per_m * length_m * length_m),
                ],
            ),
            Drive::Voltage { length_m } => (
                "is_voltage",
                vec![
                    ("power_numerator", 1.0),
                    ("power_divisor", resistance_ohm_per_m * length_m * length_m),
                ],
            ),
            Drive::Power { length_m } => ("is_power", vec![("length_m", length_m)]),
        };
        for (name, value) in given {
            self.number(name, value);
        }
        for name in ["is_current", "is_duty", "is_voltage", "is_power"] {
            self.flags.insert(name, name == kind);
        }
        let squares = matches!(setting.drive, Drive::Current | Drive::Voltage { .. });
        self.flags.insert("squares", squares);
        self.flags
            .insert("drive_limit", exported.drive_limit.is_some());
        self.number("drive_limit", exported.drive_limit.unwrap_or(0.0));
        let is_nested = setting.rule == Rule::Nested;
        let returns = setting.active.contains(EffectId::ReturnPointMemory);
        let nesting = if is_nested || returns {
            NESTING_CAPACITY
        } else {
            1
        };
        self.counts.insert("nesting", nesting);
        self.counts.insert("nesting_capacity", NESTING_CAPACITY);
        self.counts.insert("is_nested", usize::from(is_nested));
        self.counts
            .insert("other_is_nested", usize::from(!is_nested));
        self.counts.insert("n_sub_steps", setting.sub_steps);
        self.flags.insert("sub_steps", setting.sub_steps > 1);
    }

    fn of_effects(&mut self, exported: &Exported) {
        let Exported {
            setting, member, ..
        } = exported;
        let (params, values) = (&member.params, &member.effects);
        let active = |effect| setting.active.contains(effect);
        let part_s = exported.dt_s / setting.sub_steps as f64;
        let tau_s = params.heat.heat_capacity_j_per_m_k / params.heat.conductance_w_per_m_k;
        for (name, effect) in [
            ("supply_limit", EffectId::SupplyLimit),
            ("supply_lag", EffectId::SupplyLag),
            ("dead_time", EffectId::DeadTime),
            ("return_point_memory", EffectId::ReturnPointMemory),
            ("loop_shape", EffectId::LoopShape),
            ("loop_asymmetry", EffectId::LoopAsymmetry),
            ("r_phase", EffectId::RPhase),
            ("thermal_expansion", EffectId::ThermalExpansion),
            ("end_stop", EffectId::EndStop),
            ("backlash", EffectId::Backlash),
            ("output_lag", EffectId::OutputLag),
            ("sensor_nonlinearity", EffectId::SensorNonlinearity),
            ("thermocouple_lag", EffectId::ThermocoupleLag),
        ] {
            self.flags.insert(name, active(effect));
        }
        let scale = [
            EffectId::LoopShape,
            EffectId::RPhase,
            EffectId::ThermalExpansion,
        ];
        self.flags.insert("scale", scale.into_iter().any(active));
        let asymmetry = values.loop_asymmetry.loop_asymmetry;
        let gain = params.gain;
        let expansion = values.thermal_expansion.expansion_per_k;
        let length = setting.length_output.unwrap_or(gain.abs() / STRAIN);
        let half_width = 0.5 * values.backlash.backlash_share * gain.abs();
        let softness = values.backlash.backlash_softness;
        let least_softness = if softness > SMALLEST_SOFTNESS {
            softness
        } else {
            SMALLEST_SOFTNESS
        };
        let contact = &values.thermocouple_lag;
        let leak = contact.thermocouple_lag_s * contact.bead_cooling_per_s;
        let output = lag(values.output_lag.output_lag_s, part_s);
        let bead = lag(contact.thermocouple_lag_s / (1.0 + leak), part_s);
        let nonlinear = &values.sensor_nonlinearity;
        let lag_s = values.supply_lag.supply_lag_s;
        let faded = part_s.max(f64::MIN_POSITIVE) / lag_s;
        let a = part_s / tau_s;
        let r_phase = &values.r_phase;
        let limiting = &params.limiting_loop;
        for (name, value) in [
            ("widening_heating", 1.0 - asymmetry),
            ("widening_cooling", 1.0 + asymmetry),
            (
                "return_point_share",
                values.return_point_memory.return_point_share,
            ),
            ("loop_shape_1", values.loop_shape.loop_shape_1),
            ("loop_shape_2", values.loop_shape.loop_shape_2),
            ("loop_shape_3", values.loop_shape.loop_shape_3),
            ("r_phase_half_width_k", R_PHASE_HALF_WIDTH_K),
            (
                "r_phase_middle_degc",
                limiting.loop_center_degc - limiting.loop_half_width_k + r_phase.r_phase_above_k,
            ),
            ("r_phase_spread_k", r_phase.r_phase_spread_k),
            ("r_phase_share", r_phase.r_phase_share),
            ("expansion_per_k", (length * expansion).copysign(gain)),
            ("of_martensite", OF_MARTENSITE),
            ("of_austenite", 1.0 - OF_MARTENSITE),
            ("end_stop", values.end_stop.end_stop_position * gain.abs()),
            ("end_stop_sign", 1f64.copysign(gain)),
            ("end_stop_share", values.end_stop.end_stop_share),
            ("backlash_half_width", half_width),
            (
                "per_backlash_half_width",
                if half_width > 0.0 {
                    1.0 / half_width
                } else {
                    0.0
                },
            ),
            ("backlash_softness", softness),
            ("backlash_least_softness", least_softness),
            ("backlash_relaxed", values.backlash.backlash_relaxed),
            ("output_retained", output[0]),
            ("output_trailing", output[1]),
            ("output_bent", output[2]),
            ("thermocouple_retained", bead[0]),
            ("thermocouple_trailing", bead[1]),
            ("thermocouple_bent", bead[2]),
            ("thermocouple_low", leak / (1.0 + leak)),
            (
                "nonlinearity_quadratic",
                4.0 * nonlinear.sensor_nonlinearity_quadratic * gain,
            ),
            (
                "nonlinearity_cubic",
                6.0 * 3f64.sqrt() * nonlinear.sensor_nonlinearity_cubic * gain,
            ),
            (
                "per_stroke",
                if gain.abs() > 0.0 { 1.0 / gain } else { 0.0 },
            ),
            ("supply_lag_s", lag_s),
            ("supply_retained", libm::exp(-faded)),
            (
                "supply_weight",
                mean_exponential(a - faded) / mean_exponential(a),
            ),
            (
                "supply_double_weight",
                mean_exponential(a - 2.0 * faded) / mean_exponential(a),
            ),
            ("supply_limit", supply_limit(exported)),
            ("supply_limit_share", values.supply_limit.supply_limit_share),
        ] {
            self.number(name, value);
        }
        self.flags.insert("falls_on_heating", gain < 0.0);
    }

    /// Dead time, and what needs the middle of a sample.
    fn late(&mut self, exported: &Exported) {
        let Exported {
            setting, member, ..
        } = exported;
        let active = |effect| setting.active.contains(effect);
        let part_s = exported.dt_s / setting.sub_steps as f64;
        let late = &member.effects.dead_time;
        let output_delay_s = late.dead_time_s * late.dead_time_output_share;
        let drive_delay_s = late.dead_time_s - output_delay_s;
        self.number("output_delay_s", output_delay_s);
        self.number("drive_delay_s", drive_delay_s);
        let is_late = active(EffectId::DeadTime);
        let delays_output = is_late && output_delay_s > 0.0;
        // Beyond these nothing arrives.
        let samples = (drive_delay_s.max(output_delay_s) / part_s) as usize + 4;
        self.counts.insert("late_capacity", samples);
        self.flags.insert("delays_output", delays_output);
        let parts = is_late || active(EffectId::SupplyLag);
        self.flags.insert("parts", parts);
        let middle = [EffectId::OutputLag, EffectId::ThermocoupleLag];
        let wants_middle = delays_output || middle.into_iter().any(active);
        self.flags.insert("middle", wants_middle);
    }

    fn controller(&mut self, controller: Option<&Controller>) {
        let is = |wanted: fn(&Controller) -> bool| controller.is_some_and(wanted);
        for (name, value) in [
            ("pid", controller.is_some()),
            ("turned", is(|one| one.is_turned)),
            (
                "derivative_of_error",
                is(|one| one.params.derivative_of == DerivativeOf::Error),
            ),
            (
                "clamping",
                is(|one| one.params.anti_windup == AntiWindup::Clamping),
            ),
            (
                "back_calculation",
                is(|one| matches!(one.params.anti_windup, AntiWindup::BackCalculation { .. })),
            ),
            ("scheduled", is(|one| one.params.gain_schedule.is_some())),
        ] {
            self.flags.insert(name, value);
        }
        let Some(Controller { params, gains, .. }) = controller else {
            return;
        };
        let retained = libm::exp(-params.dt_s / params.derivative_filter_s);
        for (name, value) in [
            ("pid_lower", params.limits.lower),
            ("pid_upper", params.limits.upper),
            ("pid_kp", gains.kp),
            ("pid_ki_dt", gains.ki * params.dt_s),
            ("pid_kd_new", (1.0 - retained) * gains.kd),
            ("pid_retained", retained),
            ("pid_per_dt_s", 1.0 / params.dt_s),
            ("pid_setpoint_weight", params.setpoint_weight),
        ] {
            self.number(name, value);
        }
        if let AntiWindup::BackCalculation { tracking_s } = params.anti_windup {
            self.number("pid_tracking_share", params.dt_s / tracking_s);
        }
        if let Some(schedule) = &params.gain_schedule {
            self.schedule(schedule);
        }
    }

    fn schedule(&mut self, schedule: &GainSchedule) {
        let GainScheduleParams { outputs, turn, .. } = schedule.params();
        let [lower, upper] = outputs;
        let last = SCHEDULE_LEVELS - 1;
        self.counts.insert("schedule_last", last);
        self.number("schedule_first", *lower);
        self.number("schedule_per_level", last as f64 / (upper - lower));
        self.number("schedule_half_turn", 0.5 * turn);
        self.number("schedule_per_turn", 1.0 / turn);
    }
}

/// Where the supply begins to give less, as amplitude or power, in powers per meter.
fn supply_limit(exported: &Exported) -> f64 {
    let Exported {
        setting, member, ..
    } = exported;
    let largest = setting.largest_drive.unwrap_or(0.0);
    let resistance = [member.params.heat.resistance_ohm_per_m];
    let [power] = setting.drive.power_w_per_m([largest], resistance);
    let limits_amplitude = matches!(setting.drive, Drive::Current | Drive::Voltage { .. });
    let limit = if limits_amplitude {
        power.sqrt()
    } else {
        power
    };
    limit * member.effects.supply_limit.supply_limit_position
}
