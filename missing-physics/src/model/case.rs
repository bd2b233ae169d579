//! One rig with its recordings, and models of it with ever other effects.

use identify::{
    Fit, FitConfig, ForwardModel, IdentifyError, LeastSquaresConfig, ParameterInfo, ParameterState,
    ParameterVector, Prior, RefineConfig, Refined, ResidualNoise, WienerModel, refine,
};
use recording::Recording;

use crate::config::Part;
use crate::model::coarse::{SEARCHED, coarse_at};
use crate::model::elsewhere::is_drift;
use crate::model::extended_model::LoopFreedom;
use crate::model::series::{Channel, Layout, Noise};
use crate::watch::{Unwatched, Watch, Watched};
use crate::{
    Candidate, CandidateSet, EffectParameter, ExtendedModel, LoopFamily, Need, Role, Setting,
};

/// Iterations of a refinement that is only to be compared with others.
const ITERATIONS: usize = 8;

/// Iterations of such a refinement for models with one effect, from which all the rest grows, and for models with a drift.
const FIRST_ITERATIONS: usize = 24;

/// Other minima of the baseline that effects are tried at: what a large effect bends may fit best far from the truth.
const OTHER_BASELINES: usize = 2;

/// Iterations after which only the lowest of several starts go on.
const RACE: usize = 4;

/// Relative offset at which a model that is only to be compared with others has come far enough: a ten-thousandth of its square
/// is left to gain.
const NEAR_THE_END: f64 = 2e-2;

/// Logarithm of a likelihood, if each sample were told by itself, that is left to gain where a refinement has its end: a twelfth of what
/// another model may lack to do as well.
const LEFT_NATS: f64 = 0.25;

/// Logarithm of a likelihood, if each sample were told by itself, that an iteration must gain; two in a row that gain less end a search.
/// As many as ten times so much moves no belief.
const LEAST_NATS: f64 = 0.005;

/// Iterations until a refinement has its end.
const TO_THE_END: usize = 60;

/// A fitted baseline and what it was fitted to.
#[derive(Debug)]
pub(crate) struct Case<'a> {
    pub(crate) base: &'a WienerModel,
    pub(crate) fit: &'a Fit,
    pub(crate) training: &'a [Recording],
    pub(crate) setting: Setting,
    pub(crate) layout: Layout,
    freedom: LoopFreedom,
    recorded: Vec<f64>,
    watch: &'a dyn Watch,
}

/// A model of the case, refined.
#[derive(Debug, Clone)]
pub(crate) struct Node {
    pub(crate) effects: CandidateSet,
    pub(crate) model: ExtendedModel,
    /// Coordinates of the model's parameters.
    pub(crate) coordinates: Vec<f64>,
    /// Values of all parameters in each recording.
    pub(crate) points: Vec<Vec<f64>>,
    /// Recorded - model.
    pub(crate) residual: Vec<f64>,
    /// Noise model of the residual, for each channel.
    pub(crate) noise: Noise,
    /// Simulations that it took.
    pub(crate) simulations: u64,
}

impl<'a> Case<'a> {
    pub(crate) fn new(
        base: &'a WienerModel,
        fit: &'a Fit,
        training: &'a [Recording],
        setting: Setting,
    ) -> Self {
        // Both channels count alike where the baseline stands.
        let layout = Layout::of(training, fit.output_per_k().unwrap_or(0.0));
        let drives = training.iter().map(Recording::largest_drive);
        let largest = drives.fold(0.0, f64::max);
        Self {
            recorded: layout.recorded(training),
            base,
            fit,
            training,
            setting: Setting {
                // Of parts of a case it is that of the whole.
                largest_drive: setting.largest_drive.or((largest > 0.0).then_some(largest)),
                ..setting
            },
            layout,
            freedom: LoopFreedom::Formula,
            watch: &Unwatched,
        }
    }

    /// This case with other samples of its recordings.
    pub(crate) fn on<'b>(&self, training: &'b [Recording]) -> Case<'b>
    where
        'a: 'b,
    {
        let layout = Layout::of(training, self.layout.per_k);
        Case {
            recorded: layout.recorded(training),
            training,
            layout,
            ..*self
        }
    }

    /// A node of this case with other samples, where it stands.
    pub(crate) fn stands(&self, node: &Node) -> Result<Node, IdentifyError> {
        let (coordinates, points) = (node.coordinates.clone(), node.points.clone());
        self.node(node.model.clone(), coordinates, points, 0)
    }

    /// This case with all samples of its recordings; `None` if it has them.
    pub(crate) fn whole<'b>(&self, recordings: &'b [Recording]) -> Option<Case<'b>>
    where
        'a: 'b,
    {
        self.is_thinned(recordings).then(|| self.on(recordings))
    }

    /// True if it has fewer samples than its recordings.
    pub(crate) fn is_thinned(&self, recordings: &[Recording]) -> bool {
        let mut pairs = self.training.iter().zip(recordings);
        pairs.any(|(few, all)| few.len() < all.len())
    }

    /// This case with its searches watched.
    pub(crate) fn watched_by(self, watch: &'a dyn Watch) -> Self {
        Self { watch, ..self }
    }

    /// This case with as much free of its loops as a model has.
    pub(crate) fn with_freedom_of(self, model: &ExtendedModel) -> Self {
        Self {
            freedom: model.loop_freedom(),
            ..self
        }
    }

    /// True if a part of the search is to be left out.
    pub(crate) fn leaves_out(&self, part: Part) -> bool {
        self.watch.leaves_out(part)
    }

    /// A model of the case, its simulations watched.
    pub(crate) fn watched<'m>(&'m self, model: &'m ExtendedModel) -> Watched<'m> {
        Watched {
            model,
            watch: self.watch,
        }
    }

    /// Recorded series, in the order of the layout.
    pub(crate) fn recorded(&self) -> &[f64] {
        &self.recorded
    }

    /// Case of this rig with a loop of another family; `base` is the baseline model and `fit` its fit with that loop,
    /// of which so much is free.
    pub(crate) fn of_family<'b>(
        &self,
        loop_family: LoopFamily,
        base: &'b WienerModel,
        fit: &'b Fit,
        freedom: LoopFreedom,
    ) -> Case<'b>
    where
        'a: 'b,
    {
        let setting = Setting {
            loop_family,
            ..self.setting
        };
        Case {
            base,
            fit,
            setting,
            freedom,
            // Temperatures on one scale: models of all families are compared.
            layout: self.layout.clone(),
            recorded: self.recorded.clone(),
            ..*self
        }
    }

    /// Squares of the recorded outputs about the mean of each recording.
    pub(crate) fn output_squares(&self) -> f64 {
        self.recorded_squares(Channel::Output)
    }

    /// Standard deviation of the recorded outputs, each about the mean of its recording.
    pub(crate) fn output_deviation(&self) -> f64 {
        (self.output_squares() / self.layout.n_outputs() as f64).sqrt()
    }

    /// Squares of what a channel recorded about the mean of each recording.
    pub(crate) fn recorded_squares(&self, channel: Channel) -> f64 {
        let squares = self.layout.of_channel(channel).map(|one| {
            let own = &self.recorded[one.range.clone()];
            let mean = own.iter().sum::<f64>() / own.len() as f64;
            own.iter().map(|y| (y - mean).powi(2)).sum::<f64>()
        });
        squares.sum()
    }

    /// The model with these effects.
    pub(crate) fn model(&self, effects: CandidateSet) -> ExtendedModel {
        ExtendedModel::new(self.base, self.fit, self.setting, effects)
            .with_loop_freedom(self.freedom)
    }

    /// The fitted baseline as a node.
    pub(crate) fn baseline(&self) -> Result<Node, IdentifyError> {
        self.plain_at(self.fit.points())
    }

    /// The baseline at its other minima.
    pub(crate) fn other_baselines(&self) -> Result<Vec<Node>, IdentifyError> {
        let minima = self.fit.other_minima.iter().take(OTHER_BASELINES);
        minima.map(|points| self.plain_at(points.clone())).collect()
    }

    /// The baseline with these values of all parameters in each recording.
    fn plain_at(&self, points: Vec<Vec<f64>>) -> Result<Node, IdentifyError> {
        let model = self.model(CandidateSet::EMPTY);
        let vector = ParameterVector::new(model.parameters(), self.training.len());
        let coordinates = vector.coordinates(|parameter, r| Some(points[r][parameter]));
        self.node(model, coordinates, points, 0)
    }

    /// Refines the model with these effects from each of the starts, near a node.
    pub(crate) fn refined(
        &self,
        near: &Node,
        effects: CandidateSet,
        starts: &[Vec<f64>],
    ) -> Result<Node, IdentifyError> {
        let model = self.model(effects);
        // A drift's knots follow another effect slowly.
        let iterations = if near.effects.is_empty() || effects.iter().any(is_drift) {
            FIRST_ITERATIONS
        } else {
            ITERATIONS
        };
        let refined = self.searched(near, &model, starts, iterations)?;
        self.node(
            model,
            refined.coordinates,
            refined.points,
            refined.simulations,
        )
    }

    /// A node at the end of its search, which so far was short.
    pub(crate) fn finished(&self, node: &Node) -> Result<Node, IdentifyError> {
        let starts = std::slice::from_ref(&node.coordinates);
        let refined = self.searched(node, &node.model, starts, TO_THE_END)?;
        self.node(
            node.model.clone(),
            refined.coordinates,
            refined.points,
            node.simulations + refined.simulations,
        )
    }

    /// A node at its end, sought on means of its samples first.
    ///
    /// They are means of what the node leaves, so that both have nearly one end: all samples are needed for the last of the way.
    pub(crate) fn finished_by_means(&self, node: &Node) -> Result<Node, IdentifyError> {
        let at = (&node.points[..], self.fit.tau_s());
        let few = coarse_at(SEARCHED, &node.model, at, self.training)?;
        let means = self.on(&few);
        if !means.is_thinned(self.training) {
            return self.finished(node);
        }
        self.finished(&means.finished(node)?)
    }

    /// A node where a fit of its model ended.
    pub(crate) fn fitted(&self, node: &Node, fit: &Fit) -> Result<Node, IdentifyError> {
        let vector = ParameterVector::new(node.model.parameters(), self.training.len());
        let simulations = node.simulations + fit.simulations;
        self.node(
            node.model.clone(),
            fit.coordinates(&vector),
            fit.points(),
            simulations,
        )
    }

    /// The end of a short search of a node's model.
    pub(crate) fn approached(
        &self,
        node: &Node,
        start: &[f64],
        iterations: usize,
    ) -> Result<Refined, IdentifyError> {
        self.searched(node, &node.model, &[start.to_vec()], iterations)
    }

    /// Deviance of a node, as [`Refined::deviance`] has it.
    pub(crate) fn deviance(&self, node: &Node) -> f64 {
        let scale = match node.noise.temperature.n_samples {
            0 => 0.0,
            n => 2.0 * n as f64 * self.layout.per_k.ln(),
        };
        node.noise.deviance() - scale
    }

    fn searched(
        &self,
        near: &Node,
        model: &ExtendedModel,
        starts: &[Vec<f64>],
        iterations: usize,
    ) -> Result<Refined, IdentifyError> {
        refine(
            &self.watched(model),
            self.training,
            starts,
            &self.config(near, iterations),
        )
    }

    /// Settings of fits of its models from a node, which end as refinements do.
    pub(crate) fn fit_config_at(&self, node: &Node, seed: u64) -> FitConfig {
        FitConfig {
            temperature_weight: self.temperature_weight(node),
            ..self.fit_config(&node.noise.output, seed)
        }
    }

    /// Settings of fits of its models near a residual, which end as refinements do.
    pub(crate) fn fit_config(&self, near: &ResidualNoise, seed: u64) -> FitConfig {
        FitConfig {
            seed,
            prior: prior(self.base, near.n_effective),
            least_squares: LeastSquaresConfig {
                least_gain: self.least_gain(near),
                ..LeastSquaresConfig::default()
            },
            ..FitConfig::default()
        }
    }

    /// Share of a sum of squares near a residual that cannot change a verdict: of as many samples as what is to be expected counts
    /// against, else of all.
    fn least_gain(&self, near: &ResidualNoise) -> f64 {
        let n = match prior(self.base, near.n_effective) {
            Prior::Profiled(n) => n,
            _ => self.layout.n_outputs() as f64,
        };
        2.0 * LEAST_NATS / n
    }

    /// Both channels count as well as they are met by a node from which the search goes out.
    fn config(&self, near: &Node, iterations: usize) -> RefineConfig {
        RefineConfig {
            least_squares: LeastSquaresConfig {
                iterations,
                relative_offset: if iterations < TO_THE_END {
                    NEAR_THE_END
                } else {
                    (2.0 * LEFT_NATS / self.layout.len() as f64)
                        .sqrt()
                        .min(NEAR_THE_END)
                },
                least_gain: self.least_gain(&near.noise.output),
            },
            race_iterations: RACE,
            weights: None,
            prior: prior(self.base, near.noise.n_effective()),
            temperature_weight: self.temperature_weight(near).unwrap_or(0.0),
        }
    }

    /// Weight by which recorded temperatures count as well as a node meets them, (output unit/K)²; `None` if none are recorded.
    pub(crate) fn temperature_weight(&self, node: &Node) -> Option<f64> {
        let Noise {
            output,
            temperature,
        } = &node.noise;
        let ratio = output.variance / temperature.variance;
        (temperature.variance > 0.0).then(|| self.layout.per_k.powi(2) * ratio)
    }

    pub(crate) fn node(
        &self,
        model: ExtendedModel,
        coordinates: Vec<f64>,
        points: Vec<Vec<f64>>,
        simulations: u64,
    ) -> Result<Node, IdentifyError> {
        let shown = self
            .layout
            .shown(&model, self.training, |r| vec![points[r].clone()])?;
        let residual: Vec<f64> = self
            .recorded
            .iter()
            .zip(&shown[0])
            .map(|(recorded, shown)| recorded - shown)
            .collect();
        Ok(Node {
            effects: model.active(),
            noise: self.layout.noise(&residual),
            model,
            coordinates,
            points,
            residual,
            simulations: simulations + 1,
        })
    }

    /// Sum of squared residuals of a model at points of each recording, each about its own mean in each recording.
    pub(crate) fn residuals(
        &self,
        model: &ExtendedModel,
        points: impl Fn(usize) -> Vec<Vec<f64>>,
    ) -> Result<Vec<f64>, IdentifyError> {
        let shown = self.layout.shown(model, self.training, points)?;
        Ok(shown
            .iter()
            .map(|shown| {
                let sums = self.layout.segments.iter().map(|segment| {
                    let pairs = self.recorded[segment.range.clone()]
                        .iter()
                        .zip(&shown[segment.range.clone()]);
                    let (mut sum, mut squares) = (0.0, 0.0);
                    for (recorded, shown) in pairs {
                        sum += recorded - shown;
                        squares += (recorded - shown).powi(2);
                    }
                    let mean = sum / segment.range.len() as f64;
                    match segment.channel {
                        Channel::Output => squares - sum * mean,
                        Channel::Temperature => squares,
                    }
                });
                sums.sum()
            })
            .collect())
    }

    /// Coordinates in the model with other effects, from where a node stands: what it has stays, what is new is
    /// at `value(effect, number of the parameter)`, or where the baseline has it.
    pub(crate) fn moved(
        &self,
        node: &Node,
        to: &ExtendedModel,
        value: impl Fn(Candidate, usize) -> Option<f64>,
    ) -> Vec<f64> {
        let vector = ParameterVector::new(to.parameters(), self.training.len());
        vector.coordinates(|parameter, r| {
            if parameter < to.n_plain() {
                return Some(node.points[r][parameter]);
            }
            let (effect, index) = to.slot(parameter)?;
            value(effect, index).or_else(|| match node.model.first_parameter(effect) {
                Some(first) => Some(node.points[r][first + index]),
                None => Some(effect.info().parameters[index].neutral()),
            })
        })
    }

    fn has_thermometer(&self) -> bool {
        let mut thermometers = self.layout.of_channel(Channel::Temperature);
        thermometers.next().is_some()
    }

    /// The partner of an effect that screening varies, and the values to try.
    pub(crate) fn screened_partner(&self, effect: Candidate) -> Option<(usize, &'static [f64])> {
        let info = effect.info();
        let told =
            |&(k, _): &(usize, _)| self.has_thermometer() || !info.parameters[k].needs_thermometer;
        info.screened_partner().filter(told)
    }

    /// First need of an effect that is not met; `None` if all of its needs are met.
    pub(crate) fn missing(&self, effect: Candidate) -> Option<Need> {
        let setting = &self.setting;
        let electrical = !matches!(self.base.drive(), wiener::Drive::Power { .. });
        effect.info().needs.iter().copied().find(|need| match need {
            Need::MassPerMeter => setting.mass_kg_per_m.is_none(),
            Need::SurfacePerMeter => setting.surface_m2_per_m.is_none(),
            Need::LargestDrive => setting.largest_drive.is_none(),
            Need::ElectricalDrive => !electrical,
            Need::TemperatureChannel => !self.has_thermometer(),
            // Each recording has its length, and without a load the loop shifts all the same.
            Need::RunLength | Need::Load => false,
            Need::AbsoluteTemperature => !self.base.knows_temperature(),
        })
    }
}

/// How what is ordinary from run to run counts, where what differs is left open: beside as many samples as are effective in a
/// residual. Where it is not, no parameter has a prior.
pub(crate) fn prior(base: &WienerModel, n_effective: f64) -> Prior {
    let mut infos = base.parameters().iter();
    let has_ordinary =
        infos.any(|info| info.ordinary.is_some() && info.state == ParameterState::Free);
    if has_ordinary {
        Prior::Profiled(n_effective.max(1.0))
    } else {
        Prior::Nothing
    }
}

impl Node {
    /// Mean square of the output's residual.
    pub(crate) fn mean_square(&self) -> f64 {
        self.noise.output.variance
    }

    /// Free parameters: coordinates and an offset a recording, but for partners on a bound, which adjust nothing.
    pub(crate) fn n_free(&self) -> usize {
        let is_idle = |&(parameter, info): &(usize, &ParameterInfo)| {
            let is_partner = self.model.slot(parameter).is_some_and(|(effect, k)| {
                matches!(effect.info().parameters[k].role, Role::Partner { .. })
            });
            let ends = [info.bounds.lower, info.bounds.upper];
            is_partner
                && info.state == ParameterState::Free
                && ends.contains(&self.points[0][parameter])
        };
        let idle = self
            .model
            .parameters()
            .iter()
            .enumerate()
            .filter(is_idle)
            .count();
        self.coordinates.len() + self.points.len() - idle
    }

    /// Values of an effect's parameters, if it is active.
    pub(crate) fn values(&self, effect: Candidate) -> Option<&[f64]> {
        let first = self.model.first_parameter(effect)?;
        Some(&self.points[0][first..first + effect.info().parameters.len()])
    }

    /// True if a parameter of an effect is pressed against a bound: the recordings pull it beyond what is physical. A
    /// bound that is an end of the possible values does not count.
    pub(crate) fn is_pressed(&self, effect: Candidate) -> bool {
        let values = self.values(effect).unwrap_or(&[]);
        let mut parameters = effect.info().parameters.iter().zip(values);
        parameters.any(|(parameter, &value)| is_beyond(parameter, value))
    }

    /// True if a size of an effect is too small for the effect's name.
    pub(crate) fn is_slight(&self, effect: Candidate) -> bool {
        let values = self.values(effect).unwrap_or(&[]);
        let mut parameters = effect.info().parameters.iter().zip(values);
        parameters.any(|(parameter, value)| value.abs() < parameter.least)
    }

    /// True if an effect of the model is pressed against a bound.
    pub(crate) fn is_held(&self) -> bool {
        self.effects.iter().any(|effect| self.is_pressed(effect))
    }

    /// True if all sizes of an effect are nearly zero in every recording: the effect is there by name only.
    pub(crate) fn has_vanished(&self, effect: Candidate) -> bool {
        let Some(first) = self.model.first_parameter(effect) else {
            return true;
        };
        let parameters = effect.info().parameters.iter().enumerate();
        let mut sizes = parameters.filter(|(_, parameter)| parameter.role == Role::Size);
        sizes.all(|(k, parameter)| {
            let least = 1e-4 * parameter.typical;
            let mut values = self.points.iter().map(|point| point[first + k]);
            values.all(|value| value.abs() < least)
        })
    }
}

/// True if the value of an effect's parameter stands against a bound that is no end of what can be.
pub(crate) fn is_beyond(parameter: &EffectParameter, value: f64) -> bool {
    /// Distance from a bound, as a share of the range.
    const NEAR: f64 = 1e-3;
    let [lower, upper] = parameter.bounds;
    let margin = NEAR * (upper - lower);
    // Nothing is nowhere less: without a size there is no effect, and a play has no softness.
    let at_lower = value <= lower + margin && lower != 0.0;
    let at_upper = value >= upper - margin && !parameter.upper_is_physical;
    at_lower || at_upper
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::synthetic::Synthetic;
    use crate::{EffectId, EffectSet, EffectValues, LoopFamily};

    #[test]
    fn a_bound_counts_where_it_is_no_end_of_what_can_be() {
        let parameters = |effect: EffectId| Candidate::from(effect).info().parameters;
        // A bow may be of either sign; of a backlash 0 is none.
        let bow = &parameters(EffectId::SensorNonlinearity)[0];
        let [lower, upper] = bow.bounds;
        assert!(is_beyond(bow, lower) && is_beyond(bow, upper));
        assert!(!is_beyond(bow, 0.5 * upper) && !is_beyond(bow, 0.0));
        let play = &parameters(EffectId::Backlash)[0];
        assert!(!is_beyond(play, 0.0) && is_beyond(play, play.bounds[1]));
        // A stop cannot hold back more than all of the movement.
        let stop = &parameters(EffectId::EndStop)[0];
        assert!(!is_beyond(stop, stop.bounds[1]));
    }

    #[test]
    fn as_much_of_a_loop_is_free_with_another_effect_as_without() {
        let effects = EffectValues::default();
        let synthetic = Synthetic::with_loop(LoopFamily::Relays, EffectSet::EMPTY, effects, 1);
        let plain = synthetic.case();
        let setting = Setting {
            loop_family: LoopFamily::Relays,
            ..plain.setting
        };
        let model = ExtendedModel::new(plain.base, plain.fit, setting, CandidateSet::EMPTY);
        let free = |model: &ExtendedModel| {
            let of_loop = model.parameters()[..model.n_plain()].iter();
            let free = of_loop.filter(|info| info.state == ParameterState::Free);
            free.map(|info| info.name).collect::<Vec<_>>()
        };
        assert!(free(&model).contains(&"loop_bend_1"));
        let case = Case::new(plain.base, plain.fit, plain.training, setting);
        let backlash = CandidateSet::EMPTY.with(EffectId::Backlash);
        assert!(!free(&case.model(backlash)).contains(&"loop_bend_1"));
        let case = case.with_freedom_of(&model);
        assert_eq!(free(&case.model(backlash)), free(&model));
    }
}
