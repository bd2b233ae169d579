//! Errors of models on the recordings that were not used, each computed once.

use identify::IdentifyError;
use recording::Recording;

use crate::CandidateSet;
use crate::model::case::{Case, Node};
use crate::model::unseen::{Unseen, unseen};

/// The recordings that were not used, and what models of a case leave of them.
#[derive(Debug)]
pub(crate) struct Errors<'a> {
    pub(crate) recordings: &'a [Recording],
    case: &'a Case<'a>,
    known: Vec<Known>,
}

/// Error of a model with some effects at a point.
#[derive(Debug)]
struct Known {
    effects: CandidateSet,
    point: Vec<f64>,
    error: Unseen,
}

impl<'a> Errors<'a> {
    pub(crate) fn on(recordings: &'a [Recording], case: &'a Case<'a>) -> Self {
        Self {
            recordings,
            case,
            known: Vec::new(),
        }
    }

    /// The error of a model where it stands.
    pub(crate) fn of(&mut self, node: &Node) -> Result<&Unseen, IdentifyError> {
        let point = &node.points[0];
        let is_it = |one: &Known| one.effects == node.effects && one.point == *point;
        let weight = self.case.temperature_weight(node).unwrap_or(0.0);
        let place = match self.known.iter().position(is_it) {
            Some(place) => place,
            None => {
                self.known.push(Known {
                    effects: node.effects,
                    point: point.clone(),
                    error: unseen(&node.model, (point, weight), self.recordings)?,
                });
                self.known.len() - 1
            }
        };
        Ok(&self.known[place].error)
    }
}
