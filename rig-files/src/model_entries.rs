//! Checks of what stands in a model file beyond its layout.

use std::ops::{Range, RangeInclusive};

use toml::Spanned;
use wiener::hysteresis::LoopFamily;

use identify::dense::{Matrix, symmetric_eigen};
use identify::{
    AMBIENT_LEVEL, Bounds, Enters, FittedParameter, ForwardModel, LOOP_SHAPE, ParameterCovariance,
    ParameterInfo, ParameterState, RUN_PARAMETERS, RigModel, SINCE_REVERSAL, SavedEffects, Scope,
    is_of_family,
};

use crate::RigFileError;
use crate::model_file::{IntegrationTable, ParameterTable, SCHEMA_VERSION, State};
use crate::source::Source;

/// A file that is read.
pub(crate) struct Reading<'a> {
    pub(crate) source: &'a Source<'a>,
}

impl Reading<'_> {
    fn fault(
        &self,
        place: Range<usize>,
        what: String,
        accepted: impl Into<String>,
    ) -> RigFileError {
        let (line, column) = self.source.position(place.start);
        RigFileError::Saved {
            file: self.source.file.to_owned(),
            line,
            column,
            what,
            accepted: accepted.into(),
        }
    }

    pub(crate) fn version(&self, version: &Spanned<i64>) -> Result<(), RigFileError> {
        if *version.get_ref() == SCHEMA_VERSION {
            return Ok(());
        }
        let what = format!("schema_version = {}", version.get_ref());
        Err(self.fault(version.span(), what, "must be 1"))
    }

    /// Parameters of the effects, in their order; `of_effect` gives those of one effect.
    pub(crate) fn parameters_of_effects(
        &self,
        effects: &[Spanned<String>],
        of_effect: &dyn Fn(&str) -> Result<Vec<ParameterInfo>, String>,
    ) -> Result<Vec<ParameterInfo>, RigFileError> {
        let mut infos = Vec::new();
        for (k, effect) in effects.iter().enumerate() {
            let id = effect.get_ref();
            let known = if effects[..k].iter().any(|one| one.get_ref() == id) {
                Err("must be there once".to_owned())
            } else {
                of_effect(id)
            };
            infos.extend(known.map_err(|accepted| {
                self.fault(effect.span(), format!("effects: \"{id}\""), accepted)
            })?);
        }
        Ok(infos)
    }

    /// Curves of the loop: those of another family are for who knows the effect that they are, as `of_effect` tells.
    pub(crate) fn loop_family(
        &self,
        id: Option<&Spanned<String>>,
        of_effect: &dyn Fn(&str) -> Result<Vec<ParameterInfo>, String>,
    ) -> Result<LoopFamily, RigFileError> {
        let Some(id) = id else {
            return Ok(LoopFamily::Proximity);
        };
        let what = || format!("loop_family = \"{}\"", id.get_ref());
        let Some(family) = LoopFamily::parse(id.get_ref()) else {
            let known = LoopFamily::ALL.map(LoopFamily::id).join(", ");
            return Err(self.fault(id.span(), what(), format!("must be one of {known}")));
        };
        if family == LoopFamily::Proximity {
            return Ok(family);
        }
        of_effect(LOOP_SHAPE)
            .map(|_| family)
            .map_err(|accepted| self.fault(id.span(), what(), accepted))
    }

    pub(crate) fn effects(
        &self,
        ids: Vec<Spanned<String>>,
        loop_family: LoopFamily,
        integration: &Spanned<IntegrationTable>,
    ) -> Result<Option<SavedEffects>, RigFileError> {
        if ids.is_empty() && loop_family == LoopFamily::Proximity {
            return Ok(None);
        }
        let &IntegrationTable {
            substeps,
            newton_iterations: Some(newton_iterations),
            ..
        } = integration.get_ref()
        else {
            let accepted = "must have newton_iterations, since the model has effects";
            return Err(self.fault(integration.span(), "integration".to_owned(), accepted));
        };
        Ok(Some(SavedEffects {
            ids: ids.into_iter().map(Spanned::into_inner).collect(),
            loop_family,
            sub_steps: substeps,
            newton_iterations,
        }))
    }

    /// Puts what the entries say into the model; returns its parameters, and those of the loop's family and of the effects
    /// behind them.
    pub(crate) fn parameters(
        &self,
        entries: &[Spanned<ParameterTable>],
        (trained, output_unit): (&[&str], &str),
        model: &mut RigModel,
        extra: Vec<ParameterInfo>,
    ) -> Result<Vec<FittedParameter>, RigFileError> {
        let mut infos = model.parameters().to_vec();
        let n_plain = infos.len();
        infos.extend(extra);
        for entry in entries {
            self.parameter(entry, &mut infos, n_plain, (trained, output_unit))?;
        }
        for (plain, info) in model.parameters_mut().iter_mut().zip(&infos) {
            // Beside effects a gain was searched; that of the baseline part can be solved for.
            *plain = ParameterInfo {
                enters: plain.enters,
                ..info.clone()
            };
        }
        infos
            .iter()
            .map(|info| self.fitted(info, entries, trained))
            .collect()
    }

    /// Puts what an entry says of a parameter's unit, bounds and state into what is known of it; the first
    /// `n_plain` parameters are those of the baseline part.
    fn parameter(
        &self,
        entry: &Spanned<ParameterTable>,
        infos: &mut [ParameterInfo],
        n_plain: usize,
        (trained, output_unit): (&[&str], &str),
    ) -> Result<(), RigFileError> {
        let table = entry.get_ref();
        let fault = |accepted: String| {
            let what = format!("parameter {} = {}", table.name, table.value);
            Err(self.fault(entry.span(), what, accepted))
        };
        let known: Vec<&str> = infos.iter().map(|info| info.name).collect();
        let Some(k) = known.iter().position(|&name| name == table.name) else {
            return fault(format!(
                "no such parameter; this model has {}",
                known.join(", ")
            ));
        };
        let info = &mut infos[k];
        // Those of the baseline part depend on recordings.
        if k >= n_plain && info.unit != table.unit {
            return fault(format!("unit must be \"{}\"", info.unit));
        }
        let Bounds { lower, upper } = info.admissible;
        if !(lower..=upper).contains(&table.value) {
            return fault(format!(
                "must lie from {lower:e} to {upper:e} {}",
                table.unit
            ));
        }
        if table.unit == "°C" && !RODS_DEGC.contains(&table.value) {
            return fault("no temperature of a rod: must lie from -273.15 to 3000 °C".to_owned());
        }
        if OF_OUTPUT.contains(&info.name) && table.unit != output_unit {
            return fault(format!(
                "unit must be \"{output_unit}\", that of the output"
            ));
        }
        let within = |[lower, upper]: [f64; 2]| (lower..=upper).contains(&table.value);
        let is_free = matches!(table.state, State::Free);
        if is_free && !table.bounds.is_none_or(within) {
            return fault("must lie within its bounds".to_owned());
        }
        let rises = |[lower, upper]: [f64; 2]| lower <= upper;
        if !table.ci95.is_none_or(rises) || !table.bounds.is_none_or(rises) {
            return fault("ci95 and bounds must rise".to_owned());
        }
        match (info.scope, &table.recording) {
            (Scope::Shared, None) => {}
            (Scope::PerRecording, Some(name)) if trained.contains(&name.as_str()) => {}
            (Scope::Shared, Some(_)) => {
                return fault("is shared: must not name a recording".to_owned());
            }
            (Scope::PerRecording, _) => {
                return fault(format!("must name its recording: {}", trained.join(" or ")));
            }
        }
        info.unit.clone_from(&table.unit);
        info.bounds = match table.bounds {
            Some([lower, upper]) => {
                // Who has bounds was searched.
                info.enters = Enters::Nonlinear;
                Bounds { lower, upper }
            }
            None if info.enters == Enters::Nonlinear => {
                return fault("must have bounds = [low, high]".to_owned());
            }
            None => Bounds::NONE,
        };
        info.state = match table.state {
            State::Free => ParameterState::Free,
            State::Fixed => ParameterState::Fixed(table.value),
        };
        Ok(())
    }

    /// The values of a parameter, one a training recording if it is not shared.
    fn fitted(
        &self,
        info: &ParameterInfo,
        entries: &[Spanned<ParameterTable>],
        trained: &[&str],
    ) -> Result<FittedParameter, RigFileError> {
        let own: Vec<Option<&str>> = match info.scope {
            Scope::Shared => vec![None],
            Scope::PerRecording => trained.iter().copied().map(Some).collect(),
        };
        let mut fitted = FittedParameter {
            info: info.clone(),
            values: Vec::new(),
            intervals: Vec::new(),
            at_bound: false,
        };
        for recording in own {
            let mut found = entries.iter().filter(|entry| {
                let table = entry.get_ref();
                table.name == info.name && table.recording.as_deref() == recording
            });
            let entry = found.next();
            // Files of earlier versions do not have it.
            let is_new = [AMBIENT_LEVEL, SINCE_REVERSAL].contains(&info.name)
                || is_of_family(info.name)
                || RUN_PARAMETERS.contains(&info.name);
            if entry.is_none() && is_new {
                fitted.values.push(0.0);
                fitted.intervals.push(None);
                continue;
            }
            let (Some(entry), None) = (entry, found.next()) else {
                let of = recording.map_or(String::new(), |name| format!(" of {name}"));
                let what = format!("parameter {}{of}", info.name);
                return Err(self.fault(0..0, what, "must be there once"));
            };
            let table = entry.get_ref();
            fitted.values.push(table.value);
            let interval = table.ci95.map(|[lower, upper]| Bounds { lower, upper });
            fitted.intervals.push(interval);
            fitted.at_bound |= table.at_bound;
        }
        Ok(fitted)
    }

    pub(crate) fn covariance(
        &self,
        covariance: Spanned<ParameterCovariance>,
    ) -> Result<ParameterCovariance, RigFileError> {
        let place = covariance.span();
        let covariance = covariance.into_inner();
        let n = covariance.names.len();
        let is_square = covariance.scales.len() == n
            && covariance.matrix.len() == n
            && covariance.matrix.iter().all(|row| row.len() == n);
        let what = format!("covariance of {n} names");
        if !is_square {
            let accepted = "must have as many scales, rows and columns";
            return Err(self.fault(place, what, accepted));
        }
        if is_covariance(&covariance.matrix) {
            return Ok(covariance);
        }
        let accepted = "must be symmetric, of finite numbers, and positive semidefinite: no variance is below 0, no correlation beyond 1";
        Err(self.fault(place, what, accepted))
    }
}

/// Temperatures that a rod may have, °C: from absolute zero to far above its melting.
const RODS_DEGC: RangeInclusive<f64> = -273.15..=3000.0;

/// Parameters in the unit of the output.
const OF_OUTPUT: [&str; 2] = ["gain", "offset"];

/// Least eigenvalue of a matrix of correlations that counts as 0: what rounding leaves.
const ROUNDING: f64 = 1e-6;

/// True if a square matrix may be one of variances and covariances.
fn is_covariance(rows: &[Vec<f64>]) -> bool {
    let n = rows.len();
    let scale = |i: usize, k: usize| (rows[i][i] * rows[k][k]).sqrt();
    for i in 0..n {
        for k in 0..n {
            let value = rows[i][k];
            // Of a parameter that the data do not fix the variance is infinite.
            let is_open = i == k && value.is_infinite();
            if !(value.is_finite() || is_open) || rows[i][i] < 0.0 {
                return false;
            }
            let asymmetry = (value - rows[k][i]).abs();
            if asymmetry > ROUNDING * scale(i, k) {
                return false;
            }
        }
    }
    let correlations = Matrix::from_fn(n, n, |i, k| {
        let scale = scale(i, k);
        match (i == k, scale > 0.0) {
            (true, _) => 1.0,
            // 0 beside an infinite variance.
            (false, true) => rows[i][k] / scale,
            // Beside a variance of 0 there is no covariance.
            (false, false) => rows[i][k],
        }
    });
    symmetric_eigen(&correlations)
        .is_some_and(|eigen| eigen.values.iter().all(|value| *value >= -ROUNDING))
}
