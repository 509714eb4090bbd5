//! How much memory a scene may take. Counting is needed because a few bytes can claim gigabytes, many buffer views can
//! share the same bytes, and many meshes the same view.

use std::cell::Cell;
use std::path::Path;
use std::rc::Rc;

use cyclopean_analysis::files;

use crate::scene::error::Reason;

/// Memory that is assumed where the system does not tell how much there is.
const MEMORY_BYTES: u64 = 16 << 30;
/// The least budget, whatever the system says. A machine that has less memory cannot show the scenes of a study anyway.
const LEAST_BYTES: u64 = 1 << 30;

/// The bytes that a scene may take in all: files, what is unpacked from them, meshes and textures. It is half of the
/// memory that this program may use, so that every scene is read that the machine can hold, and no file takes all of
/// its memory.
pub fn most_bytes() -> u64 {
    let read = |path: &str| files::read_text(Path::new(path), 1 << 16).unwrap_or_default();
    let machine = number(&read("/proc/meminfo"), "MemTotal:").map(|kib| kib << 10);
    let allowed = number(&read("/proc/self/limits"), "Max address space");
    let memory = machine.unwrap_or(MEMORY_BYTES).min(allowed.unwrap_or(u64::MAX));
    (memory / 2).max(LEAST_BYTES)
}

/// The number after `name` at the beginning of a line; `None` where there is no such line or no number.
fn number(text: &str, name: &str) -> Option<u64> {
    text.lines().find_map(|line| line.strip_prefix(name)?.split_whitespace().next()?.parse().ok())
}

/// What is left of the bytes that one scene may take. All clones share the same count.
#[derive(Debug, Clone)]
pub struct Budget {
    of: u64,
    left: Rc<Cell<u64>>,
}

impl Default for Budget {
    fn default() -> Budget {
        let of = most_bytes();
        Budget { of, left: Rc::new(Cell::new(of)) }
    }
}

impl Budget {
    /// Takes `bytes` from what is left, and fails where they are too many. It must be called before the bytes are
    /// allocated.
    pub fn take(&self, bytes: u64) -> Result<(), Reason> {
        let left = self.left.get().checked_sub(bytes);
        let of = self.of as f64 / f64::from(1 << 30);
        let left = left.ok_or_else(|| {
            format!("the scene takes more than {of:.1} GiB, half of the memory that this program may use")
        })?;
        self.left.set(left);
        Ok(())
    }

    /// What is left, in bytes.
    pub fn left(&self) -> u64 {
        self.left.get()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_the_system_says_is_read() {
        let said =
            "MemTotal:       16316412 kB\nMemFree: 1 kB\nMax address space         6442450944   unlimited  bytes\n";
        assert_eq!(number(said, "MemTotal:"), Some(16_316_412));
        assert_eq!(number(said, "Max address space"), Some(6_442_450_944));
        assert_eq!(number("Max address space  unlimited  unlimited  bytes", "Max address space"), None);
        assert!(most_bytes() >= LEAST_BYTES);
    }

    #[test]
    fn clones_share_what_is_left() {
        let budget = Budget::default();
        let other = budget.clone();
        other.take(1000).unwrap();
        assert_eq!(budget.left(), most_bytes() - 1000);
        assert!(budget.take(u64::MAX).unwrap_err().to_string().contains("half of the memory"));
    }
}
