//! Dates and times of day.

use jiff::civil::{DateTime, Time};

/// Forms of a date with a time of day, the likelier first.
const DATED: [&str; 6] = [
    "%Y-%m-%d %H:%M:%S%.f",
    "%Y-%m-%dT%H:%M:%S%.f",
    "%Y/%m/%d %H:%M:%S%.f",
    "%d.%m.%Y %H:%M:%S%.f",
    "%m/%d/%Y %H:%M:%S%.f",
    "%d/%m/%Y %H:%M:%S%.f",
];

/// Forms of a time of day.
const OF_DAY: [&str; 2] = ["%H:%M:%S%.f", "%I:%M:%S%.f %p"];

/// Nanoseconds of a stamp, of a date from its epoch, else of the day.
#[derive(Debug, Clone, Copy)]
pub(super) enum Stamp {
    Dated(i128),
    OfDay(i128),
}

/// True if a field is a date with a time, or a time of day.
pub(super) fn is_stamp(field: &str) -> bool {
    stamp(field).is_some()
}

/// The stamp in a field, if it is one.
pub(super) fn stamp(field: &str) -> Option<Stamp> {
    let field = field.trim();
    // Most fields are plain numbers.
    if field.len() < 7 || !field.contains(':') {
        return None;
    }
    let zone = field.strip_suffix('Z').unwrap_or(field);
    let of_day = |form: &str| Time::strptime(form, zone).ok();
    let dated = |form: &str| DateTime::strptime(form, zone).ok();
    if let Some(time) = OF_DAY.into_iter().find_map(of_day) {
        let since = time - Time::midnight();
        return Some(Stamp::OfDay(
            since.total(jiff::Unit::Nanosecond).ok()? as i128
        ));
    }
    let time = DATED.into_iter().find_map(dated)?;
    let since = time.duration_since(DateTime::constant(1970, 1, 1, 0, 0, 0, 0));
    Some(Stamp::Dated(since.as_nanos()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn seconds(field: &str) -> Option<f64> {
        stamp(field).map(|stamp| match stamp {
            Stamp::Dated(since) | Stamp::OfDay(since) => since as f64 / 1e9,
        })
    }

    #[test]
    fn stamps_are_read() {
        assert_eq!(seconds("10:00:00.250"), Some(36_000.25));
        assert_eq!(seconds("01:00:00.5 PM"), Some(46_800.5));
        let day = seconds("2024-05-02 00:00:00").unwrap();
        for same in [
            "2024-05-02T10:00:01.5Z",
            "02.05.2024 10:00:01.5",
            "2024/05/02 10:00:01.5",
        ] {
            assert_eq!(seconds(same).map(|at| at - day), Some(36_001.5), "{same}");
        }
        for none in ["1.5", "10:00", "25:00:00", "t: 10:00:00", "2024-05-02"] {
            assert_eq!(seconds(none), None, "{none}");
        }
    }
}
