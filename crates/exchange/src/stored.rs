//! Form factors in files: measured onto them, saved, opened.
//!
//! The first record holds the patches, so that a file can be opened alone, and whatever text its user wants beside
//! them. Blocks of the operator follow in the order of facets, each with a tally of what was done; then standard errors
//! where there are any, and the report.

use crate::enclosure::Enclosure;
use crate::exchange::Exchange;
use crate::factors::{
    FactorReport, Failure, FormFactors, Kept, Method, Settings, is_by_pairs, measure, report_of_links,
};
use crate::hierarchy::{self, LinkBlock, Links};
use crate::pairs::{self, PairBlock, Pairs, Tally};
use glam::DVec3;
use radiosity_geometry::Patches;
use radiosity_operator::{Block, Control, Hierarchical, Part, Symmetric};
use radiosity_store::{
    Checkpoint, Identity, Numbers, Opened, Section, Sections, StoreError, StoreFile, Stored, fingerprint, role,
};
use serde_json::{Value, json};
use std::path::Path;
use std::sync::{Arc, OnceLock};
use std::time::Instant;

/// The kind of files that hold each pair once, in blocks of rows.
const PAIRS: &str = "symmetric";

/// The kind of files that hold blocks of rank one and near pairs.
const LINKS: &str = "hierarchical";

/// The kind of file that a method makes.
fn kind(method: Method) -> &'static str {
    if method == Method::Hierarchical { LINKS } else { PAIRS }
}

/// The record with the report and the order of rows.
const REPORT: u32 = role::OTHER;

/// Blocks of standard errors.
const STANDARD_ERROR: u32 = role::OTHER + 1;

/// Form factors whose operator is in a mapped file.
///
/// What sparse rows point at is checked before the first use, because that reads a third of them: opening takes no
/// longer for a large file than for a small one.
pub struct StoredFactors {
    file: StoreFile,
    factors: Arc<FormFactors>,
    checked: OnceLock<Result<(), String>>,
}

impl StoredFactors {
    /// With an operator of which no more stays in memory than needed if it is larger than the limit.
    fn new(file: StoreFile, enclosure: Arc<Enclosure>, memory_limit: u64) -> Result<Self, StoreError> {
        let sides = enclosure.sides();
        let mut last = file.only(REPORT)?;
        let (text, order) = (last.take_text()?, last.take::<u32>()?.to_vec());
        let told = serde_json::from_str(&text).map_err(|e| last.damaged(e))?;
        let joined = |blocks: Vec<Block>| -> Result<Symmetric, StoreError> {
            let joined = Symmetric::from_stored(sides, order.clone(), blocks).map_err(|what| last.damaged(what))?;
            Ok(if file.length() > memory_limit { joined.frugal() } else { joined })
        };
        let operator = if file.kind() == LINKS {
            let parts = file.with_role(role::BLOCK).map(|mut s| Ok(LinkBlock::from_sections(&mut s)?.part));
            let parts = parts.collect::<Result<_, StoreError>>()?;
            let links = Hierarchical::from_stored(sides, order.clone(), parts).map_err(|what| last.damaged(what))?;
            Exchange::Links(if file.length() > memory_limit { links.frugal() } else { links })
        } else {
            let blocks = file.with_role(role::BLOCK).map(|mut s| Ok(PairBlock::from_sections(&mut s)?.block));
            Exchange::Pairs(joined(blocks.collect::<Result<_, StoreError>>()?)?)
        };
        let errors: Vec<Block> =
            file.with_role(STANDARD_ERROR).map(|mut s| Block::from_sections(&mut s)).collect::<Result<_, _>>()?;
        let standard_error = if errors.is_empty() { None } else { Some(joined(errors)?) };
        let settings = file.settings().clone();
        let factors = FormFactors {
            operator,
            standard_error,
            report: report_in(&told),
            settings,
            enclosure,
            check: OnceLock::new(),
            sums: OnceLock::new(),
        };
        // What was touched of every block to find its arrays.
        file.release();
        Ok(Self { file, factors: Arc::new(factors), checked: OnceLock::new() })
    }

    /// The form factors, for their sizes and report.
    pub fn unchecked(&self) -> &Arc<FormFactors> {
        &self.factors
    }

    /// The form factors.
    ///
    /// # Errors
    /// If the file is damaged.
    pub fn checked(&self) -> Result<&Arc<FormFactors>, StoreError> {
        let check = || {
            self.factors.operator.check_indices()?;
            self.factors.standard_error.as_ref().map_or(Ok(()), Symmetric::check_indices)
        };
        match self.checked.get_or_init(check) {
            Ok(()) => Ok(&self.factors),
            Err(what) => Err(StoreError::damaged(self.file.path(), format!("the file is damaged: {what}"))),
        }
    }
}

/// An open file of form factors, before it is known what geometry they are used on.
pub struct ExchangeFile {
    file: StoreFile,
    patches: Patches,
    description: String,
}

impl ExchangeFile {
    /// Opens a file and checks its structure; with `verify` also all checksums, which reads it all.
    ///
    /// # Errors
    /// If it cannot be read, or is no whole file of form factors.
    pub fn open(path: &Path, verify: bool) -> Result<Self, StoreError> {
        Self::of(StoreFile::open(path)?, verify)
    }

    fn of(file: StoreFile, verify: bool) -> Result<Self, StoreError> {
        if ![PAIRS, LINKS].contains(&file.kind().as_str()) {
            return Err(StoreError::damaged(file.path(), format!("this is no file of form factors: {}", file.kind())));
        }
        if verify {
            file.verify()?;
        }
        let mut head = file.head();
        let description = head.take_text()?;
        let patches = patches_in(&mut head)?;
        Ok(Self { patches, description, file })
    }

    /// The patches that the form factors are between.
    pub fn patches(&self) -> &Patches {
        &self.patches
    }

    /// The text that was saved with them.
    pub fn description(&self) -> &str {
        &self.description
    }

    /// The form factors, on an enclosure of the same patches. If the file is larger than the limit, what is read of it
    /// does not stay in memory.
    ///
    /// # Errors
    /// If it is of other patches, or the file is damaged.
    pub fn on(self, enclosure: Arc<Enclosure>, memory_limit: u64) -> Result<StoredFactors, StoreError> {
        let (a, b) = (&self.patches, enclosure.patches());
        if a.polygons != b.polygons || a.two_sided != b.two_sided || a.obstructions != b.obstructions {
            return Err(StoreError::different(self.file.path(), "these form factors are between other patches"));
        }
        StoredFactors::new(self.file, enclosure, memory_limit)
    }
}

/// Measures the form factors between all sides onto a file, or goes on where that was cut off, or opens the file if it
/// holds them already. The bytes of the file are the same however often the work was cut off.
///
/// What is measured pair by pair is written block by block and takes little memory; what is measured by rows is written
/// in the end.
///
/// # Errors
/// As [`measure`], and if the file cannot be written or is of something else.
pub fn measure_onto(
    path: &Path,
    description: &str,
    enclosure: Arc<Enclosure>,
    settings: &Settings,
    control: &Control,
) -> Result<StoredFactors, Failure> {
    let start = Instant::now();
    enclosure.without_specular("form factors")?;
    let identity = Identity { kind: kind(settings.method), settings: settings.named(enclosure.patches()) };
    if !path.exists() {
        // Before anything is begun.
        settings.check_memory(enclosure.sides(), Kept::InFile)?;
    }
    let opened = Checkpoint::open(path, &identity, &head(description, enclosure.patches()))?;
    let file = match opened {
        Opened::Whole(file) => file,
        Opened::Building(checkpoint) if is_by_pairs(settings.method) => {
            by_pairs(*checkpoint, &enclosure, settings, control)?
        }
        Opened::Building(checkpoint) if settings.method == Method::Hierarchical => {
            by_links(*checkpoint, &enclosure, settings, control)?
        }
        Opened::Building(checkpoint) => write_measured(*checkpoint, enclosure.clone(), settings, control)?,
    };
    let mut stored = StoredFactors::new(file, enclosure, settings.memory_limit)?;
    if let Some(factors) = Arc::get_mut(&mut stored.factors) {
        factors.report.seconds = start.elapsed().as_secs_f64();
    }
    Ok(stored)
}

/// Block by block.
fn by_pairs(
    mut checkpoint: Checkpoint,
    enclosure: &Enclosure,
    settings: &Settings,
    control: &Control,
) -> Result<StoreFile, Failure> {
    let of_pairs = settings.of_pairs().expect("asked before");
    let pairs = Pairs::new(enclosure, &of_pairs);
    let mut sum = Tally::default();
    for k in 0..checkpoint.resumed() {
        sum = sum.plus(Tally::from_arrays(&checkpoint.section(k, 0)?, &checkpoint.section(k, 1)?));
    }
    let window = pairs::window(enclosure.sides(), rayon::current_num_threads(), settings.memory_limit);
    let mut keep = Tallied { checkpoint, sum };
    pairs.measure_onto(&mut keep, window, control)?;
    let report = settings.report_of_pairs(keep.sum);
    Ok(keep.checkpoint.finish(&[(REPORT, last(&report, &pairs.order()))])?)
}

/// The same of links, whose error rays tell in the end.
fn by_links(
    mut checkpoint: Checkpoint,
    enclosure: &Enclosure,
    settings: &Settings,
    control: &Control,
) -> Result<StoreFile, Failure> {
    let of_links = hierarchy::Settings::new(settings.tolerance, settings.seed);
    let links = Links::new(enclosure, &of_links, &[]);
    let order = links.order();
    let mut sum = OfLinks { ones: vec![1.0; order.len()], sums: vec![0.0; order.len()], ..Default::default() };
    for k in 0..checkpoint.resumed() {
        let block = resumed(&mut checkpoint, k, order.len())?;
        sum.add(&block);
    }
    // Blocks are small beside what all of them read.
    let window = 8 * rayon::current_num_threads();
    let mut keep = Tallied { checkpoint, sum };
    links.measure_onto(&mut keep, window, control)?;
    drop(links);
    let Tallied { checkpoint, sum } = keep;
    let mut sums = vec![0.0; enclosure.sides()];
    order.iter().zip(&sum.sums).for_each(|(&side, s)| sums[side as usize] = *s);
    let report = report_of_links(enclosure, &sums, settings, (sum.links, sum.pairs), control)?;
    Ok(checkpoint.finish(&[(REPORT, last(&report, &order))])?)
}

/// A block that was there when the file was opened.
fn resumed(checkpoint: &mut Checkpoint, k: usize, n: usize) -> Result<LinkBlock, StoreError> {
    let tally = hierarchy::Tally::from_array(&checkpoint.section(k, 0)?);
    let pairs = Tally::from_arrays(&checkpoint.section(k, 1)?, &checkpoint.section(k, 2)?);
    let (links, weights) = (checkpoint.section(k, 3)?, checkpoint.section(k, 4)?);
    let (rows, offsets) = (checkpoint.section(k, 5)?, checkpoint.section(k, 6)?);
    let near = (checkpoint.section(k, 7)?, checkpoint.section(k, 8)?);
    let part = Part::from_arrays(n, links, weights, rows, offsets, near);
    let part = part.map_err(|what| StoreError::damaged(checkpoint.path(), format!("block {k}: {what}")))?;
    Ok(LinkBlock { tally, pairs, part })
}

/// What is counted of links, and the row sums by position.
#[derive(Default)]
struct OfLinks {
    links: hierarchy::Tally,
    pairs: Tally,
    ones: Vec<f64>,
    sums: Vec<f64>,
}

impl OfLinks {
    fn add(&mut self, block: &LinkBlock) {
        self.links = self.links.plus(block.tally);
        self.pairs = self.pairs.plus(block.pairs);
        block.part.add_to(&self.ones, &mut self.sums);
    }
}

/// A checkpoint that counts what it takes.
struct Tallied<T> {
    checkpoint: Checkpoint,
    sum: T,
}

impl radiosity_store::Keep<LinkBlock> for Tallied<OfLinks> {
    fn kept(&self) -> usize {
        self.checkpoint.blocks()
    }

    fn keep(&mut self, block: LinkBlock) -> Result<(), StoreError> {
        self.sum.add(&block);
        self.checkpoint.append(&block)
    }
}

impl radiosity_store::Keep<PairBlock> for Tallied<Tally> {
    fn kept(&self) -> usize {
        self.checkpoint.blocks()
    }

    fn keep(&mut self, block: PairBlock) -> Result<(), StoreError> {
        self.sum = self.sum.plus(block.tally);
        self.checkpoint.append(&block)
    }
}

/// Measured in memory, then written.
fn write_measured(
    mut checkpoint: Checkpoint,
    enclosure: Arc<Enclosure>,
    settings: &Settings,
    control: &Control,
) -> Result<StoreFile, Failure> {
    let factors = measure(enclosure, settings, control)?;
    let pairs = factors.operator.pairs().expect("rows make pairs");
    for block in pairs.blocks().iter().skip(checkpoint.resumed()) {
        checkpoint.append(&Saved(block))?;
    }
    Ok(checkpoint.finish(&last_records(&factors))?)
}

/// Writes form factors to a file that appears when it is whole.
///
/// # Errors
/// Of the system.
pub fn save(path: &Path, description: &str, factors: &FormFactors) -> Result<(), StoreError> {
    let kind = if factors.operator.pairs().is_some() { PAIRS } else { LINKS };
    let identity = Identity { kind, settings: factors.settings.clone() };
    let head = head(description, factors.enclosure.patches());
    radiosity_store::save(path, &identity, &head, |writer| {
        match &factors.operator {
            Exchange::Pairs(pairs) => {
                pairs.blocks().iter().try_for_each(|b| writer.append(role::BLOCK, &Saved(b).sections()))?;
            }
            Exchange::Links(links) => {
                let none = LinkTallies::default();
                links.parts().iter().try_for_each(|part| writer.append(role::BLOCK, &none.sections_with(part)))?;
            }
        }
        last_records(factors).iter().try_for_each(|(role, sections)| writer.append(*role, sections))
    })
}

fn last_records(factors: &FormFactors) -> Vec<(u32, Vec<Section<'_>>)> {
    let errors = factors.standard_error.iter().flat_map(|errors| errors.blocks());
    let mut records: Vec<_> = errors.map(|block| (STANDARD_ERROR, block.sections())).collect();
    records.push((REPORT, last(&factors.report, factors.operator.order())));
    records
}

/// The last record.
fn last(report: &FactorReport, order: &[u32]) -> Vec<Section<'static>> {
    vec![Section::owned(report_out(report).to_string().as_bytes()), Section::owned(order)]
}

/// What the first record holds beside the settings.
fn head<'a>(description: &'a str, patches: &'a Patches) -> Vec<Section<'a>> {
    let two_sided: Vec<u8> = patches.two_sided.iter().map(|t| u8::from(*t)).collect();
    vec![
        Section::text(description),
        coordinates(&patches.polygons),
        Section::of(&patches.surface),
        Section::of(&patches.face),
        Section::owned(&two_sided),
        coordinates(&patches.obstructions),
    ]
}

fn coordinates(polygons: &[[DVec3; 4]]) -> Section<'static> {
    Section::owned(&polygons.iter().flatten().flat_map(|c| c.to_array()).collect::<Vec<f64>>())
}

fn patches_in(head: &mut Sections) -> Result<Patches, StoreError> {
    let polygons = polygons_in(head)?;
    let (surface, face) = (head.take::<u32>()?.to_vec(), head.take::<u32>()?.to_vec());
    let two_sided: Vec<bool> = head.take::<u8>()?.iter().map(|t| *t != 0).collect();
    let obstructions = polygons_in(head)?;
    if [surface.len(), face.len(), two_sided.len()] != [polygons.len(); 3] {
        return Err(head.damaged("there is not one surface, face and side for each polygon"));
    }
    Ok(Patches::new(polygons, surface, face, two_sided).with_obstructions(obstructions))
}

fn polygons_in(head: &mut Sections) -> Result<Vec<[DVec3; 4]>, StoreError> {
    let numbers: Numbers<f64> = head.take()?;
    let (corners, rest) = numbers.as_chunks::<12>();
    if !rest.is_empty() || numbers.iter().any(|x| !x.is_finite()) {
        return Err(head.damaged("polygons are twelve finite numbers each"));
    }
    Ok(corners.iter().map(|c| [0, 3, 6, 9].map(|k| DVec3::new(c[k], c[k + 1], c[k + 2]))).collect())
}

/// A hash of all that form factors between patches depend on.
pub(crate) fn geometry(patches: &Patches) -> String {
    fingerprint(&head("", patches))
}

/// What form factors follow from that were not measured here: themselves.
pub fn given(enclosure: &Enclosure, operator: &Symmetric) -> radiosity_store::Settings {
    let sections: Vec<Section> = operator.blocks().iter().flat_map(Block::sections).collect();
    let Value::Object(named) = json!({
        "method": "given",
        "factors": fingerprint(&sections),
        "patches": enclosure.patches().len(),
        "geometry": geometry(enclosure.patches()),
    }) else {
        unreachable!("an object")
    };
    named
}

/// A block of an operator whose tally is in the report alone.
struct Saved<'a>(&'a Block);

impl Stored for Saved<'_> {
    fn sections(&self) -> Vec<Section<'_>> {
        with_tally(&Tally::default(), self.0)
    }

    fn from_sections(sections: &mut Sections<'_>) -> Result<Self, StoreError> {
        Err(sections.damaged("blocks are read as such"))
    }
}

impl Stored for PairBlock {
    fn sections(&self) -> Vec<Section<'_>> {
        with_tally(&self.tally, &self.block)
    }

    fn from_sections(sections: &mut Sections<'_>) -> Result<Self, StoreError> {
        let (counts, errors) = (sections.take::<u64>()?, sections.take::<f64>()?);
        Ok(Self { tally: Tally::from_arrays(&counts, &errors), block: Block::from_sections(sections)? })
    }
}

/// Tallies of a block of links.
#[derive(Default)]
struct LinkTallies {
    links: hierarchy::Tally,
    pairs: Tally,
}

impl LinkTallies {
    fn sections_with<'a>(&self, part: &'a Part) -> Vec<Section<'a>> {
        let (counts, errors) = self.pairs.to_arrays();
        let mut sections =
            vec![Section::owned(&self.links.to_array()), Section::owned(&counts), Section::owned(&errors)];
        sections.extend(part.sections());
        sections
    }
}

impl Stored for LinkBlock {
    fn sections(&self) -> Vec<Section<'_>> {
        LinkTallies { links: self.tally, pairs: self.pairs }.sections_with(&self.part)
    }

    fn from_sections(sections: &mut Sections<'_>) -> Result<Self, StoreError> {
        let tally = hierarchy::Tally::from_array(&sections.take::<u64>()?);
        let (counts, errors) = (sections.take::<u64>()?, sections.take::<f64>()?);
        Ok(Self { tally, pairs: Tally::from_arrays(&counts, &errors), part: Part::from_sections(sections)? })
    }
}

impl hierarchy::Tally {
    fn to_array(self) -> [u64; 6] {
        let Self { clear, sampled, negligible, mixed, rays, near_leaves } = self;
        [clear, sampled, mixed, rays, near_leaves, negligible]
    }

    /// Numbers that are missing are zero.
    fn from_array(counts: &[u64]) -> Self {
        let count = |k: usize| counts.get(k).copied().unwrap_or(0);
        Self {
            clear: count(0),
            sampled: count(1),
            mixed: count(2),
            rays: count(3),
            near_leaves: count(4),
            negligible: count(5),
        }
    }
}

fn with_tally<'a>(tally: &Tally, block: &'a Block) -> Vec<Section<'a>> {
    let (counts, errors) = tally.to_arrays();
    let mut sections = vec![Section::owned(&counts), Section::owned(&errors)];
    sections.extend(block.sections());
    sections
}

impl Tally {
    fn to_arrays(self) -> ([u64; 8], [f64; 2]) {
        let Tally { full, partial, hidden, by_areas, by_contour, by_rays, rays, unresolved, .. } = self;
        let counts = [full, partial, hidden, by_areas, by_contour, by_rays, rays, unresolved];
        (counts, [self.worst_error, self.disagreement])
    }

    /// Numbers that are missing are zero.
    fn from_arrays(counts: &[u64], errors: &[f64]) -> Self {
        let count = |k: usize| counts.get(k).copied().unwrap_or(0);
        let error = |k: usize| errors.get(k).copied().unwrap_or(0.0);
        Self {
            full: count(0),
            partial: count(1),
            hidden: count(2),
            by_areas: count(3),
            by_contour: count(4),
            by_rays: count(5),
            rays: count(6),
            unresolved: count(7),
            worst_error: error(0),
            disagreement: error(1),
        }
    }
}

/// A report without times, which would differ from run to run.
fn report_out(report: &FactorReport) -> Value {
    let (counts, errors) = report.tally.to_arrays();
    json!({
        "tally": counts,
        "links": report.links.to_array(),
        "errors": errors,
        "estimated_error": report.estimated_error,
        "disagreement": report.disagreement,
        "samples": report.samples,
    })
}

fn report_in(told: &Value) -> FactorReport {
    let list = |name: &str| told[name].as_array().map_or(&[] as &[Value], Vec::as_slice);
    let counts = |name: &str| list(name).iter().map(|v| v.as_u64().unwrap_or(0)).collect::<Vec<u64>>();
    // JSON has no infinity, which null stands for.
    let number = |v: &Value| v.as_f64().unwrap_or(f64::INFINITY);
    let errors: Vec<f64> = list("errors").iter().map(number).collect();
    FactorReport {
        tally: Tally::from_arrays(&counts("tally"), &errors),
        links: hierarchy::Tally::from_array(&counts("links")),
        estimated_error: number(&told["estimated_error"]),
        disagreement: number(&told["disagreement"]),
        samples: told["samples"].as_u64().unwrap_or(0),
        seconds: 0.0,
    }
}

impl Settings {
    /// By name, with the version of the engine and a hash of the geometry: what the numbers follow from.
    pub(crate) fn named(&self, patches: &Patches) -> radiosity_store::Settings {
        let Value::Object(mut named) = self.method.named() else { unreachable!("an object") };
        named.insert("tolerance".into(), json!(self.tolerance));
        named.insert("seed".into(), json!(self.seed));
        named.insert("engine".into(), json!(env!("CARGO_PKG_VERSION")));
        named.insert("patches".into(), json!(patches.len()));
        named.insert("geometry".into(), json!(geometry(patches)));
        named
    }
}

impl Method {
    fn named(self) -> Value {
        match self {
            Method::Auto => json!({"method": "auto"}),
            Method::Analytic => json!({"method": "analytic"}),
            Method::Contour => json!({"method": "contour"}),
            Method::Nusselt { points } => json!({"method": "nusselt", "points": points}),
            Method::Hemicube { resolution, positions } => {
                json!({"method": "hemicube", "resolution": resolution, "hemicubes": positions})
            }
            Method::Hierarchical => json!({"method": "hierarchical"}),
            Method::MonteCarlo { rays } => json!({"method": "monte_carlo", "rays": rays}),
        }
    }
}
