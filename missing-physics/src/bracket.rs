//! The safeguard of a Newton search for the root of a rising function, in each lane.

/// Between which points the root lies, as far as they were tried.
#[derive(Debug)]
pub(crate) struct Bracket<const L: usize> {
    lower: [f64; L],
    upper: [f64; L],
}

impl<const L: usize> Bracket<L> {
    pub(crate) fn open() -> Self {
        Self {
            lower: [f64::NEG_INFINITY; L],
            upper: [f64::INFINITY; L],
        }
    }

    /// Takes a tried point and the sign of the function there; returns the next one: that of Newton's
    /// rule, or the middle of the bracket if Newton leaves it.
    #[inline(always)]
    pub(crate) fn next(&mut self, lane: usize, tried: f64, value: f64, newton: f64) -> f64 {
        let below = value < 0.0;
        let lower = if below { tried } else { self.lower[lane] };
        let upper = if below { self.upper[lane] } else { tried };
        self.lower[lane] = lower;
        self.upper[lane] = upper;
        // Both comparisons fail on NaN, which is passed on.
        let leaves = (newton < lower) | (newton > upper);
        if leaves {
            0.5 * (lower + upper)
        } else {
            newton
        }
    }
}
