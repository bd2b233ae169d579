//! Laws of the heat balance, over random rods.

use proptest::prelude::*;
use sma_thermal::{HeatBalance, HeatBalanceParams, Heating, Reach};

/// Rounding of a few operations on temperatures of some hundred degrees, K.
const ROUNDING_K: f64 = 1e-12;

fn any_rod() -> impl Strategy<Value = HeatBalanceParams> {
    (0.1..100.0, 0.01..10.0, 0.1..10.0).prop_map(|(tau_s, conductance, resistance)| {
        HeatBalanceParams {
            heat_capacity_j_per_m_k: tau_s * conductance,
            conductance_w_per_m_k: conductance,
            resistance_ohm_per_m: resistance,
        }
    })
}

/// Ambient temperature, and a steady rise above it.
fn any_heating() -> impl Strategy<Value = (f64, f64)> {
    (-20.0..60.0, prop_oneof![Just(0.0), 0.0..200.0])
}

fn heating(rod: &HeatBalanceParams, (ambient_degc, rise_k): (f64, f64)) -> Heating {
    Heating {
        power_w_per_m: [rise_k * rod.conductance_w_per_m_k],
        ambient_degc,
    }
}

fn lanes<const L: usize>(rods: &[HeatBalanceParams]) -> HeatBalance<L> {
    HeatBalance::new(std::array::from_fn(|l| rods[l])).unwrap()
}

#[test]
fn a_model_and_its_sample_say_what_they_were_made_of() {
    let rods = [1.5, 3.0].map(|scale| HeatBalanceParams {
        heat_capacity_j_per_m_k: 2.0 * scale,
        conductance_w_per_m_k: 0.25,
        resistance_ohm_per_m: 0.5 + scale,
    });
    let heat = HeatBalance::new(rods).unwrap();
    assert_eq!(
        heat.resistance_ohm_per_m().map(f64::to_bits),
        [2.0, 3.5].map(f64::to_bits)
    );
    assert_eq!(
        heat.tau_s().map(f64::to_bits),
        [12.0, 24.0].map(f64::to_bits)
    );
    for dt_s in [0.0, 0.25, 3.0] {
        assert_eq!(heat.over(dt_s).dt_s().to_bits(), dt_s.to_bits());
    }
}

proptest! {
    #[test]
    fn two_half_samples_equal_one(
        rod in any_rod(), acting in any_heating(), from in -20.0..200.0, dt_s in 1e-3..100.0,
    ) {
        let heat = HeatBalance::new([rod]).unwrap();
        let heating = heating(&rod, acting);
        let half = heat.over(dt_s / 2.0);
        let [halves] = heat.step(heat.step([from], &heating, &half), &heating, &half);
        let [whole] = heat.step([from], &heating, &heat.over(dt_s));
        prop_assert!((halves - whole).abs() <= ROUNDING_K, "{} {}", halves, whole);
    }

    #[test]
    fn without_current_a_rod_stays_at_ambient_to_the_last_bit(
        rod in any_rod(), ambient_degc in -20.0..60.0, dt_s in 1e-3..100.0,
    ) {
        let heat = HeatBalance::new([rod]).unwrap();
        let heating = heating(&rod, (ambient_degc, 0.0));
        let mut temperature_degc = [ambient_degc];
        for _ in 0..100 {
            temperature_degc = heat.step(temperature_degc, &heating, &heat.over(dt_s));
        }
        prop_assert_eq!(temperature_degc[0].to_bits(), ambient_degc.to_bits());
    }

    #[test]
    fn a_rod_in_balance_stays_there_to_the_last_bit(
        rod in any_rod(), acting in any_heating(), from in -20.0..200.0, dt_s in 1e-3..100.0,
    ) {
        let heat = HeatBalance::new([rod]).unwrap();
        let heating = heating(&rod, acting);
        // So long that nothing is left of the start.
        let balance = heat.step([from], &heating, &heat.over(1e9));
        let mut temperature_degc = balance;
        for _ in 0..100 {
            temperature_degc = heat.step(temperature_degc, &heating, &heat.over(dt_s));
        }
        prop_assert_eq!(temperature_degc[0].to_bits(), balance[0].to_bits());
    }

    #[test]
    fn the_balance_is_approached_from_one_side(
        rod in any_rod(), acting in any_heating(), from in -20.0..200.0, dt_s in 1e-3..10.0,
    ) {
        let heat = HeatBalance::new([rod]).unwrap();
        let heating = heating(&rod, acting);
        let [balance] = heat.step([from], &heating, &heat.over(1e9));
        let sample = heat.over(dt_s);
        let mut before = from;
        for _ in 0..50 {
            let [after] = heat.step([before], &heating, &sample);
            let towards = (balance - from).signum();
            prop_assert!(towards * (after - before) >= -ROUNDING_K);
            prop_assert!(towards * (balance - after) >= 0.0);
            before = after;
        }
    }

    #[test]
    fn a_sample_of_no_length_changes_nothing(
        rod in any_rod(), acting in any_heating(), from in -20.0..200.0,
    ) {
        let heat = HeatBalance::new([rod]).unwrap();
        let [after] = heat.step([from], &heating(&rod, acting), &heat.over(0.0));
        prop_assert!((after - from).abs() <= ROUNDING_K);
    }

    #[test]
    fn the_current_found_leads_where_it_was_asked_to(
        rod in any_rod(), ambient_degc in -20.0..60.0, from_rise in 0.0..100.0,
        rise_k in 0.0..200.0, within_s in 1e-2..100.0,
    ) {
        let heat = HeatBalance::new([rod]).unwrap();
        let from_degc = ambient_degc + from_rise;
        let sample = heat.over(within_s);
        let [coolest] = heat.step([from_degc], &heating(&rod, (ambient_degc, 0.0)), &sample);
        let to_degc = coolest + rise_k;
        let reach = Reach { from_degc, to_degc, ambient_degc, within_s };
        let current_a = heat.current_to_reach_a(&reach).unwrap();
        let heating = Heating {
            power_w_per_m: [current_a * current_a * rod.resistance_ohm_per_m],
            ambient_degc,
        };
        let [reached] = heat.step([from_degc], &heating, &sample);
        // 1 - e^(-t/τ), here no smaller than 1e-4, loses digits in eq. 2 but not in eq. 3.
        prop_assert!((reached - to_degc).abs() <= 1e4 * ROUNDING_K);
    }

    #[test]
    fn the_current_that_holds_does_not_depend_on_the_time(
        rod in any_rod(), ambient_degc in -20.0..60.0, rise_k in 1.0..200.0,
        digits in prop_oneof![Just(-12.0), -15.0..2.0],
    ) {
        let heat = HeatBalance::new([rod]).unwrap();
        let [tau_s] = heat.tau_s();
        let [lambda_k_per_a2] = heat.lambda_k_per_a2();
        let degc = ambient_degc + rise_k;
        let reach = Reach {
            from_degc: degc,
            to_degc: degc,
            ambient_degc,
            within_s: tau_s * 10_f64.powf(digits),
        };
        let current_a = heat.current_to_reach_a(&reach).unwrap();
        let steady_a = ((degc - ambient_degc) / lambda_k_per_a2).sqrt();
        prop_assert!((current_a / steady_a - 1.0).abs() <= ROUNDING_K, "{} {}", current_a, steady_a);
    }

    #[test]
    fn the_sensitivity_is_the_derivative_by_the_power(
        rod in any_rod(), acting in any_heating(), from in -20.0..200.0, dt_s in 1e-2..100.0,
    ) {
        let heat = HeatBalance::new([rod]).unwrap();
        let sample = heat.over(dt_s);
        let (ambient_degc, _) = acting;
        let [power] = heating(&rod, acting).power_w_per_m;
        // A rise of 10 K to either side: the step is linear in the power.
        let aside = 10.0 * rod.conductance_w_per_m_k;
        let [below, above] = [power - aside, power + aside].map(|power| {
            let heating = Heating { power_w_per_m: [power], ambient_degc };
            heat.step([from], &heating, &sample)[0]
        });
        let difference = (above - below) / (2.0 * aside);
        let [sensitivity] = heat.sensitivity_k_m_per_w(&sample);
        prop_assert!((sensitivity - difference).abs() * rod.conductance_w_per_m_k <= ROUNDING_K);
    }

    #[test]
    fn lanes_give_equal_bits(
        rods in prop::collection::vec(any_rod(), 32),
        powers in prop::collection::vec(0.0..100.0, 32),
        from in prop::collection::vec(-20.0..200.0, 32),
        ambient_degc in -20.0..60.0,
        steps_s in prop::collection::vec(1e-3..10.0, 1..10),
    ) {
        let (wide, narrow) = (lanes::<32>(&rods), lanes::<8>(&rods));
        let single: Vec<HeatBalance> = (0..32).map(|l| lanes(&rods[l..])).collect();
        let mut in_wide: [f64; 32] = std::array::from_fn(|l| from[l]);
        let mut in_narrow: [f64; 8] = std::array::from_fn(|l| from[l]);
        let mut alone = from;
        for dt_s in steps_s {
            let heating = Heating { power_w_per_m: std::array::from_fn(|l| powers[l]), ambient_degc };
            in_wide = wide.step(in_wide, &heating, &wide.over(dt_s));
            let heating = Heating { power_w_per_m: std::array::from_fn(|l| powers[l]), ambient_degc };
            in_narrow = narrow.step(in_narrow, &heating, &narrow.over(dt_s));
            for l in 0..32 {
                let heating = Heating { power_w_per_m: [powers[l]], ambient_degc };
                [alone[l]] = single[l].step([alone[l]], &heating, &single[l].over(dt_s));
                prop_assert_eq!(alone[l].to_bits(), in_wide[l].to_bits());
                if l < 8 {
                    prop_assert_eq!(alone[l].to_bits(), in_narrow[l].to_bits());
                }
            }
        }
    }
}

#[test]
fn a_sample_knows_what_it_is_of() {
    let heat = |tau_s: [f64; 3]| {
        HeatBalance::new(tau_s.map(|tau_s| HeatBalanceParams {
            heat_capacity_j_per_m_k: tau_s,
            conductance_w_per_m_k: 1.0,
            resistance_ohm_per_m: 1.0,
        }))
        .unwrap()
    };
    let model = heat([1.0, 2.0, 3.0]);
    for dt_s in [0.0, 0.5, f64::NAN] {
        let sample = model.over(dt_s);
        assert!(sample.is_of(&model, dt_s));
        assert!(!sample.is_of(&model, 0.25));
        assert!(!sample.is_of(&heat([1.0, 2.0, 3.5]), dt_s));
        assert!(!sample.is_of(&heat([1.5, 2.0, 3.0]), dt_s));
    }
}

#[test]
fn a_sample_time_that_is_no_number_gives_no_number() {
    let heat = HeatBalance::new([HeatBalanceParams {
        heat_capacity_j_per_m_k: 2.0,
        conductance_w_per_m_k: 0.5,
        resistance_ohm_per_m: 1.0,
    }])
    .unwrap();
    let heating = Heating {
        power_w_per_m: [1.0],
        ambient_degc: 20.0,
    };
    assert!(heat.step([50.0], &heating, &heat.over(f64::NAN))[0].is_nan());
}
