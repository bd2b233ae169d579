//! The file in which hypotheses are described.

use std::collections::BTreeMap;
use std::ops::Range;
use std::sync::{Mutex, PoisonError};

use serde::Deserialize;
use toml::Spanned;

use super::expression::{self, Expression};
use super::{Hypothesis, MOST_HYPOTHESES, MOST_PARAMETERS, Place, TIME, VARIABLES, vanishing};
use crate::{Belongs, EffectId, EffectInfo, EffectParameter, Need, PhysicsError, Role, Smoothness};

/// Most characters of an id, a name of a parameter or a unit.
const LONGEST_NAME: usize = 40;
/// Most characters of a name or sentence for reports.
const LONGEST_SENTENCE: usize = 300;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    hypothesis: Vec<Spanned<Table>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Table {
    id: Spanned<String>,
    name: Option<Spanned<String>>,
    sentence: Option<Spanned<String>>,
    belongs_to: Option<Spanned<String>>,
    drive: Option<Spanned<String>>,
    heat_flow_w_per_m: Option<Spanned<String>>,
    shift_k: Option<Spanned<String>>,
    displacement: Option<Spanned<String>>,
    parameters: Spanned<BTreeMap<Spanned<String>, Parameter>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Parameter {
    unit: Spanned<String>,
    typical: Spanned<f64>,
    bounds: Spanned<[f64; 2]>,
    #[serde(default = "yes")]
    size: bool,
}

fn yes() -> bool {
    true
}

/// The text of a file, to turn places into lines and columns.
struct Source<'a> {
    file: &'a str,
    text: &'a str,
}

impl Source<'_> {
    /// Line and column, from 1, of a byte.
    fn position(&self, byte: usize) -> (usize, usize) {
        let before = self.text.get(..byte).unwrap_or(self.text);
        let line_start = before.rfind('\n').map_or(0, |newline| newline + 1);
        (
            before.matches('\n').count() + 1,
            before[line_start..].chars().count() + 1,
        )
    }

    fn toml(&self, error: &toml::de::Error) -> PhysicsError {
        let (line, column) = self.position(error.span().map_or(0, |span| span.start));
        PhysicsError::Toml {
            file: self.file.to_owned(),
            line,
            column,
            message: error
                .message()
                .replace('\n', " ")
                .replace("expected f64", "expected a number"),
        }
    }

    /// Error in the entry at a place. `key`: the entry's key, with its value if it has one.
    fn refused(
        &self,
        at: usize,
        key: impl Into<String>,
        accepted: impl Into<String>,
    ) -> PhysicsError {
        let (line, column) = self.position(at);
        PhysicsError::Hypothesis {
            file: self.file.to_owned(),
            line,
            column,
            key: key.into(),
            accepted: accepted.into(),
        }
    }

    /// Place of a byte of a string whose value has that place in the file.
    fn inside(&self, span: &Range<usize>, value: &str, at: usize) -> usize {
        // A string of one line without escapes stands in the file as it is, behind its quotation mark.
        let as_it_is = self.text.get(span.start + 1..span.end.max(1) - 1) == Some(value);
        span.start + if as_it_is { 1 + at } else { 0 }
    }
}

/// `key = "value"`, the value cut short if it is long.
fn quoted(key: &str, value: &str) -> String {
    let mut short: String = value.chars().take(LONGEST_SENTENCE / 5).collect();
    if short.len() < value.len() {
        short.push('…');
    }
    format!("{key} = \"{}\"", short.escape_debug())
}

/// Hypotheses that were read, by their text. An effect's facts live as long as the program, whether they come from the
/// catalogue or from a file; a text that is read a hundred times is kept once.
static KEPT: Mutex<BTreeMap<String, &'static [Hypothesis]>> = Mutex::new(BTreeMap::new());

pub(super) fn parse(file: &str, text: &str) -> Result<&'static [Hypothesis], PhysicsError> {
    let mut kept = KEPT.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some(hypotheses) = kept.get(text) {
        return Ok(hypotheses);
    }
    let hypotheses: &[Hypothesis] = parsed(file, text)?.leak();
    kept.insert(text.to_owned(), hypotheses);
    Ok(hypotheses)
}

fn parsed(file: &str, text: &str) -> Result<Vec<Hypothesis>, PhysicsError> {
    let source = Source { file, text };
    let parsed: File = toml::from_str(text).map_err(|error| source.toml(&error))?;
    if let Some(extra) = parsed.hypothesis.get(MOST_HYPOTHESES) {
        let count = format!("{} hypotheses", parsed.hypothesis.len());
        return Err(source.refused(
            extra.span().start,
            count,
            format!("must be at most {MOST_HYPOTHESES}"),
        ));
    }
    let mut hypotheses: Vec<Hypothesis> = Vec::new();
    for table in &parsed.hypothesis {
        let hypothesis = hypothesis(&source, table)?;
        let id = hypothesis.info.id;
        // Parameters have the id before their names: it must tell them apart, too.
        let names = |one: &Hypothesis| one.info.parameters.iter().map(|known| known.name);
        if hypotheses.iter().any(|before| {
            before.info.id == id
                || names(before).any(|name| names(&hypothesis).any(|own| own == name))
        }) {
            let at = table.get_ref().id.span().start;
            return Err(source.refused(at, quoted("id", id), "must be another than those above"));
        }
        hypotheses.push(hypothesis);
    }
    Ok(hypotheses)
}

fn hypothesis(source: &Source<'_>, table: &Spanned<Table>) -> Result<Hypothesis, PhysicsError> {
    let start = table.span().start;
    let table = table.get_ref();
    let id = checked_id(source, &table.id)?;
    let (place, written) = place_of(source, start, table)?;
    let parameters = parameters_of(source, &id, table)?;
    let (names, parameters): (Vec<&str>, Vec<EffectParameter>) = parameters.into_iter().unzip();

    let mut variables = VARIABLES.to_vec();
    if place != Place::Displacement {
        variables[VARIABLES.len() - 1] = "";
    }
    variables.extend(&names);
    let term = Expression::parse(written.get_ref(), &variables).map_err(|refused| {
        source.refused(
            source.inside(&written.span(), written.get_ref(), refused.at),
            place.key(),
            refused.message,
        )
    })?;
    if let Some(unused) = (0..names.len()).find(|k| !term.uses(VARIABLES.len() + k)) {
        return Err(source.refused(
            written.span().start,
            quoted(place.key(), term.text()),
            format!("must use the parameter {}", names[unused]),
        ));
    }
    if let Some(exception) = vanishing::exception(&term, &parameters) {
        return Err(source.refused(
            written.span().start,
            quoted(place.key(), term.text()),
            format!(
                "is {} {} with all sizes 0: must be 0 there; multiply every term by a size, and keep roots and quotients \
                 defined, as in max(T - Ta, 0)",
                exception.value, exception.state
            ),
        ));
    }
    let has_partner = parameters
        .iter()
        .any(|parameter| parameter.role != Role::Size);
    let name =
        report_text(source, "name", &table.name, &[])?.unwrap_or_else(|| id.replace('-', " "));
    let placeholders: &[&str] = if has_partner {
        &["{value}", "{partner}"]
    } else {
        &["{value}"]
    };
    let sentence = report_text(source, "sentence", &table.sentence, placeholders)?
        .unwrap_or_else(|| format!("{name}, with {{value}}"));
    let uses_temperature = term.uses(0) || term.uses(1);
    let is_thermal = matches!(place, Place::HeatFlow | Place::Shift);
    let info = EffectInfo {
        id: intern(id),
        name: intern(name),
        block: place.block(),
        flexible: false,
        smoothness: Smoothness::Smooth,
        needs: if uses_temperature || is_thermal {
            &[Need::AbsoluteTemperature]
        } else {
            &[]
        },
        parameters: Vec::leak(parameters),
        equation: intern(format!("{} = {}", place.key(), term.text())),
        sentence: intern(sentence),
        belongs_to: belongs_to(source, table, &term)?,
        ..EffectInfo::ORDINARY
    };
    Ok(Hypothesis {
        info: Box::leak(Box::new(info)),
        place,
        term,
    })
}

/// Whose the values are: as written, and otherwise a recording's if the term is of the time in it.
fn belongs_to(
    source: &Source<'_>,
    table: &Table,
    term: &Expression,
) -> Result<Belongs, PhysicsError> {
    let Some(written) = &table.belongs_to else {
        let is_timed = term.uses(TIME);
        return Ok(if is_timed {
            Belongs::Recording
        } else {
            Belongs::Rig
        });
    };
    let text = written.get_ref();
    // Nothing in a term counts cycles: a history it cannot have.
    let all = [Belongs::Rig, Belongs::Recording];
    all.into_iter().find(|one| one.id() == text).ok_or_else(|| {
        source.refused(
            written.span().start,
            quoted("belongs_to", text),
            format!("must be {}", all.map(Belongs::id).join(" or ")),
        )
    })
}

/// Keeps a text for the life of the program: what is known of an effect is static, and a program reads few files.
fn intern(text: String) -> &'static str {
    String::leak(text)
}

fn checked_id(source: &Source<'_>, id: &Spanned<String>) -> Result<String, PhysicsError> {
    let text = id.get_ref();
    let refused = |accepted: &str| source.refused(id.span().start, quoted("id", text), accepted);
    let is_word = |word: &str| {
        !word.is_empty()
            && word
                .bytes()
                .all(|byte| byte.is_ascii_lowercase() || byte.is_ascii_digit())
    };
    let starts_well = text.starts_with(|first: char| first.is_ascii_lowercase());
    if !(starts_well && text.split('-').all(is_word) && text.len() <= LONGEST_NAME) {
        return Err(refused(
            "must be small letters, digits and single hyphens, from a letter, at most 40",
        ));
    }
    if EffectId::parse(text).is_ok() {
        return Err(refused("must not be the id of an effect of the catalogue"));
    }
    Ok(text.clone())
}

fn place_of<'a>(
    source: &Source<'_>,
    start: usize,
    table: &'a Table,
) -> Result<(Place, &'a Spanned<String>), PhysicsError> {
    let given: Vec<(Place, &Spanned<String>)> = Place::ALL
        .into_iter()
        .zip([
            &table.drive,
            &table.heat_flow_w_per_m,
            &table.shift_k,
            &table.displacement,
        ])
        .filter_map(|(place, term)| Some((place, term.as_ref()?)))
        .collect();
    match given[..] {
        [one] => Ok(one),
        _ => {
            let keys: Vec<&str> = given.iter().map(|(place, _)| place.key()).collect();
            let found = if keys.is_empty() {
                "no term".to_owned()
            } else {
                keys.join(" and ")
            };
            let accepted = Place::ALL.map(Place::key).join(", ");
            Err(source.refused(
                given.last().map_or(start, |(_, term)| term.span().start),
                found,
                format!("must be exactly one of {accepted}"),
            ))
        }
    }
}

/// Names in the expression and what is known of each parameter, in the order of the file, sizes first.
fn parameters_of<'a>(
    source: &Source<'_>,
    id: &str,
    table: &'a Table,
) -> Result<Vec<(&'a str, EffectParameter)>, PhysicsError> {
    let start = table.parameters.span().start;
    let mut written: Vec<_> = table.parameters.get_ref().iter().collect();
    written.sort_by_key(|(name, _)| name.span().start);
    if !(1..=MOST_PARAMETERS).contains(&written.len()) {
        let found = format!("{} parameters", written.len());
        return Err(source.refused(start, found, format!("must be 1 to {MOST_PARAMETERS}")));
    }
    let mut parameters = Vec::new();
    for (name, parameter) in written {
        let known = parameter_of(source, id, name, parameter)?;
        parameters.push((name.get_ref().as_str(), known));
    }
    parameters.sort_by_key(|(_, parameter)| parameter.role != Role::Size);
    if parameters
        .iter()
        .all(|(_, parameter)| parameter.role != Role::Size)
    {
        return Err(source.refused(
            start,
            "no size",
            "at least one parameter must have size = true",
        ));
    }
    Ok(parameters)
}

fn parameter_of(
    source: &Source<'_>,
    id: &str,
    name: &Spanned<String>,
    parameter: &Parameter,
) -> Result<EffectParameter, PhysicsError> {
    let text = name.get_ref();
    let is_name = text.starts_with(|first: char| first.is_ascii_alphabetic())
        && text
            .bytes()
            .all(|byte| byte.is_ascii_alphanumeric() || byte == b'_')
        && text.len() <= LONGEST_NAME;
    let is_free = !VARIABLES.contains(&text.as_str()) && !expression::is_taken(text);
    // The name of an effect's parameter is that of a value in files, too.
    let full = format!("{}_{text}", id.replace('-', "_"));
    let in_catalogue = EffectId::ALL
        .iter()
        .flat_map(|effect| effect.info().parameters)
        .any(|known| known.name == full);
    if !(is_name && is_free && !in_catalogue) {
        return Err(source.refused(
            name.span().start,
            format!("parameter '{}'", text.escape_debug()),
            "must be letters, digits and _, from a letter, at most 40, and no variable or function",
        ));
    }
    let unit = parameter.unit.get_ref();
    if unit.is_empty() || unit.chars().count() > LONGEST_NAME || unit.contains(char::is_control) {
        return Err(source.refused(
            parameter.unit.span().start,
            quoted(&format!("{text}.unit"), unit),
            "must be 1 to 40 characters; \"1\" for a pure number",
        ));
    }
    let bounds = *parameter.bounds.get_ref();
    let [lower, upper] = bounds;
    let holds_zero = lower <= 0.0 && upper >= 0.0;
    let accepted = if !(lower < upper && lower.is_finite() && upper.is_finite()) {
        Some("must be two finite numbers, the first smaller")
    } else if parameter.size && !holds_zero {
        Some("must hold 0, which a size is in the baseline; or size = false")
    } else {
        None
    };
    if let Some(accepted) = accepted {
        return Err(source.refused(
            parameter.bounds.span().start,
            format!("{text}.bounds = [{lower}, {upper}]"),
            accepted,
        ));
    }
    let typical = *parameter.typical.get_ref();
    let is_zero = typical.abs() <= 0.0;
    if !(lower..=upper).contains(&typical) || (parameter.size && is_zero) {
        let but = if parameter.size { ", but not 0" } else { "" };
        return Err(source.refused(
            parameter.typical.span().start,
            format!("{text}.typical = {typical}"),
            format!("must be in [{lower}, {upper}]{but}"),
        ));
    }
    let unit = intern(unit.clone());
    let known = if parameter.size {
        EffectParameter::size(unit, typical, bounds)
    } else {
        EffectParameter::partner(unit, typical, bounds, Vec::leak(grid(typical, bounds)))
    };
    Ok(known.named(intern(full)))
}

/// Values of a partner for screening: the typical one and the middles of the quarters of its bounds.
fn grid(typical: f64, [lower, upper]: [f64; 2]) -> Vec<f64> {
    let mut grid = vec![typical];
    grid.extend([0.125, 0.375, 0.625, 0.875].map(|share| lower + share * (upper - lower)));
    grid.sort_by(f64::total_cmp);
    grid
}

/// A text for reports, with no other placeholder than these.
fn report_text(
    source: &Source<'_>,
    key: &str,
    text: &Option<Spanned<String>>,
    placeholders: &[&str],
) -> Result<Option<String>, PhysicsError> {
    let Some(spanned) = text else { return Ok(None) };
    let text = spanned.get_ref();
    let mut rest = text.clone();
    for placeholder in placeholders {
        rest = rest.replace(placeholder, "");
    }
    let is_plain = !rest.contains(|c: char| c == '{' || c == '}' || c.is_control());
    if is_plain && !text.is_empty() && text.chars().count() <= LONGEST_SENTENCE {
        return Ok(Some(text.clone()));
    }
    let but = if placeholders.is_empty() {
        String::new()
    } else {
        format!(" but for {}", placeholders.join(" and "))
    };
    Err(source.refused(
        spanned.span().start,
        quoted(key, text),
        format!("must be one line of at most {LONGEST_SENTENCE} characters, without braces{but}"),
    ))
}
