//! Check that a term is zero where its sizes are zero.

use super::{Expression, VARIABLES};
use crate::{EffectParameter, Role};

/// Values that are tried of each variable, in the order of [`VARIABLES`]: rods and surroundings from frost to a
/// red glow, among them equal ones; all drives, times and displacements of a laboratory.
const TRIED: [&[f64]; VARIABLES.len()] = [
    &[-30.0, 0.0, 22.0, 60.0, 110.0, 600.0],
    &[-30.0, 0.0, 22.0, 60.0],
    &[0.0, 0.4, 1.0],
    &[-2.0, 0.0, 0.3, 1.0, 24.0],
    &[0.0, 1.0, 1e4],
    &[-1.0, 1.0],
    &[-20.0, 0.0, 0.5, 20.0],
];

/// A state in which a term with all sizes 0 is not 0.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Exception {
    pub(super) value: f64,
    /// Variables and values, as in `T = 22, Ta = 22`.
    pub(super) state: String,
}

/// The first state among those tried in which the term does not vanish.
pub(super) fn exception(term: &Expression, parameters: &[EffectParameter]) -> Option<Exception> {
    let mut tried: Vec<Vec<f64>> = TRIED.iter().map(|values| values.to_vec()).collect();
    tried.extend(parameters.iter().map(|parameter| match parameter.role {
        Role::Size => vec![0.0],
        Role::Partner { .. } => {
            let [lower, upper] = parameter.bounds;
            vec![lower, parameter.typical, upper]
        }
    }));
    for (variable, values) in tried.iter_mut().enumerate() {
        if !term.uses(variable) {
            values.truncate(1);
        }
    }
    let mut place = vec![0; tried.len()];
    loop {
        let mut values = [0.0; Expression::MOST_VARIABLES];
        for (variable, &index) in place.iter().enumerate() {
            values[variable] = tried[variable][index];
        }
        let value = term.value(&values);
        let vanishes = value.abs() <= 0.0;
        if !vanishes {
            let names = VARIABLES.into_iter().enumerate();
            let shown: Vec<String> = names
                .filter(|&(variable, _)| term.uses(variable))
                .map(|(variable, name)| format!("{name} = {}", values[variable]))
                .collect();
            return Some(Exception {
                value,
                state: if shown.is_empty() {
                    "everywhere".to_owned()
                } else {
                    format!("at {}", shown.join(", "))
                },
            });
        }
        // The next combination, the last variable fastest.
        let next = (0..place.len())
            .rev()
            .find(|&variable| place[variable] + 1 < tried[variable].len())?;
        place[next] += 1;
        place[next + 1..].fill(0);
    }
}
