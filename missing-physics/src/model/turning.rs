//! Where a series turns back.

/// Point at which a series turns.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct TurningPoint {
    /// Its sample.
    pub(crate) at: usize,
    /// True if the series falls from there.
    pub(crate) is_top: bool,
}

/// Points from which a series comes back by more than `swing`; the one that it begins with counts, too.
pub(crate) fn turning_points(values: &[f64], swing: f64) -> Vec<TurningPoint> {
    let mut points = Vec::new();
    let mut rises = None;
    // Highest and lowest since the last one.
    let (mut top, mut bottom) = (0, 0);
    for (k, &now) in values.iter().enumerate() {
        if now >= values[top] {
            top = k;
        }
        if now <= values[bottom] {
            bottom = k;
        }
        let is_top = rises != Some(false) && values[top] - now > swing;
        let is_bottom = rises != Some(true) && now - values[bottom] > swing;
        if is_top || is_bottom {
            let at = if is_top { top } else { bottom };
            points.push(TurningPoint { at, is_top });
            rises = Some(!is_top);
            (top, bottom) = (k, k);
        }
    }
    points
}
