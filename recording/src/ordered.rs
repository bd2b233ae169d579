//! A series by size.

/// Share of the range below which no distance is usual: a drive that is held has none.
pub(crate) const LEAST: f64 = 1e-3;

/// Share of the samples from which a value is a level of the series.
const A_LEVEL: f64 = 0.01;

/// The values of a series in ascending order.
pub(crate) struct Ordered(Vec<f64>);

impl Ordered {
    pub(crate) fn new(values: &[f64]) -> Self {
        Self::of(values.to_vec())
    }

    pub(crate) fn of(mut values: Vec<f64>) -> Self {
        values.sort_by(f64::total_cmp);
        Self(values)
    }

    /// The upper of the two in the middle, if there are two.
    pub(crate) fn middle(&self) -> Option<f64> {
        self.0.get(self.0.len() / 2).copied()
    }

    /// From the first to the last hundredth: wild ones would stretch the range itself.
    pub(crate) fn range(&self) -> f64 {
        let at = |share: f64| self.0[(share * (self.0.len() - 1) as f64) as usize];
        at(0.99) - at(0.01)
    }

    /// True if the series stands at a value again and again: a drive that switches may do so for a single sample.
    pub(crate) fn has_level(&self, value: f64) -> bool {
        let near = LEAST * self.range();
        let below = self.0.partition_point(|other| *other < value - near);
        let up_to = self.0.partition_point(|other| *other <= value + near);
        (up_to - below) as f64 > A_LEVEL * self.0.len() as f64
    }
}

/// Middle of absolute values, as the standard deviation of a normal distribution.
pub(crate) fn usual_size(values: impl Iterator<Item = f64>) -> f64 {
    let mut sizes: Vec<f64> = values.map(f64::abs).collect();
    if sizes.is_empty() {
        return 0.0;
    }
    let middle = sizes.len() / 2;
    let (_, median, _) = sizes.select_nth_unstable_by(middle, f64::total_cmp);
    1.4826 * *median
}
