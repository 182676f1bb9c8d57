//! The allocator of the system, which calls a function of the program when memory is exhausted.
//!
//! A program installs it with `#[global_allocator]` and names the function with [`on_exhaustion`]. Stable Rust has no other way to
//! end in order: its own handler writes two lines and aborts.

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

/// The allocator of the system, watched for failures.
#[derive(Clone, Copy, Debug, Default)]
pub struct WatchedAllocator;

/// Function that is called with the number of bytes that could not be allocated.
static HANDLER: OnceLock<fn(usize)> = OnceLock::new();
/// True once the handler is running.
static HANDLING: AtomicBool = AtomicBool::new(false);
/// Hundredths of a second that other threads wait for the handler.
const LONGEST_WAIT: u32 = 1000;

thread_local! {
    /// True in the thread that runs the handler, which may allocate, and fail.
    static INSIDE: Cell<bool> = const { Cell::new(false) };
}

/// Names the function that is called once, with the number of bytes that could not be allocated (0 if unknown). It should end the program; if it
/// returns, the program goes on as it would have without it, and mostly aborts. Only the first call counts.
pub fn on_exhaustion(handler: fn(usize)) {
    let _ = HANDLER.set(handler);
}

/// Calls the handler, for memory that was asked for in another way than by this allocator. Of several threads that call it one runs
/// the handler, and the others wait for the end of the program.
pub fn exhausted(bytes: usize) {
    let Some(handler) = HANDLER.get() else { return };
    if INSIDE.get() {
        return;
    }
    if HANDLING.swap(true, Ordering::SeqCst) {
        // Another thread is about to end the program.
        for _ in 0..LONGEST_WAIT {
            std::thread::sleep(Duration::from_millis(10));
        }
    } else {
        INSIDE.set(true);
        handler(bytes);
        INSIDE.set(false);
        HANDLING.store(false, Ordering::SeqCst);
    }
}

/// Calls the handler if the allocator has returned nothing.
fn checked(pointer: *mut u8, bytes: usize) -> *mut u8 {
    if pointer.is_null() {
        exhausted(bytes);
    }
    pointer
}

// SAFETY: every call goes to the allocator of the system with its arguments as they are, and its result is returned as it is.
unsafe impl GlobalAlloc for WatchedAllocator {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        // SAFETY: the caller keeps the contract of `alloc`, which is the same there.
        checked(unsafe { System.alloc(layout) }, layout.size())
    }
    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        // SAFETY: the caller keeps the contract of `alloc_zeroed`, which is the same there.
        checked(unsafe { System.alloc_zeroed(layout) }, layout.size())
    }
    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        // SAFETY: the pointer is from `System`, because all of ours are.
        unsafe { System.dealloc(pointer, layout) }
    }
    unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        // SAFETY: the pointer is from `System`, because all of ours are.
        checked(unsafe { System.realloc(pointer, layout, size) }, size)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::AtomicUsize;

    #[global_allocator]
    static ALLOCATOR: WatchedAllocator = WatchedAllocator;

    static MISSED: AtomicUsize = AtomicUsize::new(0);

    #[test]
    fn the_handler_hears_of_what_cannot_be_had() {
        on_exhaustion(|bytes| {
            MISSED.store(bytes, Ordering::SeqCst);
        });
        let impossible = isize::MAX as usize / 2;
        assert!(Vec::<u8>::new().try_reserve_exact(impossible).is_err());
        assert_eq!(MISSED.load(Ordering::SeqCst), impossible);
        let mut grown = vec![1u8; 100];
        assert!(grown.try_reserve_exact(impossible).is_err());
        assert_eq!(grown, [1u8; 100]);
    }
}
