//! Surroundings whose level nobody wrote down.

use wiener::Block;

/// Shows blocks with the temperatures of members that stand in warmer surroundings than they were simulated in.
///
/// ```text
/// T = T' + level,   the loop met level lower: heat that is lost by a difference of temperatures does not know the level
/// ```
///
/// `levels_k` has a value a member.
pub fn in_warmer_surroundings<'v>(
    levels_k: Vec<f64>,
    visit: &'v mut dyn FnMut(Block<'_>),
) -> impl FnMut(Block<'_>) + 'v {
    let is_none = levels_k.iter().all(|level_k| *level_k == 0.0);
    let mut warmer = Vec::new();
    move |block: Block<'_>| {
        if is_none {
            visit(block);
            return;
        }
        warmer.clear();
        warmer.extend_from_slice(block.temperature_degc);
        for row in warmer.chunks_exact_mut(block.stride) {
            let own = row.iter_mut().zip(&levels_k[block.first_member..]);
            own.for_each(|(degc, level_k)| *degc += level_k);
        }
        visit(Block {
            temperature_degc: &warmer,
            ..block
        });
    }
}
