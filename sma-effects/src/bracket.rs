//! The safeguard of a Newton search for the root of a rising function, in each lane.

/// Between which points the root lies, as far as they were tried.
#[derive(Debug)]
#[repr(align(64))]
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

    /// Takes a tried point and the value of the function there; returns the next one: that of Newton's
    /// rule, or the middle of the bracket if Newton leaves it. While one side is open there is no middle, and
    /// the way there is that of a function of slope 1.
    #[inline(always)]
    pub(crate) fn next(&mut self, lane: usize, tried: f64, value: f64, newton: f64) -> f64 {
        let below = value < 0.0;
        let lower = if below { tried } else { self.lower[lane] };
        let upper = if below { self.upper[lane] } else { tried };
        self.lower[lane] = lower;
        self.upper[lane] = upper;
        let middle = 0.5 * (lower + upper);
        let inside = if middle.is_finite() {
            middle
        } else {
            tried - value
        };
        // Both comparisons fail on NaN, which is passed on.
        let leaves = (newton < lower) | (newton > upper);
        if leaves { inside } else { newton }
    }
}
