//! When a solver stops, what it says about itself, and who may look on.

use radiosity_operator::{Cancelled, Control};

/// When to stop, and who looks on.
#[derive(Clone, Copy)]
pub struct SolveOptions<'a> {
    /// Stop when every band's residual is below this, relative to what the solver's page says.
    pub tolerance: f64,
    /// Stop after this many iterations: products with the exchange, sweeps, shots.
    pub max_iterations: usize,
    /// Sees every iteration and may stop the solve.
    pub observer: Option<&'a Observer<'a>>,
}

impl Default for SolveOptions<'_> {
    fn default() -> Self {
        Self { tolerance: 1e-8, max_iterations: 1000, observer: None }
    }
}

/// Who looks on: is called by the thread that solves, which waits for the answer.
pub type Observer<'a> = dyn Fn(&Snapshot) -> Flow + Sync + 'a;

/// Whether to go on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Flow {
    /// Yes.
    Continue,
    /// No: the answer is what there is.
    Stop,
}

/// A solution on its way.
#[derive(Clone, Copy, Debug)]
pub struct Snapshot<'a> {
    /// Iterations so far.
    pub iteration: usize,
    /// The worst band's relative residual.
    pub residual: f64,
    /// Power that has arrived but was not sent on, as a share of what is emitted; where the solver knows it.
    pub unshot: Option<f64>,
    /// W/m2, elements x bands.
    pub radiosity: &'a [f64],
    /// Per band what irradiance is still to come, if it came evenly everywhere (Cohen et al. 1988), W/m2: for a
    /// picture, add the reflectance times this. Zero where the solver does not estimate it.
    pub ambient: &'a [f64],
}

/// Why a solver stopped.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stop {
    /// The tolerance is met.
    Converged,
    /// The iterations are spent; the answer has not converged.
    MaxIterations,
    /// The residual grew without bound, or the symmetric form is not positive definite: rows of the exchange sum to
    /// more than the area over the reflectance. The answer means nothing.
    Diverged,
    /// The observer wanted no more; the answer has not converged.
    Observer,
}

impl Stop {
    /// A word for tables and files.
    pub fn name(self) -> &'static str {
        match self {
            Stop::Converged => "converged",
            Stop::MaxIterations => "max_iterations",
            Stop::Diverged => "diverged",
            Stop::Observer => "observer",
        }
    }
}

/// How a solve went.
#[derive(Clone, Debug)]
pub struct SolveReport {
    /// Products with the exchange, sweeps or shots.
    pub iterations: usize,
    /// Work in products with the exchange, those before the first iteration included; a shot is one row of it.
    pub products: f64,
    /// The worst band's relative residual at the end.
    pub residual: f64,
    /// How it got there.
    pub history: History,
    /// Where the power went, shot by shot; of shooting alone.
    pub ledger: Option<Ledger>,
    /// Why it stopped.
    pub stop: Stop,
}

/// What was noted on the way, thinned to at most [`History::MOST`] entries, evenly from the start; and the last.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct History {
    /// Iterations before each note.
    pub iterations: Vec<usize>,
    /// The worst band's relative residual.
    pub residuals: Vec<f64>,
    /// Power that has arrived but was not sent on, as a share of what is emitted; empty where it is not known.
    pub unshot: Vec<f64>,
}

/// Power in W per band. What is emitted is absorbed, escaped or unshot.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Ledger {
    /// Emitted, and reflected of what came from outside the exchange.
    pub emitted: Vec<f64>,
    /// Sent on, what was reflected counting again at every reflection.
    pub shot: Vec<f64>,
    /// Of what was sent on, absorbed where it arrived.
    pub absorbed: Vec<f64>,
    /// Of what was sent on, what arrived nowhere.
    pub escaped: Vec<f64>,
    /// Arrived, and not sent on; less than nothing where more was shot than had arrived.
    pub unshot: Vec<f64>,
}

impl History {
    /// The most entries kept.
    pub const MOST: usize = 1024;

    fn note(&mut self, iteration: usize, residual: f64, unshot: Option<f64>) {
        if self.iterations.len() == Self::MOST {
            let keep = |k: &usize| k.is_multiple_of(2);
            self.residuals = (0..Self::MOST).filter(keep).map(|k| self.residuals[k]).collect();
            self.unshot = (0..self.unshot.len()).filter(keep).map(|k| self.unshot[k]).collect();
            self.iterations = (0..Self::MOST).filter(keep).map(|k| self.iterations[k]).collect();
        }
        self.iterations.push(iteration);
        self.residuals.push(residual);
        self.unshot.extend(unshot);
    }

    /// How many iterations apart notes are.
    fn stride(&self) -> usize {
        if self.iterations.len() > 1 { self.iterations[1] - self.iterations[0] } else { 1 }
    }
}

/// A relative residual so far above its start never comes back.
const DIVERGED: f64 = 1e6;

/// The report of a solve that is under way.
pub(crate) struct Track<'a> {
    options: &'a SolveOptions<'a>,
    control: &'a Control,
    report: SolveReport,
}

impl<'a> Track<'a> {
    pub fn new(options: &'a SolveOptions<'a>, control: &'a Control) -> Self {
        let report = SolveReport {
            iterations: 0,
            products: 0.0,
            residual: f64::INFINITY,
            history: History::default(),
            ledger: None,
            stop: Stop::MaxIterations,
        };
        Self { options, control, report }
    }

    /// Counts work in products.
    pub fn work(&mut self, products: f64) {
        self.report.products += products;
    }

    /// Notes where the solve is, radiosity and ambient term by `state`; true when it should stop.
    pub fn note(
        &mut self,
        residual: f64,
        unshot: Option<f64>,
        state: impl FnOnce() -> (Vec<f64>, Vec<f64>),
    ) -> Result<bool, Cancelled> {
        self.control.check()?;
        let (options, report) = (self.options, &mut self.report);
        report.residual = residual;
        let mut flow = Flow::Continue;
        if let Some(observer) = options.observer {
            let (radiosity, ambient) = state();
            let iteration = report.iterations;
            flow = observer(&Snapshot { iteration, residual, unshot, radiosity: &radiosity, ambient: &ambient });
            self.control.check()?;
        }
        let stop = if residual <= options.tolerance {
            Some(Stop::Converged)
        } else if residual > DIVERGED || residual.is_nan() {
            Some(Stop::Diverged)
        } else if flow == Flow::Stop {
            Some(Stop::Observer)
        } else if report.iterations >= options.max_iterations {
            Some(Stop::MaxIterations)
        } else {
            None
        };
        if stop.is_some() || report.iterations.is_multiple_of(report.history.stride()) {
            report.history.note(report.iterations, residual, unshot);
        }
        match stop {
            Some(stop) => report.stop = stop,
            None => report.iterations += 1,
        }
        Ok(stop.is_some())
    }

    /// Ends a solve that cannot go on.
    pub fn diverged(mut self) -> SolveReport {
        self.report.stop = Stop::Diverged;
        self.report
    }

    pub fn finish(self, ledger: Option<Ledger>) -> SolveReport {
        SolveReport { ledger, ..self.report }
    }
}
