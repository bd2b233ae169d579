//! Any plant in lockstep: here a lag without hysteresis.

use wiener::{
    Drives, Fleet, Input, Lanes, MEDIUM, NARROW, Output, Plant, Profile, Shown, Started, Stretch,
    WIDE, lockstep, run,
};

/// A displacement that follows the drive, each lane with its own time constant.
struct Lag<const L: usize> {
    tau_s: [f64; L],
}

impl<const L: usize> Plant<L> for Lag<L> {
    type State = [f64; L];

    fn rest(&self, _: f64) -> [f64; L] {
        [0.0; L]
    }

    #[inline(always)]
    fn output(&self, state: &[f64; L]) -> Output<L> {
        Output {
            displacement: *state,
            temperature_degc: [20.0; L],
        }
    }

    #[inline(always)]
    fn step(&self, state: &mut [f64; L], input: &Input<L>, dt_s: f64) {
        for l in 0..L {
            state[l] += (input.drive[l] - state[l]) * dt_s / (dt_s + self.tau_s[l]);
        }
    }
}

/// Members: time constant and first displacement.
struct Lags {
    has_medium: bool,
    has_wide: bool,
}

const LAGS: Lags = Lags {
    has_medium: true,
    has_wide: true,
};

impl Fleet for Lags {
    type Member = (f64, f64);
    type Error = String;

    fn narrow(
        &self,
        members: &[(f64, f64); NARROW],
    ) -> Result<Box<dyn Lanes<NARROW> + Send>, String> {
        Ok(started(members)?.boxed())
    }

    fn medium(
        &self,
        members: &[(f64, f64); MEDIUM],
    ) -> Result<Option<Box<dyn Lanes<MEDIUM> + Send>>, String> {
        let lags = self.has_medium.then(|| started(members)).transpose()?;
        Ok(lags.map(|lags| lags.boxed() as Box<dyn Lanes<MEDIUM> + Send>))
    }

    fn wide(&self, members: &[(f64, f64); WIDE]) -> Result<Box<dyn Lanes<WIDE> + Send>, String> {
        if !self.has_wide {
            return Err("wide".to_owned());
        }
        Ok(started(members)?.boxed())
    }
}

fn started<const L: usize>(members: &[(f64, f64); L]) -> Result<Started<L, Lag<L>>, String> {
    match members.iter().find(|(tau_s, _)| tau_s.is_nan()) {
        Some(_) => Err("tau_s = NaN".to_owned()),
        None => Ok(Started {
            plant: Lag {
                tau_s: members.map(|(tau_s, _)| tau_s),
            },
            state: members.map(|(_, first)| first),
        }),
    }
}

fn profile(drive: &[f64]) -> Profile<'_> {
    Profile::uniform(drive, 0.1, 20.0).unwrap()
}

#[test]
fn members_of_any_fleet_have_the_bits_of_a_run_alone() {
    let drive: Vec<f64> = (0..100).map(|k| f64::from(k % 7)).collect();
    let profile = profile(&drive);
    for size in [0, 1, 8, 9, 16, 17, 50, 57, 70] {
        let members: Vec<(f64, f64)> = (0..size)
            .map(|k| (0.1 + 0.3 * f64::from(k), f64::from(k)))
            .collect();
        let mut traces = vec![Vec::new(); members.len()];
        lockstep(&LAGS, &members, &profile, &mut |block| {
            for row in block.displacement.chunks(block.stride) {
                for column in 0..block.members {
                    traces[block.first_member + column].push(row[column].to_bits());
                }
            }
        })
        .unwrap();
        for (&(tau_s, first), trace) in members.iter().zip(&traces) {
            let mut alone = Vec::new();
            run(
                &Lag { tau_s: [tau_s] },
                &mut [first],
                &profile,
                |_, output| {
                    alone.push(output.displacement[0].to_bits());
                },
            );
            assert_eq!(trace, &alone);
        }
    }
}

#[test]
fn an_error_of_a_fleet_is_passed_on() {
    let members = [(1.0, 0.0), (f64::NAN, 0.0)];
    let refused = lockstep(&LAGS, &members, &profile(&[1.0]), &mut |_| {});
    assert_eq!(refused, Err("tau_s = NaN".to_owned()));
}

#[test]
fn few_members_take_narrow_lanes_and_more_take_wider_ones() {
    let members = [(1.0, 0.0); MEDIUM + 1];
    let of = |n: usize, has_medium: bool| {
        let lags = Lags {
            has_medium,
            has_wide: false,
        };
        lockstep(&lags, &members[..n], &profile(&[1.0]), &mut |_| {})
    };
    let wide = Err("wide".to_owned());
    assert_eq!(of(NARROW, false), Ok(()));
    assert_eq!(of(NARROW + 1, false), wide);
    assert_eq!(of(MEDIUM, true), Ok(()));
    assert_eq!(of(MEDIUM + 1, true), wide);
}

/// Lanes that have no step of their own.
struct ByRun(Started<1, Lag<1>>);

impl Lanes<1> for ByRun {
    fn output(&self) -> Output<1> {
        self.0.output()
    }

    fn run(&mut self, stretch: &Stretch<'_, 1>, shown: &mut Shown<'_, 1>) {
        self.0.run(stretch, shown);
    }
}

#[test]
fn a_step_is_a_run_of_one_sample_whoever_makes_it() {
    let input = Input {
        drive: [2.0],
        ambient_degc: 20.0,
    };
    let lag = || Lag { tau_s: [0.3] };
    let by_reference = lag();
    let started = Started {
        plant: lag(),
        state: [0.5],
    };
    let mut all: [Box<dyn Lanes<1>>; 4] = [
        Box::new(ByRun(Started {
            plant: lag(),
            state: [0.5],
        })),
        started.boxed(),
        Box::new(Started {
            plant: lag(),
            state: [0.5],
        }),
        Box::new(Started {
            plant: &by_reference,
            state: [0.5],
        }),
    ];
    let expected: f64 = 0.5 + (2.0 - 0.5) * 0.1 / (0.1 + 0.3);
    for lanes in &mut all {
        lanes.step(&input, 0.1);
        let [displacement] = lanes.output().displacement;
        assert_eq!(displacement.to_bits(), expected.to_bits());
    }
    let mut shown = Shown {
        displacement: &mut [[0.0]],
        temperature_degc: &mut [[0.0]],
    };
    let stretch = Stretch {
        drive: Drives::Common(&[2.0]),
        ambient_degc: &[20.0],
        dt_s: &[0.1],
    };
    all[0].run(&stretch, &mut shown);
    assert_eq!(shown.displacement, &[[expected]]);
}
