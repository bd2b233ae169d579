use crate::Hysteresis;
use crate::error::{TruthError, within};
use crate::reversals::{Recall, Reversals, Turn};

/// Cells of the density along each axis.
const CELLS: usize = 160;
/// How far the grid goes beyond both centers, in deviations.
const REACH: f64 = 4.0;

/// Relays whose switching temperatures are normally distributed.
///
/// ```text
/// ξ = ∫∫ w(α, β) r_αβ dα dβ        relay up above α, down below β ≤ α
/// w ∝ exp(-½ (a² - 2 ϱ a b + b²)/(1 - ϱ²)),   a = (α - ᾱ)/s_α,  b = (β - β̄)/s_β
/// ```
///
/// F. Preisach, 1935; I. D. Mayergoyz, 2003, doi:10.1016/B978-0-12-480873-7.X5000-X. The density is constant over the
/// cells of a grid and 0 for β > α, so that the mass switched between two reversals is exact by bilinear
/// interpolation of its table. Reversals are wiped out, minor loops close and are congruent.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PreisachLoop {
    /// Mean temperature at which relays switch up ᾱ, °C; above that of switching down, to 250.
    pub heating_center_degc: f64,
    /// Its standard deviation s_α, K; 0.5 to 40.
    pub heating_deviation_k: f64,
    /// Mean temperature at which relays switch down β̄, °C; -100 to 200.
    pub cooling_center_degc: f64,
    /// Its standard deviation s_β, K; 0.5 to 40.
    pub cooling_deviation_k: f64,
    /// Correlation of both ϱ; -0.9 to 0.95.
    pub correlation: f64,
}

impl Default for PreisachLoop {
    fn default() -> Self {
        Self {
            heating_center_degc: 66.0,
            heating_deviation_k: 5.0,
            cooling_center_degc: 50.0,
            cooling_deviation_k: 5.0,
            correlation: 0.5,
        }
    }
}

impl PreisachLoop {
    pub(crate) fn check(&self) -> Result<(), TruthError> {
        within(
            "cooling_center_degc",
            self.cooling_center_degc,
            -100.0..=200.0,
        )?;
        within(
            "heating_center_degc",
            self.heating_center_degc,
            self.cooling_center_degc..=250.0,
        )?;
        within("heating_deviation_k", self.heating_deviation_k, 0.5..=40.0)?;
        within("cooling_deviation_k", self.cooling_deviation_k, 0.5..=40.0)?;
        within("correlation", self.correlation, -0.9..=0.95)
    }

    pub(crate) fn with_spread_ratio(self, ratio: f64) -> Self {
        Self {
            heating_deviation_k: self.heating_deviation_k / ratio.sqrt(),
            cooling_deviation_k: self.cooling_deviation_k * ratio.sqrt(),
            ..self
        }
    }

    /// The operator, with its table.
    ///
    /// # Errors
    ///
    /// [`TruthError::OutOfRange`] naming the parameter.
    pub fn operator(&self) -> Result<Preisach, TruthError> {
        self.check()?;
        let low = (self.cooling_center_degc - REACH * self.cooling_deviation_k)
            .min(self.heating_center_degc - REACH * self.heating_deviation_k);
        let high = (self.cooling_center_degc + REACH * self.cooling_deviation_k)
            .max(self.heating_center_degc + REACH * self.heating_deviation_k);
        let cell_k = (high - low) / CELLS as f64;
        let middle = |cell: usize| low + (cell as f64 + 0.5) * cell_k;
        // Mass of all cells below in α and above in β, by the corner of the grid.
        let width = CELLS + 1;
        let mut mass = vec![0.0; width * width];
        for i in 0..CELLS {
            let mut column = 0.0;
            for j in (0..CELLS).rev() {
                if i > j {
                    column += self.density(middle(i), middle(j));
                }
                mass[(i + 1) * width + j] = mass[i * width + j] + column;
            }
        }
        let total = mass[CELLS * width];
        mass.iter_mut().for_each(|mass| *mass /= total);
        Ok(Preisach {
            low_degc: low,
            high_degc: high,
            cells_per_k: 1.0 / cell_k,
            mass,
        })
    }

    fn density(&self, up_degc: f64, down_degc: f64) -> f64 {
        let a = (up_degc - self.heating_center_degc) / self.heating_deviation_k;
        let b = (down_degc - self.cooling_center_degc) / self.cooling_deviation_k;
        let rho = self.correlation;
        (-0.5 * (a * a - 2.0 * rho * a * b + b * b) / (1.0 - rho * rho)).exp()
    }
}

/// Preisach's operator with its table, ready to use.
#[derive(Debug, Clone, PartialEq)]
pub struct Preisach {
    low_degc: f64,
    high_degc: f64,
    cells_per_k: f64,
    mass: Vec<f64>,
}

/// Memory of Preisach's operator: the reversals that have not been wiped out.
#[derive(Debug, Clone, PartialEq)]
pub struct PreisachMemory(Reversals);

impl PreisachMemory {
    /// How many reversals are remembered.
    #[must_use]
    pub fn depth(&self) -> usize {
        self.0.depth()
    }
}

impl Preisach {
    /// Share of the relays with α ≤ `up_degc` and β ≥ `down_degc`.
    fn switched(&self, up_degc: f64, down_degc: f64) -> f64 {
        let place = |degc: f64| {
            let x = ((degc - self.low_degc) * self.cells_per_k).clamp(0.0, CELLS as f64);
            let cell = (x as usize).min(CELLS - 1);
            (cell, x - cell as f64)
        };
        let ((i, u), (j, v)) = (place(up_degc), place(down_degc));
        let row = |i: usize| {
            let at = i * (CELLS + 1) + j;
            self.mass[at] * (1.0 - v) + self.mass[at + 1] * v
        };
        row(i) * (1.0 - u) + row(i + 1) * u
    }

    fn on(&self, reversals: &Reversals, recall: &Recall, temperature_degc: f64) -> f64 {
        let from = reversals.start(recall).unwrap_or(Turn {
            temperature_degc: self.high_degc,
            fraction: 1.0,
        });
        let fraction = if recall.rising {
            from.fraction + self.switched(temperature_degc, from.temperature_degc)
        } else {
            from.fraction - self.switched(from.temperature_degc, temperature_degc)
        };
        // The sums of a deep memory may round beyond.
        fraction.clamp(0.0, 1.0)
    }
}

impl Hysteresis for Preisach {
    type Memory = PreisachMemory;

    fn rest(&self, temperature_degc: f64) -> PreisachMemory {
        PreisachMemory(Reversals::fallen_to(
            Turn {
                temperature_degc,
                fraction: 1.0 - self.switched(self.high_degc, temperature_degc),
            },
            true,
        ))
    }

    fn fraction(&self, memory: &PreisachMemory, temperature_degc: f64) -> f64 {
        let recall = memory.0.recall(temperature_degc);
        self.on(&memory.0, &recall, temperature_degc)
    }

    fn commit(&self, memory: &mut PreisachMemory, temperature_degc: f64) -> f64 {
        let recall = memory.0.recall(temperature_degc);
        let fraction = self.on(&memory.0, &recall, temperature_degc);
        let end = Turn {
            temperature_degc,
            fraction,
        };
        memory.0.follow(&recall, end);
        fraction
    }
}
