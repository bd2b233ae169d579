//! Things in the order of a number of each: one sort of numbers, instead of one for each kind of thing.

/// The lowest first; those of one number stay as they stand.
pub fn rising<T>(things: &mut Vec<T>, number: impl Fn(&T) -> f64) {
    let order = in_order(things.iter().map(number).collect());
    let mut slots: Vec<Option<T>> = things.drain(..).map(Some).collect();
    things.extend(order.into_iter().filter_map(|place| slots[place].take()));
}

/// The highest first; those of one number stay as they stand.
pub fn falling<T>(things: &mut Vec<T>, number: impl Fn(&T) -> f64) {
    rising(things, |thing| -number(thing));
}

/// Places of numbers, the lowest first.
fn in_order(numbers: Vec<f64>) -> Vec<usize> {
    let mut places: Vec<usize> = (0..numbers.len()).collect();
    places.sort_by(|&a, &b| numbers[a].total_cmp(&numbers[b]));
    places
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equals_stay_as_they_stand_either_way() {
        let things = [(2.0, 'a'), (1.0, 'b'), (2.0, 'c'), (f64::INFINITY, 'd')];
        let letters =
            |things: &[(f64, char)]| -> String { things.iter().map(|one| one.1).collect() };
        let mut up = things.to_vec();
        rising(&mut up, |one| one.0);
        assert_eq!(letters(&up), "bacd");
        let mut down = things.to_vec();
        falling(&mut down, |one| one.0);
        assert_eq!(letters(&down), "dacb");
    }
}
