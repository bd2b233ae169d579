//! Each effect at its typical size on one run: where and by how much does the displacement move?
//!
//! The shares are those of the squared change while the drive is on, and while it is off.

use std::error::Error;
use std::io::{self, Write};

use sma_effects::{EffectId, EffectSet, EffectValues, Extended, Member, Setting};
use wiener::hysteresis::LoopParams;
use wiener::thermal::RodParams;
use wiener::{Profile, Start, WienerParams};

const AMBIENT_DEGC: f64 = 22.0;
const DT_S: f64 = 0.2;
const LARGEST_A: f64 = 2.4;

fn main() -> Result<(), Box<dyn Error>> {
    let rod = RodParams {
        diameter_m: 0.75e-3,
        density_kg_per_m3: 6450.0,
        specific_heat_j_per_kg_k: 480.0,
        resistance_ohm_per_m: 2.13,
        convective_coefficient_w_per_m2_k: 60.0,
    };
    let params = WienerParams {
        heat: rod.heat_balance()?,
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
    // Two full cycles with an inner one between them.
    let mut current_a = Vec::new();
    for (level, samples) in [
        (LARGEST_A, 75),
        (0.0, 90),
        (2.1, 60),
        (1.4, 40),
        (2.2, 40),
        (0.0, 145),
    ] {
        current_a.extend(std::iter::repeat_n(level, samples));
    }
    let profile = Profile::uniform(&current_a, DT_S, AMBIENT_DEGC)?;
    let setting = Setting {
        active: EffectSet::all(),
        mass_kg_per_m: Some(rod.mass_kg_per_m()),
        surface_m2_per_m: Some(rod.surface_m2_per_m()),
        length_output: Some(125.0),
        run_length_s: Some(DT_S * current_a.len() as f64),
        largest_drive: Some(LARGEST_A),
        ..Setting::default()
    };
    let member = |effects| Member {
        params,
        effects,
        start: Start::rest(AMBIENT_DEGC),
    };
    // The baseline first, then each effect: all side by side.
    let mut members = vec![member(EffectValues::default())];
    members.extend(EffectId::ALL.map(|effect| member(EffectValues::typical(effect, 1.0))));
    let mut traces = vec![Vec::new(); members.len()];
    Extended { setting }.run(&members, &profile, &mut |block| {
        for row in block.displacement.chunks(block.stride) {
            for column in 0..block.members {
                traces[block.first_member + column].push(row[column]);
            }
        }
    })?;

    let mut out = io::stdout().lock();
    writeln!(
        out,
        "{:28} {:>9} {:>9} {:>6} {:>6}",
        "effect", "rms mm", "max mm", "on", "off"
    )?;
    let (baseline, effects) = traces.split_at(1);
    for (effect, trace) in EffectId::ALL.iter().zip(effects) {
        let change: Vec<f64> = trace.iter().zip(&baseline[0]).map(|(a, b)| a - b).collect();
        let squares: f64 = change.iter().map(|x| x * x).sum();
        let largest = change.iter().map(|x| x.abs()).fold(0.0, f64::max);
        let heated = change.iter().zip(&current_a).filter(|&(_, &i)| i > 0.0);
        let heated: f64 = heated.map(|(x, _)| x * x).sum();
        if largest <= 0.0 {
            writeln!(out, "{:28} does not move the displacement", effect.id())?;
            continue;
        }
        let share = heated / squares;
        writeln!(
            out,
            "{:28} {:9.4} {:9.4} {:5.0}% {:5.0}%",
            effect.id(),
            (squares / change.len() as f64).sqrt(),
            largest,
            100.0 * share,
            100.0 * (1.0 - share),
        )?;
    }
    Ok(())
}
