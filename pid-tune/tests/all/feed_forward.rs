//! The current of eq. 3 as feed-forward.

use crate::common;

use common::{AMBIENT_DEGC, assert_near, assert_same, rod, rods};
use pid_tune::feed_forward_a;
use wiener::thermal::{HeatBalance, Reach};
use wiener::{Input, Plant};

const REACH: Reach = Reach {
    from_degc: 40.0,
    to_degc: 60.0,
    ambient_degc: AMBIENT_DEGC,
    within_s: 0.287,
};

fn heat() -> HeatBalance {
    HeatBalance::new([rod(6.0).heat]).unwrap()
}

#[test]
fn the_rod_is_there_in_time() {
    let model = rods(&[rod(6.0)]);
    let mut state = model.at([40.0], [0.05]).unwrap();
    let input = Input {
        drive: [feed_forward_a(&heat(), &REACH).unwrap()],
        ambient_degc: AMBIENT_DEGC,
    };
    model.step(&mut state, &input, REACH.within_s);
    assert_near(state.temperature_degc()[0], 60.0, 1e-9);
}

#[test]
fn from_a_temperature_to_itself_it_holds() {
    for within_s in [0.01, 1.0, 1000.0] {
        let hold = Reach {
            from_degc: 60.0,
            within_s,
            ..REACH
        };
        // i² λ is the rise above ambient.
        let steady_a = ((60.0 - AMBIENT_DEGC) / 15.0_f64).sqrt();
        assert_near(feed_forward_a(&heat(), &hold).unwrap(), steady_a, 1e-12);
    }
}

#[test]
fn where_the_rod_cannot_cool_that_fast_there_is_no_current() {
    for to_degc in [39.0, AMBIENT_DEGC, -10.0] {
        let cool = Reach { to_degc, ..REACH };
        assert!(heat().current_to_reach_a(&cool).is_err());
        assert_same(&[feed_forward_a(&heat(), &cool).unwrap()], &[0.0]);
    }
}
