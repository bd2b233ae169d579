//! Responses of a loop at a sweep of frequencies, real and imaginary parts apart.

use wiener::widest_vectors;

use crate::PidGains;
use crate::complex::Complex;

/// Squares of magnitudes below which products of two responses are numbers.
const PLAIN: f64 = 1e200;

/// Complex numbers, one a frequency.
#[derive(Debug, Clone)]
pub(crate) struct Swept {
    re: Vec<f64>,
    im: Vec<f64>,
}

impl Swept {
    /// The number at a frequency.
    pub(crate) fn at(&self, k: usize) -> Complex {
        Complex {
            re: self.re[k],
            im: self.im[k],
        }
    }

    pub(crate) fn len(&self) -> usize {
        self.re.len()
    }

    /// A loop around a plant of these responses: P, and P times integral and derivative at gains of 1.
    pub(crate) fn sum_up([plant, integral, derivative]: &[Self; 3], gains: &PidGains) -> Self {
        Self {
            re: weighted([&plant.re, &integral.re, &derivative.re], gains),
            im: weighted([&plant.im, &integral.im, &derivative.im], gains),
        }
    }

    /// For each frequency, whether anything may happen between the one before and it: this crosses the real axis, or has a magnitude of
    /// 1, or is no plain number. False at the first.
    pub(crate) fn stirs(&self) -> Vec<bool> {
        let mut stirs = vec![false; self.len()];
        widest_vectors(
            #[inline(always)]
            || marked([&self.re, &self.im], &mut stirs),
        );
        stirs
    }
}

impl FromIterator<Complex> for Swept {
    fn from_iter<I: IntoIterator<Item = Complex>>(all: I) -> Self {
        let (re, im) = all.into_iter().map(|one| (one.re, one.im)).unzip();
        Self { re, im }
    }
}

/// Sum of three series, each times its gain.
fn weighted([plant, integral, derivative]: [&[f64]; 3], gains: &PidGains) -> Vec<f64> {
    let PidGains { kp, ki, kd } = *gains;
    let mut sum = vec![0.0; plant.len()];
    widest_vectors(
        #[inline(always)]
        || {
            let parts = plant.iter().zip(integral).zip(derivative);
            for (sum, ((plant, integral), derivative)) in sum.iter_mut().zip(parts) {
                *sum = plant * kp + integral * ki + derivative * kd;
            }
        },
    );
    sum
}

#[inline(always)]
fn marked([re, im]: [&[f64]; 2], stirs: &mut [bool]) {
    let n = stirs.len().min(re.len()).min(im.len());
    for k in 1..n {
        let [before, after] = [k - 1, k].map(|k| re[k] * re[k] + im[k] * im[k]);
        let turns = (im[k - 1] >= 0.0) != (im[k] >= 0.0);
        let is_plain = (before < PLAIN) & (after < PLAIN);
        stirs[k] = turns | ((before - 1.0) * (after - 1.0) <= 0.0) | !is_plain;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_stirs_but_crossings_and_what_is_no_number() {
        let of = |all: &[[f64; 2]]| -> Vec<bool> {
            let all = all.iter().map(|&[re, im]| Complex { re, im });
            all.collect::<Swept>().stirs()
        };
        let [far, near] = [[-3.0, -0.1], [-0.5, -0.1]];
        assert_eq!(of(&[far, far, near, near]), [false, false, true, false]);
        assert_eq!(of(&[far, [-3.0, 0.1], [-3.0, 0.2]]), [false, true, false]);
        assert_eq!(of(&[far, [f64::NAN, 0.1], far]), [false, true, true]);
        assert_eq!(of(&[[1e160, 1.0]; 2]), [false, true]);
    }
}
