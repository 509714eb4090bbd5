//! The targets of `tests/fuzz` for libFuzzer; one program each, see README.md.

use std::alloc::{GlobalAlloc, Layout, System};
use std::sync::atomic::{AtomicUsize, Ordering};

#[path = "../../tests/fuzz/targets/mod.rs"]
pub mod targets;

/// Runs the target of this name, which may use `most` bytes.
///
/// # Panics
/// Where the target does.
pub fn run(name: &str, most: usize, bytes: &[u8]) {
    MOST.store(most, Ordering::Relaxed);
    let target = targets::ALL.iter().find(|target| target.name == name).expect("a target");
    (target.run)(bytes);
}

/// The fuzzer's function for the target of this name, which may use so many GiB.
#[macro_export]
macro_rules! target {
    ($name:literal, $most:literal GiB) => {
        libfuzzer_sys::fuzz_target!(|bytes: &[u8]| $crate::run($name, $most << 30, bytes));
    };
}

/// Counts what is allocated: libFuzzer looks at the memory of the process once a second, and misses what is gone by then.
struct Counted;

#[global_allocator]
static COUNTED: Counted = Counted;
static IN_USE: AtomicUsize = AtomicUsize::new(0);
static MOST: AtomicUsize = AtomicUsize::new(usize::MAX);

fn take(size: usize) {
    let before = IN_USE.fetch_add(size, Ordering::Relaxed);
    let most = MOST.load(Ordering::Relaxed);
    if before.saturating_add(size) > most {
        // The words take a few bytes themselves.
        MOST.store(usize::MAX, Ordering::Relaxed);
        panic!("more than {most} bytes are in use: {before}, and {size} more are asked for");
    }
}

// SAFETY: every call is handed to the system's allocator as it came; what is counted beside it changes nothing there.
unsafe impl GlobalAlloc for Counted {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        take(layout.size());
        // SAFETY: as the caller promises.
        unsafe { System.alloc(layout) }
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        take(layout.size());
        // SAFETY: as the caller promises.
        unsafe { System.alloc_zeroed(layout) }
    }

    unsafe fn realloc(&self, at: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        take(size.saturating_sub(layout.size()));
        IN_USE.fetch_sub(layout.size().saturating_sub(size), Ordering::Relaxed);
        // SAFETY: as the caller promises.
        unsafe { System.realloc(at, layout, size) }
    }

    unsafe fn dealloc(&self, at: *mut u8, layout: Layout) {
        IN_USE.fetch_sub(layout.size(), Ordering::Relaxed);
        // SAFETY: as the caller promises.
        unsafe { System.dealloc(at, layout) }
    }
}
