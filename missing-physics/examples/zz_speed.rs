//! x
#![allow(clippy::unwrap_used, clippy::print_stdout, reason = "x")]
use missing_physics::*;
use std::time::Instant;
use wiener::hysteresis::*;
use wiener::thermal::*;
use wiener::*;
fn main() {
    let rod = RodParams {
        diameter_m: 0.75e-3,
        density_kg_per_m3: 6450.0,
        specific_heat_j_per_kg_k: 480.0,
        resistance_ohm_per_m: 2.13,
        convective_coefficient_w_per_m2_k: 60.0,
    };
    let params = WienerParams {
        heat: rod.heat_balance().unwrap(),
        limiting_loop: LoopParams {
            loop_center_degc: 55.0,
            loop_half_width_k: 8.0,
            loop_spread_k: 3.0,
            ..LoopParams::default()
        },
        zeta: 0.85,
        gain: 5.0,
        offset: 0.0,
    };
    let mut cur = vec![];
    for k in 0..20 {
        cur.extend(std::iter::repeat_n(if k % 2 == 0 { 2.2 } else { 0.5 }, 100));
    }
    let profile = Profile::uniform(&cur, 0.1, 22.0).unwrap();
    let time = |f: &mut dyn FnMut()| {
        let mut best = f64::MAX;
        for _ in 0..7 {
            let t = Instant::now();
            for _ in 0..10 {
                f();
            }
            best = best.min(t.elapsed().as_secs_f64() / 10.0);
        }
        best
    };
    let only = std::env::args().nth(1);
    for n in [1usize, 32] {
        let base: Vec<wiener::Member> = (0..n)
            .map(|_| wiener::Member {
                params,
                start: Start::rest(22.0),
            })
            .collect();
        let mut s = 0.0;
        let tb = time(&mut || {
            Ensemble {
                drive: Drive::Current,
                rule: Rule::LastReversal,
            }
            .run(&base, &profile, &mut |b| s += b.displacement[0])
            .unwrap()
        });
        println!("L={n} baseline {:.1} ns/step", tb / 2000.0 * 1e9);
        let mut sets: Vec<(String, EffectSet)> = vec![("none".into(), EffectSet::EMPTY)];
        for e in EffectId::ALL {
            sets.push((e.id().into(), EffectSet::of(e)));
        }
        sets.push(("all".into(), EffectSet::all()));
        for (name, active) in sets {
            if only.as_ref().is_some_and(|o| *o != name) {
                continue;
            }
            let setting = Setting {
                active,
                mass_kg_per_m: Some(rod.mass_kg_per_m()),
                surface_m2_per_m: Some(rod.surface_m2_per_m()),
                length_output: Some(125.0),
                run_length_s: Some(200.0),
                ..Setting::default()
            };
            let mut effects = EffectValues::default();
            for e in active.iter() {
                for (i, _) in e.info().parameters.iter().enumerate() {
                    *effects.slot(e, i).unwrap() = EffectValues::typical(e, 1.0).get(e, i).unwrap();
                }
            }
            let m: Vec<missing_physics::Member> = (0..n)
                .map(|_| missing_physics::Member {
                    params,
                    effects,
                    start: Start::rest(22.0),
                })
                .collect();
            let t = time(&mut || {
                Extended { setting }
                    .run(&m, &profile, &mut |b| s += b.displacement[0])
                    .unwrap()
            });
            println!("  {name:28} {:.2}", t / tb);
        }
    }
}
