use crate::error::{TruthError, within};
use std::f64::consts::PI;

/// The scale of the transducer is bent.
///
/// ```text
/// y → y + c (w³ - w) S,   w = 2 y/S - 1        S the stroke
/// ```
///
/// Ends and middle of the stroke are read right.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SensorCubic {
    /// c; -0.2 to 0.2. The largest error is 0.38 c of the stroke. Typical: 0.03.
    pub coefficient: f64,
}

/// The electronics' low-pass filter and its pure delay.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OutputFilter {
    /// Time constant, s; 0 to 100. Typical: 0.4.
    pub time_constant_s: f64,
    /// Delay, s; 0 to 10. Typical: 0, or 0.3 on its own.
    pub dead_time_s: f64,
}

/// The zero moves with the temperature of the sensor: it warms after switching on, and follows the surroundings.
///
/// ```text
/// y → y + b (ΔT (1 - exp(-t/θ)) + T_amb(t) - T_amb(0))
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SensorDrift {
    /// Offset over temperature b, m/K; -1e-3 to 1e-3. Typical: 0.5 % of the stroke per kelvin.
    pub offset_m_per_k: f64,
    /// Own warming ΔT, K; 0 to 60. Typical: 8.
    pub warming_k: f64,
    /// Its time constant θ, s; 1 to 1e6. Typical: a third of the run.
    pub warming_time_s: f64,
}

/// Mains hum on the signal, folded to a low frequency by the sampling.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MainsHum {
    /// Amplitude, m; 0 to 0.1. Typical: 1 % of the stroke.
    pub amplitude_m: f64,
    /// Frequency, Hz; 0.001 to 1,000. Typical: 50.02.
    pub frequency_hz: f64,
    /// Phase, rad; -7 to 7.
    pub phase_rad: f64,
}

/// The converter's steps.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Converter {
    /// Range from code 0 to the last, m; above 0, to 10.
    pub full_scale_m: f64,
    /// Displacement of code 0, m; -10 to 10.
    pub lowest_m: f64,
    /// Bits, 2 to 32. Typical: 12.
    pub bits: u32,
}

impl SensorCubic {
    pub(crate) fn check(&self) -> Result<(), TruthError> {
        within("coefficient", self.coefficient, -0.2..=0.2)
    }

    pub(crate) fn read_m(&self, displacement_m: f64, stroke_m: f64) -> f64 {
        let w = 2.0 * displacement_m / stroke_m - 1.0;
        displacement_m + self.coefficient * (w * w * w - w) * stroke_m
    }
}

impl OutputFilter {
    pub(crate) fn check(&self) -> Result<(), TruthError> {
        within("time_constant_s", self.time_constant_s, 0.0..=100.0)?;
        within("dead_time_s", self.dead_time_s, 0.0..=10.0)
    }
}

impl SensorDrift {
    pub(crate) fn check(&self) -> Result<(), TruthError> {
        within("offset_m_per_k", self.offset_m_per_k, -1e-3..=1e-3)?;
        within("warming_k", self.warming_k, 0.0..=60.0)?;
        within("warming_time_s", self.warming_time_s, 1.0..=1e6)
    }

    pub(crate) fn offset_m(&self, time_s: f64, ambient_rise_k: f64) -> f64 {
        let own_k = -self.warming_k * (-time_s / self.warming_time_s).exp_m1();
        self.offset_m_per_k * (own_k + ambient_rise_k)
    }
}

impl MainsHum {
    pub(crate) fn check(&self) -> Result<(), TruthError> {
        within("amplitude_m", self.amplitude_m, 0.0..=0.1)?;
        within("frequency_hz", self.frequency_hz, 1e-3..=1e3)?;
        within("phase_rad", self.phase_rad, -7.0..=7.0)
    }

    pub(crate) fn at_m(&self, time_s: f64) -> f64 {
        self.amplitude_m * (2.0 * PI * self.frequency_hz * time_s + self.phase_rad).sin()
    }
}

impl Converter {
    pub(crate) fn check(&self) -> Result<(), TruthError> {
        within("full_scale_m", self.full_scale_m, 1e-9..=10.0)?;
        within("lowest_m", self.lowest_m, -10.0..=10.0)?;
        within("bits", f64::from(self.bits), 2.0..=32.0)
    }

    pub(crate) fn read_m(&self, displacement_m: f64) -> f64 {
        let last_code = 2_f64.powf(f64::from(self.bits)) - 1.0;
        let step_m = self.full_scale_m / last_code;
        let code = ((displacement_m - self.lowest_m) / step_m).round();
        self.lowest_m + step_m * code.clamp(0.0, last_code)
    }
}

/// Filter and delay at work: fed with the path between steps, asked at samples.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Electronics {
    filter: OutputFilter,
    input_m: f64,
    filtered_m: f64,
    time_s: f64,
    /// Filtered values with their times, from the last that the delay can ask for.
    line: std::collections::VecDeque<(f64, f64)>,
}

impl Electronics {
    pub(crate) fn at_rest(filter: OutputFilter, displacement_m: f64) -> Self {
        Self {
            filter,
            input_m: displacement_m,
            filtered_m: displacement_m,
            time_s: 0.0,
            line: [(0.0, displacement_m)].into(),
        }
    }

    /// The input goes straight to `input_m` within `length_s`: exact for that.
    pub(crate) fn advance(&mut self, input_m: f64, length_s: f64) {
        let tau_s = self.filter.time_constant_s;
        if tau_s > 0.0 {
            let kept = (-length_s / tau_s).exp();
            let behind_m = (input_m - self.input_m) * tau_s / length_s;
            let start_m = self.filtered_m - (self.input_m - behind_m);
            self.filtered_m = input_m - behind_m + start_m * kept;
        } else {
            self.filtered_m = input_m;
        }
        self.input_m = input_m;
        self.time_s += length_s;
        self.line.push_back((self.time_s, self.filtered_m));
        let asked_s = self.time_s - self.filter.dead_time_s;
        while self.line.len() > 2 && self.line[1].0 <= asked_s {
            self.line.pop_front();
        }
    }

    /// The output now.
    pub(crate) fn output_m(&self) -> f64 {
        let asked_s = self.time_s - self.filter.dead_time_s;
        match (self.line.front(), self.line.get(1)) {
            (Some(&(from_s, from_m)), Some(&(to_s, to_m))) => {
                let s = ((asked_s - from_s) / (to_s - from_s)).clamp(0.0, 1.0);
                from_m + s * (to_m - from_m)
            }
            _ => self.filtered_m,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A ramp of 1 m/s, late by the time constant once that has passed, and by the delay.
    #[test]
    fn a_ramp_comes_late_by_time_constant_and_delay() {
        let filter = OutputFilter {
            time_constant_s: 0.2,
            dead_time_s: 0.35,
        };
        let mut electronics = Electronics::at_rest(filter, 0.0);
        for k in 1..=300 {
            electronics.advance(0.1 * f64::from(k), 0.1);
            let since_s = (0.1 * f64::from(k) - 0.35).max(0.0);
            // y = s - τ (1 - exp(-s/τ)), straight between knots of 0.1 s: curved by 5 per second at most.
            let expected_m = since_s + 0.2 * (-since_s / 0.2).exp_m1();
            assert!(
                (electronics.output_m() - expected_m).abs() < 5.0 * 0.01 / 8.0,
                "{k}"
            );
        }
        assert!((electronics.output_m() - (30.0 - 0.55)).abs() < 1e-9);
    }

    #[test]
    fn the_converter_rounds_and_saturates() {
        let converter = Converter {
            full_scale_m: 3.0,
            lowest_m: -1.0,
            bits: 2,
        };
        for (input_m, code_m) in [
            (-9.0, -1.0),
            (-0.6, -1.0),
            (-0.4, 0.0),
            (1.2, 1.0),
            (9.0, 2.0),
        ] {
            assert!((converter.read_m(input_m) - code_m).abs() < 1e-15);
        }
    }
}
