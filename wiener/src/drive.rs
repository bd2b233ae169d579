use crate::WienerError;

/// How the drive heats the rod: what the drive's number means.
///
/// Power per meter of rod, with the resistance per meter R and the length l:
///
/// ```text
/// current  i² R      duty  V² D/(R l²)      voltage  V²/(R l²)      power  P/l
/// ```
///
/// A resistance that changes with the phase therefore acts with opposite sign on a current and on a
/// duty or voltage drive.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Drive {
    /// Current, A.
    Current,
    /// Duty of a pulse-width modulated supply, 0 to 1, switched much faster than the rod warms.
    Duty {
        /// Supply voltage V, V; > 0.
        supply_v: f64,
        /// Length of rod between the contacts l, m; > 0.
        length_m: f64,
    },
    /// Voltage, V.
    Voltage {
        /// Length of rod between the contacts l, m; > 0.
        length_m: f64,
    },
    /// Electrical power, W.
    Power {
        /// Length of rod between the contacts l, m; > 0.
        length_m: f64,
    },
}

impl Drive {
    /// Checks supply and length.
    ///
    /// # Errors
    ///
    /// [`WienerError::NotPositive`] unless finite and > 0.
    pub fn checked(self) -> Result<Self, WienerError> {
        let positive = |name, value: f64, unit| {
            if value > 0.0 && value.is_finite() {
                Ok(())
            } else {
                Err(WienerError::NotPositive { name, value, unit })
            }
        };
        match self {
            Drive::Current => {}
            Drive::Duty { supply_v, length_m } => {
                positive("supply_v", supply_v, "V")?;
                positive("length_m", length_m, "m")?;
            }
            Drive::Voltage { length_m } | Drive::Power { length_m } => {
                positive("length_m", length_m, "m")?;
            }
        }
        Ok(self)
    }

    /// Heating power, W/m, from the drive in its own unit and the resistance per meter, Ω/m.
    ///
    /// The sign of a current or voltage does not matter. A negative duty or power would cool the rod:
    /// keep it out at the edge, as `recording` does.
    #[inline(always)]
    #[must_use]
    pub fn power_w_per_m<const L: usize>(
        self,
        drive: [f64; L],
        resistance_ohm_per_m: [f64; L],
    ) -> [f64; L] {
        // The choice stands outside the lanes' loop, which then is one vector instruction after another.
        match self {
            Drive::Current => lanes(|l| drive[l] * drive[l] * resistance_ohm_per_m[l]),
            Drive::Duty { supply_v, length_m } => lanes(|l| {
                supply_v * supply_v * drive[l] / (resistance_ohm_per_m[l] * length_m * length_m)
            }),
            Drive::Voltage { length_m } => {
                lanes(|l| drive[l] * drive[l] / (resistance_ohm_per_m[l] * length_m * length_m))
            }
            Drive::Power { length_m } => lanes(|l| drive[l] / length_m),
        }
    }
}

#[inline(always)]
fn lanes<const L: usize>(value: impl Fn(usize) -> f64) -> [f64; L] {
    let mut values = [0.0; L];
    for l in 0..L {
        values[l] = value(l);
    }
    values
}
