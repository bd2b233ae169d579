use crate::{Reference, RodLoop, TuneError};

/// Time constant over the time in which the inverse wants to be at a new temperature.
const HORIZONS_PER_TAU: f64 = 10.0;
/// Halvings of the range of temperatures.
const HALVINGS: usize = 40;

/// Drive and output of a model that is turned around, a value for each sample.
#[derive(Debug, Clone, PartialEq)]
pub struct InverseRun {
    /// Drive, for [`ClosedLoopParams::feed_forward`](crate::ClosedLoopParams::feed_forward).
    pub drive: Vec<f64>,
    /// Output that it leads to, for [`ClosedLoopParams::aim`](crate::ClosedLoopParams::aim).
    pub output: Vec<f64>,
}

impl RodLoop {
    /// Drive that takes the rod along a reference from rest, by the model alone, and the output on that way, later by the dead
    /// time.
    ///
    /// At every sample the loop is inverted, with the reversals that it remembers: which temperature has the output that
    /// is wanted? The drive is the one that reaches it in a tenth of a time constant `[Sadeghi, eq. 3]`, within the limits:
    ///
    /// ```text
    /// T_∞ = T_a + ((T* - T_a) - (T - T_a) a)/(1 - a),   a = e^(-1/10)
    /// ```
    ///
    /// and T goes on as the heat balance says. What the rod has beyond heat balance and loop the controller makes up
    /// for.
    ///
    /// # Errors
    ///
    /// Those of [`Reference::checked`].
    pub fn inverse_run(
        &self,
        reference: &Reference<'_>,
        n_samples: usize,
    ) -> Result<InverseRun, TuneError> {
        reference.checked()?;
        let params = self.params();
        let hysteresis = self.plant().hysteresis();
        let coldest_degc = params.ambient_degc;
        let hottest_degc = self.balance_degc(self.limits().upper);
        let mut memory = wiener::Plant::rest(self.plant(), coldest_degc)
            .memory()
            .clone();
        let mut temperature_degc = coldest_degc;
        let dt_s = self.dt_s();
        let horizon_s = dt_s.max(self.tau_s() / HORIZONS_PER_TAU);
        let [kept_over_horizon, kept] =
            [horizon_s, dt_s].map(|time_s| libm::exp(-time_s / self.tau_s()));
        let mut run = InverseRun {
            drive: Vec::with_capacity(n_samples),
            output: vec![
                self.output_at(hysteresis.peek(&memory, [coldest_degc]).fraction[0]);
                params.dead_time_samples
            ],
        };
        for k in 0..n_samples {
            let wanted = (reference.at(k, dt_s) - params.rod.offset) / params.rod.gain;
            let [mut below, mut above] = [coldest_degc, hottest_degc];
            for _ in 0..HALVINGS {
                let middle = 0.5 * (below + above);
                if hysteresis.peek(&memory, [middle]).fraction[0] < wanted {
                    below = middle;
                } else {
                    above = middle;
                }
            }
            let goal_degc = 0.5 * (below + above);
            let steady_degc =
                (goal_degc - temperature_degc * kept_over_horizon) / (1.0 - kept_over_horizon);
            let drive = self.holding_drive(steady_degc);
            let balance_degc = self.balance_degc(drive);
            let before_degc = temperature_degc;
            temperature_degc = balance_degc + (temperature_degc - balance_degc) * kept;
            // Shown before the sample's drive acts.
            let [fraction] = hysteresis.peek(&memory, [before_degc]).fraction;
            run.output.push(self.output_at(fraction));
            let _fraction = hysteresis.commit(&mut memory, [temperature_degc]);
            run.drive.push(drive);
        }
        run.output.truncate(n_samples);
        Ok(run)
    }
}
