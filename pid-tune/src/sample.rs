/// Inputs of a controller at one sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sample<const L: usize = 1> {
    /// Reference r, in the output's unit.
    pub setpoint: f64,
    /// Measurement y, in the output's unit.
    pub measured: [f64; L],
    /// Drive that is added to the controller's own, in the drive's unit; 0 for none.
    pub feed_forward: f64,
}

/// Command of a controller, in the drive's unit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Command<const L: usize = 1> {
    /// Drive u, within the limits; finite.
    pub drive: [f64; L],
    /// Drive v before the limits.
    pub unsaturated: [f64; L],
}

impl<const L: usize> Sample<L> {
    #[inline(always)]
    pub(crate) fn error(&self) -> [f64; L] {
        let mut error = [0.0; L];
        for l in 0..L {
            error[l] = self.setpoint - self.measured[l];
        }
        error
    }
}
