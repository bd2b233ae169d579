//! Effects described in a file: they compete with the catalogue, and cannot do harm.

use crate::support;

use std::path::Path;

use sma_effects::{
    Belongs, EffectBlock, EffectId, EffectSet, EffectValues, ExtendedPlant, Hypothesis,
    PhysicsError, Role, Setting,
};
use support::{
    AMBIENT_DEGC, DRIVES, all_typical, current_a, drive_of, fleet, largest, params, setting, trace,
    various,
};
use wiener::{Drive, Input, Plant, Profile};

/// One hypothesis with the parameter `a`, of typical size 1 within -1000 and 1000.
fn one(place: &str, expression: &str) -> String {
    format!(
        "[[hypothesis]]\nid = \"own-{}\"\n{place} = \"{expression}\"\n[hypothesis.parameters.a]\n\
         unit = \"1\"\ntypical = 1\nbounds = [-1000, 1000]\n",
        place.replace('_', "-")
    )
}

fn parsed(text: &str) -> &'static [Hypothesis] {
    Hypothesis::parse("own.toml", text).unwrap()
}

fn refusal(text: &str) -> String {
    Hypothesis::parse("own.toml", text).unwrap_err().to_string()
}

/// A plant with these hypotheses, and values where the first parameter of the first is `a`.
fn with(text: &str, a: f64) -> (Setting, EffectValues) {
    let setting = Setting {
        hypotheses: parsed(text),
        ..setting(EffectSet::EMPTY)
    };
    let mut values = EffectValues::default();
    values.own[0][0] = a;
    (setting, values)
}

fn shown(text: &str, a: f64, dt_s: f64) -> Vec<f64> {
    let (setting, values) = with(text, a);
    trace(&setting, &params(), &values, &current_a(dt_s), dt_s).displacement
}

fn four() -> String {
    one("drive", "a * drive * dir * T / 100")
        + &one("heat_flow_w_per_m", "-a * (T - Ta)^1.25 * (1 + sin(t))")
        + &one("shift_k", "a * xi * tanh(T / 50) + a * drive")
        + &one("displacement", "a * (T - Ta) * xi + a * max(y, 1, t / 50)")
}

const STRONGER_CONVECTION: &str = r#"
[[hypothesis]]
id = "stronger-convection"
name = "convection that grows with temperature"
sentence = "the rod loses {value} more, to the power {partner}"
heat_flow_w_per_m = "-k * (T - Ta)^n"

[hypothesis.parameters.n]
unit = "1"
typical = 1.25
bounds = [1.0, 2.0]
size = false

[hypothesis.parameters.k]
unit = "W/(m K^n)"
typical = 0.02
bounds = [0.0, 1.0]
"#;

#[test]
fn it_says_what_the_catalogue_says_of_an_effect() {
    let hypothesis = &parsed(STRONGER_CONVECTION)[0];
    let info = hypothesis.info();
    assert_eq!(info.id, "stronger-convection");
    assert_eq!(info.name, "convection that grows with temperature");
    assert_eq!(
        info.sentence,
        "the rod loses {value} more, to the power {partner}"
    );
    assert_eq!(info.block, EffectBlock::HeatBalance);
    assert!(!info.flexible);
    assert_eq!(hypothesis.expression(), "-k * (T - Ta)^n");
    let names: Vec<_> = info.parameters.iter().map(|known| known.name).collect();
    assert_eq!(names, ["stronger_convection_k", "stronger_convection_n"]);
    assert_eq!(info.parameters[0].role, Role::Size);
    assert_eq!(
        info.parameters[1].role,
        Role::Partner {
            grid: &[1.125, 1.25, 1.375, 1.625, 1.875]
        }
    );
    let expected = [2.0 * 0.02, 1.25, 0.0, 0.0].map(f64::to_bits);
    assert_eq!(hypothesis.values(2.0).map(f64::to_bits), expected);

    let plain = parsed("hypothesis = [{ id = 'a-b', drive = 'c', parameters = { c = { unit = 'A', typical = 1, bounds = [0, 2] } } }]")[0].info();
    assert_eq!(plain.name, "a b");
    assert_eq!(plain.sentence, "a b, with {value}");
}

#[test]
fn a_file_is_read() {
    let missing = Hypothesis::read(Path::new("no such file.toml")).unwrap_err();
    assert!(
        matches!(&missing, PhysicsError::Unreadable { file, .. } if file == "no such file.toml")
    );
    let text = missing.to_string();
    assert!(
        text.starts_with("no such file.toml: cannot be read: "),
        "{text}"
    );
}

#[test]
fn sizes_of_zero_are_the_baseline_to_the_last_bit() {
    for (active, values) in [
        (EffectSet::EMPTY, EffectValues::default()),
        (
            EffectSet::of(EffectId::LatentHeat),
            EffectValues::typical(EffectId::LatentHeat, 1.0),
        ),
        (
            EffectSet::of(EffectId::EndConduction),
            EffectValues::typical(EffectId::EndConduction, 1.0),
        ),
        (EffectSet::all(), all_typical()),
    ] {
        for drive in DRIVES {
            let input = drive_of(drive, &current_a(0.3));
            let plain = Setting {
                drive,
                ..setting(active)
            };
            let own = Setting {
                hypotheses: parsed(&four()),
                ..plain
            };
            let expected = trace(&plain, &params(), &values, &input, 0.3);
            let found = trace(&own, &params(), &values, &input, 0.3);
            let bits = |values: &[f64]| values.iter().map(|x| x.to_bits()).collect::<Vec<_>>();
            assert_eq!(bits(&found.displacement), bits(&expected.displacement));
            assert_eq!(bits(&found.recorded_degc), bits(&expected.recorded_degc));
        }
    }
}

#[test]
fn lanes_have_the_bits_of_one_plant_alone() {
    let current_a = current_a(0.3);
    let profile = Profile::uniform(&current_a, 0.3, AMBIENT_DEGC).unwrap();
    let setting = Setting {
        hypotheses: parsed(&four()),
        ..setting(EffectSet::all())
    };
    let mut members = various(9, all_typical());
    for (k, member) in members.iter_mut().enumerate() {
        let size = 0.01 * (1.0 + k as f64);
        member.effects.own = [[size, 0.0, 0.0, 0.0]; 4];
    }
    let together = fleet(&setting, &members, &profile);
    for (member, expected) in members.iter().zip(&together) {
        assert_eq!(&fleet(&setting, &[*member], &profile)[0], expected);
    }
}

#[test]
fn a_loss_is_a_larger_conductance_to_first_order() {
    let added = 0.1 * params().heat.conductance_w_per_m_k;
    let error = |dt_s: f64| {
        let mut larger = params();
        larger.heat.conductance_w_per_m_k += added;
        let plain = setting(EffectSet::EMPTY);
        let input = current_a(dt_s);
        let expected = trace(&plain, &larger, &EffectValues::default(), &input, dt_s);
        let found = shown(&one("heat_flow_w_per_m", "-a * (T - Ta)"), added, dt_s);
        let without = shown(&one("heat_flow_w_per_m", "-a * (T - Ta)"), 0.0, dt_s);
        assert!(largest(&found, &without) > 0.5);
        largest(&found, &expected.displacement)
    };
    let [coarse, fine] = [error(0.1), error(0.05)];
    assert!(coarse < 0.02, "{coarse}");
    assert!((1.8..2.2).contains(&(coarse / fine)), "{coarse} {fine}");
}

#[test]
fn a_displacement_that_falls_with_temperature_is_thermal_expansion() {
    let mut values = EffectValues::default();
    values.thermal_expansion.expansion_per_k = 2e-5;
    let catalogue = setting(EffectSet::of(EffectId::ThermalExpansion));
    let expected = trace(&catalogue, &params(), &values, &current_a(0.2), 0.2);
    let length = catalogue.length_output.unwrap();
    let found = shown(
        &one("displacement", "-a * (0.6 + 0.4 * xi) * (T - 20)"),
        2e-5 * length,
        0.2,
    );
    assert!(largest(&found, &expected.displacement) < 1e-13);
}

#[test]
fn a_drive_is_scaled() {
    let found = shown(&one("drive", "a * drive"), 0.05, 0.2);
    let input: Vec<f64> = current_a(0.2).iter().map(|i| i * 1.05).collect();
    let plain = setting(EffectSet::EMPTY);
    let expected = trace(&plain, &params(), &EffectValues::default(), &input, 0.2);
    assert!(largest(&found, &expected.displacement) < 1e-12);
}

#[test]
fn a_drive_stays_within_its_range() {
    let duty = Drive::Duty {
        supply_v: 12.0,
        length_m: 0.5,
    };
    let power = Drive::Power { length_m: 0.5 };
    for (drive, given, added, held) in [
        (duty, 0.2, 5.0, 1.0),
        (duty, 0.2, -5.0, 0.0),
        (duty, 1.1, 5.0, 1.1),
        (power, 0.2, -5.0, 0.0),
        (power, 0.2, 5.0, 5.2),
        (Drive::Current, 0.2, -1.0, -0.8),
    ] {
        let (own, values) = with(&one("drive", "a"), added);
        let own = Setting { drive, ..own };
        let plain = Setting {
            hypotheses: &[],
            ..own
        };
        let found = trace(&own, &params(), &values, &[given; 9], 0.1);
        let expected = trace(&plain, &params(), &EffectValues::default(), &[held; 9], 0.1);
        assert!(largest(&found.displacement, &expected.displacement) < 1e-12);
    }
}

#[test]
fn a_constant_shift_moves_the_loop() {
    let found = shown(&one("shift_k", "a"), 4.0, 0.2);
    let mut moved = params();
    moved.limiting_loop.loop_center_degc += 4.0;
    let plain = setting(EffectSet::EMPTY);
    let expected = trace(
        &plain,
        &moved,
        &EffectValues::default(),
        &current_a(0.2),
        0.2,
    );
    assert!(largest(&found, &expected.displacement) < 1e-9);
}

#[test]
fn time_direction_and_the_displacement_itself_are_seen() {
    let plain = shown(&one("displacement", "a"), 0.0, 0.2);
    let timed = shown(&one("displacement", "a * t"), 1.0, 0.2);
    for (k, (timed, plain)) in timed.iter().zip(&plain).enumerate() {
        assert!((timed - plain - 0.2 * k as f64).abs() < 1e-9);
    }
    let squared = shown(&one("displacement", "a * y^2"), 0.1, 0.2);
    for (squared, plain) in squared.iter().zip(&plain) {
        assert!((squared - plain - 0.1 * plain * plain).abs() < 1e-12);
    }
    let (setting, values) = with(&one("displacement", "a * dir"), 1.0);
    let found = trace(&setting, &params(), &values, &current_a(0.2), 0.2);
    let mut direction = -1.0;
    for k in 0..plain.len() {
        let change_k = if k == 0 {
            0.0
        } else {
            found.temperature_degc[k] - found.temperature_degc[k - 1]
        };
        if change_k.abs() > 0.0 {
            direction = change_k.signum();
        }
        assert!((found.displacement[k] - plain[k] - direction).abs() < 1e-12);
    }
}

#[test]
fn a_hypothesis_acts_beside_the_catalogue() {
    let active = EffectSet::all();
    let plain = trace(
        &setting(active),
        &params(),
        &all_typical(),
        &current_a(0.2),
        0.2,
    );
    for place in ["drive", "heat_flow_w_per_m", "shift_k", "displacement"] {
        let own = Setting {
            hypotheses: parsed(&one(place, "a * (T - Ta)")),
            ..setting(active)
        };
        let mut values = all_typical();
        values.own[0][0] = 0.001;
        let found = trace(&own, &params(), &values, &current_a(0.2), 0.2);
        let moved = largest(&found.displacement, &plain.displacement);
        assert!((1e-3..5.0).contains(&moved), "{place}: {moved}");
    }
}

#[test]
fn where_a_term_has_no_value_the_lane_has_none_and_others_do_not_notice() {
    let current_a = current_a(0.3);
    let profile = Profile::uniform(&current_a, 0.3, AMBIENT_DEGC).unwrap();
    for place in ["drive", "heat_flow_w_per_m", "shift_k", "displacement"] {
        let setting = Setting {
            hypotheses: parsed(&one(place, "exp(a * (T - Ta)) - 1")),
            ..setting(EffectSet::of(EffectId::LatentHeat))
        };
        let mut members = various(3, EffectValues::default());
        members[1].effects.own[0][0] = 1000.0;
        let together = fleet(&setting, &members, &profile);
        let is_nan = |bits: &u64| f64::from_bits(*bits).is_nan();
        assert!(together[1].iter().any(is_nan), "{place}");
        for k in [0, 2] {
            assert!(!together[k].iter().any(is_nan));
            assert_eq!(fleet(&setting, &[members[k]], &profile)[0], together[k]);
        }
    }
}

#[test]
fn values_are_checked() {
    let refused = |hypotheses: &'static [Hypothesis], h: usize, k: usize, value: f64| {
        let setting = Setting {
            hypotheses,
            ..setting(EffectSet::EMPTY)
        };
        let mut values = EffectValues::default();
        if let Some(hypothesis) = hypotheses.first() {
            values.own[0] = hypothesis.values(0.0);
        }
        values.own[h][k] = value;
        ExtendedPlant::new(&setting, &params(), &values)
            .unwrap_err()
            .to_string()
    };
    let hypotheses = parsed(STRONGER_CONVECTION);
    let bounds = "must be in [0, 1]";
    for (value, written) in [(1.5, "1.5"), (-0.1, "-0.1"), (f64::NAN, "NaN")] {
        assert_eq!(
            refused(hypotheses, 0, 0, value),
            format!("stronger-convection: stronger_convection_k = {written} W/(m K^n): {bounds}")
        );
    }
    assert_eq!(
        refused(hypotheses, 0, 1, 0.0),
        "stronger-convection: stronger_convection_n = 0: must be in [1, 2]"
    );
    assert_eq!(
        refused(hypotheses, 1, 0, 2.0),
        "own[1][0] = 2: must be 0: the setting has no such parameter"
    );
    assert_eq!(
        refused(&[], 0, 0, f64::NAN),
        "own[0][0] = NaN: must be 0: the setting has no such parameter"
    );
    let many = [
        hypotheses[0].clone(),
        hypotheses[0].clone(),
        hypotheses[0].clone(),
        hypotheses[0].clone(),
        hypotheses[0].clone(),
    ]
    .to_vec()
    .leak();
    assert_eq!(refused(many, 0, 0, 0.0), "5 hypotheses: must be at most 4");
}

#[test]
fn an_equal_text_is_kept_once() {
    let text = one("drive", "a * T");
    assert!(std::ptr::eq(parsed(&text), parsed(&text.clone())));
}

#[test]
fn what_a_file_must_not_say_is_refused_with_its_place() {
    let good = one("drive", "a * T");
    let changed = |from: &str, to: &str| {
        assert!(good.contains(from));
        refusal(&good.replace(from, to))
    };
    let places = "must be exactly one of drive, heat_flow_w_per_m, shift_k, displacement";
    let id = "must be small letters, digits and single hyphens, from a letter, at most 40";
    let name =
        "must be letters, digits and _, from a letter, at most 40, and no variable or function";
    for (found, expected) in [
        (refusal(""), "1:1: missing field `hypothesis`".to_owned()),
        (changed("id =", "idd ="), "2:1: unknown field `idd`, expected one of `id`, `name`, `sentence`, `belongs_to`, `drive`, `heat_flow_w_per_m`, `shift_k`, `displacement`, `parameters`".to_owned()),
        (changed("typical = 1", "typical = \"x\""), "6:11: invalid type: string \"x\", expected a number".to_owned()),
        (changed("bounds", "range"), "7:1: unknown field `range`, expected one of `unit`, `typical`, `bounds`, `size`".to_owned()),
        (changed("own-drive", "Own"), format!("2:6: id = \"Own\": {id}")),
        (changed("own-drive", "a--b"), format!("2:6: id = \"a--b\": {id}")),
        (changed("own-drive", "radiation"), "2:6: id = \"radiation\": must not be the id of an effect of the catalogue".to_owned()),
        (changed("drive = \"a * T\"", ""), format!("1:1: no term: {places}")),
        (changed("drive = \"a", "shift_k = \"a\"\ndrive = \"a"), format!("3:11: drive and shift_k: {places}")),
        (changed("a * T", "a * Q"), "3:14: drive: 'Q': no such variable; known are T Ta xi drive t dir a pi".to_owned()),
        (changed("a * T", "a * y"), "3:14: drive: 'y': no such variable; known are T Ta xi drive t dir a pi".to_owned()),
        (changed("a * T", "a * (T"), "3:16: drive: ends where ')' must follow".to_owned()),
        (changed("a * T", "T"), "3:9: drive = \"T\": must use the parameter a".to_owned()),
        (changed("a * T", "a * T + 3"), "3:9: drive = \"a * T + 3\": is 3 at T = -30 with all sizes 0: must be 0 there; multiply every term by a size, and keep roots and quotients defined, as in max(T - Ta, 0)".to_owned()),
        (changed("a * T", "a * sqrt(T - Ta)"), "3:9: drive = \"a * sqrt(T - Ta)\": is NaN at T = -30, Ta = 0 with all sizes 0: must be 0 there; multiply every term by a size, and keep roots and quotients defined, as in max(T - Ta, 0)".to_owned()),
        (changed("a * T", "exp(a)"), "3:9: drive = \"exp(a)\": is 1 everywhere with all sizes 0: must be 0 there; multiply every term by a size, and keep roots and quotients defined, as in max(T - Ta, 0)".to_owned()),
        (changed("parameters.a", "parameters.exp"), format!("4:24: parameter 'exp': {name}")),
        (changed("parameters.a", "parameters.Ta"), format!("4:24: parameter 'Ta': {name}")),
        (changed("parameters.a", "parameters.\"a b\""), format!("4:24: parameter 'a b': {name}")),
        (changed("\"1\"", "\"\""), "5:8: a.unit = \"\": must be 1 to 40 characters; \"1\" for a pure number".to_owned()),
        (changed("typical = 1", "typical = 1e4"), "6:11: a.typical = 10000: must be in [-1000, 1000], but not 0".to_owned()),
        (changed("typical = 1", "typical = 0"), "6:11: a.typical = 0: must be in [-1000, 1000], but not 0".to_owned()),
        (changed("typical = 1", "typical = nan"), "6:11: a.typical = NaN: must be in [-1000, 1000], but not 0".to_owned()),
        (changed("[-1000, 1000]", "[0.5, 1000]"), "7:10: a.bounds = [0.5, 1000]: must hold 0, which a size is in the baseline; or size = false".to_owned()),
        (changed("[-1000, 1000]", "[3, 2]"), "7:10: a.bounds = [3, 2]: must be two finite numbers, the first smaller".to_owned()),
        (changed("[-1000, 1000]", "[nan, 2]"), "7:10: a.bounds = [NaN, 2]: must be two finite numbers, the first smaller".to_owned()),
        (changed("[-1000, 1000]", "[0, inf]"), "7:10: a.bounds = [0, inf]: must be two finite numbers, the first smaller".to_owned()),
        (refusal(&format!("{good}size = false\n")), "4:13: no size: at least one parameter must have size = true".to_owned()),
        (changed("id =", "name = \"{value}\"\nid ="), "2:8: name = \"{value}\": must be one line of at most 300 characters, without braces".to_owned()),
        (changed("id =", "sentence = \"{partner}\"\nid ="), "2:12: sentence = \"{partner}\": must be one line of at most 300 characters, without braces but for {value}".to_owned()),
        (refusal(&good.repeat(2)), "9:6: id = \"own-drive\": must be another than those above".to_owned()),
        (refusal(&good.repeat(5)), "29:1: 5 hypotheses: must be at most 4".to_owned()),
    ] {
        assert_eq!(found, format!("own.toml:{expected}"));
    }
    let parameter = "unit = \"1\"\ntypical = 1\nbounds = [0, 2]\n";
    let five: String = (1..=5)
        .map(|k| format!("[hypothesis.parameters.a{k}]\n{parameter}"))
        .collect();
    let many = format!("[[hypothesis]]\nid = \"many\"\ndrive = \"a1*a2*a3*a4*a5\"\n{five}");
    assert_eq!(
        refusal(&many),
        "own.toml:4:13: 5 parameters: must be 1 to 4"
    );
}

#[test]
fn an_expression_cannot_exhaust_the_stack() {
    let deep = format!("{}a{}", "(".repeat(100_000), ")".repeat(100_000));
    assert_eq!(
        refusal(&one("drive", &deep)),
        "own.toml:3:10: drive: 200001 characters: at most 1000"
    );
    let arrays = format!(
        "hypothesis = {}{}",
        "[".repeat(100_000),
        "]".repeat(100_000)
    );
    assert!(Hypothesis::parse("own.toml", &arrays).is_err());
}

#[test]
fn a_state_can_be_kept_and_resumed() {
    let (setting, values) = with(&four(), 0.01);
    let plant = ExtendedPlant::new(&setting, &params(), &values).unwrap();
    let mut state = plant.rest(AMBIENT_DEGC);
    let step = |state: &mut _, current: f64| {
        let input = Input {
            drive: [current],
            ambient_degc: AMBIENT_DEGC,
        };
        plant.step(state, &input, 0.2);
    };
    let current_a = current_a(0.2);
    let (first, second) = current_a.split_at(200);
    first.iter().for_each(|&i| step(&mut state, i));
    let mut kept = state.clone();
    second.iter().for_each(|&i| step(&mut state, i));
    second.iter().for_each(|&i| step(&mut kept, i));
    assert_eq!(kept, state);
}

#[test]
fn a_term_of_time_belongs_to_its_recording_unless_the_file_says_otherwise() {
    let whose = |text: &str| parsed(text)[0].info().belongs_to;
    assert_eq!(whose(&one("displacement", "a")), Belongs::Rig);
    let timed = one("displacement", "a * t");
    assert_eq!(whose(&timed), Belongs::Recording);
    let written = |whose: &str| {
        timed.replacen(
            "displacement =",
            &format!("belongs_to = \"{whose}\"\ndisplacement ="),
            1,
        )
    };
    assert_eq!(whose(&written("rig")), Belongs::Rig);
    assert_eq!(
        refusal(&written("history")),
        "own.toml:3:14: belongs_to = \"history\": must be rig or recording"
    );
}

#[test]
fn a_hypothesis_has_the_facts_of_an_ordinary_effect() {
    let info = parsed(&one("displacement", "a"))[0].info();
    assert!(info.is_rigid() && !info.in_every_rod() && !info.is_of_sensor() && !info.costly);
    assert!(info.acts_like.is_empty() && info.needs_in_recording.is_empty());
    let [a] = info.parameters else {
        panic!("one parameter");
    };
    // Typically 1, within -1000 and 1000.
    assert!(a.ln_prior(-6.0).abs() <= 0.0);
    assert!(a.ln_prior(100.0) < a.ln_prior(-10.0) && a.ln_prior(-10.0) < 0.0);
    assert!(a.ln_prior_width() > 12_f64.ln());
}
