//! Runs the targets of `tests/fuzz` under libFuzzer, with one program for each target. See README.md.

use std::alloc::{GlobalAlloc, Layout, System};
use std::sync::atomic::{AtomicUsize, Ordering};

#[path = "../../tests/fuzz/targets/mod.rs"]
pub mod targets;

/// Runs the target of this name, which may use `most` bytes of memory.
///
/// # Panics
/// If the target panics, or if it asks for more memory.
pub fn run(name: &str, most: usize, bytes: &[u8]) {
    MOST.store(most, Ordering::Relaxed);
    let target = targets::ALL.iter().find(|target| target.name == name).expect("a target");
    (target.run)(bytes);
}

/// Defines the fuzzer's entry function for the target of this name, which may use this many GiB.
#[macro_export]
macro_rules! target {
    ($name:literal, $most:literal GiB) => {
        libfuzzer_sys::fuzz_target!(|bytes: &[u8]| $crate::run($name, $most << 30, bytes));
    };
}

/// Counts the allocated bytes. libFuzzer looks at the memory of the process only once a second and misses short peaks.
struct Counted;

#[global_allocator]
static COUNTED: Counted = Counted;
static IN_USE: AtomicUsize = AtomicUsize::new(0);
static MOST: AtomicUsize = AtomicUsize::new(usize::MAX);

fn take(size: usize) {
    let before = IN_USE.fetch_add(size, Ordering::Relaxed);
    let most = MOST.load(Ordering::Relaxed);
    if before.saturating_add(size) > most {
        // The message of the panic needs a few bytes itself.
        MOST.store(usize::MAX, Ordering::Relaxed);
        panic!("more than {most} bytes are in use: {before}, and {size} more are asked for");
    }
}

// SAFETY: every call is passed to the system's allocator unchanged, and counting does not affect it.
unsafe impl GlobalAlloc for Counted {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        take(layout.size());
        // SAFETY: the caller keeps the contract of `alloc`.
        unsafe { System.alloc(layout) }
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        take(layout.size());
        // SAFETY: the caller keeps the contract of `alloc_zeroed`.
        unsafe { System.alloc_zeroed(layout) }
    }

    unsafe fn realloc(&self, at: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        take(size.saturating_sub(layout.size()));
        IN_USE.fetch_sub(layout.size().saturating_sub(size), Ordering::Relaxed);
        // SAFETY: the caller keeps the contract of `realloc`.
        unsafe { System.realloc(at, layout, size) }
    }

    unsafe fn dealloc(&self, at: *mut u8, layout: Layout) {
        IN_USE.fetch_sub(layout.size(), Ordering::Relaxed);
        // SAFETY: the caller keeps the contract of `dealloc`.
        unsafe { System.dealloc(at, layout) }
    }
}
