//! Two rods that pull against one another.

use recording::Recording;
use wiener::Block;
use wiener::hysteresis::Rule;

use crate::wiener_model::{
    CENTER, GAIN, HALF_WIDTH, More, OFFSET, SPREAD, START_RISE, START_SHARE, START_SINCE_REVERSAL,
    STARTS, TAU, WienerModel, start_rise, start_share,
};
use crate::{Bounds, Fit, ForwardModel, IdentifyError, ParameterInfo, ParameterState, Rod, Scale};

/// A pair of rods of one alloy, each with its own drive, that pull one output to opposite sides.
///
/// ```text
/// y = g (x₁ - s x₂) + offset,   x_j the displacement of rod j over its stroke   [Sadeghi, eqs 1-12]
/// ```
///
/// g is the stroke of the first rod and s that of its antagonist over it. Each has its own time constant and loop; the shape of the
/// branches ζ, and steady rise or heat capacity and resistance, they share. The effect of one on the load of the other shows
/// as a difference of their loops, and is not modeled beyond it. Temperatures that are shown are those of the first.
#[derive(Debug, Clone)]
pub struct AntagonistModel {
    /// The first rod; its parameters are those of both.
    first: WienerModel,
}

/// Names of what the antagonist has of its own, and where the same of the first rod stands in a point.
const OWN: [(&str, usize); 4] = [
    ("antagonist_tau_s", TAU),
    ("antagonist_center_degc", CENTER),
    ("antagonist_half_width_k", HALF_WIDTH),
    ("antagonist_spread_k", SPREAD),
];

/// Name of the antagonist's stroke over that of the first rod.
const STROKE: &str = "antagonist_stroke";

/// Strokes over that of the first rod among which is searched.
const STROKES: Bounds = Bounds {
    lower: 0.05,
    upper: 20.0,
};

/// Parameters that the antagonist adds: its own, its stroke, and its start.
const ADDED: usize = OWN.len() + 1 + 2;

/// Parameters that the antagonist adds to those of the first rod.
const MORE: More<'static> = &|first| {
    let mut more: Vec<ParameterInfo> = OWN
        .iter()
        .map(|&(name, place)| ParameterInfo {
            name,
            ..first[place].clone()
        })
        .collect();
    more.push(ParameterInfo::searched(
        STROKE,
        "1",
        Scale::Logarithmic,
        STROKES,
    ));
    let [_, start] = STARTS;
    more.extend([start_rise(start[0]), start_share(start[1])]);
    more
};

impl AntagonistModel {
    /// True if the recordings of a rig have the drive of an antagonist, judged by the first of them.
    #[must_use]
    pub fn is_for(training: &[Recording]) -> bool {
        let first = training.first();
        first.is_some_and(|recording| recording.antagonist_drive().is_some())
    }

    /// The model of a rig, with bounds wide enough for the given training recordings.
    ///
    /// # Errors
    ///
    /// As [`WienerModel::new`].
    pub fn new(rod: &Rod, rule: Rule, training: &[Recording]) -> Result<Self, IdentifyError> {
        Ok(Self {
            first: WienerModel::with_more(rod, rule, training, MORE)?,
        })
    }

    /// The model before anything is known of recordings; see `WienerModel::template`.
    pub(crate) fn template(
        rod: &Rod,
        rule: Rule,
        rise_is_assumed: bool,
        reference: Option<&str>,
    ) -> Result<Self, IdentifyError> {
        let first = WienerModel::template(rod, rule, rise_is_assumed, MORE)?;
        Ok(Self {
            first: first.with_reference(reference),
        })
    }

    pub(crate) fn parameters_mut(&mut self) -> &mut [ParameterInfo] {
        self.first.parameters_mut()
    }

    /// See [`WienerModel::with_open_starts`]; that of the antagonist is left open with that of the first rod.
    #[must_use]
    pub fn with_open_starts(&self, training: &[Recording]) -> Self {
        let mut first = self.first.with_open_starts(training);
        let parameters = first.parameters();
        let at_rest = |place: usize| matches!(parameters[place].state, ParameterState::Fixed(_));
        if !(at_rest(START_RISE) && at_rest(START_SHARE)) {
            let n = parameters.len();
            first.leave_open(n - 2);
            first.leave_open(n - 1);
        }
        Self { first }
    }

    /// See [`WienerModel::carry_specific_heat`]; both rods have it.
    pub(crate) fn carry_specific_heat(&self, fit: &mut Fit) -> bool {
        self.first.carry_specific_heat(fit)
    }

    /// True if temperatures are in kelvins; see [`WienerModel::knows_temperature`].
    #[must_use]
    pub fn knows_temperature(&self) -> bool {
        self.first.knows_temperature()
    }

    /// Where what the antagonist adds begins in a point.
    fn added(&self) -> usize {
        self.first.parameters().len() - ADDED
    }

    /// The antagonist as a first rod, with its whole stroke as 1.
    fn antagonist(&self, point: &[f64]) -> Vec<f64> {
        let mut antagonist = point.to_vec();
        let added = &point[self.added()..];
        for ((_, place), value) in OWN.iter().zip(added) {
            antagonist[*place] = *value;
        }
        antagonist[START_RISE] = added[OWN.len() + 1];
        antagonist[START_SHARE] = added[OWN.len() + 2];
        antagonist[START_SINCE_REVERSAL] = 0.0;
        whole_stroke(&mut antagonist);
        antagonist
    }
}

/// Lets a point have a gain of 1 and no offset.
fn whole_stroke(point: &mut [f64]) {
    (point[GAIN], point[OFFSET]) = (1.0, 0.0);
}

impl ForwardModel for AntagonistModel {
    fn parameters(&self) -> &[ParameterInfo] {
        self.first.parameters()
    }

    /// Holds the displacement of the antagonist at all points, 8 bytes a sample and point, while the first rod is simulated.
    fn simulate(
        &self,
        points: &[Vec<f64>],
        recording: &Recording,
        visit: &mut dyn FnMut(Block<'_>),
    ) -> Result<(), IdentifyError> {
        let drive = recording
            .antagonist_drive()
            .ok_or_else(|| IdentifyError::NoAntagonist {
                recording: recording.name().to_owned(),
            })?;
        let antagonists: Vec<Vec<f64>> = points.iter().map(|one| self.antagonist(one)).collect();
        let mut pulled = Vec::new();
        let mut keep = |block: Block<'_>| pulled.extend_from_slice(block.displacement);
        self.first
            .simulate_driven(&antagonists, recording, drive, &mut keep)?;
        let mut firsts = points.to_vec();
        firsts.iter_mut().for_each(|point| whole_stroke(point));
        let stroke = self.added() + OWN.len();
        let (mut shown, mut before) = (Vec::new(), 0);
        // The same members over the same samples come in the same blocks.
        let mut show = |block: Block<'_>| {
            shown.clear();
            shown.extend_from_slice(block.displacement);
            let pulled = &pulled[before..before + shown.len()];
            before += shown.len();
            let rows = shown.chunks_exact_mut(block.stride);
            for (row, pulled) in rows.zip(pulled.chunks_exact(block.stride)) {
                let points = &points[block.first_member..][..block.members];
                for ((x, pulled), point) in row.iter_mut().zip(pulled).zip(points) {
                    *x = point[GAIN] * (*x - point[stroke] * pulled) + point[OFFSET];
                }
            }
            visit(Block {
                displacement: &shown,
                ..block
            });
        };
        self.first
            .simulate_driven(&firsts, recording, recording.drive(), &mut show)
    }

    fn branches_degc(&self, point: &[f64]) -> Option<[f64; 2]> {
        self.first.branches_degc(point)
    }
}
