//! Each effect by another route: a closed form, or a plain integration in steps a hundred times finer.

use crate::support;

use std::f64::consts::PI;

use approx::assert_abs_diff_eq;
use sma_effects::{EffectId, EffectSet, EffectValues, ExtendedPlant, Setting};
use support::{
    AMBIENT_DEGC, DRIVES, Trace, current_a, drive_of, largest, params, rod, setting, trace,
    with_effect,
};
use wiener::hysteresis::{
    Branch, Hysteresis, LimitingLoop, LoopParams, Memory, Rule, SineProximity,
};
use wiener::thermal::HeatBalanceParams;
use wiener::{Drive, Input, Plant, WienerParams};

const DT_S: f64 = 0.2;

fn operator(rule: Rule) -> Hysteresis<1> {
    let params = params();
    Hysteresis::new(
        LimitingLoop::new([params.limiting_loop]).unwrap(),
        SineProximity::new([params.zeta]).unwrap(),
        rule,
    )
}

fn baseline() -> Trace {
    with_effect(EffectId::EndStop, &EffectValues::default(), DT_S)
}

fn tau_s() -> f64 {
    params().heat.heat_capacity_j_per_m_k / params().heat.conductance_w_per_m_k
}

/// Heat into each zone, W/m, from time, drive, temperatures and fractions.
type Net<'a> = dyn Fn(f64, f64, &[f64], &[f64]) -> Vec<f64> + 'a;

/// A rod of some zones integrated by Heun's rule in steps of `DT_S`/400, each zone with its own
/// hysteresis. `net` gives the heat into each zone, W/m, from time, drive, temperatures and fractions.
struct Fine<'a> {
    shares: &'a [f64],
    latent_j_per_m: f64,
    net: &'a Net<'a>,
}

impl Fine<'_> {
    /// Displacement at every sample, and the temperature of the first zone.
    fn run(&self, drive: &[f64]) -> (Vec<f64>, Vec<f64>) {
        let parts = 400;
        let h = DT_S / f64::from(parts);
        let operator = operator(Rule::LastReversal);
        let zones = self.shares.len();
        let mut degc = vec![AMBIENT_DEGC; zones];
        let mut memory: Vec<Memory<1>> = (0..zones)
            .map(|_| operator.on_limiting_curve(Branch::Cooling, [AMBIENT_DEGC]))
            .collect();
        let (mut shown, mut first_degc) = (Vec::new(), Vec::new());
        for (k, &drive) in drive.iter().enumerate() {
            let fractions: Vec<f64> = (0..zones)
                .map(|z| operator.peek(&memory[z], [degc[z]]).fraction[0])
                .collect();
            let mean: f64 = self.shares.iter().zip(&fractions).map(|(a, b)| a * b).sum();
            shown.push(params().gain * mean + params().offset);
            first_degc.push(degc[0]);
            for part in 0..parts {
                let time_s = k as f64 * DT_S + f64::from(part) * h;
                let rate = |time_s: f64, degc: &[f64], towards: &[f64]| -> Vec<f64> {
                    let sensed: Vec<_> = (0..zones)
                        .map(|z| operator.peek(&memory[z], [degc[z] + 1e-6 * towards[z]]))
                        .collect();
                    let fractions: Vec<f64> = sensed.iter().map(|seen| seen.fraction[0]).collect();
                    let net = (self.net)(time_s, drive, degc, &fractions);
                    (0..zones)
                        .map(|z| {
                            let latent = self.latent_j_per_m * sensed[z].slope_per_k[0];
                            net[z] / (params().heat.heat_capacity_j_per_m_k + latent)
                        })
                        .collect()
                };
                // Which way it goes decides the branch, and with it the latent heat.
                let direction = rate(time_s, &degc, &vec![0.0; zones]);
                let signs: Vec<f64> = direction.iter().map(|rate| rate.signum()).collect();
                let first = rate(time_s, &degc, &signs);
                let ahead: Vec<f64> = (0..zones).map(|z| degc[z] + h * first[z]).collect();
                let second = rate(time_s + h, &ahead, &signs);
                for z in 0..zones {
                    degc[z] += 0.5 * h * (first[z] + second[z]);
                    let _fraction = operator.commit(&mut memory[z], [degc[z]]);
                }
            }
        }
        (shown, first_degc)
    }
}

fn compare(effect: EffectId, values: &EffectValues, fine: &Fine<'_>, limit: f64) {
    let shown = with_effect(effect, values, DT_S);
    let (expected, expected_degc) = fine.run(&current_a(DT_S));
    let gap = largest(&shown.displacement, &expected) / params().gain;
    assert!(gap < limit, "{effect}: {gap:e} of the stroke");
    let gap_k = largest(&shown.temperature_degc, &expected_degc);
    assert!(gap_k < 20.0 * limit, "{effect}: {gap_k:e} K");
    // The effect is not what makes them agree by being nothing.
    let size = largest(&shown.displacement, &baseline().displacement) / params().gain;
    let size_k = largest(&shown.temperature_degc, &baseline().temperature_degc) / 50.0;
    assert!(size.max(size_k) > 20.0 * limit, "{effect}: {size:e}");
}

fn loss(degc: f64) -> f64 {
    params().heat.conductance_w_per_m_k * (degc - AMBIENT_DEGC)
}

fn joule(current_a: f64) -> f64 {
    current_a * current_a * rod().resistance_ohm_per_m
}

#[test]
fn the_fine_integration_is_that_of_the_baseline_without_effects() {
    let fine = Fine {
        shares: &[1.0],
        latent_j_per_m: 0.0,
        net: &|_, i, degc, _| vec![joule(i) - loss(degc[0])],
    };
    let (expected, _) = fine.run(&current_a(DT_S));
    assert!(largest(&baseline().displacement, &expected) < 1e-6 * params().gain);
}

#[test]
fn latent_heat_is_a_heat_capacity_where_the_fraction_changes() {
    let mut values = EffectValues::default();
    values.latent_heat.latent_heat_j_per_kg = 12e3;
    let fine = Fine {
        shares: &[1.0],
        latent_j_per_m: 12e3 * rod().mass_kg_per_m(),
        net: &|_, i, degc, _| vec![joule(i) - loss(degc[0])],
    };
    compare(EffectId::LatentHeat, &values, &fine, 2e-4);
}

#[test]
fn radiation_is_a_loss_by_the_fourth_power() {
    let mut values = EffectValues::default();
    values.radiation.emissivity = 0.8;
    let fine = Fine {
        shares: &[1.0],
        latent_j_per_m: 0.0,
        net: &|_, i, degc, _| {
            let (rod_k, ambient_k) = (degc[0] + 273.15, AMBIENT_DEGC + 273.15);
            let radiated = 0.8 * 5.670_374_419e-8 * rod().surface_m2_per_m();
            let radiated = radiated * (rod_k.powi(4) - ambient_k.powi(4));
            vec![joule(i) - loss(degc[0]) - radiated]
        },
    };
    compare(EffectId::Radiation, &values, &fine, 5e-5);
}

#[test]
fn convection_is_a_power_of_the_rise() {
    let mut values = EffectValues::default();
    values.natural_convection.convection_exponent = 0.25;
    let fine = Fine {
        shares: &[1.0],
        latent_j_per_m: 0.0,
        net: &|_, i, degc, _| {
            let power = ((degc[0] - AMBIENT_DEGC).abs() / 50.0).powf(0.25);
            vec![joule(i) - loss(degc[0]) * power]
        },
    };
    compare(EffectId::NaturalConvection, &values, &fine, 1e-4);
}

#[test]
fn resistance_acts_with_opposite_signs_on_current_and_voltage_and_not_on_power() {
    const RISE_PER_K: f64 = 5e-4;
    let mut values = EffectValues::default();
    values.phase_dependent_resistance.resistance_change = 0.2;
    values.phase_dependent_resistance.resistance_rise_per_k = RISE_PER_K;
    let behind_leads = DRIVES.map(|drive| (drive, 0.4));
    for (drive, lead_share) in DRIVES
        .map(|drive| (drive, 0.0))
        .into_iter()
        .chain(behind_leads)
    {
        let setting = Setting {
            drive,
            lead_share,
            ..setting(EffectSet::of(EffectId::PhaseDependentResistance))
        };
        let samples = drive_of(drive, &current_a(DT_S));
        let shown = trace(&setting, &params(), &values, &samples, DT_S);
        let heating = |p: f64, degc: f64| {
            let ratio = (1.0 + 0.2 * p) * (1.0 + RISE_PER_K * (degc - setting.reference_degc));
            match drive {
                Drive::Current => ratio,
                Drive::Duty { .. } | Drive::Voltage { .. } => {
                    ratio / ((1.0 - lead_share) * ratio + lead_share).powi(2)
                }
                Drive::Power { .. } => 1.0,
            }
        };
        let fine = Fine {
            shares: &[1.0],
            latent_j_per_m: 0.0,
            net: &|_, i, degc, p| vec![joule(i) * heating(p[0], degc[0]) - loss(degc[0])],
        };
        let (expected, _) = fine.run(&current_a(DT_S));
        let gap = largest(&shown.displacement, &expected) / params().gain;
        assert!(gap < 1e-4, "{drive:?} {lead_share} {gap:e}");
    }
}

#[test]
fn ambient_drift_is_smooth_through_its_knots() {
    let knots_k = [2.0, -1.0, 3.0, 5.0, 4.5, -2.0, 0.0, 1.0];
    let mut values = EffectValues::default();
    for (k, knot_k) in knots_k.into_iter().enumerate() {
        *values.slot(EffectId::AmbientDrift, k).unwrap() = knot_k;
    }
    let fine = Fine {
        shares: &[1.0],
        latent_j_per_m: 0.0,
        net: &|time_s, i, degc, _| {
            let hotter = params().heat.conductance_w_per_m_k * wandered(time_s / 120.0, &knots_k);
            vec![joule(i) - loss(degc[0]) + hotter]
        },
    };
    compare(EffectId::AmbientDrift, &values, &fine, 5e-5);
}

/// Through 0 and knots at equal parts of the run, by Hermite's cubics: the slope at a knot is that of the line through its
/// neighbors, at an end that to its neighbor.
fn wandered(run_share: f64, knots: &[f64]) -> f64 {
    let value = |k: usize| if k == 0 { 0.0 } else { knots[k - 1] };
    let last = knots.len();
    let slope = |k: usize| match k {
        0 => value(1) - value(0),
        k if k == last => value(last) - value(last - 1),
        k => 0.5 * (value(k + 1) - value(k - 1)),
    };
    let place = last as f64 * run_share.clamp(0.0, 1.0);
    let k = (place as usize).min(last - 1);
    let x = place - k as f64;
    value(k) * (1.0 + 2.0 * x) * (1.0 - x).powi(2)
        + slope(k) * x * (1.0 - x).powi(2)
        + value(k + 1) * x * x * (3.0 - 2.0 * x)
        + slope(k + 1) * x * x * (x - 1.0)
}

/// Through 0 and knots at quarters of the run, by Neville's scheme.
fn drift(run_share: f64, knots: [f64; 4]) -> f64 {
    let place = 4.0 * run_share.clamp(0.0, 1.0);
    let mut at = [0.0, knots[0], knots[1], knots[2], knots[3]];
    for order in 1..5 {
        for k in 0..5 - order {
            let (left, right) = (k as f64, (k + order) as f64);
            at[k] = ((right - place) * at[k] + (place - left) * at[k + 1]) / (right - left);
        }
    }
    at[0]
}

/// A rod whose ends cool over 0.3 of its length, and its zones from the middle to the clamp.
struct Ends {
    values: EffectValues,
    /// Lengths over that on which a fin cools; half of the middle first.
    lengths: [f64; 6],
}

impl Ends {
    fn new(contact_ratio: f64, clamp_warming: f64, clamp_s: f64) -> Self {
        let mut values = EffectValues::default();
        values.end_conduction.end_share = 0.3;
        values.end_conduction.contact_ratio = contact_ratio;
        values.end_conduction.clamp_warming = clamp_warming;
        values.end_conduction.clamp_s = clamp_s;
        let shorter = 1.0 + 2.85 * 0.3;
        let lengths = [1.0 / 0.3, 1.2, 0.7, 0.45, 0.3, 0.2].map(|length| length / shorter);
        Self { values, lengths }
    }

    /// The clamps are a zone without a share.
    fn shares(&self) -> [f64; 7] {
        std::array::from_fn(|z| self.lengths.get(z).map_or(0.0, |length| 0.3 * length))
    }

    /// Heat into each zone, W/m, and what warms the clamps as the rod's heat capacity would be warmed.
    fn net(&self, i: f64, degc: &[f64], fractions: &[f64]) -> Vec<f64> {
        const CLAMP: usize = 6;
        let ends = &self.values.end_conduction;
        let heat = params().heat;
        let mut net: Vec<f64> = (0..CLAMP).map(|z| joule(i) - loss(degc[z])).collect();
        for z in 0..CLAMP {
            // Ways to the next node over the conductivity, of the mean of 8.6 and 18 W/(m K).
            let resistance = |z: usize| {
                let conductivity = (8.6 + (18.0 - 8.6) * fractions[z]) / 13.3;
                match z {
                    0 => 1.0 / (1.0 / 0.9_f64).hypot(2.0 / self.lengths[0]) / conductivity,
                    CLAMP => ends.contact_ratio,
                    _ => 0.5 * self.lengths[z] / conductivity,
                }
            };
            let flow = heat.conductance_w_per_m_k * (degc[z] - degc[z + 1])
                / (resistance(z) + resistance(z + 1));
            net[z] -= flow / self.lengths[z];
            if z + 1 < CLAMP {
                net[z + 1] += flow / self.lengths[z + 1];
            }
        }
        let behind_k =
            ends.clamp_warming * (degc[CLAMP - 1] - AMBIENT_DEGC) - (degc[CLAMP] - AMBIENT_DEGC);
        net.push(heat.heat_capacity_j_per_m_k * behind_k / ends.clamp_s);
        net
    }
}

#[test]
fn ends_exchange_heat_with_clamps_and_middle() {
    for (contact, warming, clamp_s) in [(0.5, 0.0, 200.0), (0.1, 0.5, 30.0), (2.0, 0.9, 5.0)] {
        let ends = Ends::new(contact, warming, clamp_s);
        let fine = Fine {
            shares: &ends.shares(),
            latent_j_per_m: 0.0,
            net: &|_, i, degc, fractions| ends.net(i, degc, fractions),
        };
        compare(EffectId::EndConduction, &ends.values, &fine, 1e-4);
    }
}

#[test]
fn latent_heat_and_conduction_go_together() {
    let mut ends = Ends::new(0.5, 0.3, 60.0);
    ends.values.latent_heat.latent_heat_j_per_kg = 12_000.0;
    let fine = Fine {
        shares: &ends.shares(),
        latent_j_per_m: 12_000.0 * rod().mass_kg_per_m(),
        net: &|_, i, degc, fractions| ends.net(i, degc, fractions),
    };
    let active = EffectSet::of(EffectId::EndConduction).with(EffectId::LatentHeat);
    let current = current_a(DT_S);
    let shown = trace(&setting(active), &params(), &ends.values, &current, DT_S);
    let (expected, _) = fine.run(&current);
    let gap = largest(&shown.displacement, &expected) / params().gain;
    assert!(gap < 2e-4, "{gap:e} of the stroke");
    assert!(
        shown.largest_residual_k <= 1e-9,
        "{:e}",
        shown.largest_residual_k
    );
}

#[test]
fn in_the_steady_state_the_ends_are_fins() {
    // A fin in closed form: T_m - T = T_m e^(-x/ℓ)/(1 + c), so that the rod's mean is lower by φ T_m/(1 + c), with φ and c of
    // martensite's conductivity. A rod that expands, far below its transformation, shows its mean temperature.
    let cold: f64 = (8.6_f64 / 13.3).sqrt();
    let mut values = EffectValues::default();
    values.thermal_expansion.expansion_per_k = 1e-5;
    let active = EffectSet::of(EffectId::EndConduction).with(EffectId::ThermalExpansion);
    let still = WienerParams {
        limiting_loop: LoopParams {
            loop_center_degc: 300.0,
            ..params().limiting_loop
        },
        ..params()
    };
    let current = vec![0.8; 2000];
    let rise = |values: &EffectValues| {
        let shown = trace(&setting(active), &still, values, &current, DT_S).displacement;
        shown[0] - shown[shown.len() - 1]
    };
    let everywhere = rise(&values);
    for share in [0.05, 0.1, 0.2] {
        for contact in [0.1, 0.5, 2.0] {
            values.end_conduction.end_share = share;
            values.end_conduction.contact_ratio = contact;
            values.end_conduction.clamp_warming = 0.0;
            let missing = 1.0 - rise(&values) / everywhere;
            let of_a_fin = cold * share / (1.0 + cold * contact);
            assert!(
                (missing / of_a_fin - 1.0).abs() < 0.08,
                "{share} {contact}: {missing} {of_a_fin}"
            );
        }
    }
}

#[test]
fn dead_time_is_a_shift_of_the_drive() {
    // 0.35 s in samples of 0.2 s: seven samples of 0.05 s.
    let mut values = EffectValues::default();
    values.dead_time.dead_time_s = 0.35;
    let shown = with_effect(EffectId::DeadTime, &values, DT_S);
    let mut shifted = vec![0.0; 7];
    shifted.extend(current_a(DT_S).iter().flat_map(|&i| [i; 4]));
    shifted.truncate(4 * shown.displacement.len());
    let expected = trace(
        &setting(EffectSet::EMPTY),
        &params(),
        &EffectValues::default(),
        &shifted,
        0.05,
    );
    let expected: Vec<f64> = expected.displacement.iter().step_by(4).copied().collect();
    let gap = largest(&shown.displacement, &expected) / params().gain;
    assert!(gap < 1e-6, "{gap:e}");
}

#[test]
fn a_delayed_drive_turns_the_rod_where_it_changes_in_samples_of_any_length() {
    // Ticks of 0.05 s: the drive changes each 1.25 s. Samples end there, a tick later, and each 0.3 s: of ends of samples that are
    // delayed into another, the first but one is a change.
    const TICK_S: f64 = 0.05;
    let ticks: Vec<f64> = (0..1600)
        .map(|k| if k / 25 % 2 == 0 { 2.4 } else { 0.9 })
        .collect();
    let mut values = EffectValues::default();
    values.dead_time.dead_time_s = 0.35;
    let setting = setting(EffectSet::of(EffectId::DeadTime));
    let fine = trace(&setting, &params(), &values, &ticks, TICK_S);
    let turns = fine.fraction.windows(3);
    let turns = turns
        .filter(|w| (w[1] - w[0]) * (w[2] - w[1]) < 0.0)
        .count();
    assert!(turns > 20, "{turns}");

    let plant = ExtendedPlant::new(&setting, &params(), &values).unwrap();
    let mut state = plant.rest(AMBIENT_DEGC);
    let ends: Vec<usize> = (0..ticks.len())
        .filter(|k| k % 25 < 2 || k % 6 == 0)
        .collect();
    let mut gap = 0.0_f64;
    for pair in ends.windows(2) {
        let shown = plant.output(&state).displacement[0];
        gap = gap.max((shown - fine.displacement[pair[0]]).abs() / params().gain);
        let input = Input {
            drive: [ticks[pair[0]]],
            ambient_degc: AMBIENT_DEGC,
        };
        plant.step(&mut state, &input, (pair[1] - pair[0]) as f64 * TICK_S);
    }
    assert!(gap < 1e-6, "{gap:e}");
}

#[test]
fn a_delay_behind_the_rod_shifts_the_output_and_leaves_the_temperature() {
    for (delay_s, share) in [(0.4, 1.0), (0.8, 0.5), (0.5, 0.6), (0.9, 1.0)] {
        let mut values = EffectValues::default();
        values.dead_time.dead_time_s = delay_s;
        values.dead_time.dead_time_output_share = share;
        let shown = with_effect(EffectId::DeadTime, &values, DT_S);
        values.dead_time.dead_time_s = delay_s * (1.0 - share);
        values.dead_time.dead_time_output_share = 0.0;
        let of_drive = with_effect(EffectId::DeadTime, &values, DT_S);
        assert_eq!(shown.temperature_degc, of_drive.temperature_degc);
        let fine = with_effect(EffectId::DeadTime, &values, 0.1 * DT_S).displacement;
        let samples = (10.0 * delay_s * share / DT_S).round() as usize;
        let gap = (samples / 10 + 1..shown.displacement.len())
            .map(|k| (shown.displacement[k] - fine[10 * k - samples]).abs())
            .fold(0.0, f64::max);
        assert!(gap < 1e-5 * params().gain, "{delay_s} {share}: {gap:e}");
    }
}

#[test]
fn a_lag_behind_a_delay_is_a_delayed_lag() {
    let mut values = EffectValues::default();
    values.output_lag.output_lag_s = 0.3;
    let lagging = with_effect(EffectId::OutputLag, &values, DT_S).displacement;
    values.dead_time.dead_time_s = 0.4;
    values.dead_time.dead_time_output_share = 1.0;
    let both = EffectSet::of(EffectId::OutputLag).with(EffectId::DeadTime);
    let shown = trace(&setting(both), &params(), &values, &current_a(DT_S), DT_S).displacement;
    let gap = largest(&shown[2..], &lagging[..lagging.len() - 2]) / params().gain;
    assert!(gap < 1e-4, "{gap:e}");
}

#[test]
fn before_a_run_that_begins_warm_the_rod_was_held() {
    const RISE_K: f64 = 38.0;
    let lost_w_per_m = params().heat.conductance_w_per_m_k * RISE_K;
    let holding_a = (lost_w_per_m / rod().resistance_ohm_per_m).sqrt();
    for (effect, size) in [(EffectId::DeadTime, 0.4), (EffectId::SupplyLag, 0.3)] {
        let mut values = EffectValues::default();
        *values.slot(effect, 0).unwrap() = size;
        for drive in DRIVES {
            let setting = Setting {
                drive,
                ..setting(EffectSet::of(effect))
            };
            let plant = ExtendedPlant::new(&setting, &params(), &values).unwrap();
            let mut state = plant.between_limiting_curves(AMBIENT_DEGC + RISE_K, 0.4);
            let start = plant.output(&state);
            for held in drive_of(drive, &[holding_a; 10]) {
                let input = Input {
                    drive: [held],
                    ambient_degc: AMBIENT_DEGC,
                };
                plant.step(&mut state, &input, DT_S);
            }
            let end = plant.output(&state);
            let warmer_k = end.temperature_degc[0] - start.temperature_degc[0];
            assert!(warmer_k.abs() < 1e-9, "{effect} {drive:?}: {warmer_k:e}");
            assert_abs_diff_eq!(end.displacement[0], start.displacement[0], epsilon = 1e-9);
        }
    }
}

#[test]
fn dead_time_of_whole_samples_is_exact() {
    for (delay_s, samples) in [(0.4, 2), (0.6, 3), (1.0, 5)] {
        let mut values = EffectValues::default();
        values.dead_time.dead_time_s = delay_s;
        let shown = with_effect(EffectId::DeadTime, &values, DT_S).displacement;
        let expected = baseline().displacement;
        for k in samples..shown.len() {
            assert_abs_diff_eq!(shown[k], expected[k - samples], epsilon = 1e-9);
        }
    }
}

#[test]
fn a_delay_of_any_number_of_samples_is_exact() {
    const FINE_S: f64 = 0.002;
    let current = current_a(FINE_S);
    let without = setting(EffectSet::EMPTY);
    let plain = trace(
        &without,
        &params(),
        &EffectValues::default(),
        &current,
        FINE_S,
    );
    let active = setting(EffectSet::of(EffectId::DeadTime));
    for share in [0.0, 1.0] {
        let mut values = EffectValues::default();
        values.dead_time.dead_time_s = 1.0;
        values.dead_time.dead_time_output_share = share;
        let shown = trace(&active, &params(), &values, &current, FINE_S);
        let gap = largest(
            &shown.displacement[500..],
            &plain.displacement[..current.len() - 500],
        );
        assert!(gap < 1e-9 * params().gain, "{share}: {gap:e}");
        assert!(largest(&shown.displacement[..500], &[shown.displacement[0]; 500]) < 1e-12);
    }
}

#[test]
fn supply_lag_is_that_of_the_amplitude_or_of_the_power() {
    let mut values = EffectValues::default();
    values.supply_lag.supply_lag_s = 0.1;
    for drive in DRIVES {
        let setting = Setting {
            drive,
            ..setting(EffectSet::of(EffectId::SupplyLag))
        };
        let samples = drive_of(drive, &current_a(DT_S));
        let shown = trace(&setting, &params(), &values, &samples, DT_S);
        // The lagged drive itself, in fine samples of the baseline.
        let parts = 200;
        let keeps = (-DT_S / parts as f64 / 0.1).exp();
        let (mut level, mut fine) = (0.0, Vec::new());
        for &sample in &samples {
            for _ in 0..parts {
                let next: f64 = sample + (level - sample) * keeps;
                fine.push(0.5 * (level + next));
                level = next;
            }
        }
        let plain = Setting {
            active: EffectSet::EMPTY,
            ..setting
        };
        let fine = trace(&plain, &params(), &EffectValues::default(), &fine, 1e-3);
        let sampled =
            |values: &[f64]| -> Vec<f64> { values.iter().step_by(parts).copied().collect() };
        let gap_k = largest(&shown.temperature_degc, &sampled(&fine.temperature_degc));
        assert!(gap_k < 1e-4, "{drive:?} {gap_k:e} K");
        // The loop turns where the rod does, between two samples.
        let gap_mm = largest(&shown.displacement, &sampled(&fine.displacement));
        assert!(gap_mm < 1e-4 * params().gain, "{drive:?} {gap_mm:e} mm");
    }
}

#[test]
fn stress_is_solved_for() {
    let mut values = EffectValues::default();
    values.stress_coupling.stress_shift_k = 15.0;
    let shown = with_effect(EffectId::StressCoupling, &values, DT_S);
    // The temperature does not depend on the fraction; the fraction by halving an interval.
    let degc = baseline().temperature_degc;
    assert_eq!(shown.temperature_degc, degc);
    let operator = operator(Rule::LastReversal);
    let mut start_degc = AMBIENT_DEGC;
    for _ in 0..100 {
        let [fraction] = operator.limits().fraction(Branch::Cooling, [start_degc]);
        start_degc = AMBIENT_DEGC - 15.0 * fraction;
    }
    let mut memory = operator.on_limiting_curve(Branch::Cooling, [start_degc]);
    for (k, &degc) in degc.iter().enumerate() {
        let (mut lower, mut upper) = (0.0, 1.0);
        for _ in 0..60 {
            let tried = 0.5 * (lower + upper);
            let found = operator.peek(&memory, [degc - 15.0 * tried]).fraction[0];
            (lower, upper) = if found > tried {
                (tried, upper)
            } else {
                (lower, tried)
            };
        }
        let _fraction = operator.commit(&mut memory, [degc - 15.0 * lower]);
        assert_abs_diff_eq!(shown.fraction[k], lower, epsilon = 1e-10);
    }
}

/// A rod that takes on the temperature of balance within a sample: the loop's own input.
fn quick(limiting_loop: LoopParams) -> WienerParams {
    WienerParams {
        heat: HeatBalanceParams {
            heat_capacity_j_per_m_k: 1e-3,
            conductance_w_per_m_k: 1.0,
            resistance_ohm_per_m: 1.0,
        },
        limiting_loop,
        ..params()
    }
}

/// Currents for temperatures up and down, °C, in such a rod.
fn sweep(degc: &[f64]) -> Vec<f64> {
    degc.iter()
        .map(|degc| (degc - AMBIENT_DEGC).sqrt())
        .collect()
}

fn up_and_down(highest_degc: f64) -> Vec<f64> {
    let count = 400;
    let at = |k: usize| AMBIENT_DEGC + (highest_degc - AMBIENT_DEGC) * k as f64 / count as f64;
    (0..=count).chain((0..count).rev()).map(at).collect()
}

#[test]
fn asymmetry_moves_the_limiting_curves_by_the_formula() {
    let shape = params().limiting_loop;
    let mut values = EffectValues::default();
    values.loop_asymmetry.loop_asymmetry = 0.15;
    let active = setting(EffectSet::of(EffectId::LoopAsymmetry));
    let mut drive = sweep(&up_and_down(110.0));
    drive.push(0.0);
    let shown = trace(&active, &quick(shape), &values, &drive, 1.0);
    let mut compared = 0;
    for (k, (&p, &degc)) in shown
        .fraction
        .iter()
        .zip(&shown.temperature_degc)
        .enumerate()
    {
        // On the limiting curves only: far from where each sweep began.
        let side = match k {
            0..=401 if degc > 90.0 => 1.0,
            402.. if degc < 60.0 => -1.0,
            _ => continue,
        };
        let spread_k = shape.loop_spread_k * (1.0 - side * 0.15);
        let from_branch_k = spread_k * (PI * (p - 0.5)).tan();
        let expected_degc = shape.loop_center_degc + side * shape.loop_half_width_k + from_branch_k;
        assert_abs_diff_eq!(degc, expected_degc, epsilon = 1e-6);
        compared += 1;
    }
    assert!(compared > 150);
}

#[test]
fn fatigue_shifts_the_loop_with_the_cycles_and_fades() {
    let mut values = EffectValues::default();
    values.functional_fatigue.fatigue_k = 3.0;
    values.functional_fatigue.fatigue_stroke_loss = 0.05;
    values.functional_fatigue.fatigue_fading = 0.6;
    let shown = with_effect(EffectId::FunctionalFatigue, &values, DT_S);
    let operator = operator(Rule::LastReversal);
    let mut memory = operator.on_limiting_curve(Branch::Cooling, [AMBIENT_DEGC]);
    let mut cycles = 0.0_f64;
    for k in 0..shown.fraction.len() {
        if k > 0 {
            cycles += 0.5 * (shown.fraction[k] - shown.fraction[k - 1]).abs();
        }
        let come = (-0.6 * cycles).exp_m1() / (-0.6_f64).exp_m1();
        let [expected] = operator.commit(&mut memory, [shown.temperature_degc[k] - 3.0 * come]);
        assert_abs_diff_eq!(shown.fraction[k], expected, epsilon = 1e-10);
        let of = params();
        let stroke = of.gain * (expected * (1.0 - 0.05 * come)) + of.offset;
        assert_abs_diff_eq!(shown.displacement[k], stroke, epsilon = 1e-9);
    }
    assert!(cycles > 1.5);
}

#[test]
fn memory_is_blended() {
    let mut values = EffectValues::default();
    values.return_point_memory.return_point_share = 0.3;
    let shown = with_effect(EffectId::ReturnPointMemory, &values, DT_S);
    let degc = baseline().temperature_degc;
    let fractions = [Rule::LastReversal, Rule::Nested].map(|rule| {
        let operator = operator(rule);
        let mut memory = operator.on_limiting_curve(Branch::Cooling, [AMBIENT_DEGC]);
        let visit = |&degc: &f64| operator.commit(&mut memory, [degc])[0];
        degc.iter().map(visit).collect::<Vec<f64>>()
    });
    assert!(largest(&fractions[0], &fractions[1]) > 1e-3);
    for k in 0..degc.len() {
        let expected = 0.7 * fractions[0][k] + 0.3 * fractions[1][k];
        assert_abs_diff_eq!(shown.fraction[k], expected, epsilon = 1e-14);
    }
}

#[test]
fn the_shape_is_bent_by_polynomials_that_keep_the_ends_and_rise() {
    let mut values = EffectValues::default();
    values.loop_shape.loop_shape_1 = 0.3;
    values.loop_shape.loop_shape_2 = -0.3;
    values.loop_shape.loop_shape_3 = 0.3;
    let shown = with_effect(EffectId::LoopShape, &values, DT_S);
    let bent = |p: f64| {
        p + 0.3 * (p - p * p) - 0.3 * (p - 3.0 * p * p + 2.0 * p.powi(3))
            + 0.3 * (p - 6.0 * p * p + 10.0 * p.powi(3) - 5.0 * p.powi(4))
    };
    for (&shown, &p) in shown.fraction.iter().zip(&baseline().fraction) {
        assert_abs_diff_eq!(shown, bent(p), epsilon = 1e-14);
    }
    assert_abs_diff_eq!(bent(1.0), 1.0, epsilon = 1e-14);
    assert!((0..1000).all(|k| bent(f64::from(k) * 1e-3) < bent(f64::from(k + 1) * 1e-3)));
}

#[test]
fn the_r_phase_gives_stroke_back_mostly_on_cooling() {
    let shape = params().limiting_loop;
    let mut values = EffectValues::default();
    values.r_phase.r_phase_share = 0.2;
    values.r_phase.r_phase_above_k = 10.0;
    values.r_phase.r_phase_spread_k = 2.0;
    let mut drive = sweep(&up_and_down(150.0));
    drive.push(0.0);
    let run = |values: &EffectValues| {
        let active = setting(EffectSet::of(EffectId::RPhase));
        trace(&active, &quick(shape), values, &drive, 1.0)
    };
    let (shown, plain) = (run(&values), run(&EffectValues::default()));
    let middle_degc = shape.loop_center_degc - shape.loop_half_width_k + 10.0;
    let given_back = |k: usize| (plain.displacement[k] - shown.displacement[k]) / 5.0;
    for (k, &degc) in shown.temperature_degc.iter().enumerate() {
        // Its own loop: 1.5 K late to either side.
        let side = if k <= 401 { 1.5 } else { -1.5 };
        let given_up = 0.5 - ((degc - side - middle_degc) / 2.0).atan() / std::f64::consts::PI;
        let expected = 0.2 * plain.fraction[k] * given_up;
        // The first 3 K after the start and after the reversal are inside its loop.
        let after = if k <= 401 { 0 } else { 401 };
        let moved_k = (degc - shown.temperature_degc[after]).abs();
        if moved_k > 3.0 && k != 401 {
            assert_abs_diff_eq!(given_back(k), expected, epsilon = 1e-9);
        }
    }
    let most = |range: std::ops::Range<usize>| range.map(given_back).fold(0.0, f64::max);
    let [heating, cooling] = [most(0..401), most(402..800)];
    assert!(cooling > 1.5 * heating, "{cooling} against {heating}");
}

#[test]
fn output_lag_is_a_filter_of_the_output() {
    let mut values = EffectValues::default();
    values.output_lag.output_lag_s = 0.15;
    let shown = with_effect(EffectId::OutputLag, &values, DT_S).displacement;
    let parts = 200;
    let fine: Vec<f64> = current_a(DT_S)
        .iter()
        .flat_map(|&i| vec![i; parts])
        .collect();
    let plain = EffectValues::default();
    let plain = trace(&setting(EffectSet::EMPTY), &params(), &plain, &fine, 1e-3).displacement;
    let mut value = plain[0];
    let mut expected = Vec::new();
    for k in 0..plain.len() {
        if k > 0 {
            let middle = 0.5 * (plain[k] + plain[k - 1]);
            value = middle + (value - middle) * (-1e-3_f64 / 0.15).exp();
        }
        if k % parts == 0 {
            expected.push(value);
        }
    }
    let gap = largest(&shown, &expected) / params().gain;
    assert!(gap < 1e-4, "{gap:e}");
}

#[test]
fn the_thermocouple_is_a_filter_of_the_temperature() {
    let mut values = EffectValues::default();
    values.thermocouple_lag.thermocouple_lag_s = 0.5;
    values.thermocouple_lag.bead_cooling_per_s = 0.0;
    let shown = with_effect(EffectId::ThermocoupleLag, &values, DT_S);
    assert_eq!(shown.displacement, baseline().displacement);
    // A step from rest, in closed form: two exponentials.
    let current: Vec<f64> = current_a(DT_S);
    let first = current.iter().position(|&i| i > 0.0).unwrap();
    let rise_k = joule(current[first]) / params().heat.conductance_w_per_m_k;
    for k in first..first + 50 {
        let t = (k - first) as f64 * DT_S;
        let (slow, fast) = ((-t / tau_s()).exp(), (-t / 0.5).exp());
        let expected_k = rise_k * (1.0 - (tau_s() * slow - 0.5 * fast) / (tau_s() - 0.5));
        assert_abs_diff_eq!(
            shown.recorded_degc[k] - AMBIENT_DEGC,
            expected_k,
            epsilon = 1e-4
        );
    }
}

#[test]
fn what_the_air_cools_reads_low_and_is_less_late() {
    let mut values = EffectValues::default();
    values.thermocouple_lag.thermocouple_lag_s = 0.5;
    values.thermocouple_lag.bead_cooling_per_s = 0.3;
    let cooled = with_effect(EffectId::ThermocoupleLag, &values, DT_S).recorded_degc;
    values.thermocouple_lag.thermocouple_lag_s = 0.5 / 1.15;
    values.thermocouple_lag.bead_cooling_per_s = 0.0;
    let late = with_effect(EffectId::ThermocoupleLag, &values, DT_S).recorded_degc;
    for (cooled, late) in cooled.iter().zip(&late) {
        let expected_k = (late - AMBIENT_DEGC) / 1.15;
        assert_abs_diff_eq!(cooled - AMBIENT_DEGC, expected_k, epsilon = 1e-9);
    }
}

#[test]
fn backlash_waits_after_each_reversal() {
    let mut values = EffectValues::default();
    values.backlash.backlash_share = 0.1;
    let shown = with_effect(EffectId::Backlash, &values, DT_S).displacement;
    let half = 0.05 * params().gain;
    let mut carried: Option<f64> = None;
    for (&y, &shown) in baseline().displacement.iter().zip(&shown) {
        // It came cooling: the output hangs above.
        let before = carried.unwrap_or(y + half);
        let gap = y - before;
        let expected = if gap > half {
            y - half
        } else if gap < -half {
            y + half
        } else {
            before
        };
        assert_abs_diff_eq!(shown, expected, epsilon = 1e-14);
        carried = Some(expected);
    }
}

#[test]
fn soft_friction_comes_after_by_an_exponential() {
    let (share, softness, relaxed) = (0.1, 2.5, 0.7);
    let mut values = EffectValues::default();
    values.backlash.backlash_share = share;
    values.backlash.backlash_softness = softness;
    values.backlash.backlash_relaxed = relaxed;
    let shown = with_effect(EffectId::Backlash, &values, DT_S).displacement;
    let half = 0.5 * share * params().gain;
    let plain = baseline().displacement;
    let mut lag = -half * (1.0 - relaxed);
    for k in 0..plain.len() {
        // Many small steps of dδ = (1 - δ sign/w)/q dy.
        let way = if k > 0 { plain[k] - plain[k - 1] } else { 0.0 };
        for _ in 0..2000 {
            let end = half * way.signum();
            let middle = lag + 0.5 * (1.0 - lag / end) / softness * (way / 2000.0);
            lag += (1.0 - middle / end) / softness * (way / 2000.0);
        }
        assert_abs_diff_eq!(shown[k], plain[k] - lag, epsilon = 1e-6 * half);
    }
}

#[test]
fn a_supply_that_gives_no_more_is_a_drive_that_is_cut() {
    for drive in DRIVES {
        let asked = drive_of(drive, &current_a(DT_S));
        let highest = asked.iter().copied().fold(0.0, f64::max);
        let limited = Setting {
            drive,
            largest_drive: Some(highest),
            ..setting(EffectSet::of(EffectId::SupplyLimit))
        };
        let mut values = EffectValues::default();
        values.supply_limit.supply_limit_share = 1.0;
        values.supply_limit.supply_limit_position = 0.7;
        let shown = trace(&limited, &params(), &values, &asked, DT_S);
        let cut: Vec<f64> = asked
            .iter()
            .map(|&asked| asked.min(0.7 * highest))
            .collect();
        assert!(cut != asked);
        let none = EffectValues::default();
        let expected = trace(&limited, &params(), &none, &cut, DT_S);
        let off = largest(&shown.displacement, &expected.displacement);
        assert!(off < 1e-12, "{drive:?} {off:e}");
        // One that gives way lets the rest through.
        values.supply_limit.supply_limit_share = 0.6;
        let shown = trace(&limited, &params(), &values, &asked, DT_S);
        let let_through = asked
            .iter()
            .zip(&cut)
            .map(|(asked, cut)| cut + 0.4 * (asked - cut));
        let let_through: Vec<f64> = let_through.collect();
        let expected = trace(&limited, &params(), &none, &let_through, DT_S);
        let off = largest(&shown.displacement, &expected.displacement);
        assert!(off < 1e-12, "{drive:?} {off:e}");
    }
    // A current below zero heats as one above it.
    let setting = setting(EffectSet::of(EffectId::SupplyLimit));
    let mut values = EffectValues::default();
    values.supply_limit.supply_limit_share = 1.0;
    let current = current_a(DT_S);
    let turned: Vec<f64> = current.iter().map(|current_a| -current_a).collect();
    assert_eq!(
        trace(&setting, &params(), &values, &current, DT_S),
        trace(&setting, &params(), &values, &turned, DT_S)
    );
}

#[test]
fn a_hard_stop_is_a_minimum() {
    let mut values = EffectValues::default();
    values.end_stop.end_stop_share = 1.0;
    values.end_stop.end_stop_position = 0.6;
    let shown = with_effect(EffectId::EndStop, &values, DT_S).displacement;
    let stop = params().offset + 0.6 * params().gain;
    let plain = baseline().displacement;
    assert!(plain.iter().any(|&y| y > stop));
    for (&shown, &plain) in shown.iter().zip(&plain) {
        assert_abs_diff_eq!(shown, plain.min(stop), epsilon = 1e-14);
    }
    // Of a sensor mounted the other way round it is a maximum.
    let turned = WienerParams {
        gain: -params().gain,
        ..params()
    };
    let active = setting(EffectSet::of(EffectId::EndStop));
    let current = current_a(DT_S);
    let shown = trace(&active, &turned, &values, &current, DT_S).displacement;
    let plain = trace(&active, &turned, &EffectValues::default(), &current, DT_S).displacement;
    let stop = turned.offset + 0.6 * turned.gain;
    for (&shown, &plain) in shown.iter().zip(&plain) {
        assert_abs_diff_eq!(shown, plain.max(stop), epsilon = 1e-14);
    }
}

#[test]
fn the_sensor_is_bent_between_the_ends_of_the_stroke() {
    let mut values = EffectValues::default();
    values.sensor_nonlinearity.sensor_nonlinearity_quadratic = 0.02;
    values.sensor_nonlinearity.sensor_nonlinearity_cubic = -0.01;
    let shown = with_effect(EffectId::SensorNonlinearity, &values, DT_S).displacement;
    for (&shown, &p) in shown.iter().zip(&baseline().fraction) {
        let cubic = -0.01 * p * (1.0 - p) * (1.0 - 2.0 * p) * 6.0 * 3f64.sqrt();
        let share = p + 0.02 * 4.0 * p * (1.0 - p) + cubic;
        assert_abs_diff_eq!(
            shown,
            params().offset + params().gain * share,
            epsilon = 1e-13
        );
    }
}

#[test]
fn the_sensor_drifts_with_the_clock() {
    let mut values = EffectValues::default();
    values.sensor_drift.sensor_drift_1 = 0.1;
    values.sensor_drift.sensor_drift_2 = -0.05;
    values.sensor_drift.sensor_drift_4 = 0.2;
    let setting = Setting {
        start_s: 20.0,
        ..setting(EffectSet::of(EffectId::SensorDrift))
    };
    let shown = trace(&setting, &params(), &values, &current_a(DT_S), DT_S).displacement;
    for (k, (&shown, &plain)) in shown.iter().zip(&baseline().displacement).enumerate() {
        let run_share = (20.0 + k as f64 * DT_S) / 120.0;
        let drifted = params().gain * drift(run_share, [0.1, -0.05, 0.0, 0.2]);
        assert_abs_diff_eq!(shown, plain + drifted, epsilon = 1e-10);
    }
}

#[test]
fn expansion_acts_against_the_stroke_whatever_its_sign() {
    let mut values = EffectValues::default();
    values.thermal_expansion.expansion_per_k = 1e-5;
    for sign in [1.0, -1.0] {
        let params = WienerParams {
            gain: sign * params().gain,
            ..params()
        };
        let active = setting(EffectSet::of(EffectId::ThermalExpansion));
        let run = |values| trace(&active, &params, values, &current_a(DT_S), DT_S);
        let (shown, plain) = (run(&values), run(&EffectValues::default()));
        // A rod whose stroke, 5 mm, is 4 % of its length.
        let without_length = Setting {
            length_output: None,
            ..active
        };
        let strained = trace(&without_length, &params, &values, &current_a(DT_S), DT_S);
        assert_eq!(strained.displacement, shown.displacement);
        for k in 0..shown.displacement.len() {
            // The share of austenite, from 0 to 1.
            let of_phase = 0.6 + 0.4 * plain.fraction[k];
            let expanded = 1e-5 * 125.0 * of_phase * (plain.temperature_degc[k] - 20.0);
            let expected = plain.displacement[k] - sign * expanded;
            assert_abs_diff_eq!(shown.displacement[k], expected, epsilon = 1e-12);
        }
    }
}
