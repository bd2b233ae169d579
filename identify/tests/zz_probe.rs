use identify::*; use recording::*; use std::ops::ControlFlow; use wiener::hysteresis::Rule;
#[test] fn probe() {
    let mut out=String::new();
    let text="[drive]\nkind=\"temperature\"\n[columns]\ndrive={name=\"Temperature\",unit=\"degc\"}\noutput=\"Strain\"\nstress={name=\"Stress\",unit=\"mpa\"}\n";
    let rod=Rod::parse("rod.toml",text).unwrap();
    let all:Vec<Recording>=[50,100,150].iter().map(|p| read_csv(fixtures::shared::path(&format!("recordings/flexinol/filtered_data_{p}MPa.txt")).unwrap(),&rod.read_options()).unwrap()).collect();
    let mean=|r:&Recording|{let s=r.stress_pa().unwrap(); s.iter().sum::<f64>()/s.len() as f64};
    let flat:Vec<Recording>=all.iter().map(|r| Recording::new(RecordingParts{name:r.name().into(),drive_quantity:Quantity::Temperature,drive:r.drive().to_vec(),output:r.output().to_vec(),stress_pa:Some(vec![mean(r);r.len()]),..Default::default()}).unwrap()).collect();
    let norm:Vec<Recording>=all.iter().map(|r| {let h=r.output().iter().fold(0.0f64,|a,b|a.max(*b)); Recording::new(RecordingParts{name:r.name().into(),drive_quantity:Quantity::Temperature,drive:r.drive().to_vec(),output:r.output().iter().map(|y|y/h).collect(),stress_pa:Some(vec![mean(r);r.len()]),..Default::default()}).unwrap()}).collect();
    let mut go=|name:&str,rule:Rule,t:&[Recording],stress:bool|{
        let m=LoopModel::new(&rod,rule,t).unwrap(); let m=if stress {m.with_stress_coupling(t).unwrap()} else {m};
        let f=fit(&m,t,&FitConfig::default(),&mut |_|ControlFlow::Continue(())).unwrap();
        out+=&format!("{name} {rule:?} rmse {:.6} bic {:.1} lag {:.3} neff {:.1} conv {} {:?}\n",f.train_rmse,f.bic,f.noise.lag_1,f.noise.n_effective,f.converged(),f.recordings.iter().map(|r|r.rmse).collect::<Vec<_>>());
        for p in &f.parameters { out+=&format!("   {} {:?} {:?}\n",p.info.name,p.values,p.intervals.iter().map(|b|b.map(|b|(b.lower,b.upper))).collect::<Vec<_>>()); }
    };
    for r in &flat { go("single",Rule::LastReversal,std::slice::from_ref(r),false); }
    go("plain",Rule::LastReversal,&all,false);
    for rule in [Rule::LastReversal,Rule::Nested] {
    go("coupled sample",rule,&all,true);
    go("coupled flat",rule,&flat,true); }
    go("coupled flat norm",Rule::LastReversal,&norm,true);
    std::fs::write("/tmp/probe.txt",out).unwrap();
}
