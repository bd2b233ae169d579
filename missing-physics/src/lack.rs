//! What a model leaves that is more than noise, whatever its shape.

use identify::IdentifyError;

use crate::case::Node;
use crate::local_terms::{local_terms, slow_terms};
use crate::projection::{Span, dot};
use crate::search::Search;
use crate::whiten::Whitener;

/// What is left of a residual along local and slow terms of any shape.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Lack {
    /// Whitened sum of squares beyond that of noise.
    pub(crate) beyond: f64,
    /// Probability that noise leaves as much.
    pub(crate) p_value: f64,
}

/// Probability under noise alone, below which there is a lack of fit.
pub(crate) const LACK_OF_FIT: f64 = 0.01;

/// The same where nothing else speaks for it.
pub(crate) const BEYOND_DOUBT_P: f64 = 1e-6;

/// Share of a lack that comes back without an effect from which that takes it away.
const MOST: f64 = 2.0 / 3.0;

impl Lack {
    /// Whether a model that leaves this mends what one with an effect less leaves: all or most of it.
    pub(crate) fn is_mended(&self, without: &Self) -> bool {
        let takes_most = without.beyond - self.beyond > MOST * without.beyond;
        without.p_value < BEYOND_DOUBT_P && (self.p_value > LACK_OF_FIT || takes_most)
    }
}

/// How much of a node's residual lies along terms of any shape in the blocks of the cascade.
pub(crate) fn lack(search: &Search<'_>, node: &Node) -> Result<Lack, IdentifyError> {
    let case = search.case;
    let sensitivities = search.sensitivities(node)?;
    let whitener = Whitener::new(&case.layout, &node.noise);
    let white = |column: &Vec<f64>| whitener.whiten(column);
    let fitted: Vec<Vec<f64>> = sensitivities.iter().map(|one| white(&one.column)).collect();
    let mut span = Span::of(&fitted);
    let residual = span.outside(&white(&node.residual));
    let own = span.dimension();
    let terms = local_terms(case, node, &sensitivities)?;
    for column in terms
        .iter()
        .map(|term| &term.column)
        .chain(&slow_terms(case))
    {
        span.widen(&white(column));
    }
    let added = &span.basis()[own..];
    let along: f64 = added.iter().map(|one| dot(one, &residual).powi(2)).sum();
    let degrees = added.len() as f64;
    // What noise leaves in 95 % of cases is no lack.
    let usual = degrees + 1.645 * (2.0 * degrees).sqrt();
    Ok(Lack {
        beyond: (along - usual).max(0.0),
        p_value: chi_squared_tail(along, degrees),
    })
}

/// Probability of a χ² above a value (Wilson and Hilferty's cube root).
fn chi_squared_tail(value: f64, degrees: f64) -> f64 {
    if degrees <= 0.0 {
        return 1.0;
    }
    let spread = 2.0 / (9.0 * degrees);
    let normal = ((value / degrees).cbrt() - (1.0 - spread)) / spread.sqrt();
    0.5 * libm::erfc(normal / std::f64::consts::SQRT_2)
}
