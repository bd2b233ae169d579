//! Eqs 1-3 of [Sadeghi], each by a second route, with the misprints that were corrected.

use std::collections::BTreeSet;
use std::f64::consts::PI;

use approx::{assert_abs_diff_eq, assert_relative_eq};
use fixtures::sadeghi;
use sma_thermal::{HeatBalance, Heating, Reach, RodParams, ThermalError};

const ROD: RodParams = RodParams {
    diameter_m: 1.2e-3,
    density_kg_per_m3: 6450.0,
    specific_heat_j_per_kg_k: 480.0,
    resistance_ohm_per_m: 0.83,
    convective_coefficient_w_per_m2_k: 60.0,
};
const AMBIENT_DEGC: f64 = 22.0;

fn heat(rod: &RodParams) -> HeatBalance<1> {
    HeatBalance::new([rod.heat_balance().unwrap()]).unwrap()
}

/// Eq. 2: the temperature after `t_s` of a constant current.
fn after(rod: &RodParams, from_degc: f64, current_a: f64, t_s: f64) -> f64 {
    let heat = heat(rod);
    let heating = Heating {
        power_w_per_m: [current_a * current_a * rod.resistance_ohm_per_m],
        ambient_degc: AMBIENT_DEGC,
    };
    let [temperature_degc] = heat.step([from_degc], &heating, &heat.over(t_s));
    temperature_degc
}

/// Eq. 1 solved for dT/dt, K/s, from the rod's measures: a circle of radius r has the area π r² and the
/// circumference 2 π r.
fn rate_k_per_s(rod: &RodParams, temperature_degc: f64, current_a: f64) -> f64 {
    let radius_m = rod.diameter_m / 2.0;
    let mass_kg_per_m = rod.density_kg_per_m3 * PI * radius_m * radius_m;
    let surface_m2_per_m = 2.0 * PI * radius_m;
    let gain_w_per_m = current_a * current_a * rod.resistance_ohm_per_m;
    let loss_w_per_m = rod.convective_coefficient_w_per_m2_k
        * surface_m2_per_m
        * (temperature_degc - AMBIENT_DEGC);
    (gain_w_per_m - loss_w_per_m) / (mass_kg_per_m * rod.specific_heat_j_per_kg_k)
}

/// Classical Runge-Kutta on eq. 1 in steps of 10 ms.
fn runge_kutta(rod: &RodParams, from_degc: f64, current_a: f64, n_steps: u32) -> f64 {
    const STEP_S: f64 = 0.01;
    let rate = |temperature_degc| rate_k_per_s(rod, temperature_degc, current_a);
    let mut temperature_degc = from_degc;
    for _ in 0..n_steps {
        let first = rate(temperature_degc);
        let second = rate(temperature_degc + STEP_S / 2.0 * first);
        let third = rate(temperature_degc + STEP_S / 2.0 * second);
        let fourth = rate(temperature_degc + STEP_S * third);
        temperature_degc += STEP_S / 6.0 * (first + 2.0 * second + 2.0 * third + fourth);
    }
    temperature_degc
}

/// Every correction of eqs 1-3, and of the assumptions under eq. 1, with the test that rests on it.
const COVERED: [(&str, fn()); 8] = [
    (
        "mass",
        eq_1_mass_per_meter_grows_with_the_square_of_the_diameter,
    ),
    ("surface", eq_1_surface_per_meter_knows_no_length),
    ("two-cases", eq_1_cooling_is_heating_without_current),
    ("linear-block", eq_1_is_linear_in_the_square_of_the_current),
    ("conduction-mode", eq_1_loses_heat_by_convection_alone),
    ("maximum-temperature", eq_2_holds_at_any_time),
    (
        "initial-temperature",
        eq_2_starts_from_the_initial_temperature,
    ),
    ("radicand", eq_3_is_defined_for_what_a_current_can_do),
];

#[test]
fn every_correction_of_eqs_1_to_3_has_a_test() {
    // Corrections under "section 3" that speak of the transformation or of headings.
    const ELSEWHERE: [&str; 2] = ["transformation-causes-heat", "section-number"];
    let concerns_heat = |place: &str| {
        let first_number = place
            .split(|c: char| !c.is_ascii_digit())
            .find_map(|digits| digits.parse::<u32>().ok());
        place == "section 3" || place.starts_with("eq") && first_number.is_some_and(|n| n <= 3)
    };
    let printed: BTreeSet<&str> = sadeghi::corrections()
        .unwrap()
        .iter()
        .filter(|correction| concerns_heat(correction.place))
        .map(|correction| correction.id)
        .filter(|id| !ELSEWHERE.contains(id))
        .collect();
    let covered: BTreeSet<&str> = COVERED.iter().map(|(id, _)| *id).collect();
    assert_eq!(printed, covered);
    for (_, test) in COVERED {
        test();
    }
}

#[test]
fn eq_1_holds_along_the_solution() {
    // Heating, cooling, heating to a lower balance.
    let mut exact_degc = AMBIENT_DEGC;
    let mut integrated_degc = AMBIENT_DEGC;
    for (current_a, n_steps) in [(4.0, 600), (0.0, 900), (2.0, 1200)] {
        exact_degc = after(&ROD, exact_degc, current_a, 0.01 * f64::from(n_steps));
        integrated_degc = runge_kutta(&ROD, integrated_degc, current_a, n_steps);
        assert_abs_diff_eq!(exact_degc, integrated_degc, epsilon = 1e-10);
    }
    assert!(exact_degc > AMBIENT_DEGC + 5.0);
}

#[test]
fn eq_1_is_met_at_every_moment() {
    // dT/dt of eq. 2 by a central difference, without any integration.
    const STEP_S: f64 = 1e-3;
    for current_a in [0.0, 1.5, 4.0] {
        for t_s in [0.1, 1.0, 5.0, 20.0, 60.0] {
            let here_degc = after(&ROD, 90.0, current_a, t_s);
            let difference_k = after(&ROD, 90.0, current_a, t_s + STEP_S)
                - after(&ROD, 90.0, current_a, t_s - STEP_S);
            assert_abs_diff_eq!(
                difference_k / (2.0 * STEP_S),
                rate_k_per_s(&ROD, here_degc, current_a),
                epsilon = 1e-7
            );
        }
    }
}

#[test]
fn eq_1_mass_per_meter_grows_with_the_square_of_the_diameter() {
    // Printed "ρπ²d/4": kg/m² instead of kg/m, growing with d.
    let thick = RodParams {
        diameter_m: 2.0 * ROD.diameter_m,
        ..ROD
    };
    assert_relative_eq!(
        thick.mass_kg_per_m(),
        4.0 * ROD.mass_kg_per_m(),
        epsilon = 1e-15
    );
    // A square bar of side d around the rod weighs 4/π as much.
    let bar_kg_per_m = ROD.density_kg_per_m3 * ROD.diameter_m * ROD.diameter_m;
    assert_relative_eq!(
        ROD.mass_kg_per_m() * 4.0 / PI,
        bar_kg_per_m,
        epsilon = 1e-15
    );
    let as_printed = ROD.density_kg_per_m3 * PI * PI * ROD.diameter_m / 4.0;
    assert!(as_printed > 1000.0 * ROD.mass_kg_per_m());
}

#[test]
fn eq_1_surface_per_meter_knows_no_length() {
    // Printed "πdl" beside a mass and a resistance per meter: the time constant would depend on the
    // length of the rod.
    const LENGTH_M: f64 = 0.11;
    let capacity_j_per_k = ROD.mass_kg_per_m() * LENGTH_M * ROD.specific_heat_j_per_kg_k;
    let surface_m2 = PI * ROD.diameter_m * LENGTH_M;
    let conductance_w_per_k = ROD.convective_coefficient_w_per_m2_k * surface_m2;
    let resistance_ohm = ROD.resistance_ohm_per_m * LENGTH_M;
    let heat = heat(&ROD);
    let tau_s = capacity_j_per_k / conductance_w_per_k;
    assert_relative_eq!(heat.tau_s()[0], tau_s, epsilon = 1e-14);
    let lambda_k_per_a2 = resistance_ohm / conductance_w_per_k;
    assert_relative_eq!(heat.lambda_k_per_a2()[0], lambda_k_per_a2, epsilon = 1e-14);
    let as_printed_s = capacity_j_per_k / LENGTH_M / conductance_w_per_k;
    assert!(as_printed_s > 5.0 * tau_s);
}

#[test]
fn eq_1_cooling_is_heating_without_current() {
    // Printed as two cases, in eq. 2 again.
    let tau_s = heat(&ROD).tau_s()[0];
    for t_s in [0.3, 3.0, 30.0] {
        let printed_degc = AMBIENT_DEGC + (90.0 - AMBIENT_DEGC) * (-t_s / tau_s).exp();
        assert_abs_diff_eq!(after(&ROD, 90.0, 0.0, t_s), printed_degc, epsilon = 1e-12);
    }
    assert!(rate_k_per_s(&ROD, 90.0, 0.0) < 0.0);
}

#[test]
fn eq_1_is_linear_in_the_square_of_the_current() {
    // The text calls the block linear; in i it is not.
    let rise_k = |current_a: f64| after(&ROD, AMBIENT_DEGC, current_a, 7.0) - AMBIENT_DEGC;
    assert_abs_diff_eq!(rise_k(5.0), rise_k(3.0) + rise_k(4.0), epsilon = 1e-12);
    assert!(rise_k(5.0) > 1.5 * (rise_k(2.0) + rise_k(3.0)));
    assert_abs_diff_eq!(rise_k(4.0), 4.0 * rise_k(2.0), epsilon = 1e-12);
}

#[test]
fn eq_1_loses_heat_by_convection_alone() {
    // The text compares radiation with a "conduction mode" that eq. 1 does not have. Steadily, all
    // heat leaves as h π d (T - T_a): no term in T⁴, none that the coefficient does not scale.
    for coefficient in [20.0, 60.0, 180.0] {
        let rod = RodParams {
            convective_coefficient_w_per_m2_k: coefficient,
            ..ROD
        };
        for current_a in [0.5, 2.0, 6.0] {
            let steady_degc = after(&rod, AMBIENT_DEGC, current_a, 1e6);
            let loss_w_per_m = coefficient * PI * rod.diameter_m * (steady_degc - AMBIENT_DEGC);
            assert_relative_eq!(
                loss_w_per_m,
                current_a * current_a * rod.resistance_ohm_per_m,
                max_relative = 1e-12
            );
        }
    }
}

#[test]
fn eq_2_adds_up_over_many_small_samples() {
    let heat = heat(&ROD);
    let heating = Heating {
        power_w_per_m: [3.0 * 3.0 * ROD.resistance_ohm_per_m],
        ambient_degc: AMBIENT_DEGC,
    };
    let dt_s = sadeghi::setting("rig.sample_time").unwrap().value();
    let sample = heat.over(dt_s);
    let fine = heat.over(dt_s / 1000.0);
    let mut coarse_degc = [60.0];
    let mut fine_degc = [60.0];
    for _ in 0..50 {
        coarse_degc = heat.step(coarse_degc, &heating, &sample);
        for _ in 0..1000 {
            fine_degc = heat.step(fine_degc, &heating, &fine);
        }
        assert_abs_diff_eq!(coarse_degc[0], fine_degc[0], epsilon = 1e-9);
    }
}

#[test]
fn eq_2_holds_at_any_time() {
    // Printed for "the rod maximum temperature": that is the limit only.
    let heat = heat(&ROD);
    let ([tau_s], [lambda_k_per_a2]) = (heat.tau_s(), heat.lambda_k_per_a2());
    let maximum_degc = AMBIENT_DEGC + 4.0 * lambda_k_per_a2;
    for (multiple, share) in [(0.5, 0.393_469), (1.0, 0.632_121), (3.0, 0.950_213)] {
        let temperature_degc = after(&ROD, AMBIENT_DEGC, 2.0, multiple * tau_s);
        let risen = (temperature_degc - AMBIENT_DEGC) / (maximum_degc - AMBIENT_DEGC);
        assert_abs_diff_eq!(risen, share, epsilon = 5e-7);
    }
    assert_abs_diff_eq!(
        after(&ROD, AMBIENT_DEGC, 2.0, 40.0 * tau_s),
        maximum_degc,
        epsilon = 1e-12
    );
}

#[test]
fn eq_2_starts_from_the_initial_temperature() {
    // Printed: T_i is the temperature "at the time t".
    for from_degc in [10.0, 22.0, 85.0] {
        assert_abs_diff_eq!(after(&ROD, from_degc, 3.0, 0.0), from_degc, epsilon = 1e-12);
        assert!((after(&ROD, from_degc, 3.0, 5.0) - from_degc).abs() > 1.0);
    }
}

fn current_over_a_sample(from_degc: f64, to_degc: f64) -> Result<f64, ThermalError> {
    heat(&ROD).current_to_reach_a(&Reach {
        from_degc,
        to_degc,
        ambient_degc: AMBIENT_DEGC,
        within_s: sadeghi::setting("rig.sample_time").unwrap().value(),
    })
}

#[test]
fn eq_3_inverts_eq_2_over_the_papers_sampling_time() {
    let sample_time = sadeghi::setting("rig.sample_time").unwrap();
    assert!(sample_time.agrees(0.287));
    let mut compared = 0;
    for from_degc in [22.0, 40.0, 75.0, 110.0] {
        for current_a in [0.2, 1.0, 2.5, 10.0] {
            let to_degc = after(&ROD, from_degc, current_a, sample_time.value());
            let found_a = current_over_a_sample(from_degc, to_degc).unwrap();
            // 1e-14 of some 100 °C over the 0.015 K/A² that a sample gives.
            assert_abs_diff_eq!(found_a, current_a, epsilon = 1e-10);
            compared += 1;
        }
    }
    assert_eq!(compared, 16);
}

#[test]
fn eq_3_is_defined_for_what_a_current_can_do() {
    // Printed for any value under the root.
    let coolest_degc = after(&ROD, 75.0, 0.0, 0.287);
    let least_a = current_over_a_sample(75.0, coolest_degc + 1e-9).unwrap();
    assert!((0.0..1e-3).contains(&least_a));
    assert!(matches!(
        current_over_a_sample(75.0, coolest_degc - 1e-9),
        Err(ThermalError::CannotCool { .. })
    ));
    assert!(matches!(
        current_over_a_sample(75.0, AMBIENT_DEGC - 1e-9),
        Err(ThermalError::BelowAmbient { .. })
    ));
}

#[test]
fn eq_3_keeps_its_digits_in_times_far_below_the_time_constant() {
    // So fast that nothing is lost to the surroundings: i² R t = m C_p (T - T_i).
    const RISE_K: f64 = 50.0;
    let heat = heat(&ROD);
    let within_s = 1e-10 * heat.tau_s()[0];
    let found_a = heat
        .current_to_reach_a(&Reach {
            from_degc: AMBIENT_DEGC,
            to_degc: AMBIENT_DEGC + RISE_K,
            ambient_degc: AMBIENT_DEGC,
            within_s,
        })
        .unwrap();
    let heat_j_per_m = ROD.mass_kg_per_m() * ROD.specific_heat_j_per_kg_k * RISE_K;
    let lossless_a = (heat_j_per_m / (ROD.resistance_ohm_per_m * within_s)).sqrt();
    assert_relative_eq!(found_a, lossless_a, max_relative = 1e-9);
}
