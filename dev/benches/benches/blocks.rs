//! A stretch of steps of each block, in 1, 8 and 32 lanes.
//!
//! The stretch is one call of the widest vectors, as in an ensemble: a single step costs less than the
//! dispatch. Items are steps of a lane.

use benches::sound;
use divan::counter::ItemsCount;
use divan::{Bencher, black_box};
use wiener::hysteresis::{Hysteresis, LimitingLoop, LoopFamily, LoopParams, Rule, SineProximity};
use wiener::thermal::{HeatBalance, HeatBalanceParams, Heating, ThermalConstants};
use wiener::{Drive, Input, Plant, Wiener, WienerError, WienerParams, widest_vectors};

const AMBIENT_DEGC: f64 = 25.0;
const DT_S: f64 = 0.287;
const N_STEPS: usize = 1024;
/// Steps between two reversals.
const N_SWEEP: usize = 64;

/// Share of a lane on the way through the lanes' parameters, 0 to 1.
fn share(lane: usize) -> f64 {
    lane as f64 / 32.0
}

fn params(lane: usize) -> WienerParams {
    WienerParams {
        heat: HeatBalanceParams::from_constants(ThermalConstants {
            tau_s: 4.0 + share(lane),
            lambda_k_per_a2: 24.0,
        }),
        limiting_loop: LoopParams {
            loop_center_degc: 74.0,
            loop_half_width_k: 12.0 + share(lane),
            loop_spread_k: 6.0,
            ..LoopParams::default()
        },
        zeta: 0.85,
        gain: 6.0,
        offset: 0.35,
    }
}

/// A triangle between 0 and 1 whose peaks fall and rise again: loops within loops.
fn triangle(step: usize) -> f64 {
    let phase = (step % (2 * N_SWEEP)) as f64 / N_SWEEP as f64;
    let size = 0.6 + 0.4 * (step as f64 * 0.01).cos();
    size * (1.0 - (phase - 1.0).abs())
}

fn currents_a() -> Vec<f64> {
    (0..N_STEPS).map(|step| 2.0 * triangle(step)).collect()
}

fn steps(n_lanes: usize) -> ItemsCount {
    ItemsCount::new(N_STEPS * n_lanes)
}

#[divan::bench(consts = [1, 8, 32])]
fn heat_balance<const L: usize>(bencher: Bencher) {
    let lanes = std::array::from_fn(|lane| params(lane).heat);
    let heat = sound(HeatBalance::<L>::new(lanes));
    let sample = heat.over(DT_S);
    let currents_a = currents_a();
    bencher.counter(steps(L)).bench(|| {
        let currents_a = black_box(&currents_a);
        widest_vectors(
            #[inline(always)]
            || {
                let mut temperature_degc = [AMBIENT_DEGC; L];
                for &current_a in currents_a {
                    let heating = Heating {
                        power_w_per_m: Drive::Current
                            .power_w_per_m([current_a; L], heat.resistance_ohm_per_m()),
                        ambient_degc: AMBIENT_DEGC,
                    };
                    temperature_degc = heat.step(temperature_degc, &heating, &sample);
                }
                temperature_degc
            },
        )
    });
}

const LOOPS: [(Rule, LoopFamily); 4] = [
    (Rule::LastReversal, LoopFamily::Proximity),
    (Rule::Nested, LoopFamily::Proximity),
    (Rule::Nested, LoopFamily::Relays),
    (Rule::Nested, LoopFamily::Kinetics),
];

#[divan::bench(consts = [1, 8, 32], args = LOOPS)]
fn commit<const L: usize>(bencher: Bencher, (rule, family): (Rule, LoopFamily)) {
    let hysteresis = sound(hysteresis::<L>(rule)).of_family(family);
    let memory = hysteresis.between_limiting_curves([AMBIENT_DEGC; L], [1.0; L]);
    let temperatures_degc: Vec<[f64; L]> = (0..N_STEPS)
        .map(|step| {
            std::array::from_fn(|lane| AMBIENT_DEGC + (95.0 - 4.0 * share(lane)) * triangle(step))
        })
        .collect();
    bencher
        .counter(steps(L))
        .with_inputs(|| memory.clone())
        .bench_local_refs(|memory| {
            let temperatures_degc = black_box(&temperatures_degc);
            widest_vectors(
                #[inline(always)]
                || {
                    let mut sum = [0.0; L];
                    for &temperature_degc in temperatures_degc {
                        let fraction = hysteresis.commit(memory, temperature_degc);
                        for lane in 0..L {
                            sum[lane] += fraction[lane];
                        }
                    }
                    sum
                },
            )
        });
}

fn hysteresis<const L: usize>(rule: Rule) -> Result<Hysteresis<L>, WienerError> {
    let lanes: [WienerParams; L] = std::array::from_fn(params);
    let limits = LimitingLoop::new(lanes.map(|lane| lane.limiting_loop))?;
    let proximity = SineProximity::new(lanes.map(|lane| lane.zeta))?;
    Ok(Hysteresis::new(limits, proximity, rule))
}

#[divan::bench(consts = [1, 8, 32])]
fn cascade<const L: usize>(bencher: Bencher) {
    let lanes = std::array::from_fn(params);
    let model = sound(Wiener::<L>::new(Drive::Current, Rule::LastReversal, &lanes));
    let rest = model.rest(AMBIENT_DEGC);
    let currents_a = currents_a();
    bencher
        .counter(steps(L))
        .with_inputs(|| rest.clone())
        .bench_local_refs(|state| {
            let currents_a = black_box(&currents_a);
            widest_vectors(
                #[inline(always)]
                || {
                    let mut sum = [0.0; L];
                    for &current_a in currents_a {
                        let output = model.output(state);
                        for lane in 0..L {
                            sum[lane] += output.displacement[lane];
                        }
                        let input = Input {
                            drive: [current_a; L],
                            ambient_degc: AMBIENT_DEGC,
                        };
                        model.step(state, &input, DT_S);
                    }
                    sum
                },
            )
        });
}

fn main() {
    divan::main();
}
