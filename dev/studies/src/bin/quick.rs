//! Quick look.
#![allow(clippy::all, clippy::unwrap_used, unused)]
use identify::WienerModel;
use missing_physics::*;
use std::io::Write;
use std::time::Instant;
use studies::*;
use wiener::hysteresis::Rule;

fn main() {
    let args: Vec<String> = std::env::args().collect();
    let kind = args[1].as_str();
    let seeds: std::ops::Range<u64> = {
        let v: Vec<u64> = args[2].split("..").map(|x| x.parse().unwrap()).collect();
        v[0]..v[1]
    };
    let phi: f64 = args.get(3).map_or(0.0, |x| x.parse().unwrap());
    let multiple: f64 = args.get(4).map_or(1.0, |x| x.parse().unwrap());
    let remove = args.get(5).map_or("", |x| x.as_str());
    let effects: Vec<Option<EffectId>> = match kind {
        "clean" => vec![None],
        "all" => EffectId::ALL.into_iter().map(Some).collect(),
        id => vec![Some(EffectId::parse(id).unwrap())],
    };
    for effect in effects {
        for seed in seeds.clone() {
            let made = Made {
                effects: effect.map_or(EffectSet::EMPTY, EffectSet::of),
                values: effect.map_or(EffectValues::default(), |e| {
                    EffectValues::typical(e, multiple)
                }),
                noise: if phi > 0.0 {
                    NoiseKind::Autoregressive(phi)
                } else {
                    NoiseKind::White
                },
                noise_share: 0.0015,
                seed,
            };
            let m = made_up(&made);
            let base = WienerModel::new(&m.rod, Rule::LastReversal, &m.training).unwrap();
            let t0 = Instant::now();
            let mut config = DiagnoseConfig {
                setting: setting_of_rod(&m.rod, "mm"),
                ..DiagnoseConfig::default()
            };
            if remove == "truth" {
                if let Some(e) = effect {
                    config.catalogue = config.catalogue.without(e);
                }
            }
            let mut marks = vec![];
            let d = diagnose(&base, &m.training, &m.unseen, &config, &mut |p| {
                marks.push((
                    t0.elapsed().as_secs_f64(),
                    format!("{p:?}").chars().take(6).collect::<String>(),
                ));
            })
            .unwrap();
            let name = effect.map_or("clean", |e| e.id());
            let mut out = std::io::stdout().lock();
            let f: Vec<String> = d
                .findings
                .iter()
                .map(|f| {
                    format!(
                        "{}({:.2};{:.2};{:?})",
                        f.effect,
                        f.contribution,
                        f.probability,
                        f.could_also_be.iter().map(|e| e.id()).collect::<Vec<_>>()
                    )
                })
                .collect();
            let s: Vec<String> = d.suspects.iter().map(|f| format!("{}", f.effect)).collect();
            let t = effect
                .and_then(|e| d.catalogue.iter().find(|c| c.effect == e).and_then(|c| c.t))
                .unwrap_or(0.0);
            let rm = |v: &Vec<identify::Validated>| {
                identify::Validated::rmse_of_all(v).unwrap_or(0.0) / m.noise_mm
            };
            writeln!(out, "{name:26} {seed:3} t={t:7.1} {:16} base {:.3}/{:.3} ext {:.3}/{:.3} FE {:?} F={} S={} sims {} {:.2}s", d.verdict.id(), d.baseline.fit.train_rmse / m.noise_mm, rm(&d.baseline.validated),
            d.extended.as_ref().map_or(0.0, |e| e.stage.fit.train_rmse / m.noise_mm), d.extended.as_ref().map_or(0.0, |e| rm(&e.stage.validated)),
            d.explained.as_ref().and_then(|e| e.train).map(|x| (x * 1000.0).round() / 1000.0), f.join(","), s.join(","), d.simulations, t0.elapsed().as_secs_f64()).unwrap();
            if args.get(6).is_some() {
                for f in &d.findings {
                    writeln!(out, "    {}", f.sentence).unwrap();
                }
                writeln!(out, "   {marks:?}").unwrap();
            }
        }
    }
}
