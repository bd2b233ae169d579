//! Dry air at sea level, and free convection from a horizontal cylinder in it.

/// 0 °C on the absolute scale, K.
pub(crate) const ZERO_DEGC_K: f64 = 273.15;
/// Acceleration of free fall, m/s².
const GRAVITY_M_PER_S2: f64 = 9.806_65;
/// Standard atmosphere, Pa, over the specific gas constant of dry air, J/(kg K): density times temperature.
const DENSITY_TEMPERATURE_KG_K_PER_M3: f64 = 101_325.0 / 287.05;
/// Specific heat at constant pressure, J/(kg K); it changes by 1 % up to 150 °C.
const SPECIFIC_HEAT_J_PER_KG_K: f64 = 1007.0;

/// Which correlation of free convection.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Correlation {
    /// S. W. Churchill, H. H. S. Chu: *Correlating equations for laminar and turbulent free convection from a
    /// horizontal cylinder*. International Journal of Heat and Mass Transfer 18, pp. 1049-1053, 1975.
    /// doi:10.1016/0017-9310(75)90222-7.
    ///
    /// ```text
    /// Nu = (0.60 + 0.387 Ra^(1/6)/(1 + (0.559/Pr)^(9/16))^(8/27))²
    /// ```
    ChurchillChu,
    /// V. T. Morgan: *The overall convective heat transfer from smooth circular cylinders*. Advances in Heat
    /// Transfer 11, pp. 199-264, 1975, in the five ranges that textbooks give:
    ///
    /// ```text
    /// Nu = C Ra^n;   C, n = 0.675, 0.058 | 1.02, 0.148 | 0.850, 0.188 | 0.480, 0.250 | 0.125, 0.333
    ///                up to Ra = 1e-2 | 1e2 | 1e4 | 1e7 | above
    /// ```
    ///
    /// Where two ranges meet, the larger value counts, so that nothing jumps.
    Morgan,
}

/// Properties of air at one temperature.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Air {
    conductivity_w_per_m_k: f64,
    viscosity_m2_per_s: f64,
    diffusivity_m2_per_s: f64,
}

impl Air {
    /// Sutherland's law for viscosity and conductivity (constants of F. M. White, *Viscous Fluid Flow*), ideal gas.
    fn at(temperature_k: f64) -> Self {
        let ratio = temperature_k / ZERO_DEGC_K;
        let power = ratio * ratio.sqrt();
        let viscosity_pa_s = 1.716e-5 * power * (ZERO_DEGC_K + 111.0) / (temperature_k + 111.0);
        let conductivity_w_per_m_k =
            0.0241 * power * (ZERO_DEGC_K + 194.0) / (temperature_k + 194.0);
        let density_kg_per_m3 = DENSITY_TEMPERATURE_KG_K_PER_M3 / temperature_k;
        Self {
            conductivity_w_per_m_k,
            viscosity_m2_per_s: viscosity_pa_s / density_kg_per_m3,
            diffusivity_m2_per_s: conductivity_w_per_m_k
                / (density_kg_per_m3 * SPECIFIC_HEAT_J_PER_KG_K),
        }
    }
}

/// Coefficient of free convection from a horizontal cylinder, W/(m² K), with air at the film's temperature.
pub(crate) fn free_convection_w_per_m2_k(
    correlation: Correlation,
    diameter_m: f64,
    (surface_degc, ambient_degc): (f64, f64),
) -> f64 {
    let film_k = 0.5 * (surface_degc + ambient_degc) + ZERO_DEGC_K;
    let air = Air::at(film_k);
    let rise_k = (surface_degc - ambient_degc).abs();
    let rayleigh = GRAVITY_M_PER_S2 * rise_k * diameter_m.powi(3)
        / (film_k * air.viscosity_m2_per_s * air.diffusivity_m2_per_s);
    let nusselt = match correlation {
        Correlation::ChurchillChu => {
            let prandtl = air.viscosity_m2_per_s / air.diffusivity_m2_per_s;
            let damping = (1.0 + (0.559 / prandtl).powf(9.0 / 16.0)).powf(8.0 / 27.0);
            (0.60 + 0.387 * rayleigh.powf(1.0 / 6.0) / damping).powi(2)
        }
        Correlation::Morgan => morgan_nusselt(rayleigh),
    };
    nusselt * air.conductivity_w_per_m_k / diameter_m
}

fn morgan_nusselt(rayleigh: f64) -> f64 {
    let range = |c: f64, n: f64| c * rayleigh.powf(n);
    if rayleigh < 1.0 {
        range(0.675, 0.058).max(range(1.02, 0.148))
    } else if rayleigh < 1e3 {
        range(1.02, 0.148).max(range(0.850, 0.188))
    } else if rayleigh < 1e5 {
        range(0.850, 0.188).max(range(0.480, 0.250))
    } else {
        range(0.480, 0.250).max(range(0.125, 1.0 / 3.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Table A.4 of F. P. Incropera, D. P. DeWitt at 300 K: k = 26.3e-3, ν = 15.89e-6, α = 22.5e-6.
    #[test]
    fn air_at_300_k_is_that_of_the_tables() {
        let air = Air::at(300.0);
        assert!((air.conductivity_w_per_m_k - 26.3e-3).abs() < 0.4e-3);
        assert!((air.viscosity_m2_per_s - 15.89e-6).abs() < 0.3e-6);
        assert!((air.diffusivity_m2_per_s - 22.5e-6).abs() < 0.5e-6);
    }

    #[test]
    fn morgan_rises_without_jumps() {
        let mut last = 0.0;
        for k in -90_000..80_000 {
            let nusselt = morgan_nusselt(10_f64.powf(f64::from(k) * 1e-4));
            assert!(nusselt > last);
            assert!(
                k == -90_000 || nusselt / last < 1.001,
                "Ra = 1e{}",
                f64::from(k) * 1e-4
            );
            last = nusselt;
        }
    }

    #[test]
    fn both_correlations_agree_for_a_thin_wire() {
        let h = |c| free_convection_w_per_m2_k(c, 0.75e-3, (75.0, 22.0));
        let (churchill, morgan) = (h(Correlation::ChurchillChu), h(Correlation::Morgan));
        assert!((25.0..45.0).contains(&churchill), "{churchill}");
        assert!(
            (churchill / morgan - 1.0).abs() < 0.25,
            "{churchill} {morgan}"
        );
    }
}
