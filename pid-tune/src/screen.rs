use crate::complex::Complex;
use crate::error::{not_negative, positive};
use crate::open_loop::controller_parts;
use crate::swept::Swept;
use crate::{
    Answers, GainSchedule, Margins, OpenLoop, Passage, PidGains, PidParams, PlantResponse,
    TuneError,
};

/// Of the frequencies of a plant's response a search looks at every so many.
const THINNED: usize = 3;

/// Requirements that gains must meet before their response counts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Requirements {
    /// Smallest gain margin; ≥ 1.
    pub gain_margin: f64,
    /// Smallest phase margin, rad; ≥ 0.
    pub phase_margin_rad: f64,
    /// By how much what is measured jumps while nothing moves: the converter's step, or the noise from sample to sample,
    /// in the output's unit; 0 for an ideal sensor.
    pub sensor_step: f64,
    /// Largest share of the drive's range by which one such jump may move the drive; > 0.
    pub largest_kick: f64,
}

/// Looks at gains before they are simulated: at margins wherever a plant is steepest, and at how far a jump of the sensor
/// moves the drive.
#[derive(Debug, Clone)]
pub struct Screen {
    requirements: Requirements,
    controller: PidParams,
    plants: Vec<PlantResponse>,
    /// For each plant the factor that the gains have there, at most; 1 without a schedule.
    factors: Vec<f64>,
    /// The largest factor that the gains have anywhere.
    largest_factor: f64,
    /// For each plant its frequencies, rad/s.
    frequencies: Vec<Vec<f64>>,
    /// For each plant: P, and P times integral and derivative at gains of 1.
    parts: Vec<[Swept; 3]>,
}

impl Screen {
    /// For a controller, and answers of the plant to small changes at the controller's sample time. Nothing is known of where
    /// they are: a gain schedule counts with its largest factor.
    ///
    /// # Errors
    ///
    /// [`TuneError::NotPositive`] and [`TuneError::Negative`] for a requirement.
    pub fn new(
        requirements: Requirements,
        controller: PidParams,
        plants: Vec<PlantResponse>,
    ) -> Result<Self, TuneError> {
        positive("gain_margin", requirements.gain_margin)?;
        not_negative("gain_margin - 1", requirements.gain_margin - 1.0)?;
        not_negative("phase_margin_rad", requirements.phase_margin_rad)?;
        not_negative("sensor_step", requirements.sensor_step)?;
        positive("largest_kick", requirements.largest_kick)?;
        let thinned = |plant: &PlantResponse| {
            let swept: Vec<(f64, Complex)> = plant.swept().collect();
            // From the back: half of the sampling frequency is the last one.
            let mut kept: Vec<_> = swept.into_iter().rev().step_by(THINNED).collect();
            kept.reverse();
            kept
        };
        let swept: Vec<_> = plants.iter().map(thinned).collect();
        let schedule = controller.gain_schedule.as_ref();
        let largest_factor = schedule.map_or(1.0, GainSchedule::largest);
        let of_plant = |swept: &Vec<(f64, Complex)>| {
            let of_controller = |&(omega, plant): &(f64, Complex)| {
                let [integral, derivative] = controller_parts(&controller, omega);
                [plant, plant * integral, plant * derivative]
            };
            let parts: Vec<[Complex; 3]> = swept.iter().map(of_controller).collect();
            [0, 1, 2].map(|part| parts.iter().map(|parts| parts[part]).collect())
        };
        Ok(Self {
            requirements,
            controller,
            frequencies: swept
                .iter()
                .map(|swept| swept.iter().map(|&(omega, _)| omega).collect())
                .collect(),
            parts: swept.iter().map(of_plant).collect(),
            factors: vec![largest_factor; plants.len()],
            largest_factor,
            plants,
        })
    }

    /// For a controller with a gain schedule: at every output and branch where the plant answers, with the largest factor that
    /// the schedule has at that output, whatever branch the controller takes it for.
    ///
    /// # Errors
    ///
    /// As [`Screen::new`].
    pub fn everywhere(
        requirements: Requirements,
        controller: PidParams,
        answers: &Answers,
    ) -> Result<Self, TuneError> {
        let all = answers.heating.iter().chain(&answers.cooling);
        let rising: Vec<_> = all.filter(|answer| answer.plant.gain() > 0.0).collect();
        let plants = rising.iter().map(|answer| answer.plant.clone()).collect();
        let mut screen = Self::new(requirements, controller, plants)?;
        if let Some(schedule) = &controller.gain_schedule {
            let factors = rising
                .iter()
                .map(|answer| schedule.largest_at(answer.output));
            screen.factors = factors.collect();
        }
        Ok(screen)
    }

    /// The requirements.
    #[must_use]
    pub fn requirements(&self) -> &Requirements {
        &self.requirements
    }

    /// Answers of the plant to small changes.
    #[must_use]
    pub fn plants(&self) -> &[PlantResponse] {
        &self.plants
    }

    /// Share of the drive's range by which one jump of the sensor moves the drive at once; with a schedule, where its factor is
    /// largest.
    #[must_use]
    pub fn kick(&self, gains: &PidGains) -> f64 {
        let PidParams {
            dt_s,
            limits,
            derivative_filter_s,
            ..
        } = self.controller;
        let new = 1.0 - libm::exp(-dt_s / derivative_filter_s);
        let per_step = gains.kp + gains.ki * dt_s + gains.kd * new / dt_s;
        self.largest_factor * per_step * self.requirements.sensor_step
            / (limits.upper - limits.lower)
    }

    /// The largest gains that move the drive little enough, each by itself; ∞ for an ideal sensor.
    #[must_use]
    pub fn largest_gains(&self) -> PidGains {
        let of = |gains: PidGains| self.requirements.largest_kick / self.kick(&gains);
        let none = PidGains {
            kp: 0.0,
            ki: 0.0,
            kd: 0.0,
        };
        PidGains {
            kp: of(PidGains { kp: 1.0, ..none }),
            ki: of(PidGains { ki: 1.0, ..none }),
            kd: of(PidGains { kd: 1.0, ..none }),
        }
    }

    /// The least margins that gains have anywhere, and the highest peak of sensitivity; `None` without plants.
    #[must_use]
    pub fn margins(&self, gains: &PidGains) -> Option<Margins> {
        self.loops(gains)
            .map(|open| open.margins())
            .reduce(|a, b| a.worse(&b))
    }

    /// The most that noise is amplified anywhere, and the bandwidth where it is least; `None` without plants.
    #[must_use]
    pub fn passage(&self, gains: &PidGains) -> Option<Passage> {
        self.loops(gains)
            .map(|open| open.passage())
            .reduce(|a, b| Passage {
                noise_gain: a.noise_gain.max(b.noise_gain),
                bandwidth_hz: a.bandwidth_hz.min(b.bandwidth_hz),
            })
    }

    /// The loop around each plant, with the factor that its gains have there.
    pub fn loops(&self, gains: &PidGains) -> impl Iterator<Item = OpenLoop<'_>> {
        let around = self.plants.iter().zip(&self.factors);
        around.map(|(plant, &factor)| {
            let (controller, gains) = self.controller.frozen(gains, factor);
            OpenLoop {
                controller,
                gains,
                plant,
            }
        })
    }

    /// By how much gains miss what is required, each part in its own proportion; 0 where they meet it all.
    #[must_use]
    pub fn shortfall(&self, gains: &PidGains) -> f64 {
        let required = &self.requirements;
        let over = |value: f64| if value > 1.0 { value.ln() } else { 0.0 };
        let mut shortfall = over(self.kick(gains) / required.largest_kick);
        let plants = self.frequencies.iter().zip(&self.parts);
        for ((omegas, parts), &factor) in plants.zip(&self.factors) {
            let (_, gains) = self.controller.frozen(gains, factor);
            let margins = Margins::between(omegas, &Swept::sum_up(parts, &gains));
            shortfall += over(required.gain_margin / margins.gain_margin);
            let lag = required.phase_margin_rad - margins.phase_margin_rad;
            shortfall += lag.max(0.0);
            shortfall += if margins.stable { 0.0 } else { 1.0 };
        }
        shortfall
    }
}
