//! A sample whose power changes within it: two parts, each of constant power.

use crate::effect::Acting;

/// Share of what a whole sample would do that is done after a share `s` of it.
///
/// ```text
/// G(s) = (1 - e^(-as))/(1 - e^(-a)) = s + s(1 - s)(a/2 + (1 - 2s) a²/12 - s(1 - s) a³/24) + O(a⁴)
/// ```
///
/// a = dt/τ ≤ 1. Exactly 0 at s = 0 and 1 at s = 1; off by 1e-7 at a = 0.1, 1e-5 at a = 0.5.
#[inline(always)]
pub(crate) fn progress(s: f64, a: f64) -> f64 {
    let product = s * (1.0 - s);
    s + product * a * (0.5 + a * ((1.0 - 2.0 * s) / 12.0 - product * a / 24.0))
}

/// x within 0 and 1.
#[inline(always)]
pub(crate) fn unit(x: f64) -> f64 {
    let x = if x > 0.0 { x } else { 0.0 };
    if x < 1.0 { x } else { 1.0 }
}

/// A sample in two parts: the rod may turn from heating to cooling between them.
#[derive(Debug, Clone, Copy)]
#[repr(align(64))]
pub(crate) struct Turn<const L: usize> {
    /// Share of the sample before it, 0 to 1.
    pub(crate) share: [f64; L],
    /// Constant powers that leave what those of the parts do, W/m.
    pub(crate) earlier_w_per_m: [f64; L],
    pub(crate) later_w_per_m: [f64; L],
}

/// Which part of a sample is being computed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Part {
    /// All of it: its power is constant.
    Whole,
    /// Up to the change of power.
    Earlier,
    /// From there on.
    Later,
}

/// A part of a sample and what acts in it.
#[derive(Debug)]
#[repr(align(64))]
pub(crate) struct Stage<const L: usize> {
    pub(crate) part: Part,
    /// Share of the sample that the part takes.
    pub(crate) share: [f64; L],
    /// Place of the sample's middle within the part, and whether it lies there.
    pub(crate) middle: [f64; L],
    pub(crate) has_middle: [bool; L],
    pub(crate) acting: Acting<L>,
}

impl<const L: usize> Stage<L> {
    /// All of the sample.
    #[inline(always)]
    pub(crate) fn whole(acting: Acting<L>) -> Self {
        Self {
            part: Part::Whole,
            share: [1.0; L],
            middle: [0.5; L],
            has_middle: [true; L],
            acting,
        }
    }

    /// Becomes the part before or after the change of power.
    #[inline(always)]
    pub(crate) fn divide(&mut self, part: Part, turn: &Turn<L>, dt_s: f64) {
        self.part = part;
        let is_earlier = part == Part::Earlier;
        self.acting.power_w_per_m = if is_earlier {
            turn.earlier_w_per_m
        } else {
            turn.later_w_per_m
        };
        for l in 0..L {
            let earlier = turn.share[l];
            let share = if is_earlier { earlier } else { 1.0 - earlier };
            let start = if is_earlier { 0.0 } else { earlier };
            let length_s = share * dt_s;
            self.share[l] = share;
            self.acting.per_s[l] = if length_s > 0.0 { 1.0 / length_s } else { 0.0 };
            self.has_middle[l] = (earlier > 0.5) == is_earlier;
            let per_share = if share > 0.0 { 1.0 / share } else { 0.0 };
            self.middle[l] = unit((0.5 - start) * per_share);
        }
    }
}
