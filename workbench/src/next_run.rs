//! The proposed next run as a file that can be played and recorded.

use std::fmt::Write;

use identify::Rod;
use missing_physics::Run;

use crate::columns::Column;

/// Digits after the point of a time: below, a clock's own error shows.
const TIME_DECIMALS: f64 = 1e9;

/// Time and drive, in columns that are named, and in units, as the recordings' are.
#[must_use]
pub fn csv(run: &Run, rod: &Rod) -> String {
    let time = Column::of(rod.columns.time.as_ref(), "time_s");
    let drive = Column::of(rod.columns.drive.as_ref(), rod.drive_kind.column());
    let mut text = format!("{},{}\n", time.name, drive.name);
    for (k, value) in run.drive.iter().enumerate() {
        let time_s = (run.dt_s * k as f64 * TIME_DECIMALS).round() / TIME_DECIMALS;
        // Writing to a string does not fail.
        let _ = writeln!(text, "{},{}", time.factor * time_s, drive.factor * value);
    }
    text
}

#[cfg(test)]
mod tests {
    use rig_files::rod_file;

    use super::*;

    fn written(rod: &str) -> String {
        let run = Run {
            name: "slow ramp".to_owned(),
            dt_s: 0.1,
            drive: vec![0.0, 0.5, 1.0, 0.25],
            separation: 9.0,
            separation_now: 1.0,
            decisive: 1..3,
        };
        csv(&run, &rod_file::parse("rod.toml", rod).unwrap())
    }

    #[test]
    fn columns_are_those_of_the_recordings() {
        assert_eq!(
            written(""),
            "time_s,current_a\n0,0\n0.1,0.5\n0.2,1\n0.3,0.25\n"
        );
        let rod = "[drive]\nkind = \"duty\"\nsupply_v = 24.0\n\
                   [columns]\ntime = \"t_ms\"\ndrive = { name = \"PWM\", unit = \"%\" }\n";
        assert_eq!(written(rod), "t_ms,PWM\n0,0\n100,50\n200,100\n300,25\n");
        assert_eq!(
            written("[columns]\ntime = 1\ndrive = \"I (mA)\"\n"),
            "time_s,I (mA)\n0,0\n0.1,500\n0.2,1000\n0.3,250\n"
        );
    }
}
