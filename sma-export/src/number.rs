//! Numbers as text that reads back to their bits.

/// A finite number as a hexadecimal floating constant of C99.
///
/// ```text
/// 6.25 → 0x1.9p+2,   -0.5 → -0x1p-1,   0 → 0x0p+0
/// ```
pub(crate) fn hexadecimal(value: f64) -> String {
    const MANTISSA_BITS: u32 = 52;
    const BIAS: i64 = 1023;
    let bits = value.to_bits();
    let sign = if value.is_sign_negative() { "-" } else { "" };
    let biased = ((bits >> MANTISSA_BITS) & 0x7ff) as i64;
    let mantissa = bits & ((1 << MANTISSA_BITS) - 1);
    let (lead, exponent) = match (biased, mantissa) {
        (0, 0) => (0, 0),
        (0, _) => (0, 1 - BIAS),
        _ => (1, biased - BIAS),
    };
    let digits = format!("{mantissa:013x}");
    let digits = digits.trim_end_matches('0');
    let point = if digits.is_empty() { "" } else { "." };
    format!("{sign}0x{lead}{point}{digits}p{exponent:+}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_written_as_c_reads_them() {
        for (value, text) in [
            (0.0, "0x0p+0"),
            (-0.0, "-0x0p+0"),
            (1.0, "0x1p+0"),
            (6.25, "0x1.9p+2"),
            (-0.5, "-0x1p-1"),
            (0.1, "0x1.999999999999ap-4"),
            (f64::MAX, "0x1.fffffffffffffp+1023"),
            (f64::from_bits(1), "0x0.0000000000001p-1022"),
        ] {
            assert_eq!(hexadecimal(value), text);
        }
    }
}
