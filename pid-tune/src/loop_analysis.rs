use wiener::hysteresis::Rule;

use crate::{
    Approach, ChatterOrbit, Margins, Oscillation, PredictedCycle, RodLoop, StartFrom, TuneError,
};

/// Share to which amplitude and frequency must agree for a forecast to be confirmed.
pub const AGREEMENT: f64 = 0.15;

/// Predicted limit cycle for one history of the rod.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Forecast {
    /// Amplitude of the output's first harmonic, or of the sine of equal mean square, in the output's unit.
    pub amplitude: f64,
    /// Frequency, Hz.
    pub frequency_hz: f64,
    /// Method that it rests on.
    pub source: Source,
    /// True if its method calls it reliable: [`PredictedCycle::reliable`] or [`ChatterOrbit::stable`].
    pub reliable: bool,
}

/// Method that a forecast rests on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Source {
    /// Harmonic balance.
    DescribingFunction,
    /// An orbit of the sampled loop.
    Chatter,
}

/// Agreement of a simulation with its forecast.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Agreement {
    /// It rests where rest was foreseen, or cycles with amplitude and frequency to within [`AGREEMENT`].
    Confirmed,
    /// It cycles as foreseen, with another amplitude or frequency.
    Inaccurate,
    /// It cycles where rest was foreseen, or rests where a cycle was.
    Refuted,
}

/// One simulation and what was foreseen for it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Outcome {
    /// Where it started.
    pub start: StartFrom,
    /// The forecast; `None` is rest.
    pub forecast: Option<Forecast>,
    /// The oscillation in the simulation; `None` is rest.
    pub oscillation: Option<Oscillation>,
    /// How they compare.
    pub agreement: Agreement,
}

/// All about the limit cycles of one loop.
#[derive(Debug, Clone, PartialEq)]
pub struct LoopAnalysis {
    /// By harmonic balance.
    pub cycles: Vec<PredictedCycle>,
    /// Of the sampled loop.
    pub orbits: Vec<ChatterOrbit>,
    /// At the worst slope; `None` where no temperature brings the output to the set point.
    pub margins: Option<Margins>,
    /// One for each [`StartFrom`].
    pub outcomes: [Outcome; 3],
}

impl LoopAnalysis {
    /// True if a cycle is foreseen from any start.
    #[must_use]
    pub fn foresees_cycle(&self) -> bool {
        self.outcomes
            .iter()
            .any(|outcome| outcome.forecast.is_some())
    }

    /// True if a simulation cycles from any start.
    #[must_use]
    pub fn cycles_in_simulation(&self) -> bool {
        self.outcomes
            .iter()
            .any(|outcome| outcome.oscillation.is_some())
    }
}

impl RodLoop {
    /// Predicts, looks for orbits, simulates from all starts, and compares.
    ///
    /// The forecast for a start follows a rule that does not look at the simulation, over what was predicted for the
    /// start's [approach](StartFrom::approach) and is at least [`RodLoop::smallest_amplitude`] large. "The cycle" is the
    /// largest stable one of harmonic balance; orbits count that are at least half as long. The first that there is:
    ///
    /// 1. the longest stable orbit, an exact one before others;
    /// 2. if there is a cycle, an exact orbit that is unstable, because the loop wanders about it: the one nearest in
    ///    frequency if the cycle is reliable, else the longest;
    /// 3. the cycle;
    /// 4. rest.
    ///
    /// Orbits come first because they are solutions of the loop as it is. In loops like the paper's a first harmonic is
    /// a third off in amplitude and a fifth in frequency even where its harmonics are few: what the output is depends
    /// steeply on the temperature's swing, and on how sharply it turns.
    ///
    /// # Errors
    ///
    /// Those of [`RodLoop::simulated`].
    pub fn analyzed(&self) -> Result<LoopAnalysis, TuneError> {
        let cycles = self.predicted_cycles();
        let orbits = self.chatter_orbits();
        let outcome = |start: StartFrom| {
            let forecast = self.forecast(start, &cycles, &orbits);
            let oscillation = self.simulated(start)?;
            Ok::<_, TuneError>(Outcome {
                start,
                forecast,
                oscillation,
                agreement: agreement(forecast, oscillation),
            })
        };
        let [rest, hot, near] = StartFrom::ALL;
        let outcomes = [outcome(rest)?, outcome(hot)?, outcome(near)?];
        Ok(LoopAnalysis {
            margins: self.worst_linear().map(|linear| linear.margins()),
            cycles,
            orbits,
            outcomes,
        })
    }

    fn forecast(
        &self,
        start: StartFrom,
        cycles: &[PredictedCycle],
        orbits: &[ChatterOrbit],
    ) -> Option<Forecast> {
        let belongs = |approach: Approach| {
            approach == start.approach() || self.params().rule == Rule::LastReversal
        };
        let largest_cycle = cycles
            .iter()
            .filter(|cycle| {
                belongs(cycle.approach)
                    && cycle.stable
                    && cycle.amplitude >= self.smallest_amplitude()
            })
            .max_by(|a, b| a.amplitude.total_cmp(&b.amplitude));
        let shortest_s = largest_cycle.map_or(0.0, |cycle| 0.5 / cycle.frequency_hz);
        let wanted = |exact: bool, stable: bool| {
            orbits.iter().filter(move |orbit| {
                belongs(orbit.approach)
                    && orbit.exact == exact
                    && orbit.stable == stable
                    && orbit.amplitude >= self.smallest_amplitude()
                    && 1.0 / orbit.frequency_hz >= shortest_s
            })
        };
        let longest =
            |exact, stable| wanted(exact, stable).max_by_key(|orbit| orbit.period_samples);
        let stable_orbit = longest(true, true).or(longest(false, true));
        let Some(cycle) = largest_cycle else {
            return stable_orbit.map(Forecast::of_orbit);
        };
        let unstable_orbit = || {
            let away = |orbit: &&ChatterOrbit| (orbit.frequency_hz - cycle.frequency_hz).abs();
            if cycle.reliable {
                wanted(true, false).min_by(|a, b| away(a).total_cmp(&away(b)))
            } else {
                longest(true, false)
            }
        };
        let orbit = stable_orbit.or_else(unstable_orbit);
        Some(orbit.map_or(Forecast::of_cycle(cycle), Forecast::of_orbit))
    }
}

impl Forecast {
    fn of_cycle(cycle: &PredictedCycle) -> Self {
        Self {
            amplitude: cycle.amplitude,
            frequency_hz: cycle.frequency_hz,
            source: Source::DescribingFunction,
            reliable: cycle.reliable,
        }
    }

    fn of_orbit(orbit: &ChatterOrbit) -> Self {
        Self {
            amplitude: orbit.sine_amplitude,
            frequency_hz: orbit.frequency_hz,
            source: Source::Chatter,
            reliable: orbit.stable,
        }
    }
}

fn agreement(forecast: Option<Forecast>, oscillation: Option<Oscillation>) -> Agreement {
    match (forecast, oscillation) {
        (None, None) => Agreement::Confirmed,
        (Some(forecast), Some(found)) => {
            let near =
                |foreseen: f64, found: f64| (foreseen - found).abs() <= AGREEMENT * found.abs();
            if near(forecast.amplitude, found.sine_amplitude)
                && near(forecast.frequency_hz, found.frequency_hz)
            {
                Agreement::Confirmed
            } else {
                Agreement::Inaccurate
            }
        }
        _ => Agreement::Refuted,
    }
}
