use crate::error::{TruthError, within};
use std::cmp::Ordering;
use std::collections::BinaryHeap;
use std::f64::consts::PI;

/// Relays of the main loop: a step of one is 0.025 % of the stroke.
const RELAYS: usize = 4_000;
/// Relays of the narrow loop of the R-phase.
const NARROW_RELAYS: usize = 800;
/// A relay's own width at least, K.
const NARROWEST_K: f64 = 0.5;

/// Domains of the material, each of which transforms as a whole: up above its own temperature, down below another.
///
/// ```text
/// ξ = share of the domains that are up,     up above α, down below β < α
/// ```
///
/// α and β of all domains are spread by a normal distribution of two correlated variables, whose deviations differ from
/// domain to domain themselves, log-normally: the more, the heavier the tails of the loop. They are spread evenly (a sequence of
/// low discrepancy, so that no chance of the draw is seen). Return points are remembered because every domain is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RelayLoop {
    /// Mean temperature at which domains go up, °C; above that at which they go down, to 250.
    pub heating_center_degc: f64,
    /// Median of its standard deviation, K; 0.5 to 40.
    pub heating_deviation_k: f64,
    /// Mean temperature at which domains go down, °C; -100 to 200.
    pub cooling_center_degc: f64,
    /// Median of its standard deviation, K; 0.5 to 40.
    pub cooling_deviation_k: f64,
    /// Correlation of both; -0.9 to 0.95.
    pub correlation: f64,
    /// Standard deviation of the logarithm of both deviations; 0, normal, to 1.
    pub tails: f64,
}

impl Default for RelayLoop {
    fn default() -> Self {
        Self {
            heating_center_degc: 66.0,
            heating_deviation_k: 5.0,
            cooling_center_degc: 50.0,
            cooling_deviation_k: 5.0,
            correlation: 0.6,
            tails: 0.0,
        }
    }
}

impl RelayLoop {
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
        within("correlation", self.correlation, -0.9..=0.95)?;
        within("tails", self.tails, 0.0..=1.0)
    }

    pub(crate) fn with_spread_ratio(self, ratio: f64) -> Self {
        Self {
            heating_deviation_k: self.heating_deviation_k / ratio.sqrt(),
            cooling_deviation_k: self.cooling_deviation_k * ratio.sqrt(),
            ..self
        }
    }

    /// How far from the means hardly anything is left to transform, in deviations.
    pub(crate) fn reach(&self) -> f64 {
        2.5 * (1.0 + self.tails)
    }

    /// All domains, down.
    pub(crate) fn domains(&self) -> Relays {
        let rest = (1.0 - self.correlation * self.correlation).sqrt();
        Relays::new((0..RELAYS).map(|k| {
            let [a, b, c, _] = even_normals(k);
            let wide = (self.tails * c).exp();
            let down_degc = self.cooling_center_degc
                + wide * self.cooling_deviation_k * (self.correlation * a + rest * b);
            let up_degc = self.heating_center_degc + wide * self.heating_deviation_k * a;
            [up_degc.max(down_degc + NARROWEST_K), down_degc]
        }))
    }
}

/// A loop all of whose relays are equally wide.
pub(crate) fn narrow(center_degc: f64, half_width_k: f64, deviation_k: f64) -> Relays {
    Relays::new((0..NARROW_RELAYS).map(|k| {
        let middle_degc = center_degc + deviation_k * even_normals(k)[0];
        [middle_degc + half_width_k, middle_degc - half_width_k]
    }))
}

/// Four independent normal numbers of an even sequence in four dimensions: powers of the root of x⁵ = x + 1, as the golden
/// ratio's in one, by the transform of Box and Muller.
fn even_normals(k: usize) -> [f64; 4] {
    const ROOT: f64 = 1.167_303_978_261_418_7;
    let place = |power: i32| (0.5 + (k + 1) as f64 * ROOT.powi(-power)).fract();
    let pair = |u: f64, v: f64| {
        let radius = (-2.0 * (1.0 - u).ln()).sqrt();
        let angle = 2.0 * PI * v;
        [radius * angle.cos(), radius * angle.sin()]
    };
    let ([a, b], [c, d]) = (pair(place(1), place(2)), pair(place(3), place(4)));
    [a, b, c, d]
}

/// A relay waiting to switch, by the temperature at which it does.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Waiting {
    /// Largest first: of those that go up, the negative temperature.
    key: f64,
    relay: usize,
}

impl Eq for Waiting {}

impl PartialOrd for Waiting {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Waiting {
    fn cmp(&self, other: &Self) -> Ordering {
        let by_key = self.key.total_cmp(&other.key);
        by_key.then(self.relay.cmp(&other.relay))
    }
}

/// Relays with their states.
#[derive(Debug, Clone)]
pub(crate) struct Relays {
    /// Up above the first, down below the second, °C.
    ends_degc: Vec<[f64; 2]>,
    /// Those that are down, the lowest upper end first.
    down: BinaryHeap<Waiting>,
    /// Those that are up, the highest lower end first.
    up: BinaryHeap<Waiting>,
}

impl Relays {
    fn new(ends_degc: impl Iterator<Item = [f64; 2]>) -> Self {
        let ends_degc: Vec<[f64; 2]> = ends_degc.collect();
        let mut relays = Self {
            down: BinaryHeap::new(),
            up: BinaryHeap::new(),
            ends_degc,
        };
        relays.rest(f64::NEG_INFINITY);
        relays
    }

    /// Cooled to a temperature from far above.
    pub(crate) fn rest(&mut self, temperature_degc: f64) {
        self.down.clear();
        self.up.clear();
        for relay in 0..self.ends_degc.len() {
            let [up_degc, down_degc] = self.ends_degc[relay];
            if down_degc <= temperature_degc {
                self.up.push(Waiting {
                    key: down_degc,
                    relay,
                });
            } else {
                self.down.push(Waiting {
                    key: -up_degc,
                    relay,
                });
            }
        }
    }

    /// Share that is up.
    pub(crate) fn fraction(&self) -> f64 {
        self.up.len() as f64 / self.ends_degc.len() as f64
    }

    /// Part of the whole that a relay is.
    pub(crate) fn quantum(&self) -> f64 {
        1.0 / self.ends_degc.len() as f64
    }

    /// Switches the relay that is due first at a temperature: up or down, or none.
    pub(crate) fn switch(&mut self, temperature_degc: f64) -> Option<f64> {
        if let Some(&next) = self.down.peek().filter(|next| -next.key < temperature_degc) {
            self.down.pop();
            self.up.push(Waiting {
                key: self.ends_degc[next.relay][1],
                relay: next.relay,
            });
            return Some(self.quantum());
        }
        let next = *self.up.peek().filter(|next| next.key > temperature_degc)?;
        self.up.pop();
        self.down.push(Waiting {
            key: -self.ends_degc[next.relay][0],
            relay: next.relay,
        });
        Some(-self.quantum())
    }

    /// Goes to a temperature.
    pub(crate) fn follow(&mut self, temperature_degc: f64) {
        while self.switch(temperature_degc).is_some() {}
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn along(relays: &mut Relays, path: &[f64]) -> f64 {
        for &degc in path {
            relays.follow(degc);
        }
        relays.fraction()
    }

    #[test]
    fn the_limiting_branches_have_the_means_and_deviations_asked_for() {
        let mut relays = RelayLoop::default().domains();
        assert!((along(&mut relays, &[20.0, 66.0]) - 0.5).abs() < 0.01);
        assert!((along(&mut relays, &[71.0]) - 0.841).abs() < 0.01);
        assert!(along(&mut relays, &[100.0]) > 0.9999);
        assert!((along(&mut relays, &[50.0]) - 0.5).abs() < 0.01);
        assert!((along(&mut relays, &[45.0]) - 0.159).abs() < 0.01);
    }

    #[test]
    fn tails_are_heavier_where_deviations_differ() {
        let share_beyond = |tails: f64| {
            let loops = RelayLoop {
                tails,
                ..RelayLoop::default()
            };
            1.0 - along(&mut loops.domains(), &[-200.0, 66.0 + 3.0 * 5.0])
        };
        assert!(share_beyond(0.0) < 0.003);
        assert!(
            (0.01..0.08).contains(&share_beyond(0.8)),
            "{}",
            share_beyond(0.8)
        );
        let loops = RelayLoop {
            tails: 0.8,
            ..RelayLoop::default()
        };
        let hot_degc = 66.0 + 5.0 * loops.reach();
        assert!(along(&mut loops.domains(), &[hot_degc]) > 0.97);
    }

    #[test]
    fn minor_loops_close_and_are_wiped_out() {
        let mut relays = RelayLoop::default().domains();
        let before = along(&mut relays, &[20.0, 68.0]);
        let inside = along(&mut relays, &[52.0, 60.0, 55.0, 60.0]);
        assert!(inside < before);
        assert!((along(&mut relays, &[52.0, 68.0]) - before).abs() < 1e-12);
        let mut straight = RelayLoop::default().domains();
        let expected = along(&mut straight, &[20.0, 75.0]);
        assert!((along(&mut relays, &[75.0]) - expected).abs() < 1e-12);
    }

    #[test]
    fn at_rest_is_cooled_from_above() {
        let mut cooled = RelayLoop::default().domains();
        let mut rested = RelayLoop::default().domains();
        rested.rest(52.0);
        assert!((along(&mut cooled, &[200.0, 52.0]) - rested.fraction()).abs() < 1e-12);
    }
}
