//! How much a file may grow when it is unpacked: a few bytes can claim gigabytes, and many views the same bytes.

use crate::scene::error::Reason;

/// More than any scene that the renderer can show.
const MOST_BYTES: u64 = 2 << 30;

/// What is left of the bytes that one file may unpack to.
#[derive(Debug)]
pub struct Budget {
    left: u64,
}

impl Default for Budget {
    fn default() -> Budget {
        Budget { left: MOST_BYTES }
    }
}

impl Budget {
    /// Asks before `bytes` are allocated.
    pub fn take(&mut self, bytes: u64) -> Result<(), Reason> {
        self.left = self
            .left
            .checked_sub(bytes)
            .ok_or_else(|| format!("the file unpacks to more than {} GiB, which is not read", MOST_BYTES >> 30))?;
        Ok(())
    }

    /// What is left, in bytes.
    pub fn left(&self) -> u64 {
        self.left
    }
}
