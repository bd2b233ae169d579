use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use sha2::{Digest, Sha256};

use crate::CaseId;

/// The chances of one case: each purpose has its own, which tells nothing of another.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Chance<'a> {
    /// Seed of the trial: any text.
    pub(crate) seed: &'a str,
    pub(crate) case: CaseId,
}

impl Chance<'_> {
    /// SHA-256 of seed, case and purpose.
    pub(crate) fn digest(&self, purpose: &str) -> [u8; 32] {
        let text = format!("{}\n{}\n{purpose}", self.seed, self.case);
        Sha256::digest(text.as_bytes()).into()
    }

    pub(crate) fn seed(&self, purpose: &str) -> u64 {
        let digest = self.digest(purpose);
        digest
            .iter()
            .take(8)
            .fold(0, |seed, &byte| seed << 8 | u64::from(byte))
    }

    pub(crate) fn of(&self, purpose: &str) -> ChaCha8Rng {
        ChaCha8Rng::from_seed(self.digest(purpose))
    }
}
