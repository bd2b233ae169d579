//! dev
use std::error::Error;
use std::ops::ControlFlow;
use blind_trial::injected::Injected;
use fixtures::bologna;
use identify::{Rod, WienerModel};
use missing_physics::{DiagnoseConfig, Reference, setting_of_rod};
use recording::{Recording, read_csv};
use wiener::hysteresis::Rule;
fn main() -> Result<(), Box<dyn Error>> {
    let folder = fixtures::shared::path(bologna::FOLDER).unwrap();
    let rod = Rod::parse("rod.toml", bologna::ROD)?;
    let names = ["ramp01.csv", "ramp02.csv", "step01.csv", "step02.csv"];
    let recorded: Vec<Recording> = names.iter().map(|n| read_csv(folder.join(n), &rod.read_options())).collect::<Result<_, _>>()?;
    let outputs = recorded.iter().flat_map(Recording::output);
    let [low, high] = outputs.fold([f64::INFINITY, f64::NEG_INFINITY], |[l, h], &y| [l.min(y), h.max(y)]);
    let stroke = [low, high - low];
    let from: usize = std::env::args().nth(1).map_or(0, |a| a.parse().unwrap());
    let to: usize = std::env::args().nth(2).map_or(10, |a| a.parse().unwrap());
    let splits: Vec<u32> = (1u32..15).filter(|m| m.count_ones() <= 2).collect();
    for (s, today) in splits.iter().enumerate().take(to).skip(from) {
        let pick = |inside: bool| -> Vec<usize> { (0..4).filter(|k| (today >> k & 1 == 1) == inside).collect() };
        let reference: Vec<Recording> = pick(false).iter().map(|&k| recorded[k].clone()).collect();
        let base = WienerModel::new(&rod, Rule::LastReversal, &reference)?;
        let config = DiagnoseConfig { setting: setting_of_rod(&rod, "mm"), ..DiagnoseConfig::default() };
        let t = std::time::Instant::now();
        let healthy = Reference::of(&base, &reference, &config, &mut |_| ControlFlow::Continue(()))?;
        println!("== split {s}: today {:?}: {:.1} s", pick(true).iter().map(|&k| names[k]).collect::<Vec<_>>(), t.elapsed().as_secs_f64());
        for injected in std::iter::once(None).chain(Injected::all().into_iter().map(Some)) {
            let t = std::time::Instant::now();
            let now: Vec<Recording> = pick(true).iter().map(|&k| injected.map_or(Ok(recorded[k].clone()), |i: Injected| i.on(&recorded[k], stroke))).collect::<Result<_, _>>()?;
            let said = healthy.changed(&now)?;
            if injected.is_none() {
                println!("   laws {:?} coolings {} left out {:?}", said.laws, said.coolings, said.left_out.iter().map(|l| format!("{:.3} {:.1}", l.rmse, l.nats)).collect::<Vec<_>>());
            }
            let list = said.considered.iter().take(5).map(|c| format!("{} {:.1} ({:.3e})", c.what.id(), c.nats, c.change)).collect::<Vec<_>>().join(", ");
            let named = said.finding.as_ref().map_or(String::new(), |f| format!("{} or {:?}", f.leading.what.id(), f.could_also_be.iter().map(|w| w.id()).collect::<Vec<_>>()));
            println!("{:24} {:.1}s {} [{named}] excess {:.2?} rms {:.3?} | {list}", injected.map_or("nothing".into(), |i| i.to_string()), t.elapsed().as_secs_f64(), said.verdict.id(), said.excess, said.runs.iter().map(|r| r.1).collect::<Vec<_>>());
        }
    }
    Ok(())
}
