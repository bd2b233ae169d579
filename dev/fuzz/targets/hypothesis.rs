//! Any text as a hypothesis, or as an expression in one: refused with its name, or an effect.
#![no_main]

use libfuzzer_sys::fuzz_target;
use sma_effects::Hypothesis;

fuzz_target!(|text: &str| {
    let whole;
    let text = match text.strip_prefix('=') {
        // What follows is an expression alone.
        Some(expression) if !expression.contains(['"', '\\', '\n', '\r']) => {
            whole = format!(
                "[[hypothesis]]\nid = \"own\"\nshift_k = \"k * ({expression})\"\n\
                 [hypothesis.parameters.k]\nunit = \"K\"\ntypical = 1.0\nbounds = [-5.0, 5.0]\n"
            );
            &whole
        }
        _ => text,
    };
    match Hypothesis::parse("own.toml", text) {
        Err(error) => assert!(error.to_string().contains("own.toml"), "{error}"),
        Ok(hypotheses) => {
            for one in hypotheses {
                assert!(one.values(1.0).iter().all(|value| value.is_finite()));
            }
        }
    }
});
