//! Describing functions: closed forms against quadrature and published cases, and the operator's against its laws.

use approx::assert_abs_diff_eq;
use core::f64::consts::{FRAC_PI_2, PI};
use pid_tune::{
    BiasedSine, DriveLimits, MAX_SETTLING_CYCLES, SineResponse, TemperatureSine, fraction_response,
};
use wiener::hysteresis::{
    Branch, Hysteresis, LimitingLoop, LoopParams, Memory, Rule, SineProximity,
};

const LOOP: LoopParams = LoopParams {
    loop_center_degc: 60.0,
    loop_half_width_k: 8.0,
    loop_spread_k: 4.0,
    fraction_center: 0.5,
    fraction_swing: 0.5,
};
const ZETA: f64 = 0.85;

/// Mean and first harmonic by Gauss-Legendre quadrature of five points on short pieces between the corners.
fn by_quadrature(limits: DriveLimits, sine: BiasedSine, power: i32) -> SineResponse {
    const NODES: [[f64; 2]; 5] = [
        [-0.906_179_845_938_664, 0.236_926_885_056_189_1],
        [-0.538_469_310_105_683_1, 0.478_628_670_499_366_5],
        [0.0, 0.568_888_888_888_888_9],
        [0.538_469_310_105_683_1, 0.478_628_670_499_366_5],
        [0.906_179_845_938_664, 0.236_926_885_056_189_1],
    ];
    let corner = |limit: f64| {
        ((limit - sine.bias) / sine.amplitude)
            .clamp(-1.0, 1.0)
            .asin()
    };
    let corners = [
        -FRAC_PI_2,
        corner(limits.lower),
        corner(limits.upper),
        FRAC_PI_2,
    ];
    let [mut mean, mut first] = [0.0; 2];
    for ends in corners.windows(2) {
        let pieces = 64;
        let half = 0.5 * (ends[1] - ends[0]) / f64::from(pieces);
        for piece in 0..pieces {
            let middle = ends[0] + half * (2.0 * f64::from(piece) + 1.0);
            for [node, weight] in NODES {
                let angle = middle + half * node;
                let value = (sine.bias + sine.amplitude * angle.sin())
                    .clamp(limits.lower, limits.upper)
                    .powi(power);
                mean += weight * half * value / PI;
                first += weight * half * value * angle.sin() * 2.0 / PI;
            }
        }
    }
    SineResponse { mean, first }
}

#[test]
fn closed_forms_agree_with_quadrature() {
    let mut compared = 0;
    for (lower, upper) in [(0.0, 3.0), (0.4, 2.0), (-1.0, 1.0)] {
        let limits = DriveLimits { lower, upper };
        for bias in [-7.0, -0.3, 0.0, 0.4, 1.1, 2.9, 3.0, 12.0] {
            for amplitude in [0.01, 0.7, 2.0, 3.5, 40.0] {
                let sine = BiasedSine { bias, amplitude };
                for (found, power) in [
                    (limits.saturated_sine(sine).unwrap(), 1),
                    (limits.saturated_sine_squared(sine).unwrap(), 2),
                ] {
                    let expected = by_quadrature(limits, sine, power);
                    assert_abs_diff_eq!(found.mean, expected.mean, epsilon = 1e-12);
                    assert_abs_diff_eq!(found.first, expected.first, epsilon = 1e-12);
                    compared += 1;
                }
            }
        }
    }
    assert_eq!(compared, 240);
}

#[test]
fn the_symmetric_limiter_has_the_published_describing_function() {
    // Gelb and Vander Velde 1968, chapter 2: N = (2/π) (asin(δ/A) + (δ/A) sqrt(1 - (δ/A)²)).
    let limits = DriveLimits {
        lower: -1.5,
        upper: 1.5,
    };
    for amplitude in [1.6, 2.0, 5.0, 100.0] {
        let found = limits
            .saturated_sine(BiasedSine {
                bias: 0.0,
                amplitude,
            })
            .unwrap();
        let share: f64 = 1.5 / amplitude;
        let expected = 2.0 / PI * (share.asin() + share * (1.0 - share * share).sqrt());
        assert_abs_diff_eq!(found.mean, 0.0, epsilon = 1e-14);
        assert_abs_diff_eq!(found.first / amplitude, expected, epsilon = 1e-14);
    }
}

#[test]
fn half_waves_relays_and_straight_lines_are_what_they_must_be() {
    let from_zero = |upper| DriveLimits { lower: 0.0, upper };
    let sine = BiasedSine {
        bias: 0.0,
        amplitude: 2.0,
    };
    // Half wave: A/π and A/2, squared A²/4 and 4A²/(3π).
    let half = from_zero(1e3).saturated_sine(sine).unwrap();
    assert_abs_diff_eq!(half.mean, 2.0 / PI, epsilon = 1e-14);
    assert_abs_diff_eq!(half.first, 1.0, epsilon = 1e-14);
    let half = from_zero(1e3).saturated_sine_squared(sine).unwrap();
    assert_abs_diff_eq!(half.mean, 1.0, epsilon = 1e-14);
    assert_abs_diff_eq!(half.first, 16.0 / (3.0 * PI), epsilon = 1e-14);
    // Relay of height M: half of it, and 2M/π.
    let huge = BiasedSine {
        bias: 0.0,
        amplitude: 1e9,
    };
    let relay = from_zero(3.0).saturated_sine(huge).unwrap();
    assert_abs_diff_eq!(relay.mean, 1.5, epsilon = 1e-8);
    assert_abs_diff_eq!(relay.first, 6.0 / PI, epsilon = 1e-8);
    // Nothing saturates: b and A, squared b² + A²/2 and 2bA.
    let inside = BiasedSine {
        bias: 1.5,
        amplitude: 0.25,
    };
    let straight = from_zero(3.0).saturated_sine(inside).unwrap();
    assert_abs_diff_eq!(straight.mean, 1.5, epsilon = 1e-15);
    assert_abs_diff_eq!(straight.first, 0.25, epsilon = 1e-15);
    let square = from_zero(3.0).saturated_sine_squared(inside).unwrap();
    assert_abs_diff_eq!(square.mean, 2.25 + 0.5 * 0.0625, epsilon = 1e-14);
    assert_abs_diff_eq!(square.first, 0.75, epsilon = 1e-14);
    // No sine at all: what the bias is.
    for (bias, expected) in [(-1.0, 0.0), (0.0, 0.0), (2.0, 2.0), (5.0, 3.0)] {
        let still = BiasedSine {
            bias,
            amplitude: 0.0,
        };
        let found = from_zero(3.0).saturated_sine(still).unwrap();
        assert_abs_diff_eq!(found.mean, expected, epsilon = 1e-15);
        assert_abs_diff_eq!(found.first, 0.0, epsilon = 1e-15);
    }
}

#[test]
fn what_is_no_sine_and_no_limits_is_refused() {
    let limits = DriveLimits {
        lower: 0.0,
        upper: 3.0,
    };
    let refused = |limits: DriveLimits, bias, amplitude| {
        let sine = BiasedSine { bias, amplitude };
        let error = limits.saturated_sine(sine).unwrap_err();
        assert_eq!(
            limits.saturated_sine_squared(sine).unwrap_err().to_string(),
            error.to_string()
        );
        error.to_string()
    };
    assert_eq!(refused(limits, f64::NAN, 1.0), "bias = NaN: must be finite");
    assert_eq!(
        refused(limits, 0.0, f64::NAN),
        "amplitude = NaN: must be finite and >= 0"
    );
    assert_eq!(
        refused(limits, 0.0, -1.0),
        "amplitude = -1: must be finite and >= 0"
    );
    let inverted = DriveLimits {
        lower: 3.0,
        upper: f64::NAN,
    };
    assert_eq!(
        refused(inverted, 0.0, 1.0),
        "the drive is limited to 3 .. NaN: both must be finite, the lower below the upper"
    );
}

fn operator(rule: Rule) -> Hysteresis<1> {
    Hysteresis::new(
        LimitingLoop::new([LOOP]).unwrap(),
        SineProximity::new([ZETA]).unwrap(),
        rule,
    )
}

fn cold(operator: &Hysteresis<1>) -> Memory<1> {
    operator.on_limiting_curve(Branch::Cooling, [22.0])
}

fn sine(bias_degc: f64, amplitude_k: f64) -> TemperatureSine {
    TemperatureSine {
        bias_degc,
        amplitude_k,
    }
}

#[test]
fn a_cycle_through_the_whole_loop_is_centered_and_lags() {
    for rule in [Rule::LastReversal, Rule::Nested] {
        let operator = operator(rule);
        let found = fraction_response(&operator, &cold(&operator), sine(60.0, 60.0)).unwrap();
        assert!(found.periodic);
        assert_abs_diff_eq!(found.mean, 0.5, epsilon = 1e-9);
        assert!(found.first.re > 0.4 && found.first.im < -0.01, "{found:?}");
    }
}

#[test]
fn the_imaginary_part_is_the_area_of_the_loop() {
    // ∮ ξ dT = π A Im(first), negative because the loop is run through counterclockwise.
    let operator = operator(Rule::Nested);
    for amplitude_k in [3.0, 10.0, 25.0] {
        let sine = sine(62.0, amplitude_k);
        let mut memory = cold(&operator);
        let found = fraction_response(&operator, &memory, sine).unwrap();
        let mut area = 0.0;
        let n = 40_000;
        let mut before = [0.0; 2];
        for k in 0..=3 * n {
            let angle = 2.0 * PI * f64::from(k) / f64::from(n);
            let degc = 62.0 + amplitude_k * angle.sin();
            let [fraction] = operator.commit(&mut memory, [degc]);
            if k > 2 * n {
                area += 0.5 * (fraction + before[1]) * (degc - before[0]);
            }
            before = [degc, fraction];
        }
        assert_abs_diff_eq!(
            PI * amplitude_k * found.first.im,
            area,
            epsilon = 2e-3 * area.abs()
        );
    }
}

#[test]
fn a_small_cycle_has_the_slope_behind_a_reversal() {
    // Minor branches start with 1 - ζ of the slope that the limiting loop has at the same fraction, eq. 12.
    for rule in [Rule::LastReversal, Rule::Nested] {
        let operator = operator(rule);
        // Half-way between the curves the anhysteretic temperature is the temperature itself, eq. 4.
        let memory = operator.between_limiting_curves([66.0], [0.5]);
        let slope_per_k = 4.0 / (PI * (16.0 + 36.0));
        let found = fraction_response(&operator, &memory, sine(66.0, 1e-3)).unwrap();
        assert_abs_diff_eq!(
            found.first.re / 1e-3,
            (1.0 - ZETA) * slope_per_k,
            epsilon = 1e-4 * slope_per_k
        );
    }
}

#[test]
fn history_counts_where_memory_is_nested_and_not_where_it_is_not() {
    let cycle = sine(60.0, 4.0);
    let means = |rule| {
        let operator = operator(rule);
        let hot = operator.on_limiting_curve(Branch::Cooling, [120.0]);
        [cold(&operator), hot].map(|memory| {
            let found = fraction_response(&operator, &memory, cycle).unwrap();
            assert!(found.periodic);
            (found.mean, found.n_cycles)
        })
    };
    let [(below, quick), (above, _)] = means(Rule::Nested);
    assert!(above - below > 0.2, "{below} {above}");
    assert!(quick <= 3, "{quick}");
    let [(below, slow), (above, _)] = means(Rule::LastReversal);
    assert_abs_diff_eq!(below, above, epsilon = 1e-6);
    assert!(slow > 5, "{slow}");
}

#[test]
fn a_creep_that_does_not_end_is_said() {
    let operator = operator(Rule::LastReversal);
    let found = fraction_response(&operator, &cold(&operator), sine(60.0, 0.3)).unwrap();
    assert!(!found.periodic);
    assert_eq!(found.n_cycles, MAX_SETTLING_CYCLES);
}

#[test]
fn what_is_no_cycle_is_refused() {
    let operator = operator(Rule::Nested);
    let refused = |sine| {
        fraction_response(&operator, &cold(&operator), sine)
            .unwrap_err()
            .to_string()
    };
    assert_eq!(
        refused(sine(f64::NAN, 1.0)),
        "bias_degc = NaN: must be finite"
    );
    for amplitude_k in [0.0, -1.0, f64::NAN] {
        assert_eq!(
            refused(sine(60.0, amplitude_k)),
            format!("amplitude_k = {amplitude_k}: must be finite and > 0")
        );
    }
}
