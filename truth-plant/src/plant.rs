use crate::error::{TruthError, within};
use crate::lumped::LumpedLoop;
use crate::simulate::{Course, run, run_lumped};
use crate::{
    AmbientDrift, AmbientSensor, BiasSpring, ConvectionDip, Converter, Draughts, DriveKind,
    EndFittings, EndStop, Fatigue, FreeConvection, Friction, LatentHeat, LoopAsymmetry, LoopFamily,
    MainsHum, MountSlip, Noise, OutputFilter, PhaseResistivity, RPhase, Radiation, Rod, SecondRod,
    SensorCubic, SensorDrift, SpringChange, StressCoupling, Supply, ThermalExpansion, Thermocouple,
    Traces,
};

/// An actuator: a rod heated by its own resistance, its loop, and whatever else is set.
///
/// The default is the plain plant: one temperature, constant coefficients, limiting-loop proximity, a displacement
/// in proportion to the fraction. Each further piece of physics is a field that is `None` in it.
///
/// ```text
/// m C_p dT/dt = i² R - h A (T - T_amb),     ξ = loop(T),     y = y_0 + S ξ
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct TruthPlant {
    /// Quantity of the drive.
    pub drive: DriveKind,
    /// The wire.
    pub rod: Rod,
    /// Convective coefficient h, W/(m² K); 0.1 to 1e4.
    pub convective_coefficient_w_per_m2_k: f64,
    /// Temperature of the surroundings at the start, and of the rod, °C; -40 to 80.
    pub ambient_degc: f64,
    /// The loop.
    pub hysteresis: LoopFamily,
    /// Stroke from all martensite to all austenite S, m; 1e-6 to 1.
    pub stroke_m: f64,
    /// Displacement of martensite y_0, m; -1 to 1.
    pub offset_m: f64,
    /// Largest error of a step of the integration, K; 1e-11 to 0.01.
    pub tolerance_k: f64,
    /// Longest step of the integration, s; above 1e-6. A step never spans more than a sample.
    pub longest_step_s: f64,

    /// Supply that is not ideal.
    pub supply: Option<Supply>,
    /// Resistance that changes with the phase.
    pub phase_resistivity: Option<PhaseResistivity>,
    /// A second rod in parallel.
    pub second_rod: Option<SecondRod>,

    /// Free convection.
    pub free_convection: Option<FreeConvection>,
    /// Radiation.
    pub radiation: Option<Radiation>,
    /// Convection that falls over a range of temperatures.
    pub convection_dip: Option<ConvectionDip>,
    /// Gusts.
    pub draughts: Option<Draughts>,
    /// Surroundings that become warmer or colder.
    pub ambient_drift: Option<AmbientDrift>,
    /// Heat conduction into the fittings.
    pub end_fittings: Option<EndFittings>,

    /// Heat of transformation.
    pub latent_heat: Option<LatentHeat>,
    /// Branches of different spreads.
    pub loop_asymmetry: Option<LoopAsymmetry>,
    /// R-phase.
    pub r_phase: Option<RPhase>,
    /// Functional fatigue.
    pub fatigue: Option<Fatigue>,
    /// Temperatures of transformation that rise with stress. Needs a spring or a stop.
    pub stress_coupling: Option<StressCoupling>,

    /// Bias spring.
    pub bias_spring: Option<BiasSpring>,
    /// A spring that changes in the run. Needs a spring.
    pub spring_change: Option<SpringChange>,
    /// Stop.
    pub end_stop: Option<EndStop>,
    /// Mount that slips. Needs a spring.
    pub mount_slip: Option<MountSlip>,
    /// Thermal expansion.
    pub thermal_expansion: Option<ThermalExpansion>,
    /// Friction.
    pub friction: Option<Friction>,

    /// Bent scale of the displacement's sensor.
    pub sensor_cubic: Option<SensorCubic>,
    /// Its filter and delay.
    pub output_filter: Option<OutputFilter>,
    /// Its moving zero.
    pub sensor_drift: Option<SensorDrift>,
    /// Hum on its signal.
    pub mains_hum: Option<MainsHum>,
    /// Noise on it; its deviation in m.
    pub displacement_noise: Option<Noise>,
    /// Steps of its converter.
    pub converter: Option<Converter>,
    /// Bead that reads the rod's temperature.
    pub thermocouple: Option<Thermocouple>,
    /// Noise on the recorded temperature; its deviation in K.
    pub temperature_noise: Option<Noise>,
    /// Sensor of the ambient temperature.
    pub ambient_sensor: Option<AmbientSensor>,
}

impl Default for TruthPlant {
    fn default() -> Self {
        Self {
            drive: DriveKind::Current,
            rod: Rod::default(),
            convective_coefficient_w_per_m2_k: 60.0,
            ambient_degc: 22.0,
            hysteresis: LoopFamily::default(),
            stroke_m: 5e-3,
            offset_m: 0.0,
            tolerance_k: 1e-7,
            longest_step_s: f64::INFINITY,
            supply: None,
            phase_resistivity: None,
            second_rod: None,
            free_convection: None,
            radiation: None,
            convection_dip: None,
            draughts: None,
            ambient_drift: None,
            end_fittings: None,
            latent_heat: None,
            loop_asymmetry: None,
            r_phase: None,
            fatigue: None,
            stress_coupling: None,
            bias_spring: None,
            spring_change: None,
            end_stop: None,
            mount_slip: None,
            thermal_expansion: None,
            friction: None,
            sensor_cubic: None,
            output_filter: None,
            sensor_drift: None,
            mains_hum: None,
            displacement_noise: None,
            converter: None,
            thermocouple: None,
            temperature_noise: None,
            ambient_sensor: None,
        }
    }
}

impl TruthPlant {
    /// Time constant of the plain rod, s.
    #[must_use]
    pub fn time_constant_s(&self) -> f64 {
        self.rod.heat_capacity_j_per_m_k()
            / (self.convective_coefficient_w_per_m2_k * self.rod.perimeter_m())
    }

    /// A run from rest at ambient temperature.
    ///
    /// Sample k holds the drive from t_k to t_(k+1) = t_k + `dt_s`; every trace is read at t_k, before it. The drive
    /// is in the unit of its kind, `dt_s` from 1e-4 to 1,000. All that is random comes from `seed`.
    ///
    /// # Errors
    ///
    /// [`TruthError`] naming the value that cannot be, and what can; or that the integration diverged.
    pub fn simulate(&self, drive: &[f64], dt_s: f64, seed: u64) -> Result<Traces, TruthError> {
        self.controlled(drive.len(), dt_s, seed, &mut |k, _| drive[k])
    }

    /// Simulates a run under a controller. At every sample the controller is asked for the drive, with the number of the
    /// sample, from 0, and the displacement that the sensor shows there, mm, noise and steps included.
    ///
    /// # Errors
    ///
    /// As [`TruthPlant::simulate`].
    pub fn controlled(
        &self,
        n_samples: usize,
        dt_s: f64,
        seed: u64,
        controller: &mut dyn FnMut(usize, f64) -> f64,
    ) -> Result<Traces, TruthError> {
        self.check()?;
        within("dt_s", dt_s, 1e-4..=1e3)?;
        if n_samples == 0 {
            return Err(TruthError::EmptyDrive);
        }
        let course = Course {
            n_samples,
            dt_s,
            seed,
        };
        let family = match self.loop_asymmetry {
            Some(asymmetry) => self
                .hysteresis
                .with_spread_ratio(asymmetry.cooling_over_heating_spread),
            None => self.hysteresis,
        };
        match family {
            LoopFamily::L2p(loops) => run(self, &loops.operator()?, course, controller),
            LoopFamily::Preisach(loops) => run(self, &loops.operator()?, course, controller),
            LoopFamily::Cosine(loops) => run(self, &loops.operator()?, course, controller),
            LoopFamily::Relays(loops) => {
                run_lumped(self, LumpedLoop::Relays(loops), course, controller)
            }
            LoopFamily::Tanaka(loops) => {
                run_lumped(self, LumpedLoop::Tanaka(loops), course, controller)
            }
        }
    }

    /// Checks that the plant can be simulated.
    ///
    /// # Errors
    ///
    /// [`TruthError`] naming the value that cannot be, and what can.
    pub fn check(&self) -> Result<(), TruthError> {
        self.drive.check()?;
        self.rod.check()?;
        within(
            "convective_coefficient_w_per_m2_k",
            self.convective_coefficient_w_per_m2_k,
            0.1..=1e4,
        )?;
        within("ambient_degc", self.ambient_degc, -40.0..=80.0)?;
        self.hysteresis.check()?;
        within("stroke_m", self.stroke_m, 1e-6..=1.0)?;
        within("offset_m", self.offset_m, -1.0..=1.0)?;
        within("tolerance_k", self.tolerance_k, 1e-11..=0.01)?;
        within("longest_step_s", self.longest_step_s, 1e-6..=f64::INFINITY)?;
        self.check_needs()?;
        self.check_heat()?;
        self.check_mechanics()?;
        self.check_sensors()
    }

    fn check_needs(&self) -> Result<(), TruthError> {
        let spring = self.bias_spring.is_some();
        let needs = [
            (
                self.stress_coupling.is_some() && !spring && self.end_stop.is_none(),
                "stress_coupling",
                "bias_spring or end_stop",
            ),
            (
                self.spring_change.is_some() && !spring,
                "spring_change",
                "bias_spring",
            ),
            (
                self.mount_slip.is_some() && !spring,
                "mount_slip",
                "bias_spring",
            ),
        ];
        match needs.into_iter().find(|need| need.0) {
            Some((_, addition, needs)) => Err(TruthError::Needs { addition, needs }),
            None => Ok(()),
        }
    }

    fn check_heat(&self) -> Result<(), TruthError> {
        self.supply.map_or(Ok(()), |part| part.check())?;
        self.phase_resistivity.map_or(Ok(()), |part| part.check())?;
        self.second_rod.map_or(Ok(()), |part| part.check())?;
        self.free_convection.map_or(Ok(()), |part| part.check())?;
        self.radiation.map_or(Ok(()), |part| part.check())?;
        self.convection_dip.map_or(Ok(()), |part| part.check())?;
        self.draughts.map_or(Ok(()), |part| part.check())?;
        self.ambient_drift.map_or(Ok(()), |part| part.check())?;
        self.end_fittings.map_or(Ok(()), |part| part.check())?;
        self.latent_heat.map_or(Ok(()), |part| part.check())
    }

    fn check_mechanics(&self) -> Result<(), TruthError> {
        self.loop_asymmetry.map_or(Ok(()), |part| part.check())?;
        self.r_phase.map_or(Ok(()), |part| part.check())?;
        self.fatigue.map_or(Ok(()), |part| part.check())?;
        self.stress_coupling.map_or(Ok(()), |part| part.check())?;
        self.bias_spring.map_or(Ok(()), |part| part.check())?;
        self.spring_change.map_or(Ok(()), |part| part.check())?;
        self.end_stop.map_or(Ok(()), |part| part.check())?;
        self.mount_slip.map_or(Ok(()), |part| part.check())?;
        self.thermal_expansion.map_or(Ok(()), |part| part.check())?;
        self.friction.map_or(Ok(()), |part| part.check())
    }

    fn check_sensors(&self) -> Result<(), TruthError> {
        self.sensor_cubic.map_or(Ok(()), |part| part.check())?;
        self.output_filter.map_or(Ok(()), |part| part.check())?;
        self.sensor_drift.map_or(Ok(()), |part| part.check())?;
        self.mains_hum.map_or(Ok(()), |part| part.check())?;
        self.displacement_noise
            .map_or(Ok(()), |part| part.check())?;
        self.converter.map_or(Ok(()), |part| part.check())?;
        self.thermocouple.map_or(Ok(()), |part| part.check())?;
        self.temperature_noise.map_or(Ok(()), |part| part.check())?;
        self.ambient_sensor.map_or(Ok(()), |part| part.check())
    }
}
