//! Plants whose output rises with heat: those whose output falls are turned over.

use missing_physics::{Extended, Member, PhysicsError};
use wiener::{Fleet, Input, Output, Plant, Started};

/// Plants whose displacement is multiplied by a sign.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Turned {
    pub(crate) fleet: Extended,
    /// 1 or -1.
    pub(crate) sign: f64,
}

/// One of them.
#[derive(Debug)]
pub(crate) struct TurnedPlant<Q> {
    pub(crate) plant: Q,
    pub(crate) sign: f64,
}

impl Fleet for Turned {
    type Member = Member;
    type Error = PhysicsError;

    fn start<const L: usize>(
        &self,
        members: &[Member; L],
    ) -> Result<Started<L, impl Plant<L>>, PhysicsError> {
        let Started { plant, state } = self.fleet.start(members)?;
        let sign = self.sign;
        Ok(Started {
            plant: TurnedPlant { plant, sign },
            state,
        })
    }
}

impl<const L: usize, Q: Plant<L>> Plant<L> for TurnedPlant<Q> {
    type State = Q::State;

    fn rest(&self, ambient_degc: f64) -> Q::State {
        self.plant.rest(ambient_degc)
    }

    #[inline(always)]
    fn output(&self, state: &Q::State) -> Output<L> {
        let output = self.plant.output(state);
        Output {
            displacement: output.displacement.map(|value| self.sign * value),
            ..output
        }
    }

    #[inline(always)]
    fn step(&self, state: &mut Q::State, input: &Input<L>, dt_s: f64) {
        self.plant.step(state, input, dt_s);
    }
}
