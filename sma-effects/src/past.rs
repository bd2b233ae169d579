//! The samples that a pure delay still holds back.

/// Samples of any length, each with what it carries, and how far each of `L` lanes has come in them.
///
/// A ring that grows with what is under way: a delay may span any number of samples.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Past<const L: usize, T> {
    /// As many as a power of two.
    ring: Vec<Sample<T>>,
    /// Number of the newest sample; 0 is what was since ever.
    newest: usize,
    /// Number of the sample that a lane has come to.
    reached: [usize; L],
    /// Age of the end of that, s, seen from the end of the newest.
    age_s: [f64; L],
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Sample<T> {
    pub(crate) length_s: f64,
    pub(crate) of: T,
}

/// The samples that a lane has passed since it was last asked.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Arriving {
    /// Numbers of the one in which it was, and of that in which it is now.
    pub(crate) first: usize,
    pub(crate) last: usize,
    /// Age of the end of the last, s.
    pub(crate) age_s: f64,
}

impl<const L: usize, T: Copy> Past<L, T> {
    pub(crate) fn since_ever(of: T) -> Self {
        let length_s = f64::INFINITY;
        Self {
            ring: vec![Sample { length_s, of }],
            newest: 0,
            reached: [0; L],
            age_s: [0.0; L],
        }
    }

    /// Number of the newest sample, counted from 1; 0 before the first.
    pub(crate) fn newest(&self) -> usize {
        self.newest
    }

    #[inline(always)]
    pub(crate) fn sample(&self, number: usize) -> &Sample<T> {
        &self.ring[number & (self.ring.len() - 1)]
    }

    pub(crate) fn newest_mut(&mut self) -> &mut T {
        let place = self.newest & (self.ring.len() - 1);
        &mut self.ring[place].of
    }

    /// Adds a sample of a length > 0.
    #[inline(always)]
    pub(crate) fn push(&mut self, of: T, length_s: f64) {
        self.newest += 1;
        if self.newest - self.oldest() >= self.ring.len() {
            self.grow();
        }
        let place = self.newest & (self.ring.len() - 1);
        self.ring[place] = Sample { length_s, of };
        for age_s in &mut self.age_s {
            *age_s += length_s;
        }
    }

    /// Takes a lane on to the sample that began more than `age_s` before the end of the newest, and ended no later than that: never back.
    #[inline(always)]
    pub(crate) fn go_on(&mut self, l: usize, age_s: f64) -> Arriving {
        // Share of the next sample that rounding may make of nothing.
        const NOTHING: f64 = 1e-9;
        let first = self.reached[l];
        let (mut last, mut end_s) = (first, self.age_s[l]);
        while last < self.newest {
            let next_s = self.sample(last + 1).length_s;
            if end_s - age_s <= NOTHING * next_s {
                break;
            }
            last += 1;
            end_s -= next_s;
        }
        if last == self.newest {
            // Not what rounding made of it.
            end_s = 0.0;
        }
        self.reached[l] = last;
        self.age_s[l] = end_s;
        Arriving {
            first,
            last,
            age_s: end_s,
        }
    }

    /// Number of the oldest sample that may still be asked for: a lane asks for the end of the one before.
    #[inline(always)]
    fn oldest(&self) -> usize {
        let reached = self.reached.iter().fold(usize::MAX, |a, &b| a.min(b));
        reached.saturating_sub(1)
    }

    #[cold]
    fn grow(&mut self) {
        let mut ring = vec![self.ring[0]; 2 * self.ring.len()];
        for number in self.oldest()..self.newest {
            let place = number & (ring.len() - 1);
            ring[place] = *self.sample(number);
        }
        self.ring = ring;
    }
}
