//! Quick look.
#![allow(clippy::all, clippy::unwrap_used, unused)]
use identify::{Rod, Validated, WienerModel};
use missing_physics::*;
use std::io::Write;
use std::time::Instant;
use wiener::hysteresis::Rule;
fn main() {
    let args: Vec<String> = std::env::args().collect();
    let text = std::fs::read_to_string(&args[1]).unwrap();
    let rod = Rod::parse("rod.toml", &text).unwrap();
    let read = |p: &String| recording::read_csv(p, &rod.read_options()).unwrap();
    let split = args.iter().position(|a| a == "--").unwrap();
    let training: Vec<_> = args[2..split].iter().map(read).collect();
    let unseen: Vec<_> = args[split + 1..].iter().map(read).collect();
    let base = WienerModel::new(&rod, Rule::LastReversal, &training).unwrap();
    let t0 = Instant::now();
    let config = DiagnoseConfig {
        setting: setting_of_rod(&rod, training[0].output_unit()),
        ..DiagnoseConfig::default()
    };
    let d = diagnose(&base, &training, &unseen, &config, &mut |_| ()).unwrap();
    println!(
        "{:?} floor {:?} {:.1}s sims {}",
        d.verdict,
        d.noise_floor,
        t0.elapsed().as_secs_f64(),
        d.simulations
    );
    let v = |v: &Vec<Validated>| Validated::rmse_of_all(v).unwrap_or(0.0);
    println!(
        "base {} {}  agreeing {}/{}",
        d.baseline.fit.train_rmse,
        v(&d.baseline.validated),
        d.baseline.fit.agreeing_starts,
        d.baseline.fit.starts
    );
    if let Some(e) = &d.extended {
        println!(
            "ext {} {} {:?} agreeing {}/{}",
            e.stage.fit.train_rmse,
            v(&e.stage.validated),
            e.effects,
            e.stage.fit.agreeing_starts,
            e.stage.fit.starts
        );
        for p in &e.stage.fit.parameters {
            println!(
                "   {} {:?} {:?} {}",
                p.info.name, p.values, p.intervals[0], p.at_bound
            );
        }
    }
    println!("{:?}", d.explained);
    for f in d.findings.iter().chain(&d.suspects) {
        println!(
            "{} contribution {:.3} p {:.2} could {:?} plausible {}",
            f.sentence, f.contribution, f.probability, f.could_also_be, f.plausible
        );
    }
    for c in &d.catalogue {
        println!(
            "{:28} {:?} t {:?} absorbed {:?} mde {:?}",
            c.effect.id(),
            c.status,
            c.t,
            c.absorption,
            c.minimum_detectable
        );
    }
    println!("{:#?}", d.mismatch);
    println!("{:#?}", d.remainder);
    println!("{:#?}", d.next_experiment.as_ref().map(|n| &n.sentence));
}
