//! How much a scene may take: a few bytes can claim gigabytes, many views the same bytes, many meshes the same view.

use std::cell::Cell;
use std::rc::Rc;

use crate::scene::error::Reason;

/// More than any scene that the renderer can show: files read, what is unpacked of them, meshes, textures.
pub const MOST_BYTES: u64 = 4 << 30;

/// What is left of the bytes that one scene may take. Clones share it.
#[derive(Debug, Clone)]
pub struct Budget {
    left: Rc<Cell<u64>>,
}

impl Default for Budget {
    fn default() -> Budget {
        Budget { left: Rc::new(Cell::new(MOST_BYTES)) }
    }
}

impl Budget {
    /// Asks before `bytes` are allocated.
    pub fn take(&self, bytes: u64) -> Result<(), Reason> {
        let left = self.left.get().checked_sub(bytes);
        let left =
            left.ok_or_else(|| format!("the scene takes more than {} GiB, which is not read", MOST_BYTES >> 30))?;
        self.left.set(left);
        Ok(())
    }

    /// What is left, in bytes.
    pub fn left(&self) -> u64 {
        self.left.get()
    }
}
