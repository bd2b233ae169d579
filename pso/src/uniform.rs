use rand::Rng;

/// Uniform in [0, 1): the upper 53 bits of one `next_u64`, times 2⁻⁵³.
///
/// Written here and not taken from `rand`, so that its releases cannot move a result.
pub(crate) fn unit<R: Rng>(generator: &mut R) -> f64 {
    // 53 = bits of the significand of an f64: the product is exact.
    (generator.next_u64() >> 11) as f64 * (1.0 / (1_u64 << 53) as f64)
}

/// Uniform in 0..count from one `next_u64` by a wide multiplication; count >= 1.
///
/// The bias is below count / 2⁶⁴, and, unlike rejection, it draws once whatever comes.
pub(crate) fn index<R: Rng>(generator: &mut R, count: usize) -> usize {
    ((u128::from(generator.next_u64()) * count as u128) >> 64) as usize
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand_chacha::rand_core::{RngCore, impls};

    /// Returns the same word forever.
    struct Word(u64);

    impl RngCore for Word {
        fn next_u32(&mut self) -> u32 {
            self.0 as u32
        }
        fn next_u64(&mut self) -> u64 {
            self.0
        }
        fn fill_bytes(&mut self, bytes: &mut [u8]) {
            impls::fill_bytes_via_next(self, bytes);
        }
    }

    #[test]
    fn unit_reaches_zero_and_never_one() {
        assert_eq!(unit(&mut Word(0)).to_bits(), 0.0_f64.to_bits());
        assert_eq!(
            unit(&mut Word(u64::MAX)).to_bits(),
            (1.0 - 0.5 * f64::EPSILON).to_bits()
        );
        assert_eq!(unit(&mut Word(1 << 63)).to_bits(), 0.5_f64.to_bits());
    }

    #[test]
    fn index_stays_below_count() {
        assert_eq!(index(&mut Word(u64::MAX), 7), 6);
        assert_eq!(index(&mut Word(0), 7), 0);
        assert_eq!(index(&mut Word(u64::MAX), 1), 0);
    }
}
