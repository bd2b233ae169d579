//! Plants whose output rises with heat: those whose output falls are turned over.

use wiener::{Fleet, Lanes, NARROW, Output, Shown, Stretch, WIDE};

use crate::{Extended, Member, PhysicsError};

/// Plants whose displacement is multiplied by a sign.
#[derive(Debug, Clone, Copy)]
pub struct Turned {
    /// The plants as they are.
    pub fleet: Extended,
    /// 1 or -1.
    pub sign: f64,
}

/// Some of them on their way.
struct TurnedLanes<const L: usize> {
    lanes: Box<dyn Lanes<L> + Send>,
    sign: f64,
}

impl Fleet for Turned {
    type Member = Member;
    type Error = PhysicsError;

    fn narrow(
        &self,
        members: &[Member; NARROW],
    ) -> Result<Box<dyn Lanes<NARROW> + Send>, PhysicsError> {
        Ok(Box::new(TurnedLanes {
            lanes: self.fleet.narrow(members)?,
            sign: self.sign,
        }))
    }

    fn wide(&self, members: &[Member; WIDE]) -> Result<Box<dyn Lanes<WIDE> + Send>, PhysicsError> {
        Ok(Box::new(TurnedLanes {
            lanes: self.fleet.wide(members)?,
            sign: self.sign,
        }))
    }
}

impl<const L: usize> Lanes<L> for TurnedLanes<L> {
    fn output(&self) -> Output<L> {
        let output = self.lanes.output();
        Output {
            displacement: output.displacement.map(|value| self.sign * value),
            ..output
        }
    }

    fn run(&mut self, stretch: &Stretch<'_, L>, shown: &mut Shown<'_, L>) {
        self.lanes.run(stretch, shown);
        for value in shown.displacement.as_flattened_mut() {
            *value *= self.sign;
        }
    }
}
