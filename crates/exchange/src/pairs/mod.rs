//! Form factors of all pairs of facets, each by the method that suits it.
//!
//! For every leaf of facets the tree over the others is walked down, and the list of blockers that may stand between
//! shrinks on the way; where none is left the whole of a leaf is seen by the whole of the other. Then pair by pair:
//!
//! 1. **Horizons.** What is behind the other's plane is cut off; pairs of which nothing is left do not exchange.
//! 2. **Unoccluded exchange.** Gauss points on both areas where they are apart, contours where they are near or touch.
//! 3. **Occlusion.** Full, none or partial, decided so that it errs toward partial; of partial pairs the hidden part
//!    is taken off: by a few rays where these tell enough, else integrated.
//!
//! Errors: `tolerance` T is shared so that each F_ij is within T and each row sum is too. A pair seen in full may err by
//! `T F_ij / 2`, all in one direction. Partial pairs err in either direction: `T sqrt(F_ij) / 4` each makes no more than
//! `T / 4` of a row, root mean square.

mod nodes;
mod occlusion;
mod selection;

use crate::convex::{range, split};
use crate::enclosure::Enclosure;
use crate::facets::{Bounds, Facet, Facets, Grouping, LEAF, Node};
use crate::factors::Failure;
use crate::kernels::areas::{ORDERS, Orders, Separation, areas};
use crate::kernels::contour::{contour, is_closed_form};
use crate::kernels::nusselt::nusselt;
use crate::quadrature::PlaneRule;
use crate::visibility::fragments::Fragments;
use crate::visibility::hidden::{End, Hidden};
use crate::visibility::rays::{Points, Rays};
use crate::visibility::shaft::{Sight, between};
use crate::visibility::{Blockers, Shaft};
use glam::DVec3;
use nodes::Nodes;
use occlusion::Ends;
use radiosity_operator::{Block, Cancelled, Control, Precision, Symmetric};
use radiosity_store::{Keep, in_order};
pub(crate) use selection::Selection;
use std::sync::Arc;

/// The method for what two facets exchange unoccluded.
#[derive(Clone, Debug)]
pub enum Kernel {
    /// The cheapest that meets the tolerance.
    Auto,
    /// Contour integrals for every pair.
    Contour,
    /// Contour integrals in closed form where edges are parallel or perpendicular, else to 1e-12.
    Analytic,
    /// Nusselt's analog from the points of a rule on each facet, and the mean of what both ends measure.
    Nusselt(PlaneRule),
}

/// What is asked.
#[derive(Clone, Debug)]
pub struct Settings {
    /// How.
    pub kernel: Kernel,
    /// The error allowed of a form factor and of a row sum.
    pub tolerance: f64,
    /// Of the rays between pairs.
    pub seed: u64,
}

/// What was done, in pairs.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Tally {
    /// Seen in full.
    pub full: u64,
    /// Hidden in part.
    pub partial: u64,
    /// Hidden by one blocker.
    pub hidden: u64,
    /// By Gauss points on both areas.
    pub by_areas: u64,
    /// By contour integrals.
    pub by_contour: u64,
    /// Hidden parts by rays.
    pub by_rays: u64,
    /// Rays cast.
    pub rays: u64,
    /// Partial pairs whose integration ended before the error was what they were allowed.
    pub unresolved: u64,
    /// The greatest error estimate of a form factor among partial pairs.
    pub worst_error: f64,
    /// The greatest disagreement of both ends' measurements, as a form factor of the smaller facet.
    pub disagreement: f64,
}

impl Tally {
    fn count(&mut self, sight: Sight) {
        match sight {
            Sight::Full => self.full += 1,
            Sight::None => self.hidden += 1,
            Sight::Partial => self.partial += 1,
        }
    }

    /// Both together.
    pub fn plus(self, other: Self) -> Self {
        Self {
            full: self.full + other.full,
            partial: self.partial + other.partial,
            hidden: self.hidden + other.hidden,
            by_areas: self.by_areas + other.by_areas,
            by_contour: self.by_contour + other.by_contour,
            by_rays: self.by_rays + other.by_rays,
            rays: self.rays + other.rays,
            unresolved: self.unresolved + other.unresolved,
            worst_error: self.worst_error.max(other.worst_error),
            disagreement: self.disagreement.max(other.disagreement),
        }
    }
}

/// Bytes that all pairs of so many sides may take.
pub fn forecast(sides: usize) -> u64 {
    let n = sides as u64;
    4 * n * n.saturating_sub(1) + points_forecast(sides)
}

/// Bytes that the points of so many sides may take.
fn points_forecast(sides: usize) -> u64 {
    (Nodes::forecast(sides) + Points::forecast(sides)) as u64
}

/// Bytes that a leaf's pairs with all others take at most.
fn block_forecast(sides: usize) -> u64 {
    8 * (LEAF * sides) as u64
}

/// Bytes that it takes to build pairs onto a file on so many threads, of which no block waits for another.
pub fn least_forecast(sides: usize, threads: usize) -> u64 {
    points_forecast(sides) + (threads as u64 + 1) * block_forecast(sides)
}

/// How many blocks may be built or wait at a time within a limit of memory: some a thread, and one at least.
pub fn window(sides: usize, threads: usize, memory_limit: u64) -> usize {
    let left = memory_limit.saturating_sub(least_forecast(sides, threads)) / block_forecast(sides).max(1);
    (1 + left).min(8 * threads as u64) as usize
}

/// The exchange of all pairs, by the numbers of the sides.
pub fn measure(enclosure: &Enclosure, settings: &Settings, control: &Control) -> Result<(Symmetric, Tally), Cancelled> {
    let pairs = Pairs::new(enclosure, settings);
    let mut measured: Vec<PairBlock> = Vec::with_capacity(pairs.blocks());
    match pairs.measure_onto(&mut measured, usize::MAX >> 1, control) {
        Ok(()) => {}
        Err(Failure::Cancelled) => return Err(Cancelled),
        Err(other) => unreachable!("memory takes all blocks: {other}"),
    }
    let tally = measured.iter().fold(Tally::default(), |sum, m| sum.plus(m.tally));
    let blocks = measured.into_iter().map(|m| m.block).collect();
    Ok((Symmetric::from_blocks(enclosure.sides(), pairs.order(), blocks), tally))
}

/// The pairs of a leaf of facets with all facets after them.
pub struct PairBlock {
    /// What was done.
    pub tally: Tally,
    /// What they exchange.
    pub block: Block,
}

/// All pairs of an enclosure, to be measured leaf by leaf in the order of the facets.
pub struct Pairs<'a> {
    scene: Scene<'a>,
    leaves: Vec<usize>,
    precision: Precision,
}

impl<'a> Pairs<'a> {
    /// Lays out what all pairs need.
    pub fn new(enclosure: &'a Enclosure, settings: &'a Settings) -> Self {
        let facets = Facets::new(enclosure, Grouping::OF_PAIRS, LEAF);
        let blockers = Arc::new(Blockers::new(enclosure, facets.extent));
        let scene = Scene::new(enclosure, facets, blockers, settings);
        let is_rough = matches!(settings.kernel, Kernel::Auto) && settings.tolerance >= SINGLE_ABOVE;
        let precision = if is_rough { Precision::Single } else { Precision::Double };
        Self { leaves: scene.facets.leaves().collect(), precision, scene }
    }

    /// The number of blocks, one a leaf.
    pub fn blocks(&self) -> usize {
        self.leaves.len()
    }

    /// Position in the matrix -> number of the side.
    pub fn order(&self) -> Vec<u32> {
        self.scene.facets.list.iter().map(|f| f.side).collect()
    }

    /// Measures the blocks that are not kept yet and hands them over in order, `window` at a time.
    ///
    /// # Errors
    /// If it is cancelled, or a block cannot be kept.
    pub fn measure_onto(
        &self,
        keep: &mut impl Keep<PairBlock>,
        window: usize,
        control: &Control,
    ) -> Result<(), Failure> {
        let pairs_of = |leaf: usize| -> usize {
            let n = self.scene.facets.list.len();
            self.scene.facets.nodes[leaf].range.clone().map(|i| n - 1 - i).sum()
        };
        let first = keep.kept();
        control.expect(self.leaves.iter().map(|&leaf| pairs_of(leaf) as u64).sum());
        control.advance(self.leaves[..first].iter().map(|&leaf| pairs_of(leaf) as u64).sum());
        let build = |scratch: &mut Scratch, k: usize| self.block(self.leaves[k], scratch, control);
        in_order(first..self.leaves.len(), window, Scratch::default, build, |_, block| Ok(keep.keep(block)?))
    }

    fn block(&self, leaf: usize, scratch: &mut Scratch, control: &Control) -> Result<PairBlock, Failure> {
        control.check()?;
        let rows = self.scene.facets.nodes[leaf].range.clone();
        let mut task = Task::new(&self.scene, leaf, scratch);
        task.walk_all(control)?;
        task.tally.rays = std::mem::take(&mut task.scratch.rays.cast);
        control.advance(task.values.len() as u64);
        // Packed while it is at hand, which is soonest, and so that sparse rows never take dense memory at once.
        let block = Block::new(self.scene.facets.list.len(), rows, &task.values, self.precision);
        let tally = task.tally;
        scratch.values = task.values;
        Ok(PairBlock { tally, block })
    }
}

/// What all tasks read.
struct Scene<'a> {
    enclosure: &'a Enclosure,
    facets: Facets,
    blockers: Arc<Blockers>,
    nodes: Nodes,
    points: Points,
    orders: Orders,
    settings: &'a Settings,
    /// Per facet, how much more than the mean what it sends matters; empty where all matter alike.
    importance: Vec<f64>,
}

impl<'a> Scene<'a> {
    fn new(enclosure: &'a Enclosure, facets: Facets, blockers: Arc<Blockers>, settings: &'a Settings) -> Self {
        let is_auto = matches!(settings.kernel, Kernel::Auto);
        let when = |needed: bool| if needed { facets.list.as_slice() } else { &[] };
        Self {
            enclosure,
            nodes: Nodes::new(when(is_auto)),
            points: Points::new(enclosure, when(is_auto && !blockers.list.is_empty()), settings.seed),
            blockers,
            orders: Orders::new(0.5 * settings.tolerance),
            facets,
            settings,
            importance: Vec::new(),
        }
    }

    /// How much more than the mean matters what two facets exchange.
    fn importance_of(&self, i: usize, j: usize) -> f64 {
        self.importance.get(i).map_or(1.0, |w| w.max(self.importance[j]).max(1.0))
    }
}

/// Buffers of a worker.
#[derive(Default)]
pub(crate) struct Scratch {
    /// What a leaf exchanges, when no leaf is at hand.
    values: Vec<f64>,
    /// Lists of blockers that are not in use.
    lists: Vec<Vec<u32>>,
    hidden: Hidden,
    rays: Rays,
    fragments: Fragments,
    /// Polygons cut at horizons, and what is cut off.
    first: Vec<DVec3>,
    second: Vec<DVec3>,
    behind: Vec<DVec3>,
    heights: Vec<f64>,
    /// Pairs of one facet that Gauss points serve, and their exchange.
    batch: Vec<(u32, u8)>,
    exchange: Vec<f64>,
}

impl Scratch {
    fn take_list(&mut self) -> Vec<u32> {
        self.lists.pop().unwrap_or_default()
    }
}

/// All pairs of one leaf with itself and the leaves after it.
struct Task<'a> {
    scene: &'a Scene<'a>,
    scratch: &'a mut Scratch,
    node: &'a Node,
    /// The exchange of the rows of the leaf with all columns above the diagonal, row after row.
    values: Vec<f64>,
    tally: Tally,
}

/// Whether a set of points is in front of a plane.
#[derive(Clone, Copy, PartialEq)]
enum Side {
    Front,
    Behind,
    Across,
}

/// Points in each direction of polygons whose points are not laid out beforehand: contours are cheaper than more.
const MOST_POINTS_OF_PARTS: usize = 4;

/// From this tolerance on what is stored is rounded to single precision, to 6e-8 of each.
const SINGLE_ABOVE: f64 = 1e-5;

/// A tolerance at which rays tell of nearly all pairs.
const LOOSE: f64 = 3e-3;

/// An order so cheap that it is not worth finding out for which pairs a cheaper one would do.
const CHEAP_ORDER: usize = 1;

/// Where so much error is allowed, relative to the unoccluded exchange, some ten rays tell of most pairs.
const FEW_RAYS_ERROR: f64 = 0.04;

/// The share of the tolerance that the errors of partial pairs may take of a row, root mean square: with thousands of
/// rows the worst is four times that.
const PARTIAL_SHARE: f64 = 0.25;

/// Coordinates of points meant to lie in a plane are off by rounding: relative to the scene.
const ROUNDING: f64 = 1e-13;

impl<'a> Task<'a> {
    fn new(scene: &'a Scene<'a>, leaf: usize, scratch: &'a mut Scratch) -> Self {
        let node = &scene.facets.nodes[leaf];
        let n = scene.facets.list.len();
        let count = node.range.clone().map(|i| n - 1 - i).sum();
        let mut values = std::mem::take(&mut scratch.values);
        values.clear();
        values.resize(count, 0.0);
        Self { scene, scratch, node, values, tally: Tally::default() }
    }

    fn walk_all(&mut self, control: &Control) -> Result<(), Cancelled> {
        let all: Vec<u32> = (0..self.scene.blockers.list.len() as u32).collect();
        self.walk(0, &all, control)
    }

    /// Walks down to the leaves at or after this task's, with the blockers that may matter.
    fn walk(&mut self, node: usize, candidates: &[u32], control: &Control) -> Result<(), Cancelled> {
        let target = &self.scene.facets.nodes[node];
        if target.range.end <= self.node.range.start {
            return Ok(());
        }
        let mut list = self.scratch.take_list();
        list.clear();
        if !candidates.is_empty() {
            let shaft = Shaft::new(self.node.bounds, target.bounds, self.scene.blockers.contact);
            let mut admitted =
                candidates.iter().copied().filter(|&k| shaft.admits(&self.scene.blockers.list[k as usize]));
            if target.children.is_none() && self.scene.settings.tolerance >= LOOSE {
                // Rays will tell of nearly all pairs: what matters is whether anything may be between.
                if admitted.next().is_some() {
                    list.extend_from_slice(candidates);
                }
            } else {
                list.extend(admitted);
            }
        }
        let walked = match target.children {
            Some(children) => children.into_iter().try_for_each(|c| self.walk(c, &list, control)),
            None => {
                self.leaf(target, &list);
                control.check()
            }
        };
        self.scratch.lists.push(list);
        walked
    }

    /// All pairs with one leaf.
    fn leaf(&mut self, target: &Node, candidates: &[u32]) {
        let facets = &self.scene.facets.list;
        let from_there: Vec<(f64, f64)> =
            target.range.clone().map(|j| heights_of(&facets[j], &self.node.bounds)).collect();
        let from_here: Vec<(f64, f64)> =
            self.node.range.clone().map(|i| heights_of(&facets[i], &target.bounds)).collect();
        let contact = self.scene.blockers.contact;
        let all_behind = |heights: &[(f64, f64)]| heights.iter().all(|h| h.1 <= contact);
        if all_behind(&from_here) || all_behind(&from_there) {
            return;
        }
        if candidates.is_empty()
            && let Some(order) = self.order_for_all(target, &from_here, &from_there)
        {
            return self.all_in_view(target, order);
        }
        for (i, &(low, high)) in self.node.range.clone().zip(&from_here) {
            let side = self.judge(low, high);
            if side == Side::Behind {
                continue;
            }
            self.scratch.batch.clear();
            for (j, &(low, high)) in target.range.clone().zip(&from_there).filter(|(j, _)| *j > i) {
                match self.judge(low, high) {
                    Side::Behind => {}
                    Side::Front if side == Side::Front => self.in_front(i, j, candidates),
                    _ => self.across(i, j, candidates),
                }
            }
            self.finish_batch(i, candidates);
        }
    }

    /// The order that serves all pairs with a leaf which is wholly in front and they of it, if one does.
    fn order_for_all(&self, target: &Node, here: &[(f64, f64)], there: &[(f64, f64)]) -> Option<usize> {
        let all = |heights: &[(f64, f64)]| range(heights.iter().flat_map(|&(low, high)| [low, high]));
        let (here, there) = (all(here), all(there));
        let in_front = here.0 >= 0.0 && there.0 >= 0.0;
        if !(in_front && matches!(self.scene.settings.kernel, Kernel::Auto)) {
            return None;
        }
        let (near, far) = self.node.bounds.distances_squared(&target.bounds);
        let (small, large) = (self.node.radii.0 + target.radii.0, self.node.radii.1 + target.radii.1);
        let choose = |distance_squared: f64, radii: f64, heights: (f64, f64)| {
            self.scene.orders.choose(&Separation { distance_squared, radii, heights, little: 0.0 })
        };
        let enough = choose(near, large, (here.0, there.0))?;
        (enough <= CHEAP_ORDER || Some(enough) == choose(far, small, (here.1, there.1))).then_some(enough)
    }

    /// What [`Separation`] calls little: a tenth of an equal share of all that the smaller facet sends. So little may
    /// err by the tolerance times that, and a row of it by a tenth of the tolerance.
    fn little(&self, a: &Facet, b: &Facet) -> f64 {
        0.1 * std::f64::consts::PI / (self.scene.facets.list.len() as f64 * a.area.max(b.area))
    }

    /// All pairs with a leaf by one order, nothing between.
    fn all_in_view(&mut self, target: &Node, order: usize) {
        for i in self.node.range.clone() {
            let run = target.range.start.max(i + 1)..target.range.end;
            let count = run.len();
            self.tally.full += count as u64;
            self.tally.by_areas += count as u64;
            if count > 0 {
                let at = self.index(i, run.start);
                self.scene.nodes.run(i, run, order, &mut self.values[at..at + count]);
            }
        }
    }

    fn judge(&self, low: f64, high: f64) -> Side {
        if high <= self.scene.blockers.contact {
            Side::Behind
        } else if low >= -ROUNDING * self.scene.facets.extent {
            Side::Front
        } else {
            Side::Across
        }
    }

    /// A pair of which the boxes did not tell.
    fn across(&mut self, i: usize, j: usize, candidates: &[u32]) {
        let (a, b) = (&self.scene.facets.list[i], &self.scene.facets.list[j]);
        let side = |plane: &Facet, of: &Facet| {
            let (low, high) = range(of.corners().iter().map(|&c| plane.height(c)));
            self.judge(low, high)
        };
        match (side(a, b), side(b, a)) {
            (Side::Behind, _) | (_, Side::Behind) => {}
            (Side::Front, Side::Front) => self.in_front(i, j, candidates),
            _ => self.cut_and_measure(i, j, candidates),
        }
    }

    /// A pair wholly in front of each other.
    fn in_front(&mut self, i: usize, j: usize, candidates: &[u32]) {
        let (a, b) = (&self.scene.facets.list[i], &self.scene.facets.list[j]);
        let r = b.centre - a.centre;
        let (h1, h2) = (a.normal.dot(r), -b.normal.dot(r));
        // Boxes may be in front where this facet lies in the other's plane. Its middle is a quarter as high at least.
        if h1.min(h2) <= 0.25 * self.scene.blockers.contact {
            return;
        }
        if matches!(self.scene.settings.kernel, Kernel::Auto) {
            let order = self.scene.orders.choose(&Separation {
                distance_squared: r.length_squared(),
                radii: a.radius + b.radius,
                heights: (h1, h2),
                little: self.little(a, b),
            });
            if let Some(order) = order {
                self.scratch.batch.push((j as u32, order as u8));
                return;
            }
        }
        let (first, second) = (End { facet: a, polygon: a.corners() }, End { facet: b, polygon: b.corners() });
        self.measure(i, j, first, second, candidates);
    }

    /// A pair of which only parts are in front of each other.
    fn cut_and_measure(&mut self, i: usize, j: usize, candidates: &[u32]) {
        let (a, b) = (&self.scene.facets.list[i], &self.scene.facets.list[j]);
        let (mut first, mut second) =
            (std::mem::take(&mut self.scratch.first), std::mem::take(&mut self.scratch.second));
        for (of, plane, front) in [(a, b, &mut first), (b, a, &mut second)] {
            self.scratch.heights.clear();
            self.scratch.heights.extend(of.corners().iter().map(|&c| plane.height(c)));
            split(of.corners(), &self.scratch.heights, front, &mut self.scratch.behind);
        }
        if first.len() >= 3 && second.len() >= 3 {
            let (first, second) = (End { facet: a, polygon: &first }, End { facet: b, polygon: &second });
            self.measure(i, j, first, second, candidates);
        }
        (self.scratch.first, self.scratch.second) = (first, second);
    }

    /// A pair with what may be between.
    fn measure(&mut self, i: usize, j: usize, first: End, second: End, candidates: &[u32]) {
        let value = if let Kernel::Nusselt(rule) = &self.scene.settings.kernel {
            self.by_nusselt(first, second, rule, candidates)
        } else {
            let (whole, are_apart) = self.unoccluded(first, second);
            self.less_hidden((i, j), first, second, whole, are_apart, candidates)
        };
        *self.value_mut(i, j) = value;
    }

    /// What is between of all that may be.
    fn between(&self, first: End, second: End, candidates: &[u32], kept: &mut Vec<u32>) -> Sight {
        let Blockers { list, contact, .. } = &*self.scene.blockers;
        between(list, candidates, (first.facet, first.polygon), (second.facet, second.polygon), *contact, kept)
    }

    /// The unoccluded exchange less what blockers hide.
    fn less_hidden(
        &mut self,
        numbers: (usize, usize),
        first: End,
        second: End,
        whole: f64,
        are_apart: bool,
        candidates: &[u32],
    ) -> f64 {
        if candidates.is_empty() || whole <= 0.0 {
            self.tally.full += 1;
            return whole.max(0.0);
        }
        let smaller = first.facet.area.min(second.facet.area);
        let important = self.scene.importance_of(numbers.0, numbers.1);
        let allowed = PARTIAL_SHARE * self.scene.settings.tolerance * (whole * smaller).sqrt() / important;
        let hidden = self.hidden(&Ends { numbers, first, second, whole, are_apart, allowed }, candidates);
        self.tally.worst_error = self.tally.worst_error.max(hidden.error / smaller);
        if hidden.is_all {
            return 0.0;
        }
        let left = whole - hidden.value;
        // What rounding leaves of a pair that is hidden altogether is nothing.
        if left > 1e-13 * whole { left } else { 0.0 }
    }

    /// The exchange if nothing stood between, and whether the pair is well apart.
    fn unoccluded(&mut self, first: End, second: End) -> (f64, bool) {
        self.unoccluded_by(&self.scene.settings.kernel, first, second, 0.0)
    }

    /// The same by a kernel, where an error of `enough` m2 is none.
    fn unoccluded_by(&mut self, kernel: &Kernel, first: End, second: End, enough: f64) -> (f64, bool) {
        let tolerance = self.scene.settings.tolerance;
        let (a, b) = (Extent::of(first), Extent::of(second));
        let r = b.centre - a.centre;
        let (h1, h2) = (first.facet.normal.dot(r), -second.facet.normal.dot(r));
        let radii = a.radius + b.radius;
        let separation = Separation {
            distance_squared: r.length_squared(),
            radii,
            heights: (h1, h2),
            little: self.little(first.facet, second.facet),
        };
        let order = if matches!(kernel, Kernel::Auto) { self.scene.orders.choose(&separation) } else { None };
        if let Some(order) = order.filter(|&order| ORDERS[order] <= MOST_POINTS_OF_PARTS) {
            self.tally.by_areas += 1;
            let whole = areas(first.polygon, first.facet.normal, second.polygon, second.facet.normal, order);
            return (whole, are_apart(r, radii));
        }
        self.tally.by_contour += 1;
        let smaller = first.facet.area.min(second.facet.area);
        let larger = first.facet.area.max(second.facet.area);
        let most =
            ((h1.max(0.0) + radii) * (h2.max(0.0) + radii) * larger / r.length_squared().powi(2)).clamp(1e-3, 1.0);
        let tolerance = match kernel {
            Kernel::Analytic if is_closed_form(first.polygon, second.polygon) => 1.0,
            Kernel::Analytic => 1e-12,
            _ => 0.1 * tolerance,
        };
        let tolerance = (tolerance * most * smaller).max(enough);
        (contour(first.polygon, second.polygon, tolerance), are_apart(r, radii))
    }

    fn by_nusselt(&mut self, first: End, second: End, rule: &PlaneRule, candidates: &[u32]) -> f64 {
        let mut blockers = self.scratch.take_list();
        let sight = self.between(first, second, candidates, &mut blockers);
        self.tally.count(sight);
        let exchange = if sight == Sight::None { 0.0 } else { self.mean_of_ends(first, second, rule, &blockers) };
        self.scratch.lists.push(blockers);
        exchange
    }

    /// The mean of what both ends of a pair measure by Nusselt's analog.
    fn mean_of_ends(&mut self, first: End, second: End, rule: &PlaneRule, blockers: &[u32]) -> f64 {
        let Blockers { list, contact, .. } = &*self.scene.blockers;
        let fragments = &mut self.scratch.fragments;
        let mut from = |source: End, target: End| {
            let normal = source.facet.normal;
            nusselt(source.polygon, rule, |x| {
                let between = blockers.iter().map(|&k| &list[k as usize]);
                fragments.visible(x, normal, target.polygon, between, *contact)
            })
        };
        let (there, back) = (from(first, second), from(second, first));
        let (a, b) = (first.facet.area, second.facet.area);
        self.tally.disagreement = self.tally.disagreement.max((there - back).abs() / a.min(b));
        // The smaller facet, whose points are nearer to each other, knows better.
        (there * b + back * a) / (a + b)
    }

    /// Sums the Gauss points of the pairs put aside and takes off what is hidden.
    fn finish_batch(&mut self, i: usize, candidates: &[u32]) {
        let batch = std::mem::take(&mut self.scratch.batch);
        let mut exchange = std::mem::take(&mut self.scratch.exchange);
        exchange.resize(batch.len(), 0.0);
        self.scene.nodes.row(i, &batch, &mut exchange);
        self.tally.by_areas += batch.len() as u64;
        let facets = &self.scene.facets.list;
        for (&(j, _), &whole) in batch.iter().zip(&exchange) {
            let end = |k: usize| End { facet: &facets[k], polygon: facets[k].corners() };
            let j = j as usize;
            let (a, b) = (&facets[i], &facets[j]);
            let are_apart = are_apart(b.centre - a.centre, a.radius + b.radius);
            *self.value_mut(i, j) = self.less_hidden((i, j), end(i), end(j), whole, are_apart, candidates);
        }
        (self.scratch.batch, self.scratch.exchange) = (batch, exchange);
    }

    fn value_mut(&mut self, i: usize, j: usize) -> &mut f64 {
        let at = self.index(i, j);
        &mut self.values[at]
    }

    /// Where the exchange of a pair is among the values.
    fn index(&self, i: usize, j: usize) -> usize {
        let n = self.scene.facets.list.len();
        let first = self.node.range.start;
        (i - first) * (n - 1) - (first..i).sum::<usize>() + j - i - 1
    }
}

/// Whether lines between two balls differ so little that a few of them tell of all: their ends within a ratio of
/// distances of about 3.
fn are_apart(between: DVec3, radii: f64) -> bool {
    radii * radii <= 0.25 * between.length_squared()
}

/// The least and the greatest height of a box above a facet's plane.
fn heights_of(facet: &Facet, bounds: &Bounds) -> (f64, f64) {
    let (low, high) = bounds.extent_along(facet.normal);
    let offset = facet.normal.dot(facet.centre);
    (low - offset, high - offset)
}

/// A polygon's middle and the ball about it.
struct Extent {
    centre: DVec3,
    radius: f64,
}

impl Extent {
    fn of(end: End) -> Self {
        if std::ptr::eq(end.polygon, end.facet.corners()) {
            return Self { centre: end.facet.centre, radius: end.facet.radius };
        }
        let centre = end.polygon.iter().sum::<DVec3>() / end.polygon.len() as f64;
        Self { centre, radius: end.polygon.iter().map(|c| c.distance(centre)).fold(0.0, f64::max) }
    }
}

#[cfg(test)]
mod tests;
