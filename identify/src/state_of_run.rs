//! Deviations of a rig from run to run.

use wiener::{Block, WienerParams};

/// Deviation of a recording from the stated properties of the rig.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct StateOfRun {
    /// Temperature of its surroundings above what is stated, K.
    pub level_k: f64,
    /// Share by which it loses more heat.
    pub heat_loss: f64,
    /// Share by which it moves further.
    pub gain: f64,
}

impl StateOfRun {
    /// The rod in this state, as if it stood in the surroundings that are stated: what [`in_states`] takes.
    #[must_use]
    pub fn of(self, rig: WienerParams) -> WienerParams {
        let mut params = rig;
        params.limiting_loop.loop_center_degc -= self.level_k;
        params.heat.conductance_w_per_m_k *= 1.0 + self.heat_loss;
        params
    }
}

/// Shows blocks as they are in states of runs, of members that were simulated in the surroundings that are stated.
///
/// ```text
/// T = T' + level,   the loop met level lower: heat that is lost by a difference of temperatures does not know the level
/// y = (1 + gain) y'
/// ```
///
/// `states` has one a member.
pub fn in_states<'v>(
    states: Vec<StateOfRun>,
    visit: &'v mut dyn FnMut(Block<'_>),
) -> impl FnMut(Block<'_>) + 'v {
    let is_none = |of: fn(&StateOfRun) -> f64| states.iter().all(|state| of(state) == 0.0);
    let is_warmer = !is_none(|state| state.level_k);
    let is_further = !is_none(|state| state.gain);
    let (mut warmer, mut further) = (Vec::new(), Vec::new());
    move |block: Block<'_>| {
        let rows = |kept: &mut Vec<f64>, values: &[f64], change: fn(&mut f64, &StateOfRun)| {
            kept.clear();
            kept.extend_from_slice(values);
            for row in kept.chunks_exact_mut(block.stride) {
                let own = row.iter_mut().zip(&states[block.first_member..]);
                own.for_each(|(value, state)| change(value, state));
            }
        };
        let mut shown = block;
        if is_warmer {
            rows(&mut warmer, block.temperature_degc, |degc, state| {
                *degc += state.level_k;
            });
            shown.temperature_degc = &warmer;
        }
        if is_further {
            rows(&mut further, block.displacement, |y, state| {
                *y *= 1.0 + state.gain;
            });
            shown.displacement = &further;
        }
        visit(shown);
    }
}
