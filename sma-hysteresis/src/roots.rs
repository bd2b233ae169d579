//! Roots of functions that rise from 0 to 1, side by side.

/// Values at which a search has not ended after so many steps are as near as it gets.
const MOST_STEPS: usize = 60;
/// Steps after which a search that has not ended halves the distance of the ends: false position is slow where a function is flat on one side.
const PATIENCE: usize = 20;
/// Value, and distance of the ends, that are as good as none.
const NOTHING: f64 = 1e-15;

/// Search for one root: the ends between which it lies, and the values there.
#[derive(Debug, Clone, Copy)]
struct Search {
    ends: [f64; 2],
    at_ends: [f64; 2],
    /// Which end moved last.
    moved: Option<usize>,
    root: f64,
    is_open: bool,
}

impl Search {
    fn between(at_ends: [f64; 2]) -> Self {
        let [lower, upper] = at_ends;
        Self {
            ends: [0.0, 1.0],
            at_ends,
            moved: None,
            root: if lower >= 0.0 { 0.0 } else { 1.0 },
            is_open: lower < 0.0 && upper > 0.0,
        }
    }

    fn place(&mut self, step: usize) {
        let [lower, upper] = self.at_ends;
        let share = if step < PATIENCE {
            -lower / (upper - lower)
        } else {
            0.5
        };
        self.root = self.ends[0] + share * (self.ends[1] - self.ends[0]);
    }

    fn narrow(&mut self, value: f64) {
        let end = usize::from(value >= 0.0);
        if self.moved == Some(end) {
            self.at_ends[1 - end] *= 0.5;
        }
        self.moved = Some(end);
        (self.ends[end], self.at_ends[end]) = (self.root, value);
        self.is_open = value.abs() > NOTHING && self.ends[1] - self.ends[0] > NOTHING;
    }
}

/// Roots between 0 and 1 of rising functions, the nearer end where there is none: by false position, where the value at an end that
/// stays is halved, and in the end by bisection. The root of a lane does not depend on the others.
pub(crate) fn rising_roots<const L: usize>(
    values: &mut impl FnMut(&[f64; L]) -> [f64; L],
) -> [f64; L] {
    let at_ends = [values(&[0.0; L]), values(&[1.0; L])];
    let mut searches: [Search; L] =
        core::array::from_fn(|l| Search::between([at_ends[0][l], at_ends[1][l]]));
    for step in 0..MOST_STEPS {
        if searches.iter().all(|search| !search.is_open) {
            break;
        }
        for search in searches.iter_mut().filter(|search| search.is_open) {
            search.place(step);
        }
        let at_roots = values(&searches.map(|search| search.root));
        for (search, value) in searches.iter_mut().zip(at_roots) {
            if search.is_open {
                search.narrow(value);
            }
        }
    }
    searches.map(|search| search.root)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_function_that_is_flat_on_one_side_has_its_root_where_it_leaves_zero() {
        let flat = |x: f64| (x - 0.3_f64).max(0.0).powi(4);
        for at in [0.301, 0.31, 0.4] {
            let root = rising_roots(&mut |x: &[f64; 1]| [flat(x[0]) - flat(at)]);
            assert!((flat(root[0]) - flat(at)).abs() < 1e-14, "{at}: {root:?}");
        }
    }

    #[test]
    fn roots_are_found_each_by_itself_and_the_nearer_end_where_there_is_none() {
        let fifth = |x: f64| x * x * x * x * x;
        let mut values = |x: &[f64; 4]| [x[0] - 0.3, fifth(x[1]) - 1e-3, x[2] + 0.1, x[3] - 1.5];
        let roots = rising_roots(&mut values);
        assert!((roots[0] - 0.3).abs() < 1e-14);
        assert!((fifth(roots[1]) - 1e-3).abs() < 1e-14);
        assert_eq!(roots[2].to_bits(), 0.0_f64.to_bits());
        assert_eq!(roots[3].to_bits(), 1.0_f64.to_bits());
        let alone = rising_roots(&mut |x: &[f64; 1]| [fifth(x[0]) - 1e-3]);
        assert_eq!(alone[0].to_bits(), roots[1].to_bits());
    }
}
