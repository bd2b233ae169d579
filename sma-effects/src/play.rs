//! The play operator: backlash, and the simplest hysteresis there is.

/// Where the driven side stands once the driving side is at `driver`, for a play of half width
/// `half_width` to either side. With no play, at the driver to the last bit.
///
/// ```text
/// z = max(x - w, min(x + w, z_0))
/// ```
#[inline(always)]
pub(crate) fn play(before: f64, driver: f64, half_width: f64) -> f64 {
    let upper = driver + half_width;
    let lower = driver - half_width;
    // Selections, not `clamp`, which asserts its bounds.
    let below = if before < upper { before } else { upper };
    if below > lower { below } else { lower }
}

/// Where the driven side stands between the ends of the play: `share` = 0 as after rising for long,
/// 1 as after falling.
#[inline(always)]
pub(crate) fn play_at(driver: f64, half_width: f64, share: f64) -> f64 {
    driver + half_width * (2.0 * share.clamp(0.0, 1.0) - 1.0)
}
