//! The classic method of order 4 with equal steps: W. Kutta, 1901.

/// Numbers in the state of the lumped plant.
pub(super) const STATES: usize = 8;
/// The state, or its rates.
pub(super) type State = [f64; STATES];

/// The state a step later.
pub(super) fn step(
    state: &State,
    (time_s, length_s): (f64, f64),
    rates: impl Fn(f64, &State) -> State,
) -> State {
    let moved =
        |by_s: f64, rates: &State| -> State { std::array::from_fn(|k| state[k] + by_s * rates[k]) };
    let half_s = 0.5 * length_s;
    let first = rates(time_s, state);
    let second = rates(time_s + half_s, &moved(half_s, &first));
    let third = rates(time_s + half_s, &moved(half_s, &second));
    let fourth = rates(time_s + length_s, &moved(length_s, &third));
    std::array::from_fn(|k| {
        let sum = first[k] + 2.0 * (second[k] + third[k]) + fourth[k];
        state[k] + length_s * sum / 6.0
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn half_the_step_has_a_sixteenth_of_the_error() {
        let error = |n: u32| {
            let length_s = 1.0 / f64::from(n);
            let decay = |_: f64, y: &State| y.map(|y| -y);
            let mut state = [1.0; STATES];
            for k in 0..n {
                state = step(&state, (f64::from(k) * length_s, length_s), decay);
            }
            (state[0] - (-1.0_f64).exp()).abs()
        };
        let ratio = error(10) / error(20);
        assert!((14.0..18.0).contains(&ratio), "{ratio}");
    }
}
