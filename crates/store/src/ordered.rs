//! Blocks built on all threads and handed over in order.

use crate::error::StoreError;
use std::collections::BTreeMap;
use std::ops::Range;
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};

/// Where blocks go as they are done.
pub trait Keep<B>: Send {
    /// How many blocks there are already.
    fn kept(&self) -> usize;

    /// Takes the next one.
    ///
    /// # Errors
    /// If it cannot be written.
    fn keep(&mut self, block: B) -> Result<(), StoreError>;
}

/// In memory.
impl<B: Send> Keep<B> for Vec<B> {
    fn kept(&self) -> usize {
        self.len()
    }

    fn keep(&mut self, block: B) -> Result<(), StoreError> {
        self.push(block);
        Ok(())
    }
}

/// Builds numbered blocks on all threads of the pool and hands them to `put` one after the other, in order.
///
/// Blocks begin in order too. No more than `window` are being built or wait for one before them, which bounds the
/// memory that they take. `scratch` makes what a thread keeps from block to block.
///
/// # Errors
/// What the first `build` or `put` that failed said; the others end their blocks and stop.
pub fn in_order<S, T: Send, E: Send>(
    numbers: Range<usize>,
    window: usize,
    scratch: impl Fn() -> S + Sync,
    build: impl Fn(&mut S, usize) -> Result<T, E> + Sync,
    put: impl FnMut(usize, T) -> Result<(), E> + Send,
) -> Result<(), E> {
    let desk = Desk {
        state: Mutex::new(State {
            begin: numbers.start,
            put: numbers.start,
            ready: BTreeMap::new(),
            is_putting: false,
            is_stopped: false,
            failure: None,
        }),
        moved: Condvar::new(),
        put: Mutex::new(put),
        end: numbers.end,
        window: window.max(1),
    };
    rayon::broadcast(|_| {
        let alarm = Alarm(&desk);
        let mut own = None;
        while let Some(number) = desk.begin() {
            match build(own.get_or_insert_with(&scratch), number) {
                Ok(block) => desk.deliver(number, block),
                Err(error) => desk.fail(error),
            }
        }
        drop(alarm);
    });
    match desk.state.into_inner().unwrap_or_else(PoisonError::into_inner).failure {
        Some(error) => Err(error),
        None => Ok(()),
    }
}

/// Where threads take numbers and leave blocks.
struct Desk<T, E, P> {
    state: Mutex<State<T, E>>,
    moved: Condvar,
    put: Mutex<P>,
    end: usize,
    window: usize,
}

struct State<T, E> {
    /// The next to be begun.
    begin: usize,
    /// The next to be put.
    put: usize,
    /// Those that wait for one before them.
    ready: BTreeMap<usize, T>,
    is_putting: bool,
    is_stopped: bool,
    failure: Option<E>,
}

impl<T, E, P: FnMut(usize, T) -> Result<(), E>> Desk<T, E, P> {
    fn begin(&self) -> Option<usize> {
        let mut state = self.lock();
        loop {
            if state.is_stopped || state.begin == self.end {
                return None;
            }
            if state.begin < state.put + self.window {
                state.begin += 1;
                return Some(state.begin - 1);
            }
            state = self.moved.wait(state).unwrap_or_else(PoisonError::into_inner);
        }
    }

    /// Leaves a block, and puts all whose turn it is unless another thread is at it.
    fn deliver(&self, number: usize, block: T) {
        let mut state = self.lock();
        state.ready.insert(number, block);
        if state.is_putting {
            return;
        }
        state.is_putting = true;
        while !state.is_stopped {
            let number = state.put;
            let Some(block) = state.ready.remove(&number) else { break };
            drop(state);
            let result = (self.put.lock().unwrap_or_else(PoisonError::into_inner))(number, block);
            if let Err(error) = result {
                return self.fail(error);
            }
            state = self.lock();
            state.put += 1;
            self.moved.notify_all();
        }
        state.is_putting = false;
    }

    fn fail(&self, error: E) {
        self.lock().failure.get_or_insert(error);
        self.stop();
    }
}

impl<T, E, P> Desk<T, E, P> {
    fn lock(&self) -> MutexGuard<'_, State<T, E>> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn stop(&self) {
        self.lock().is_stopped = true;
        self.moved.notify_all();
    }
}

/// Stops the other threads when one panics, which would wait for its block.
struct Alarm<'a, T, E, P>(&'a Desk<T, E, P>);

impl<T, E, P> Drop for Alarm<'_, T, E, P> {
    fn drop(&mut self) {
        if std::thread::panicking() {
            self.0.stop();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blocks_come_in_order_whatever_the_window() {
        for window in [1, 2, 7, 1000] {
            let mut seen = Vec::new();
            let result = in_order(
                3..200,
                window,
                || 0u64,
                |sum, k| {
                    // Uneven work.
                    (0..(k * 7919) % 1000).for_each(|i| *sum = sum.wrapping_add(i as u64));
                    Ok::<_, ()>(2 * k)
                },
                |k, block| {
                    seen.push((k, block));
                    Ok(())
                },
            );
            assert!(result.is_ok());
            assert!(seen.into_iter().eq((3..200).map(|k| (k, 2 * k))));
        }
    }

    #[test]
    fn a_failure_stops_all() {
        let mut seen = 0;
        let put = |_, _| {
            seen += 1;
            if seen == 10 { Err("full") } else { Ok(()) }
        };
        assert_eq!(in_order(0..1_000_000, 4, || (), |_, k| Ok(k), put), Err("full"));
        assert_eq!(seen, 10);
        let build = |_: &mut (), k| if k == 5 { Err("no") } else { Ok(k) };
        assert_eq!(in_order(0..1_000_000, 4, || (), build, |_, _| Ok(())), Err("no"));
    }

    #[test]
    fn a_panic_ends_it() {
        let build = |_: &mut (), k| if k == 5 { panic!("expected") } else { Ok::<_, ()>(k) };
        let run = || in_order(0..1000, 2, || (), build, |_, _| Ok(()));
        assert!(std::panic::catch_unwind(std::panic::AssertUnwindSafe(run)).is_err());
    }
}
