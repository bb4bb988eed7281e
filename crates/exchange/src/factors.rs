//! Form factors of an enclosure by any method, as one symmetric operator.

use crate::enclosure::Enclosure;
use crate::exchange::Exchange;
use crate::hierarchy::{self, Check};
use crate::kernels::hemicube;
use crate::pairs::{self, Kernel, Tally};
use crate::quadrature::PlaneRule;
use crate::rows::Rows;
use crate::samples::Samples;
use crate::shots::{Shot, shoot};
use crate::specular::NotFollowed;
use radiosity_operator::{Cancelled, Control, Operator, Symmetric};
use radiosity_store::StoreError;
use std::sync::{Arc, OnceLock};
use std::time::Instant;

/// How form factors are found; one file in [`crate::kernels`] each.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Method {
    /// Per pair the cheapest method that meets the tolerance.
    Auto,
    /// Closed forms where edges are parallel or perpendicular, contour integrals to 1e-12 elsewhere.
    Analytic,
    /// Contour integrals to the tolerance.
    Contour,
    /// Nusselt's analog from `points^2` points of every side; none: as many as the tolerance needs.
    Nusselt {
        /// Points along each direction.
        points: Option<usize>,
    },
    /// Item buffers of hemicubes.
    Hemicube {
        /// Pixels along an edge.
        resolution: usize,
        /// Hemicubes a side; none: as many as the tolerance needs.
        positions: Option<usize>,
    },
    /// Rays, so many from every side.
    MonteCarlo {
        /// Rays a side.
        rays: u32,
    },
    /// Blocks of rank one between what is far apart, pairs between what is near: for a great many sides.
    Hierarchical,
}

/// What is asked.
#[derive(Clone, Copy, Debug)]
pub struct Settings {
    /// How.
    pub method: Method,
    /// The error allowed of a form factor and of a row sum.
    pub tolerance: f64,
    /// The same seed gives the same bytes.
    pub seed: u64,
    /// Bytes that may be taken.
    pub memory_limit: u64,
}

/// Why there are no form factors.
#[derive(Debug, thiserror::Error)]
pub enum Failure {
    /// Stopped on request.
    #[error("stopped on request")]
    Cancelled,
    /// They would not fit.
    #[error(
        "the form factors of {sides} sides may take {} and the limit is {}; raise the limit, use fewer patches{}",
        bytes(*needed), bytes(*limit), kept.remedy(*method)
    )]
    Memory {
        /// Sides.
        sides: usize,
        /// Bytes needed at most.
        needed: u64,
        /// Bytes allowed.
        limit: u64,
        /// How.
        method: Method,
        /// Where they were to be.
        kept: Kept,
    },
    /// The file they were to be in.
    #[error(transparent)]
    Store(#[from] StoreError),
    /// There are mirrors or clear glass.
    #[error(transparent)]
    Specular(#[from] NotFollowed),
}

/// Where form factors are to be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kept {
    /// In memory.
    InMemory,
    /// In a file.
    InFile,
}

impl Kept {
    /// What else can be done where memory does not suffice.
    fn remedy(self, method: Method) -> &'static str {
        match self {
            Kept::InMemory if is_by_blocks(method) => {
                ", or have them on disk: give checkpoint=, or an output that ends in .exchange"
            }
            Kept::InMemory => ", or solve without form factors",
            Kept::InFile if is_by_blocks(method) => ", or fewer threads",
            Kept::InFile => ", or a method that writes as it goes, such as auto",
        }
    }
}

/// A size in the unit that suits it.
fn bytes(size: u64) -> String {
    match size {
        0..1_000_000 => format!("{:.1} kB", size as f64 / 1e3),
        1_000_000..1_000_000_000 => format!("{:.1} MB", size as f64 / 1e6),
        _ => format!("{:.1} GB", size as f64 / 1e9),
    }
}

impl From<Cancelled> for Failure {
    fn from(_: Cancelled) -> Self {
        Failure::Cancelled
    }
}

/// What was done and how wrong it may be.
#[derive(Clone, Copy, Debug, Default)]
pub struct FactorReport {
    /// Pairs by kind and method, where pairs were measured one by one.
    pub tally: Tally,
    /// Links, where there are any.
    pub links: hierarchy::Tally,
    /// An estimate of the greatest error of a form factor, of the smaller side of a pair.
    pub estimated_error: f64,
    /// The greatest disagreement of what both ends of a pair measured, as a form factor of the smaller side; zero
    /// where pairs are measured once for both.
    pub disagreement: f64,
    /// Points, or hemicubes, or rays of every side.
    pub samples: u64,
    /// Wall time.
    pub seconds: f64,
}

/// Form factors between all sides.
pub struct FormFactors {
    /// The geometry.
    pub enclosure: Arc<Enclosure>,
    /// G = A F, m2.
    pub operator: Exchange,
    /// The standard error of G, m2, pair by pair, where rays found it.
    pub standard_error: Option<Symmetric>,
    /// What was done.
    pub report: FactorReport,
    /// What the numbers follow from, for files.
    pub settings: radiosity_store::Settings,
    /// Rows by independent rays, once somebody asks how wrong a product is.
    pub check: OnceLock<Check>,
    /// Row sums of G, m2, once they are known.
    pub sums: OnceLock<Vec<f64>>,
}

impl FormFactors {
    /// Row sums of G, m2.
    pub fn row_sums(&self) -> &[f64] {
        self.sums.get_or_init(|| self.operator.row_sums())
    }

    /// Rows by independent rays, to hold products against that no other error is known of.
    ///
    /// # Errors
    /// If it is cancelled.
    pub fn check(&self, control: &Control) -> Result<&Check, Cancelled> {
        if self.check.get().is_none() {
            let check = Check::new(&self.enclosure, self.report.estimated_error.max(LEAST_CHECKED), 0, control)?;
            let _ = self.check.set(check);
        }
        Ok(self.check.get().expect("just set"))
    }

    /// Each pair by itself.
    ///
    /// # Errors
    /// In words, where they are kept in blocks.
    pub fn pairs(&self) -> Result<&Symmetric, NotByPairs> {
        self.operator.pairs().ok_or(NotByPairs)
    }
}

/// Rows are not looked at more closely than for an error of this.
const LEAST_CHECKED: f64 = 2e-3;

/// What asks for single form factors of a hierarchical exchange.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the exchange is hierarchical and keeps no single form factors; measure them with method auto")]
pub struct NotByPairs;

/// Measures the form factors between all sides of an enclosure.
pub fn measure(enclosure: Arc<Enclosure>, settings: &Settings, control: &Control) -> Result<FormFactors, Failure> {
    let start = Instant::now();
    enclosure.without_specular("form factors")?;
    settings.check_memory(enclosure.sides(), Kept::InMemory)?;
    if settings.method == Method::Hierarchical {
        return Ok(by_links(enclosure, settings, &[], control)?);
    }
    let pairs = |kernel: Kernel| -> Result<_, Failure> {
        let of_pairs = pairs::Settings { kernel, tolerance: settings.tolerance, seed: settings.seed };
        let (operator, tally) = pairs::measure(&enclosure, &of_pairs, control)?;
        Ok((operator, None, settings.report_of_pairs(tally)))
    };
    let (operator, standard_error, report) = match settings.method {
        Method::Auto => pairs(Kernel::Auto)?,
        Method::Analytic => pairs(Kernel::Analytic)?,
        Method::Contour => pairs(Kernel::Contour)?,
        Method::Nusselt { points: Some(points) } => pairs(Kernel::Nusselt(PlaneRule::new(points)))?,
        Method::Nusselt { points: None } => {
            let mut points = 2;
            let mut before = pairs(Kernel::Nusselt(PlaneRule::new(points)))?;
            loop {
                points *= 2;
                let (operator, none, report) = pairs(Kernel::Nusselt(PlaneRule::new(points)))?;
                let estimated_error = greatest_change(&enclosure, &before.0, &operator);
                let samples = (points * points) as u64;
                before = (operator, none, FactorReport { estimated_error, samples, ..report });
                if estimated_error <= settings.tolerance || points >= MOST_POINTS {
                    break before;
                }
            }
        }
        Method::Hemicube { resolution, positions } => {
            by_hemicubes(&enclosure, resolution, positions, settings, control)?
        }
        Method::MonteCarlo { rays } => by_rays(&enclosure, rays, settings.seed, control)?,
        Method::Hierarchical => unreachable!("dealt with before"),
    };
    let report = FactorReport { seconds: start.elapsed().as_secs_f64(), ..report };
    let named = settings.named(enclosure.patches());
    Ok(FormFactors {
        enclosure,
        operator: Exchange::Pairs(operator),
        standard_error,
        report,
        settings: named,
        check: OnceLock::new(),
        sums: OnceLock::new(),
    })
}

/// Links and near pairs, and how wrong they are by independent rays. For `importance` see [`hierarchy::measure`].
///
/// # Errors
/// If it is cancelled.
pub fn by_links(
    enclosure: Arc<Enclosure>,
    settings: &Settings,
    importance: &[f64],
    control: &Control,
) -> Result<FormFactors, Cancelled> {
    let start = Instant::now();
    let of_links = hierarchy::Settings::new(settings.tolerance, settings.seed);
    let (operator, links, tally) = hierarchy::measure(&enclosure, &of_links, importance, control)?;
    let report = report_of_links(&enclosure, &operator.row_sums(), settings, (links, tally), control)?;
    let report = FactorReport { seconds: start.elapsed().as_secs_f64(), ..report };
    let named = settings.named(enclosure.patches());
    Ok(FormFactors {
        enclosure,
        operator: Exchange::Links(operator),
        standard_error: None,
        report,
        settings: named,
        check: OnceLock::new(),
        sums: OnceLock::new(),
    })
}

/// What is said of a hierarchical exchange: its error is that of its row sums.
pub(crate) fn report_of_links(
    enclosure: &Enclosure,
    row_sums: &[f64],
    settings: &Settings,
    (links, tally): (hierarchy::Tally, Tally),
    control: &Control,
) -> Result<FactorReport, Cancelled> {
    let check = Check::new(enclosure, settings.tolerance, settings.seed, control)?;
    let area = |side: usize| enclosure.area(side);
    let sums: Vec<f64> =
        row_sums.iter().enumerate().map(|(side, sum)| if area(side) > 0.0 { sum / area(side) } else { 0.0 }).collect();
    let found = check.deviations(&vec![1.0; sums.len()], &sums, 1)[0];
    Ok(FactorReport { tally, links, estimated_error: found.error, ..Default::default() })
}

/// Whether a method measures pair by pair, once.
pub(crate) fn is_by_pairs(method: Method) -> bool {
    matches!(method, Method::Auto | Method::Analytic | Method::Contour | Method::Nusselt { points: Some(_) })
}

/// Whether a method builds blocks that can be written as they are done.
fn is_by_blocks(method: Method) -> bool {
    is_by_pairs(method) || method == Method::Hierarchical
}

impl Settings {
    /// What is asked of pairs, where they are measured one by one.
    pub(crate) fn of_pairs(&self) -> Option<pairs::Settings> {
        let kernel = match self.method {
            Method::Auto => Kernel::Auto,
            Method::Analytic => Kernel::Analytic,
            Method::Contour => Kernel::Contour,
            Method::Nusselt { points: Some(points) } => Kernel::Nusselt(PlaneRule::new(points)),
            _ => return None,
        };
        Some(pairs::Settings { kernel, tolerance: self.tolerance, seed: self.seed })
    }

    /// What is said of pairs that were measured one by one.
    pub(crate) fn report_of_pairs(&self, tally: Tally) -> FactorReport {
        let disagreement = tally.disagreement;
        let (estimated_error, samples) = match self.method {
            // Of fixed points only the disagreement of both ends is known.
            Method::Nusselt { points: Some(points) } => (disagreement, (points * points) as u64),
            _ => (tally.worst_error.max(0.5 * self.tolerance), 0),
        };
        FactorReport { tally, estimated_error, disagreement, samples, ..Default::default() }
    }

    /// Refuses what may take more memory than allowed.
    pub(crate) fn check_memory(&self, sides: usize, kept: Kept) -> Result<(), Failure> {
        let Settings { method, memory_limit: limit, .. } = *self;
        let needed = match kept {
            Kept::InFile if is_by_blocks(method) => pairs::least_forecast(sides, rayon::current_num_threads()),
            Kept::InFile if method == Method::Hierarchical => hierarchy::least_forecast(sides),
            _ => forecast(sides, self),
        };
        if needed <= limit { Ok(()) } else { Err(Failure::Memory { sides, needed, limit, method, kept }) }
    }
}

/// Nusselt's analog stops at so many points in each direction, whatever the tolerance.
pub const MOST_POINTS: usize = 32;

/// Bytes that a method may take at most.
fn forecast(sides: usize, settings: &Settings) -> u64 {
    let all_pairs = pairs::forecast(sides);
    match settings.method {
        Method::Hierarchical => hierarchy::forecast(sides, &hierarchy::Settings::new(settings.tolerance, 0)),
        // A ray's shot, and an entry for it in two operators.
        Method::MonteCarlo { rays } => {
            sides as u64 * u64::from(rays) * 8 + (24 * sides as u64 * u64::from(rays)).min(3 * all_pairs)
        }
        // Rows of both ends, twice while their number is doubled, beside the pairs.
        Method::Hemicube { .. } => 5 * all_pairs,
        _ => all_pairs,
    }
}

/// The greatest difference of two operators on the same sides, as a form factor of the smaller side.
fn greatest_change(enclosure: &Enclosure, a: &Symmetric, b: &Symmetric) -> f64 {
    // Over the pairs of one; what only the other has is found the other way round.
    let one_way = |from: &Symmetric, to: &Symmetric| {
        let (offsets, columns, values) = to.to_csr();
        let mut worst = 0.0f64;
        from.for_each_pair(|i, j, value| {
            let row = offsets[i]..offsets[i + 1];
            let other = columns[row.clone()].binary_search(&(j as u32)).map_or(0.0, |k| values[row.start + k]);
            worst = worst.max((value - other).abs() / enclosure.area(i).min(enclosure.area(j)));
        });
        worst
    };
    one_way(a, b).max(one_way(b, a))
}

type Measured = (Symmetric, Option<Symmetric>, FactorReport);

/// Hemicubes stop at so many positions on a side, whatever the tolerance.
pub const MOST_POSITIONS: usize = 256;

/// Rows by hemicubes. Where a tolerance says how many, their number is doubled until the old half and the new agree.
fn by_hemicubes(
    enclosure: &Enclosure,
    resolution: usize,
    positions: Option<usize>,
    settings: &Settings,
    control: &Control,
) -> Result<Measured, Failure> {
    let draw = |positions: usize, round: u64| -> Result<Rows, Failure> {
        control.expect(enclosure.sides() as u64);
        let seed = settings.seed.wrapping_add(round.wrapping_mul(0x9e37_79b9_7f4a_7c15));
        Ok(hemicube::rows(enclosure, &hemicube::Settings { resolution, positions, seed }, control)?)
    };
    if let Some(positions) = positions {
        let (operator, disagreement) = symmetric(enclosure, &draw(positions, 0)?);
        let samples = positions as u64;
        let report = FactorReport { estimated_error: disagreement, disagreement, samples, ..Default::default() };
        return Ok((operator, None, report));
    }
    let (mut rows, mut positions) = (draw(FIRST_POSITIONS, 0)?, FIRST_POSITIONS);
    for round in 1.. {
        let new = draw(positions, round)?;
        let (old_half, _) = symmetric(enclosure, &rows);
        let (new_half, _) = symmetric(enclosure, &new);
        let estimated_error = 0.5 * greatest_change(enclosure, &old_half, &new_half);
        rows = mean(&rows, &new);
        positions *= 2;
        if estimated_error <= settings.tolerance || positions >= MOST_POSITIONS {
            let (operator, disagreement) = symmetric(enclosure, &rows);
            let samples = positions as u64;
            let report = FactorReport { estimated_error, disagreement, samples, ..Default::default() };
            return Ok((operator, None, report));
        }
    }
    unreachable!("the loop ends by returning")
}

/// Hemicubes a side to begin with.
const FIRST_POSITIONS: usize = 4;

/// The mean of two sets of rows.
fn mean(a: &Rows, b: &Rows) -> Rows {
    let row = |side: usize| {
        let mut row = Vec::new();
        merge(a.row(side), b.row(side), |j, x, y| row.push((j, 0.5 * (x + y))));
        row
    };
    Rows::from_rows((0..a.len()).map(row).collect())
}

/// Independent replicates of the rows.
const REPLICATES: u32 = 4;

/// Rows by rays from both ends: the inverse-variance mean of the two, which is all hits of a pair over the sum of the
/// densities of rays. The standard error is that of as many independent rays, which points in sequence stay below.
fn by_rays(enclosure: &Enclosure, rays: u32, seed: u64, control: &Control) -> Result<Measured, Failure> {
    let sides = enclosure.sides();
    control.expect(u64::from(rays) * sides as u64);
    let mut shots = Samples::<Shot>::new(sides, REPLICATES as usize);
    let each = rays.div_ceil(REPLICATES);
    shoot(enclosure, &mut shots, &vec![each; sides], seed, control)?;
    let share = 1.0 / f64::from(each * REPLICATES);
    let row = |side: usize| -> Vec<(u32, f64)> {
        let mut found: Vec<u32> = shots.of(side).flatten().filter(|s| s.landed()).map(Shot::target).collect();
        found.sort_unstable();
        found.chunk_by(|a, b| a == b).map(|run| (run[0], run.len() as f64 * share)).collect()
    };
    use rayon::prelude::*;
    let rows = Rows::from_rows((0..sides).into_par_iter().map(row).collect());
    let (operator, disagreement) = symmetric(enclosure, &rows);
    // Hits of a pair from both ends, n: G is n / density and its standard error sqrt(n (1 - F)) / density.
    let density = |i: usize, j: usize| (1.0 / enclosure.area(i) + 1.0 / enclosure.area(j)) / share;
    let error = |i: usize, j: usize, g: f64| {
        let f = (g / enclosure.area(i).min(enclosure.area(j))).min(1.0);
        (g * density(i, j) * (1.0 - f)).max(0.25).sqrt() / density(i, j)
    };
    let standard_error = operator.mapped(error);
    let mut worst = 0.0f64;
    standard_error.for_each_pair(|i, j, e| worst = worst.max(e / enclosure.area(i).min(enclosure.area(j))));
    let samples = u64::from(each * REPLICATES);
    let report = FactorReport { estimated_error: worst, disagreement, samples, ..Default::default() };
    Ok((operator, Some(standard_error), report))
}

/// One exchange from the rows of both ends, and their greatest disagreement as a form factor of the smaller side.
///
/// The smaller side knows better what it exchanges, as it sees the other from nearly one point: ends weigh by the
/// inverse of their area. For equally many rays from both this is the inverse-variance mean.
pub fn symmetric(enclosure: &Enclosure, rows: &Rows) -> (Symmetric, f64) {
    let sides = rows.len();
    let area = |side: usize| enclosure.area(side);
    // Entries from below the diagonal, dealt to the rows above it: in ascending order by construction.
    let mut from_below: Vec<Vec<(u32, f64)>> = vec![Vec::new(); sides];
    for i in 0..sides {
        for &(j, f) in rows.row(i).iter().filter(|e| (e.0 as usize) < i) {
            from_below[j as usize].push((i as u32, f));
        }
    }
    let mut disagreement = 0.0f64;
    let mut upper = Vec::with_capacity(sides);
    for (i, below) in from_below.iter().enumerate() {
        let above: Vec<(u32, f64)> = rows.row(i).iter().filter(|e| e.0 as usize > i).copied().collect();
        let mut row = Vec::with_capacity(above.len().max(below.len()));
        merge(&above, below, |j, here, there| {
            let (a, b) = (area(i), area(j as usize));
            let (g, h) = (a * here, b * there);
            disagreement = disagreement.max((g - h).abs() / a.min(b));
            row.push((j, (g * b + h * a) / (a + b)));
        });
        upper.push(row);
    }
    (Symmetric::from_sparse_rows(&upper), disagreement)
}

/// Walks two lists in ascending order together.
fn merge(a: &[(u32, f64)], b: &[(u32, f64)], mut visit: impl FnMut(u32, f64, f64)) {
    let (mut k, mut l) = (0, 0);
    while k < a.len() || l < b.len() {
        let j = a.get(k).map_or(u32::MAX, |e| e.0).min(b.get(l).map_or(u32::MAX, |e| e.0));
        let take = |list: &[(u32, f64)], at: &mut usize| match list.get(*at) {
            Some(&(column, value)) if column == j => {
                *at += 1;
                value
            }
            _ => 0.0,
        };
        let (x, y) = (take(a, &mut k), take(b, &mut l));
        visit(j, x, y);
    }
}
