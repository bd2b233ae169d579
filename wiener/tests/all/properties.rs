//! Laws of the cascade, over random rods and drives.

use crate::common;

use common::{AMBIENT_DEGC, any_currents, any_params, any_rule, outputs};
use proptest::prelude::*;
use sma_hysteresis::Rule;
use wiener::{Drive, Input, Output, Plant, Profile, Wiener, WienerParams};

fn single(params: WienerParams, rule: Rule) -> Wiener {
    Wiener::new(Drive::Current, rule, &[params]).unwrap()
}

fn bits(outputs: &[Output]) -> Vec<[u64; 2]> {
    let of = |output: &Output| [output.displacement[0], output.temperature_degc[0]];
    outputs
        .iter()
        .map(|output| of(output).map(f64::to_bits))
        .collect()
}

/// Outputs at a fixed step, and at times of equal steps from a start.
fn by_both_clocks(
    model: &Wiener,
    currents_a: &[f64],
    step_s: f64,
    start_s: f64,
) -> [Vec<[u64; 2]>; 2] {
    let time_s: Vec<f64> = (0..currents_a.len())
        .map(|k| start_s + step_s * k as f64)
        .collect();
    let fixed = Profile::uniform(currents_a, step_s, AMBIENT_DEGC).unwrap();
    let timed = Profile::timed(currents_a, &time_s, AMBIENT_DEGC).unwrap();
    [fixed, timed].map(|profile| bits(&outputs(model, model.rest(AMBIENT_DEGC), &profile)))
}

/// Largest difference of displacements, relative to the gain.
fn difference(params: &WienerParams, left: &[Output], right: &[Output]) -> f64 {
    assert_eq!(left.len(), right.len());
    left.iter()
        .zip(right)
        .map(|(left, right)| (left.displacement[0] - right.displacement[0]).abs())
        .fold(0.0, f64::max)
        / params.gain.abs()
}

/// `L` models side by side, each with its own drive.
struct Lanes<const L: usize> {
    model: Wiener<L>,
    state: wiener::State<L>,
}

impl<const L: usize> Lanes<L> {
    fn new(params: &[WienerParams], rule: Rule, shares: &[f64]) -> Self {
        let lanes = std::array::from_fn(|l| params[l]);
        let model = Wiener::new(Drive::Current, rule, &lanes).unwrap();
        let state =
            model.between_limiting_curves([AMBIENT_DEGC; L], std::array::from_fn(|l| shares[l]));
        Self { model, state }
    }

    fn step(&mut self, currents_a: &[f64], dt_s: f64) -> Output<L> {
        let input = Input {
            drive: std::array::from_fn(|l| currents_a[l]),
            ambient_degc: AMBIENT_DEGC,
        };
        self.model.step(&mut self.state, &input, dt_s);
        self.model.output(&self.state)
    }
}

proptest! {
    #[test]
    fn without_a_drive_nothing_moves(
        params in any_params(), rule in any_rule(), share in 0.0..=1.0, dt_s in 1e-3..10.0,
    ) {
        let model = single(params, rule);
        let start = model.between_limiting_curves([AMBIENT_DEGC], [share]);
        let drive = [0.0; 100];
        let profile = Profile::uniform(&drive, dt_s, AMBIENT_DEGC).unwrap();
        let found = bits(&outputs(&model, start, &profile));
        prop_assert_eq!(found[0][1], AMBIENT_DEGC.to_bits());
        prop_assert!(found.iter().all(|output| output == &found[0]));
    }

    #[test]
    fn two_half_samples_equal_one(
        params in any_params(), rule in any_rule(), currents_a in any_currents(), dt_s in 0.01..2.0,
    ) {
        let model = single(params, rule);
        let whole = Profile::uniform(&currents_a, dt_s, AMBIENT_DEGC).unwrap();
        let doubled: Vec<f64> = currents_a.iter().flat_map(|&current_a| [current_a; 2]).collect();
        let halves = Profile::uniform(&doubled, dt_s / 2.0, AMBIENT_DEGC).unwrap();
        let by_whole = outputs(&model, model.rest(AMBIENT_DEGC), &whole);
        let by_halves: Vec<Output> = outputs(&model, model.rest(AMBIENT_DEGC), &halves)
            .into_iter()
            .step_by(2)
            .collect();
        // Temperatures differ by rounding, and a reversal counts from the operator's dead band of
        // 1e-9 K on: over the narrowest spread of 0.5 K.
        let off = difference(&params, &by_whole, &by_halves);
        prop_assert!(off <= 2e-9, "{:e}", off);
    }

    #[test]
    fn lanes_give_equal_bits(
        params in prop::collection::vec(any_params(), 32), rule in any_rule(),
        shares in prop::collection::vec(0.0..=1.0, 32),
        currents_a in prop::collection::vec(prop::collection::vec(0.0..3.0, 32), 1..30),
        dt_s in 0.01..2.0,
    ) {
        let mut wide = Lanes::<32>::new(&params, rule, &shares);
        let mut narrow = Lanes::<8>::new(&params, rule, &shares);
        let mut alone: Vec<Lanes<1>> = (0..32)
            .map(|l| Lanes::new(&params[l..], rule, &shares[l..]))
            .collect();
        for currents_a in &currents_a {
            let from_wide = wide.step(currents_a, dt_s);
            let from_narrow = narrow.step(currents_a, dt_s);
            for l in 0..32 {
                let one = alone[l].step(&currents_a[l..], dt_s);
                let bits = [one.displacement[0], one.temperature_degc[0]].map(f64::to_bits);
                let in_wide = [from_wide.displacement[l], from_wide.temperature_degc[l]];
                prop_assert_eq!(bits, in_wide.map(f64::to_bits));
                if l < 8 {
                    let in_narrow = [from_narrow.displacement[l], from_narrow.temperature_degc[l]];
                    prop_assert_eq!(bits, in_narrow.map(f64::to_bits));
                }
            }
        }
    }

    #[test]
    fn drives_of_equal_power_give_equal_traces(
        params in any_params(), rule in any_rule(), currents_a in any_currents(),
        length_m in 0.01..1.0, supply_v in 1.0..50.0,
    ) {
        let resistance_ohm = params.heat.resistance_ohm_per_m * length_m;
        let trace = |drive: Drive, of_current: &dyn Fn(f64) -> f64| {
            let model = Wiener::new(drive, rule, &[params]).unwrap();
            let values: Vec<f64> = currents_a.iter().map(|&current_a| of_current(current_a)).collect();
            let profile = Profile::uniform(&values, 0.287, AMBIENT_DEGC).unwrap();
            outputs(&model, model.rest(AMBIENT_DEGC), &profile)
        };
        let power_w = |current_a: f64| current_a * current_a * resistance_ohm;
        let expected = trace(Drive::Current, &|current_a| current_a);
        for (drive, of_current) in [
            (Drive::Current, &(|current_a: f64| -current_a) as &dyn Fn(f64) -> f64),
            (Drive::Voltage { length_m }, &|current_a| current_a * resistance_ohm),
            (Drive::Power { length_m }, &power_w),
            (Drive::Duty { supply_v, length_m }, &|current_a| {
                power_w(current_a) * resistance_ohm / (supply_v * supply_v)
            }),
        ] {
            let off = difference(&params, &expected, &trace(drive, of_current));
            // As for half samples.
            prop_assert!(off <= 2e-9, "{:?}: {:e}", drive, off);
        }
    }

    #[test]
    fn times_at_equal_steps_give_the_bits_of_a_fixed_step(
        params in any_params(), rule in any_rule(), currents_a in any_currents(), start in -100_i32..100,
    ) {
        // A quarter of a second: sums and differences are exact.
        let model = single(params, rule);
        let [by_fixed, by_time] = by_both_clocks(&model, &currents_a, 0.25, f64::from(start));
        prop_assert_eq!(by_fixed, by_time);
    }

    #[test]
    fn times_that_were_rounded_are_at_equal_steps(
        params in any_params(), rule in any_rule(), currents_a in any_currents(), step_s in 1e-3..10.0,
    ) {
        let model = single(params, rule);
        let [by_fixed, by_time] = by_both_clocks(&model, &currents_a, step_s, 0.0);
        prop_assert_eq!(by_fixed, by_time);
    }

    #[test]
    fn a_step_that_is_longer_than_rounding_explains_is_of_its_own_length(
        step_s in 0.1..1.0, later in 1e-12..1e-6,
    ) {
        let model = single(common::params(), Rule::Nested);
        let temperature_degc = |later_s: f64| {
            let time_s: Vec<f64> = (0..5)
                .map(|k| step_s * k as f64 + if k == 4 { later_s } else { 0.0 })
                .collect();
            let timed = Profile::timed(&[1.0; 5], &time_s, AMBIENT_DEGC).unwrap();
            let shown = outputs(&model, model.rest(AMBIENT_DEGC), &timed);
            shown[4].temperature_degc[0]
        };
        prop_assert!(temperature_degc(later) > temperature_degc(0.0));
    }

    #[test]
    fn jitter_that_cancels_leaves_the_trace_of_a_held_current(
        params in any_params(), rule in any_rule(), current_a in 0.3..3.0,
        jitter in prop::collection::vec(-0.1..0.1, 40),
    ) {
        // One held current: only the times at which it is read count.
        let model = single(params, rule);
        let currents_a = [current_a; 41];
        let time_s: Vec<f64> = (0..41)
            .map(|k| 0.3 * k as f64 + if k % 40 == 0 { 0.0 } else { jitter[k] })
            .collect();
        let fixed = Profile::uniform(&currents_a, 0.3, AMBIENT_DEGC).unwrap();
        let timed = Profile::timed(&currents_a, &time_s, AMBIENT_DEGC).unwrap();
        let by_fixed = outputs(&model, model.rest(AMBIENT_DEGC), &fixed);
        let by_time = outputs(&model, model.rest(AMBIENT_DEGC), &timed);
        prop_assert!(difference(&params, &by_fixed[40..], &by_time[40..]) <= 1e-11);
    }

    #[test]
    fn a_recorded_ambient_that_stays_gives_the_bits_of_a_constant_one(
        params in any_params(), rule in any_rule(), currents_a in any_currents(),
    ) {
        let model = single(params, rule);
        let ambient_degc = vec![AMBIENT_DEGC; currents_a.len()];
        let constant = Profile::uniform(&currents_a, 0.287, AMBIENT_DEGC).unwrap();
        let recorded = Profile::uniform(&currents_a, 0.287, 0.0)
            .and_then(|profile| profile.with_ambient(&ambient_degc))
            .unwrap();
        prop_assert_eq!(recorded.first_ambient_degc().to_bits(), AMBIENT_DEGC.to_bits());
        let by_constant = outputs(&model, model.rest(AMBIENT_DEGC), &constant);
        let by_recorded = outputs(&model, model.rest(AMBIENT_DEGC), &recorded);
        prop_assert_eq!(bits(&by_constant), bits(&by_recorded));
    }

    #[test]
    fn a_saved_state_goes_on_as_if_never_interrupted(
        params in any_params(), rule in any_rule(), currents_a in any_currents(), cut in 0.0..1.0,
    ) {
        let model = single(params, rule);
        let cut = (cut * currents_a.len() as f64) as usize;
        let input = |current_a| Input { drive: [current_a], ambient_degc: AMBIENT_DEGC };
        let mut whole = model.rest(AMBIENT_DEGC);
        let mut saved = whole.clone();
        for (k, &current_a) in currents_a.iter().enumerate() {
            if k == cut {
                saved = whole.clone();
            }
            model.step(&mut whole, &input(current_a), 0.287);
        }
        for &current_a in &currents_a[cut..] {
            model.step(&mut saved, &input(current_a), 0.287);
        }
        prop_assert_eq!(whole, saved);
    }
}

#[test]
fn a_start_of_known_fraction_shows_it() {
    let model = common::model(Rule::Nested);
    let state = model.at([75.0], [0.5]).unwrap();
    assert!((state.fraction()[0] - 0.5).abs() < 1e-12);
    assert!((state.temperature_degc()[0] - 75.0).abs() < 1e-12);
    let expected = common::params().offset + 0.5 * common::params().gain;
    assert!((model.output(&state).displacement[0] - expected).abs() < 1e-12);
}

#[test]
fn another_time_constant_acts_at_once_on_a_kept_state() {
    let input = Input {
        drive: [1.5],
        ambient_degc: AMBIENT_DEGC,
    };
    let (slow, fast) = (common::params(), {
        let mut params = common::params();
        params.heat.heat_capacity_j_per_m_k /= 4.0;
        params
    });
    let (slow, fast) = (
        single(slow, Rule::LastReversal),
        single(fast, Rule::LastReversal),
    );
    let mut kept = slow.rest(AMBIENT_DEGC);
    slow.step(&mut kept, &input, 0.287);
    // The same sample time: only the model tells that its exponential is another.
    let mut fresh = fast.rest(kept.temperature_degc()[0]);
    fast.step(&mut kept, &input, 0.287);
    fast.step(&mut fresh, &input, 0.287);
    let bits = |state: &wiener::State| state.temperature_degc().map(f64::to_bits);
    assert_eq!(bits(&kept), bits(&fresh));
}
