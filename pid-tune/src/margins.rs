use core::f64::consts::PI;

use crate::bracket::root;
use crate::complex::Complex;
use crate::swept::Swept;

/// Share of a frequency to which crossovers are found.
const FREQUENCY_TOLERANCE: f64 = 1e-12;

/// How far a loop is from instability.
///
/// ```text
/// gain margin   min 1/|L| where L < 0
/// phase margin  min π + arg L where |L| = 1, arg L from -π to π
/// delay margin  min (π + arg L)/ω where |L| = 1
/// M_s           max 1/|1 + L|                                   [Astrom2006, chapter 4]
/// ```
///
/// each over all frequencies up to half of the sampling frequency, that one included. The delay margin is that
/// of a delay in continuous time; a whole number of samples below it is safe.
///
/// A loop that is not `stable` bears no lag and no delay, both are 0; its gain margin is what its gain would have
/// to be multiplied with.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Margins {
    /// True if the closed loop is stable, by the Nyquist criterion: winding of 1 + L, which has no unstable poles.
    pub stable: bool,
    /// Factor on the gain that the loop bears; ∞ where L never is negative.
    pub gain_margin: f64,
    /// Phase lag that the loop bears, rad; ∞ where |L| never is 1.
    pub phase_margin_rad: f64,
    /// Delay that the loop bears, s; ∞ where |L| never is 1.
    pub delay_margin_s: f64,
    /// Peak sensitivity M_s; ≥ 1 but for rounding.
    pub peak_sensitivity: f64,
    /// Frequency of that peak, Hz.
    pub peak_hz: f64,
}

impl Margins {
    /// Margins of a loop by its response at a sweep of frequencies, rising, up to half of the sampling frequency,
    /// and refinement between them.
    pub(crate) fn of(
        sweep: &[f64],
        responses: &[Complex],
        response: impl Fn(f64) -> Complex,
    ) -> Self {
        let exact = |k: usize, excess: fn(Complex) -> f64| {
            let tolerance = FREQUENCY_TOLERANCE * sweep[k];
            let omega = root(
                |omega| excess(response(omega)),
                [sweep[k - 1], sweep[k]],
                tolerance,
            )?;
            Some((omega, response(omega)))
        };
        let all = 1..sweep.len();
        let mut margins = Self::along(responses.len(), |k| responses[k], all, exact);
        let (peak_sensitivity, peak_rad_per_s) = peak_sensitivity(sweep, responses, response);
        margins.peak_sensitivity = peak_sensitivity;
        margins.peak_hz = peak_rad_per_s / (2.0 * PI);
        margins
    }

    /// Margins by responses alone, with straight lines between them: for a search, that looks at many loops.
    pub(crate) fn between(sweep: &[f64], responses: &Swept) -> Self {
        let stirs = responses.stirs();
        // Of the last one the sign counts as well.
        let looked_at = (1..stirs.len()).filter(|&k| stirs[k] || k == 1 || k == stirs.len() - 1);
        Self::straight(sweep, responses, looked_at)
    }

    fn straight(sweep: &[f64], responses: &Swept, looked_at: impl Iterator<Item = usize>) -> Self {
        let crossing = |k: usize, excess: fn(Complex) -> f64| {
            let [before, after] = [responses.at(k - 1), responses.at(k)];
            let [at_before, at_after] = [excess(before), excess(after)];
            let share = at_before / (at_before - at_after);
            let way = after + before * -1.0;
            let omega = sweep[k - 1] + share * (sweep[k] - sweep[k - 1]);
            Some((omega, before + way * share))
        };
        Self::along(responses.len(), |k| responses.at(k), looked_at, crossing)
    }

    /// Margins by n responses; `looked_at` are the ends of intervals, the first and the last among them, outside of which L neither is
    /// real nor has a magnitude of 1, and `crossing` finds where L has no excess, in the interval that ends with a number.
    fn along(
        n: usize,
        response: impl Fn(usize) -> Complex,
        looked_at: impl Iterator<Item = usize>,
        crossing: impl Fn(usize, fn(Complex) -> f64) -> Option<(f64, Complex)>,
    ) -> Self {
        let mut margins = Self {
            stable: false,
            gain_margin: f64::INFINITY,
            phase_margin_rad: f64::INFINITY,
            delay_margin_s: f64::INFINITY,
            peak_sensitivity: 1.0,
            peak_hz: 0.0,
        };
        // The Nyquist criterion for a loop without unstable poles of its own: 1 + L, from its integrator's indentation
        // on the positive real axis to half of the sampling frequency, turns around 0 by nothing in all. With the
        // points at which it is real: next to -1 it turns by half a circle between two frequencies.
        let mut winding = Winding::from(Complex::ONE);
        for k in looked_at {
            let [before, after] = [response(k - 1), response(k)];
            if k > 1 {
                winding.at = before + Complex::ONE;
            }
            if before.re.min(after.re) < 0.0
                && before.im * after.im < 0.0
                && let Some((_, response)) = crossing(k, |response| response.im)
            {
                margins.bear_gain(response);
                winding.go_to(response + Complex::ONE);
            }
            winding.go_to(after + Complex::ONE);
            if (before.square() - 1.0) * (after.square() - 1.0) <= 0.0
                && let Some((omega, response)) = crossing(k, |response| response.magnitude() - 1.0)
            {
                margins.bear_delay(response, omega);
            }
        }
        // At half of the sampling frequency L is real.
        if n > 0 {
            margins.bear_gain(response(n - 1));
        }
        margins.stable = winding.is_none();
        if !margins.stable {
            margins.phase_margin_rad = 0.0;
            margins.delay_margin_s = 0.0;
        }
        margins
    }

    /// The worse of both in each respect.
    pub(crate) fn worse(&self, other: &Self) -> Self {
        let peak = if self.peak_sensitivity >= other.peak_sensitivity {
            self
        } else {
            other
        };
        Self {
            stable: self.stable && other.stable,
            gain_margin: self.gain_margin.min(other.gain_margin),
            phase_margin_rad: self.phase_margin_rad.min(other.phase_margin_rad),
            delay_margin_s: self.delay_margin_s.min(other.delay_margin_s),
            ..*peak
        }
    }

    fn bear_gain(&mut self, response: Complex) {
        if response.re < 0.0 {
            self.gain_margin = self.gain_margin.min(1.0 / response.magnitude());
        }
    }

    fn bear_delay(&mut self, response: Complex, omega_rad_per_s: f64) {
        let lag_rad = PI + response.angle_rad();
        self.phase_margin_rad = self.phase_margin_rad.min(lag_rad);
        self.delay_margin_s = self.delay_margin_s.min(lag_rad / omega_rad_per_s);
    }
}

/// Winding number of a polyline around 0: crossings of the negative real axis, each with its sign.
#[derive(Debug, Clone, Copy)]
struct Winding {
    at: Complex,
    turns: i32,
    is_finite: bool,
}

impl Winding {
    fn from(at: Complex) -> Self {
        Self {
            at,
            turns: 0,
            is_finite: true,
        }
    }

    fn go_to(&mut self, to: Complex) {
        // Positive where 0 lies to the left.
        let side = self.at.re * to.im - self.at.im * to.re;
        self.is_finite &= side.is_finite();
        match (self.at.im >= 0.0, to.im >= 0.0) {
            (true, false) if side > 0.0 => self.turns += 1,
            (false, true) if side < 0.0 => self.turns -= 1,
            _ => {}
        }
        self.at = to;
    }

    /// True if it is 0 and the last point has a positive real part; false with a point that is no number.
    fn is_none(&self) -> bool {
        self.is_finite && self.turns == 0 && self.at.re > 0.0
    }
}

fn peak_sensitivity(
    sweep: &[f64],
    responses: &[Complex],
    response: impl Fn(f64) -> Complex,
) -> (f64, f64) {
    let mut nearest = 0;
    let distance = |response: Complex| (response + Complex::ONE).magnitude();
    for k in 0..responses.len() {
        if distance(responses[k]) < distance(responses[nearest]) {
            nearest = k;
        }
    }
    let omega = smallest(
        |omega| distance(response(omega)),
        [
            sweep[nearest.max(1) - 1],
            sweep[(nearest + 1).min(sweep.len() - 1)],
        ],
    );
    let refined = distance(response(omega));
    let swept = distance(responses[nearest]);
    // A golden section comes close to an end, not onto it.
    if refined < swept {
        (1.0 / refined, omega)
    } else {
        (1.0 / swept, sweep[nearest])
    }
}

/// Where a function with one minimum between two ends is smallest, by golden section.
fn smallest(function: impl Fn(f64) -> f64, ends: [f64; 2]) -> f64 {
    const STEPS: usize = 60;
    let share = 0.5 * (5.0_f64.sqrt() - 1.0);
    let [mut low, mut high] = ends;
    let mut inner = [high - share * (high - low), low + share * (high - low)];
    let mut values = inner.map(&function);
    for _ in 0..STEPS {
        if values[0] < values[1] {
            high = inner[1];
            inner = [high - share * (high - low), inner[0]];
            values = [function(inner[0]), values[0]];
        } else {
            low = inner[0];
            inner = [inner[1], low + share * (high - low)];
            values = [values[1], function(inner[1])];
        }
    }
    0.5 * (low + high)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::complex::unwrapped;

    #[test]
    fn where_nothing_stirs_nothing_is_missed() {
        let sweep: Vec<f64> = (1..60).map(f64::from).collect();
        let mut stable = [0; 2];
        for path in 0..300 {
            let turn = 0.05 * f64::from(path % 23) + 0.01;
            let shrink = 0.5 + 0.01 * f64::from(path % 47);
            let at = |k: &f64| {
                let pulled = if path % 9 == 0 { 0.0 } else { 0.2 };
                Complex::unit(-turn * k) * (4.0 * shrink.powf(*k)) + Complex::real(-pulled)
            };
            let mut responses: Vec<Complex> = sweep.iter().map(at).collect();
            if path % 50 == 0 {
                responses[30].re = f64::INFINITY;
            }
            let responses: Swept = responses.into_iter().collect();
            let all = Margins::straight(&sweep, &responses, 1..sweep.len());
            assert_eq!(Margins::between(&sweep, &responses), all, "{path}");
            stable[usize::from(all.stable)] += 1;
        }
        assert!(stable.iter().all(|&n| n > 20), "{stable:?}");
    }

    #[test]
    fn the_winding_number_is_that_of_the_angle() {
        let mut counts = [0; 3];
        for path in 0..500 {
            let mut winding = Winding::from(Complex::ONE);
            let mut angle_rad = 0.0;
            for step in 1..20 {
                let phase = f64::from(path * 37 + step * (1 + path % 5));
                let to =
                    Complex::unit(phase) * (1.0 + 0.9 * (1.7 * phase).sin()) + Complex::real(0.3);
                winding.go_to(to);
                angle_rad = unwrapped(to.angle_rad(), angle_rad);
                let expected = ((angle_rad - to.angle_rad()) / (2.0 * PI)).round();
                assert!(
                    (f64::from(winding.turns) - expected).abs() < 0.5,
                    "{path} {step}"
                );
            }
            counts[(winding.turns.signum() + 1) as usize] += 1;
        }
        assert!(counts.iter().all(|&count| count > 0), "{counts:?}");
        let mut winding = Winding::from(Complex::ONE);
        assert!(winding.is_none());
        winding.go_to(Complex::real(f64::NAN));
        winding.go_to(Complex::ONE);
        assert!(!winding.is_none());
    }
}
