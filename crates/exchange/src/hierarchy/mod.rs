//! The exchange of a great many facets, in blocks.
//!
//! A tree groups facets that lie and face alike ([`clusters`]). Pairs of clusters are walked down from the root with
//! itself ([`plan`]):
//!
//! - clusters that lie behind each other do not exchange;
//! - clusters well apart for their size become one **link**, a block of rank one ([`far`]): what each facet of one
//!   exchanges with all of the other, and the same the other way round. If nothing stands between that is geometry
//!   alone; if something may, rays tell how much of it each facet sees;
//! - what is left are pairs of leaves that are near each other, measured pair by pair ([`crate::pairs`]).
//!
//! The block of a link is the outer product of its own row and column sums over their total, the one that assumes
//! nothing beyond them. So a facet in a pit is dark although its neighbours see far, which one visibility for a whole
//! link, as of Hanrahan, Salzman and Aupperle (1991) and Sillion (1995), would miss; and unlike blocks compressed after
//! the fact (Potter et al. 2022, *J. Comput. Phys.: X*) no entry of it is ever computed. Light that is even across
//! each end of a link is exchanged without error but for that of the rays.

mod check;
mod clusters;
mod far;
mod parts;
mod plan;

use crate::enclosure::Enclosure;
use crate::facets::Node;
use crate::factors::Failure;
use crate::pairs::{self, Kernel, Scratch, Selection};
use crate::visibility::{Blockers, Shaft};
pub use check::{Check, Deviation};
use clusters::Clusters;
use far::Far;
use plan::{Relation, Task, plan};
use radiosity_operator::{Cancelled, Control, Hierarchical, Part, PartBuilder};
use radiosity_store::{Keep, in_order};
use std::sync::Arc;

/// What is asked.
#[derive(Clone, Copy, Debug)]
pub struct Settings {
    /// The error allowed of a row's product with radiosities from 0 to 1, root mean square.
    pub tolerance: f64,
    /// Of rays.
    pub seed: u64,
    /// How near clusters may be for their size.
    pub separation: f64,
    /// The form factor that one ray of a link stands for.
    pub ray_share: f64,
    /// The tolerance of near pairs.
    pub near: f64,
}

impl Settings {
    /// What a tolerance needs.
    pub fn new(tolerance: f64, seed: u64) -> Self {
        let separation = (0.6 * (200.0 * tolerance).cbrt()).clamp(0.2, 0.7);
        Self { tolerance, seed, separation, ray_share: 10.0 * tolerance * tolerance, near: 2.0 * tolerance }
    }
}

/// Links of less than this share of the tolerance are left out. A side has some thirty of about one size, and on open
/// terrain what is farther is less by more than the size grows: all of it is less than a fifth of the tolerance.
const NEGLIGIBLE: f64 = 1.0 / 400.0;

/// Links of less than this share of the tolerance may be nearer for their size.
const LITTLE: f64 = 1.0 / 12.0;

/// The share of the tolerance that a block may err by where it is no product of two vectors.
const MIXED_SHARE: f64 = 0.25;

/// What was done.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Tally {
    /// Links in full view.
    pub clear: u64,
    /// Links with rays.
    pub sampled: u64,
    /// Links that were left out, as next to nothing goes through them.
    pub negligible: u64,
    /// Links that were given up for those of their parts, as who sees whom is no product of two shares.
    pub mixed: u64,
    /// Their rays.
    pub rays: u64,
    /// Pairs of leaves measured entry by entry.
    pub near_leaves: u64,
}

impl Tally {
    /// Both together.
    pub fn plus(self, other: Self) -> Self {
        Self {
            clear: self.clear + other.clear,
            sampled: self.sampled + other.sampled,
            negligible: self.negligible + other.negligible,
            mixed: self.mixed + other.mixed,
            rays: self.rays + other.rays,
            near_leaves: self.near_leaves + other.near_leaves,
        }
    }
}

/// The exchange of all sides, by their numbers.
///
/// `importance`: for each side how much more than the mean what it sends matters, or nothing where all matter alike.
pub fn measure(
    enclosure: &Enclosure,
    settings: &Settings,
    importance: &[f64],
    control: &Control,
) -> Result<(Hierarchical, Tally, pairs::Tally), Cancelled> {
    let links = Links::new(enclosure, settings, importance);
    let mut built: Vec<LinkBlock> = Vec::with_capacity(links.blocks());
    match links.measure_onto(&mut built, usize::MAX >> 1, control) {
        Ok(()) => {}
        Err(Failure::Cancelled) => return Err(Cancelled),
        Err(other) => unreachable!("memory takes all blocks: {other}"),
    }
    let tally = built.iter().fold(Tally::default(), |sum, b| sum.plus(b.tally));
    let of_pairs = built.iter().fold(pairs::Tally::default(), |sum, b| sum.plus(b.pairs));
    let parts = built.into_iter().map(|b| b.part).collect();
    Ok((Hierarchical::new(enclosure.sides(), links.order(), parts), tally, of_pairs))
}

/// Bytes that an exchange of so many sides may take.
pub fn forecast(sides: usize, settings: &Settings) -> u64 {
    // Far blocks and what else grows slowly; near pairs, whose region grows as the separation shrinks. Measured on rooms
    // and terrain, which have less.
    let near = 1300.0 * (0.6 / settings.separation).powi(2);
    ((700.0 + near) * sides as f64) as u64 + least_forecast(sides)
}

/// Bytes that it takes to build one onto a file: facets, their tree and blockers.
pub fn least_forecast(sides: usize) -> u64 {
    650 * sides as u64
}

/// What one piece of work builds.
pub struct LinkBlock {
    /// Links.
    pub tally: Tally,
    /// Near pairs.
    pub pairs: pairs::Tally,
    /// Their blocks.
    pub part: Part,
}

/// A hierarchical exchange, to be built piece by piece in the order of the tree.
pub struct Links<'a> {
    enclosure: &'a Enclosure,
    clusters: Clusters,
    blockers: Arc<Blockers>,
    settings: Settings,
    near: pairs::Settings,
    tasks: Vec<Task>,
}

impl<'a> Links<'a> {
    /// Lays out tree and work. For `importance` see [`measure`].
    pub fn new(enclosure: &'a Enclosure, settings: &Settings, importance: &[f64]) -> Self {
        let clusters = Clusters::new(enclosure, importance, settings.seed);
        let blockers = Arc::new(Blockers::new(enclosure, clusters.facets.extent));
        Self {
            near: pairs::Settings { kernel: Kernel::Auto, tolerance: settings.near, seed: settings.seed },
            tasks: plan(&clusters, settings.separation, blockers.contact),
            enclosure,
            clusters,
            blockers,
            settings: *settings,
        }
    }

    /// The number of blocks.
    pub fn blocks(&self) -> usize {
        self.tasks.len()
    }

    /// Position in the matrix -> number of the side.
    pub fn order(&self) -> Vec<u32> {
        self.clusters.facets.list.iter().map(|f| f.side).collect()
    }

    /// Builds the blocks that are not kept yet and hands them over in order, `window` at a time.
    ///
    /// # Errors
    /// If it is cancelled, or a block cannot be kept.
    pub fn measure_onto(
        &self,
        keep: &mut impl Keep<LinkBlock>,
        window: usize,
        control: &Control,
    ) -> Result<(), Failure> {
        let first = keep.kept();
        control.expect(self.tasks.len() as u64);
        control.advance(first as u64);
        let build = |scratch: &mut (Far, Scratch), k: usize| {
            control.check()?;
            let block = self.block(&self.tasks[k], scratch);
            control.advance(1);
            Ok(block)
        };
        in_order(first..self.tasks.len(), window, Default::default, build, |_, block| Ok(keep.keep(block)?))
    }

    /// The blocks of one piece of work.
    fn block(&self, task: &Task, (far, scratch): &mut (Far, Scratch)) -> LinkBlock {
        let (mut part, mut tally) = (PartBuilder::default(), Tally::default());
        let (mut near, mut open) = (Vec::new(), Vec::new());
        for &pair in task {
            open.push(pair);
            while let Some((a, b)) = open.pop() {
                let relation = self.clusters.relation(a, b, self.settings.separation, self.blockers.contact);
                // What may go through a link.
                let most = match relation {
                    Relation::Wide => LITTLE * self.settings.tolerance,
                    _ => f64::INFINITY,
                };
                match relation {
                    Relation::None => {}
                    Relation::Far | Relation::Wide if self.link(a, b, most, far, &mut part, &mut tally) => {}
                    Relation::Far | Relation::Wide => match self.clusters.split(a, b) {
                        Relation::Split(pairs) => open.extend(pairs.into_iter().flatten().rev()),
                        _ => near.push((a, b)),
                    },
                    Relation::Near => near.push((a, b)),
                    Relation::Split(pairs) => open.extend(pairs.into_iter().flatten().rev()),
                }
            }
        }
        near.sort_unstable();
        tally.near_leaves += near.len() as u64;
        let selection = Selection {
            enclosure: self.enclosure,
            facets: &self.clusters.facets,
            blockers: &self.blockers,
            settings: &self.near,
            importance: &self.clusters.importance,
        };
        let between = |a: &Node, b: &Node, found: &mut Vec<u32>| {
            self.blockers.find(&Shaft::new(a.bounds, b.bounds, self.blockers.contact), found);
        };
        let pairs = selection.measure(&near, scratch, between, |i, entries| part.near(i, entries));
        LinkBlock { tally, pairs, part: part.build() }
    }

    /// Adds the link of two clusters that are apart; false if their parts must be linked instead, as more than `most`
    /// goes through it or it is no product.
    fn link(&self, a: usize, b: usize, most: f64, far: &mut Far, part: &mut PartBuilder, tally: &mut Tally) -> bool {
        let nodes = &self.clusters.facets.nodes;
        if !far.unoccluded(&self.clusters, &nodes[a], &nodes[b]) {
            return true;
        }
        let factor = far.factor(&self.clusters);
        if factor > most {
            return false;
        }
        if factor < NEGLIGIBLE * self.settings.tolerance {
            tally.negligible += 1;
            return true;
        }
        let shaft = Shaft::new(nodes[a].bounds, nodes[b].bounds, self.blockers.contact);
        if self.blockers.leave_free(&shaft) {
            tally.clear += 1;
        } else {
            tally.rays += far.occlude(self.enclosure, &self.clusters, (a, b), &self.settings) as u64;
            if far.is_mixed(&self.clusters, [&nodes[a], &nodes[b]], MIXED_SHARE * self.settings.tolerance) {
                tally.mixed += 1;
                return false;
            }
            tally.sampled += 1;
            far.attenuate();
        }
        if far.balance() {
            part.link(nodes[a].range.clone(), nodes[b].range.clone(), far.rows(), far.columns());
        }
        true
    }
}

#[cfg(test)]
mod tests;
