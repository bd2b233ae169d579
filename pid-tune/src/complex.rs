use core::f64::consts::PI;
use core::ops::{Add, Div, Mul};

/// A complex number: what frequency responses are made of.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Complex {
    /// Real part.
    pub re: f64,
    /// Imaginary part.
    pub im: f64,
}

impl Complex {
    /// 1.
    pub(crate) const ONE: Self = Self { re: 1.0, im: 0.0 };

    pub(crate) fn real(re: f64) -> Self {
        Self { re, im: 0.0 }
    }

    /// e^(jφ), φ in rad.
    pub(crate) fn unit(angle_rad: f64) -> Self {
        Self {
            re: libm::cos(angle_rad),
            im: libm::sin(angle_rad),
        }
    }

    /// Absolute value.
    #[must_use]
    pub fn magnitude(self) -> f64 {
        libm::hypot(self.re, self.im)
    }

    /// Square of the absolute value.
    pub(crate) fn square(self) -> f64 {
        self.re * self.re + self.im * self.im
    }

    /// Angle, rad, from -π to π.
    #[must_use]
    pub fn angle_rad(self) -> f64 {
        libm::atan2(self.im, self.re)
    }
}

impl Add for Complex {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self {
            re: self.re + other.re,
            im: self.im + other.im,
        }
    }
}

impl Mul for Complex {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        Self {
            re: self.re * other.re - self.im * other.im,
            im: self.re * other.im + self.im * other.re,
        }
    }
}

impl Mul<f64> for Complex {
    type Output = Self;
    fn mul(self, factor: f64) -> Self {
        Self {
            re: self.re * factor,
            im: self.im * factor,
        }
    }
}

impl Div for Complex {
    type Output = Self;
    fn div(self, other: Self) -> Self {
        let square = other.square();
        Self {
            re: (self.re * other.re + self.im * other.im) / square,
            im: (self.im * other.re - self.re * other.im) / square,
        }
    }
}

/// An angle brought to where the step from `before` is shortest, rad.
pub(crate) fn unwrapped(angle_rad: f64, before_rad: f64) -> f64 {
    angle_rad - 2.0 * PI * libm::round((angle_rad - before_rad) / (2.0 * PI))
}
