//! Long work beside a listening interpreter.

use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use radiosity_operator::Control;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::{Condvar, Mutex};
use std::time::{Duration, Instant};

/// How often signals are checked and progress is shown.
const TICK: Duration = Duration::from_millis(50);

/// Runs `work` on a pool of `threads` (all cores if `None`) with the interpreter lock released.
///
/// While it runs, signals are checked and `progress(done, total)` is called at every tick; an exception from either
/// stops the work and is raised. A panic becomes a `RuntimeError`.
pub fn run<T: Send>(
    py: Python<'_>,
    threads: Option<usize>,
    progress: Option<&Bound<'_, PyAny>>,
    work: impl FnOnce(&Control) -> T + Send,
) -> PyResult<T> {
    run_asking(py, threads, progress, |_, ()| Ok(true), |control, _: &Desk<()>| work(control))
}

/// The same for work that asks whether to go on: `answer` is called on the thread of the interpreter, which holds its
/// lock, while the work waits. An exception from it stops the work and is raised.
pub fn run_asking<T: Send, M: Send>(
    py: Python<'_>,
    threads: Option<usize>,
    progress: Option<&Bound<'_, PyAny>>,
    mut answer: impl FnMut(Python<'_>, M) -> PyResult<bool>,
    work: impl FnOnce(&Control, &Desk<M>) -> T + Send,
) -> PyResult<T> {
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(threads.unwrap_or(0))
        .build()
        .map_err(|e| PyRuntimeError::new_err(format!("no threads to work on: {e}")))?;
    let (control, desk) = (Control::default(), Desk::default());
    std::thread::scope(|scope| {
        let worker = scope.spawn(|| {
            let result = catch_unwind(AssertUnwindSafe(|| pool.install(|| work(&control, &desk))));
            desk.close();
            result
        });
        let (mut interrupted, mut listened) = (None, Instant::now());
        loop {
            let mut heard = match py.detach(|| desk.wait()) {
                Heard::End => break,
                Heard::Nothing => Ok(()),
                Heard::Question(message) => {
                    // Whoever asks waits, so that there is an answer whatever happens here.
                    let given = if interrupted.is_none() { answer(py, message) } else { Ok(false) };
                    desk.reply(matches!(given, Ok(true)));
                    given.map(|_| ())
                }
            };
            if heard.is_ok() && interrupted.is_none() && listened.elapsed() >= TICK {
                listened = Instant::now();
                heard = listen(py, progress, &control);
            }
            if let Err(error) = heard {
                control.cancel();
                interrupted.get_or_insert(error);
            }
        }
        let result = worker.join().expect("the worker catches its panics");
        match (interrupted, result) {
            (Some(error), _) => Err(error),
            (None, Ok(value)) => Ok(value),
            (None, Err(panic)) => Err(PyRuntimeError::new_err(format!(
                "internal error, please report it with the scene that caused it: {}",
                message(&*panic)
            ))),
        }
    })
}

/// Where the work leaves a question and waits for the answer.
pub struct Desk<M> {
    state: Mutex<State<M>>,
    bell: Condvar,
}

struct State<M> {
    is_closed: bool,
    question: Option<M>,
    answer: Option<bool>,
}

enum Heard<M> {
    End,
    Nothing,
    Question(M),
}

impl<M> Default for Desk<M> {
    fn default() -> Self {
        Self { state: Mutex::new(State { is_closed: false, question: None, answer: None }), bell: Condvar::new() }
    }
}

impl<M> Desk<M> {
    /// Hands a message over and waits to hear whether to go on. One asks at a time.
    pub fn ask(&self, message: M) -> bool {
        let mut state = self.state.lock().unwrap();
        state.question = Some(message);
        self.bell.notify_all();
        let mut state = self.bell.wait_while(state, |s| s.answer.is_none()).unwrap();
        state.answer.take().unwrap_or(false)
    }

    fn reply(&self, answer: bool) {
        self.state.lock().unwrap().answer = Some(answer);
        self.bell.notify_all();
    }

    fn close(&self) {
        self.state.lock().unwrap().is_closed = true;
        self.bell.notify_all();
    }

    /// Waits for a question or the end, at most a tick.
    fn wait(&self) -> Heard<M> {
        let quiet = |s: &mut State<M>| !s.is_closed && s.question.is_none();
        let mut state = self.bell.wait_timeout_while(self.state.lock().unwrap(), TICK, quiet).unwrap().0;
        match state.question.take() {
            Some(question) => Heard::Question(question),
            None if state.is_closed => Heard::End,
            None => Heard::Nothing,
        }
    }
}

fn listen(py: Python<'_>, progress: Option<&Bound<'_, PyAny>>, control: &Control) -> PyResult<()> {
    py.check_signals()?;
    if let Some(progress) = progress {
        progress.call1(control.progress())?;
    }
    Ok(())
}

fn message(panic: &(dyn std::any::Any + Send)) -> &str {
    panic
        .downcast_ref::<&str>()
        .copied()
        .or_else(|| panic.downcast_ref::<String>().map(String::as_str))
        .unwrap_or("unknown panic")
}
