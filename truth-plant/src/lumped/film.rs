//! Free convection as conduction through a film of air around the wire.

/// Freezing point of water, K.
const FREEZING_K: f64 = 273.15;
/// Of air at 300 K (F. P. Incropera, D. P. DeWitt, table A.4): conductivity, W/(m K); viscosity and diffusivity, m²/s; and
/// the powers of the temperature with which they rise up to 450 K.
const CONDUCTIVITY_W_PER_M_K: [f64; 2] = [0.0263, 0.87];
const VISCOSITY_M2_PER_S: [f64; 2] = [15.9e-6, 1.77];
const DIFFUSIVITY_M2_PER_S: [f64; 2] = [22.5e-6, 1.80];
/// Acceleration of free fall, m/s².
const GRAVITY_M_PER_S2: f64 = 9.81;

/// Coefficient of a horizontal wire, W/(m² K).
///
/// ```text
/// Nu = 2 f/ln(1 + 2 f/N),   N = 0.772 · 0.515 Ra^¼,   f = 1 - 0.13/N^0.16
/// ```
///
/// The flat layer's Nusselt number N, bent around a cylinder: G. D. Raithby, K. G. T. Hollands: *A general method of
/// obtaining approximate solutions to laminar and turbulent free convection problems*, Advances in Heat Transfer 11,
/// pp. 265-315, 1975; constants for air as in the Handbook of Heat Transfer, 3rd ed., 4.2.
pub(super) fn coefficient_w_per_m2_k(diameter_m: f64, surface_degc: f64, ambient_degc: f64) -> f64 {
    let film_k = 0.5 * (surface_degc + ambient_degc) + FREEZING_K;
    let at = |[value, power]: [f64; 2]| value * (film_k / 300.0).powf(power);
    // Below a hundredth of a kelvin nothing is lost that counts.
    let rise_k = (surface_degc - ambient_degc).abs().max(0.01);
    let rayleigh = GRAVITY_M_PER_S2 * rise_k * diameter_m.powi(3)
        / (film_k * at(VISCOSITY_M2_PER_S) * at(DIFFUSIVITY_M2_PER_S));
    let flat = 0.772 * 0.515 * rayleigh.powf(0.25);
    let bend = 1.0 - 0.13 / flat.powf(0.16);
    let nusselt = 2.0 * bend / (2.0 * bend / flat).ln_1p();
    nusselt * at(CONDUCTIVITY_W_PER_M_K) / diameter_m
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_is_near_the_correlations_for_a_thin_wire_and_rises() {
        let at = |rise_k: f64| coefficient_w_per_m2_k(0.75e-3, 22.0 + rise_k, 22.0);
        assert!((25.0..45.0).contains(&at(53.0)), "{}", at(53.0));
        assert!((1..200).all(|k| at(f64::from(k + 1)) > at(f64::from(k))));
    }
}
