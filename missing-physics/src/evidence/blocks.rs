//! Stretches of the recordings that are left out in turn.

use std::ops::Range;

use crate::model::case::Case;
use crate::model::series::Channel;

/// Blocks in all, about: enough to tell what one block says from what all say.
const MOST: usize = 16;

/// Blocks of a recording, at least: each is predicted from another of its own.
const FEWEST: usize = 2;

/// Gap between what is fitted and what is left out, time constants: so long a rod remembers.
const GAP: f64 = 5.0;

/// Gap on either side of a block over the block, at most.
const WIDEST_GAP: f64 = 0.25;

/// A stretch of one recording: its places in a series, of both channels.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Block {
    /// Number of the recording.
    pub(crate) recording: usize,
    /// Samples of the output that count.
    pub(crate) output: Range<usize>,
    /// Those of a recorded temperature.
    pub(crate) temperature: Option<Range<usize>>,
    /// All that is left out with them: the same with a gap on either side, so that what is remembered does not leak.
    pub(crate) removed: Vec<Range<usize>>,
}

impl Block {
    /// Samples that count, channel by channel.
    pub(crate) fn scored(&self) -> impl Iterator<Item = &Range<usize>> {
        std::iter::once(&self.output).chain(&self.temperature)
    }

    /// Sums of the squares of a residual: of the output, and of a recorded temperature.
    pub(crate) fn squares(&self, residual: &[f64]) -> [f64; 2] {
        let of = |rows: &Range<usize>| residual[rows.clone()].iter().map(|e| e * e).sum();
        [of(&self.output), self.temperature.as_ref().map_or(0.0, of)]
    }
}

/// Equal parts of all recordings of a case, none across two.
pub(crate) fn blocks(case: &Case<'_>) -> Vec<Block> {
    let (layout, training) = (&case.layout, case.training);
    let gap_s = GAP * case.fit.tau_s();
    let n_outputs = layout.n_outputs().max(1);
    let temperatures: Vec<&Range<usize>> = training
        .iter()
        .enumerate()
        .map(|(r, _)| {
            let mut own = layout.of_channel(Channel::Temperature);
            own.find(|one| one.recording == r)
                .map_or(&(0..0), |one| &one.range)
        })
        .collect();
    let mut blocks = Vec::new();
    for segment in layout.of_channel(Channel::Output) {
        let (r, n) = (segment.recording, segment.range.len());
        let n_parts = (MOST * n / n_outputs).max(FEWEST).min(n.max(1));
        let time_s = training[r].time_s();
        let dt_s = (time_s[n - 1] - time_s[0]) / n as f64;
        let widest = WIDEST_GAP * n as f64 / n_parts as f64;
        let gap = if dt_s > 0.0 {
            (gap_s / dt_s).min(widest) as usize
        } else {
            0
        };
        for part in 0..n_parts {
            let own = part * n / n_parts..(part + 1) * n / n_parts;
            let wide = own.start.saturating_sub(gap)..(own.end + gap).min(n);
            let placed = |start: usize, part: &Range<usize>| start + part.start..start + part.end;
            let second = (!temperatures[r].is_empty()).then(|| temperatures[r].start);
            let starts = std::iter::once(segment.range.start).chain(second);
            blocks.push(Block {
                recording: r,
                output: placed(segment.range.start, &own),
                temperature: second.map(|start| placed(start, &own)),
                removed: starts.map(|start| placed(start, &wide)).collect(),
            });
        }
    }
    blocks
}
