//! The text of every error.

use std::f64::consts::LN_2;

use sma_thermal::{HeatBalance, HeatBalanceParams, Reach, RodParams, ThermalConstants};

const NOT_POSITIVE: [(f64, &str); 5] = [
    (0.0, "0"),
    (-1.5, "-1.5"),
    (f64::NAN, "NaN"),
    (f64::INFINITY, "inf"),
    (f64::NEG_INFINITY, "-inf"),
];

const NOT_FINITE: [(f64, &str); 3] = [
    (f64::NAN, "NaN"),
    (f64::INFINITY, "inf"),
    (f64::NEG_INFINITY, "-inf"),
];

const ROD: RodParams = RodParams {
    diameter_m: 1.2e-3,
    density_kg_per_m3: 6450.0,
    specific_heat_j_per_kg_k: 480.0,
    resistance_ohm_per_m: 0.83,
    convective_coefficient_w_per_m2_k: 60.0,
};

/// From 100 °C halfway to the ambient temperature of 20 °C, which takes ln 2 time constants of 1 s.
const REACH: Reach = Reach {
    from_degc: 100.0,
    to_degc: 60.0,
    ambient_degc: 20.0,
    within_s: LN_2,
};

fn heat() -> HeatBalance {
    let constants = ThermalConstants {
        tau_s: 1.0,
        lambda_k_per_a2: 10.0,
    };
    HeatBalance::new([HeatBalanceParams::from_constants(constants)]).unwrap()
}

fn unreachable(reach: Reach) -> String {
    heat().current_to_reach_a(&reach).unwrap_err().to_string()
}

#[test]
fn measures_of_a_rod_must_be_positive() {
    type Set = fn(&mut RodParams, f64);
    let fields: [(&str, &str, Set); 5] = [
        ("diameter_m", "m", |rod, value| rod.diameter_m = value),
        ("density_kg_per_m3", "kg/m³", |rod, value| {
            rod.density_kg_per_m3 = value;
        }),
        ("specific_heat_j_per_kg_k", "J/(kg K)", |rod, value| {
            rod.specific_heat_j_per_kg_k = value;
        }),
        ("resistance_ohm_per_m", "Ω/m", |rod, value| {
            rod.resistance_ohm_per_m = value;
        }),
        (
            "convective_coefficient_w_per_m2_k",
            "W/(m² K)",
            |rod, value| rod.convective_coefficient_w_per_m2_k = value,
        ),
    ];
    for (name, unit, set) in fields {
        for (value, shown) in NOT_POSITIVE {
            let mut rod = ROD;
            set(&mut rod, value);
            assert_eq!(
                rod.heat_balance().unwrap_err().to_string(),
                format!("{name} = {shown} {unit}: must be finite and > 0")
            );
        }
    }
}

#[test]
fn coefficients_of_each_lane_must_be_positive() {
    type Set = fn(&mut HeatBalanceParams, f64);
    let fields: [(&str, &str, Set); 3] = [
        ("heat_capacity_j_per_m_k", "J/(m K)", |params, value| {
            params.heat_capacity_j_per_m_k = value;
        }),
        ("conductance_w_per_m_k", "W/(m K)", |params, value| {
            params.conductance_w_per_m_k = value;
        }),
        ("resistance_ohm_per_m", "Ω/m", |params, value| {
            params.resistance_ohm_per_m = value;
        }),
    ];
    let sound = ROD.heat_balance().unwrap();
    for (name, unit, set) in fields {
        for (value, shown) in NOT_POSITIVE {
            for lane in 0..3 {
                let mut lanes = [sound; 3];
                set(&mut lanes[lane], value);
                assert_eq!(
                    HeatBalance::new(lanes).unwrap_err().to_string(),
                    format!("{name} = {shown} {unit}: must be finite and > 0")
                );
            }
        }
    }
}

#[test]
fn a_product_beyond_all_doubles_is_refused() {
    let rod = RodParams {
        density_kg_per_m3: 1e300,
        specific_heat_j_per_kg_k: 1e300,
        ..ROD
    };
    assert_eq!(
        HeatBalance::new([rod.heat_balance().unwrap()])
            .unwrap_err()
            .to_string(),
        "heat_capacity_j_per_m_k = inf J/(m K): must be finite and > 0"
    );
}

#[test]
fn constants_are_checked_under_the_names_that_they_stand_for() {
    for (value, shown) in NOT_POSITIVE {
        let refused = |constants| {
            HeatBalance::new([HeatBalanceParams::from_constants(constants)])
                .unwrap_err()
                .to_string()
        };
        assert_eq!(
            refused(ThermalConstants {
                tau_s: value,
                lambda_k_per_a2: 1.0
            }),
            format!("heat_capacity_j_per_m_k = {shown} J/(m K): must be finite and > 0")
        );
        assert_eq!(
            refused(ThermalConstants {
                tau_s: 1.0,
                lambda_k_per_a2: value
            }),
            format!("resistance_ohm_per_m = {shown} Ω/m: must be finite and > 0")
        );
    }
}

#[test]
fn temperatures_to_be_reached_must_be_finite() {
    type Set = fn(&mut Reach, f64);
    let fields: [(&str, Set); 3] = [
        ("from_degc", |reach, value| reach.from_degc = value),
        ("to_degc", |reach, value| reach.to_degc = value),
        ("ambient_degc", |reach, value| reach.ambient_degc = value),
    ];
    for (name, set) in fields {
        for (value, shown) in NOT_FINITE {
            let mut reach = REACH;
            set(&mut reach, value);
            assert_eq!(
                unreachable(reach),
                format!("{name} = {shown} °C: must be finite")
            );
        }
    }
}

#[test]
fn the_time_allowed_must_be_positive() {
    for (value, shown) in NOT_POSITIVE {
        let reach = Reach {
            within_s: value,
            ..REACH
        };
        assert_eq!(
            unreachable(reach),
            format!("within_s = {shown} s: must be finite and > 0")
        );
    }
}

#[test]
fn a_rod_that_cannot_cool_that_fast_is_told_how_far_it_comes() {
    assert!(heat().current_to_reach_a(&REACH).is_ok());
    assert_eq!(
        unreachable(Reach {
            to_degc: 59.5,
            ..REACH
        }),
        "59.5 °C within 0.6931471805599453 s: the rod cannot cool that fast; without any current it is \
         still at 60 °C then, so ask for at least that or change the time allowed"
    );
}

#[test]
fn what_is_just_reached_or_just_warmer_is_not_refused() {
    // Without current it is at 60 °C then: no current is needed, and 0 A is found.
    let coolest = heat().current_to_reach_a(&Reach {
        to_degc: 60.0,
        ..REACH
    });
    assert!(coolest.unwrap().abs() < 1e-6);
    // At ambient already, and asked to stay: neither below ambient nor too fast.
    let stays = heat().current_to_reach_a(&Reach {
        from_degc: 20.0,
        to_degc: 20.0,
        ..REACH
    });
    assert_eq!(stays.unwrap().to_bits(), 0.0_f64.to_bits());
    // A rod that is to cool down to ambient itself cannot be that fast, and is not told that no rod could.
    assert!(
        unreachable(Reach {
            to_degc: 20.0,
            ..REACH
        })
        .contains("the rod cannot cool that fast")
    );
}

#[test]
fn no_rod_is_heated_to_below_ambient() {
    assert_eq!(
        unreachable(Reach {
            to_degc: 19.5,
            ..REACH
        }),
        "19.5 °C: below the ambient temperature of 20 °C, which no rod reaches by heating"
    );
}

#[test]
fn a_rod_colder_than_ambient_is_not_told_to_wait() {
    let from_cold = Reach {
        from_degc: 4.0,
        ..REACH
    };
    // It passes 10 °C too early: less time would do.
    assert_eq!(
        unreachable(Reach {
            to_degc: 10.0,
            ..from_cold
        }),
        "10 °C within 0.6931471805599453 s: the rod cannot cool that fast; without any current it is \
         still at 12 °C then, so ask for at least that or change the time allowed"
    );
    // It is never at 3 °C.
    assert_eq!(
        unreachable(Reach {
            to_degc: 3.0,
            ..from_cold
        }),
        "3 °C: below the ambient temperature of 20 °C, which no rod reaches by heating"
    );
}
