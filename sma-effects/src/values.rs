//! Values of effects by number, and their check.

use crate::{EffectId, EffectParameter, EffectSet, EffectValues, PhysicsError, Role};

impl EffectValues {
    /// The baseline with one effect at `multiple` times its typical sizes, and its partners at their
    /// typical values.
    #[must_use]
    pub fn typical(effect: EffectId, multiple: f64) -> Self {
        let mut values = Self::default();
        for (index, parameter) in effect.info().parameters.iter().enumerate() {
            if let (Role::Size, Some(slot)) = (parameter.role, values.slot(effect, index)) {
                *slot = multiple * parameter.typical;
            }
        }
        values
    }

    /// The value of the parameter number `index` of an effect; `None` if it has fewer.
    #[must_use]
    pub fn get(mut self, effect: EffectId, index: usize) -> Option<f64> {
        self.slot(effect, index).copied()
    }

    /// Checks that every parameter of the active effects is within its bounds, and that every size of the
    /// others is 0.
    ///
    /// # Errors
    ///
    /// [`PhysicsError::OutOfBounds`], [`PhysicsError::Inactive`].
    pub fn checked(mut self, active: EffectSet) -> Result<Self, PhysicsError> {
        for effect in EffectId::ALL {
            for (index, parameter) in effect.info().parameters.iter().enumerate() {
                if let Some(&mut value) = self.slot(effect, index) {
                    check(effect, parameter, value, active)?;
                }
            }
        }
        Ok(self)
    }
}

fn check(
    effect: EffectId,
    parameter: &EffectParameter,
    value: f64,
    active: EffectSet,
) -> Result<(), PhysicsError> {
    if active.contains(effect) {
        if parameter.accepts(value) {
            Ok(())
        } else {
            Err(PhysicsError::OutOfBounds {
                effect: effect.id(),
                name: parameter.name,
                value,
                unit: parameter.unit,
                lower: parameter.bounds[0],
                upper: parameter.bounds[1],
            })
        }
    } else if matches!(parameter.role, Role::Partner { .. }) || value.abs() <= 0.0 {
        Ok(())
    } else {
        Err(PhysicsError::Inactive {
            effect: effect.id(),
            name: parameter.name,
            value,
            unit: parameter.unit,
        })
    }
}
