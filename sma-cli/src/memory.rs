//! The flag that says what a hysteresis remembers.

use clap::ValueEnum;
use wiener::hysteresis::Rule;

/// Reversals remembered.
#[derive(Debug, Clone, Copy, ValueEnum)]
pub(crate) enum Memory {
    /// The last one: the paper's operator.
    LastReversal,
    /// All that enclose the present loop: minor loops close.
    Nested,
}

impl Memory {
    pub(crate) fn rule(self) -> Rule {
        match self {
            Memory::LastReversal => Rule::LastReversal,
            Memory::Nested => Rule::Nested,
        }
    }

    /// As the flag and the model file write it.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Memory::LastReversal => "last-reversal",
            Memory::Nested => "nested",
        }
    }
}
