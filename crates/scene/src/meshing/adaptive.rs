//! A mesh that is refined where it pays.
//!
//! Every patch of a coarse mesh is the root of a tree: a quad has four quads as children, a triangle four triangles
//! ("red" refinement). Where leaves of different size meet, the larger one is cut from the middle of its edge so that
//! nothing hangs ("green"; Bank, Sherman and Weiser 1983). Green pieces are forgotten before the next refinement, so
//! that shapes do not decay. The middle of an edge follows from its ends alone, and edges are known by the bits of
//! their ends; so whatever met in the coarse mesh meets in every refined one, across faces and surfaces too.

use std::collections::HashSet;

use glam::DVec3;
use radiosity_geometry::Patches;
use radiosity_geometry::corners::{PositionBits, bits};

use super::{MOST_PATCHES, Meshing, check_size};
use crate::{Scene, SceneError};

/// Halvings of a coarse patch at most.
const DEEPEST: u8 = 12;

/// A coarse mesh with the trees that its patches have grown into.
#[derive(Clone, Debug)]
pub struct AdaptiveMesh {
    /// Roots first, in order of the coarse mesh.
    cells: Vec<Cell>,
    roots: usize,
    /// The edges that are cut in the middle.
    split: HashSet<Edge>,
    obstructions: Vec<[DVec3; 4]>,
}

/// A patch of some size.
#[derive(Clone, Copy, Debug)]
struct Cell {
    /// A triangle repeats its last.
    corners: [DVec3; 4],
    surface: u32,
    face: u32,
    two_sided: bool,
    depth: u8,
    /// The first of four, if it was cut.
    children: Option<u32>,
}

/// Its ends in order.
type Edge = [PositionBits; 2];

fn edge(a: DVec3, b: DVec3) -> Edge {
    let [a, b] = [a, b].map(bits);
    if a <= b { [a, b] } else { [b, a] }
}

/// The same from both ends, to the bit.
fn middle(a: DVec3, b: DVec3) -> DVec3 {
    0.5 * (a + b)
}

impl Cell {
    fn n(&self) -> usize {
        if self.corners[2] == self.corners[3] { 3 } else { 4 }
    }

    /// The ends of edge `k`.
    fn ends(&self, k: usize) -> (DVec3, DVec3) {
        (self.corners[k], self.corners[(k + 1) % self.n()])
    }

    fn children(&self) -> [[DVec3; 4]; 4] {
        let [a, b, c, d] = self.corners;
        let m = |k| {
            let (p, q) = self.ends(k);
            middle(p, q)
        };
        if self.n() == 3 {
            let (ab, bc, ca) = (m(0), m(1), m(2));
            return [[a, ab, ca, ca], [ab, b, bc, bc], [ca, bc, c, c], [ab, bc, ca, ca]];
        }
        let (ab, bc, cd, da) = (m(0), m(1), m(2), m(3));
        let x = middle(middle(a, c), middle(b, d));
        [[a, ab, x, da], [ab, b, bc, x], [x, bc, c, cd], [da, x, cd, d]]
    }

    /// The pieces that leave nothing hanging if the edges in `cut` have a middle; none if there is no good way.
    fn closure(&self, cut: [bool; 4]) -> Option<Vec<[DVec3; 4]>> {
        let n = self.n();
        let first = match cut.iter().filter(|&&c| c).count() {
            0 => return Some(vec![self.corners]),
            // The one that is cut, or of two neighbours the one before the other.
            1 | 2 => (0..n).find(|&k| cut[k] && !cut[(k + n - 1) % n]).unwrap_or(0),
            _ => return None,
        };
        // Turned so that edge ab is cut.
        let corner = |k: usize| self.corners[(first + k) % n];
        let is_cut = |k: usize| cut[(first + k) % n];
        let m = |k: usize| middle(corner(k), corner(k + 1));
        let (a, b, c, d) = (corner(0), corner(1), corner(2), corner(3));
        let ab = m(0);
        let pieces = match (n, is_cut(1), is_cut(2)) {
            (3, false, false) => vec![[a, ab, c, c], [ab, b, c, c]],
            (3, ..) => vec![[ab, b, m(1), m(1)], [a, ab, m(1), c]],
            (_, false, false) => vec![[a, ab, d, d], [ab, c, d, d], [ab, b, c, c]],
            (_, _, true) => vec![[a, ab, m(2), d], [ab, b, c, m(2)]],
            (_, true, _) => {
                let x = middle(middle(a, c), middle(b, d));
                vec![[ab, b, m(1), x], [a, ab, x, d], [x, m(1), c, d]]
            }
        };
        pieces.iter().all(is_convex).then_some(pieces)
    }
}

/// Whether all corners turn the same way, as those of the whole do.
fn is_convex(piece: &[DVec3; 4]) -> bool {
    let n = if piece[2] == piece[3] { 3 } else { 4 };
    let turn = |k: usize| (piece[(k + 1) % n] - piece[k]).cross(piece[(k + n - 1) % n] - piece[k]);
    let normal = (piece[2] - piece[0]).cross(piece[3] - piece[1]) + (piece[1] - piece[0]).cross(piece[2] - piece[0]);
    (0..n).all(|k| turn(k).dot(normal) > 0.0)
}

impl AdaptiveMesh {
    /// Begins with a mesh of that fineness.
    ///
    /// # Errors
    /// As [`patches`](super::patches).
    pub fn new(scene: &Scene, coarse: &Meshing) -> Result<Self, SceneError> {
        let patches = super::patches(scene, coarse)?;
        let cells: Vec<Cell> = (0..patches.len())
            .map(|i| Cell {
                corners: patches.polygons[i],
                surface: patches.surface[i],
                face: patches.face[i],
                two_sided: patches.two_sided[i],
                depth: 0,
                children: None,
            })
            .collect();
        Ok(Self { roots: cells.len(), cells, split: HashSet::new(), obstructions: patches.obstructions })
    }

    /// The patches, tree by tree, and for each the number of the leaf that it is or is a piece of; leaves are numbered
    /// in the same order.
    pub fn patches(&self) -> (Patches, Vec<u32>) {
        let (mut polygons, mut surface, mut face, mut two_sided, mut leaf) = (vec![], vec![], vec![], vec![], vec![]);
        for (number, cell) in (0u32..).zip(self.leaf_cells().into_iter().map(|i| &self.cells[i as usize])) {
            let pieces = cell.closure(self.cut_edges(cell)).unwrap_or_else(|| cell.children().to_vec());
            for piece in pieces {
                polygons.push(piece);
                surface.push(cell.surface);
                face.push(cell.face);
                two_sided.push(cell.two_sided);
                leaf.push(number);
            }
        }
        let patches = Patches::new(polygons, surface, face, two_sided);
        (patches.with_obstructions(self.obstructions.clone()), leaf)
    }

    /// Cuts each leaf as many times as it is marked with, and those that would have too much hanging otherwise. Returns
    /// the leaves there are.
    ///
    /// # Errors
    /// If there would be more than [`MOST_PATCHES`].
    ///
    /// # Panics
    /// If there is not one mark per leaf.
    pub fn refine(&mut self, scene: &Scene, marked: &[u8]) -> Result<usize, SceneError> {
        let leaves = self.leaf_cells();
        assert_eq!(leaves.len(), marked.len(), "one mark per leaf");
        let wanted: f64 = marked.iter().map(|&times| 4f64.powi(i32::from(times))).sum();
        check_size(scene, wanted)?;
        for (&leaf, &times) in leaves.iter().zip(marked) {
            self.cut_deep(leaf, times);
        }
        let mut suspects = self.leaf_cells();
        loop {
            suspects.retain(|&leaf| self.has_too_much_hanging(&self.cells[leaf as usize]));
            if suspects.is_empty() {
                break;
            }
            suspects.iter().for_each(|&leaf| self.cut(leaf));
            suspects = self.leaf_cells();
            check_size(scene, suspects.len() as f64)?;
        }
        Ok(self.leaves())
    }

    /// The number of leaves.
    pub fn leaves(&self) -> usize {
        self.cells.iter().filter(|cell| cell.children.is_none()).count()
    }

    /// Indices of the cells without children, tree by tree.
    fn leaf_cells(&self) -> Vec<u32> {
        let mut leaves = Vec::with_capacity(self.cells.len());
        let mut stack = Vec::new();
        for root in 0..self.roots as u32 {
            stack.push(root);
            while let Some(cell) = stack.pop() {
                match self.cells[cell as usize].children {
                    Some(first) => stack.extend((first..first + 4).rev()),
                    None => leaves.push(cell),
                }
            }
        }
        leaves
    }

    fn cut_deep(&mut self, leaf: u32, times: u8) {
        if times > 0 {
            self.cut(leaf);
            if let Some(first) = self.cells[leaf as usize].children {
                (first..first + 4).for_each(|child| self.cut_deep(child, times - 1));
            }
        }
    }

    fn cut(&mut self, leaf: u32) {
        let cell = self.cells[leaf as usize];
        if cell.depth >= DEEPEST || self.cells.len() + 4 > 4 * MOST_PATCHES {
            return;
        }
        for k in 0..cell.n() {
            let (a, b) = cell.ends(k);
            self.split.insert(edge(a, b));
        }
        self.cells[leaf as usize].children = Some(self.cells.len() as u32);
        self.cells.extend(cell.children().map(|corners| Cell { corners, depth: cell.depth + 1, ..cell }));
    }

    fn cut_edges(&self, cell: &Cell) -> [bool; 4] {
        std::array::from_fn(|k| {
            let (a, b) = cell.ends(k);
            k < cell.n() && self.split.contains(&edge(a, b))
        })
    }

    /// Whether an edge hangs twice, or there is no good way to close those that hang once.
    fn has_too_much_hanging(&self, cell: &Cell) -> bool {
        let cut = self.cut_edges(cell);
        let is_cut_twice = (0..cell.n()).filter(|&k| cut[k]).any(|k| {
            let (a, b) = cell.ends(k);
            let m = middle(a, b);
            self.split.contains(&edge(a, m)) || self.split.contains(&edge(m, b))
        });
        cell.depth < DEEPEST && (is_cut_twice || cell.closure(cut).is_none())
    }
}

#[cfg(test)]
mod tests {
    use std::collections::HashMap;

    use proptest::prelude::*;

    use super::*;
    use crate::Surface;

    /// A floor, a wall on its edge, and a triangle beside them.
    fn scene() -> Scene {
        let vertices = [(0, 0, 0), (2, 0, 0), (2, 2, 0), (0, 2, 0), (2, 0, 1), (2, 2, 1), (0, 4, 0)]
            .map(|(x, y, z)| DVec3::new(x as f64, y as f64, z as f64))
            .to_vec();
        let faces = vec![[0, 1, 2, 3], [2, 1, 4, 5], [3, 2, 6, 6]];
        Scene { surfaces: vec![Surface { vertices, faces, ..Surface::default() }], ..Scene::default() }
    }

    /// Every edge within the outline is used by another patch too; so nothing hangs.
    fn open_edges(patches: &Patches) -> usize {
        let mut uses: HashMap<Edge, usize> = HashMap::new();
        for i in 0..patches.len() {
            let corners = patches.corners(i);
            for k in 0..corners.len() {
                *uses.entry(edge(corners[k], corners[(k + 1) % corners.len()])).or_default() += 1;
            }
        }
        uses.values().filter(|&&n| n == 1).count()
    }

    fn outline(patches: &Patches) -> f64 {
        let mut uses: HashMap<Edge, (usize, f64)> = HashMap::new();
        for i in 0..patches.len() {
            let corners = patches.corners(i);
            for k in 0..corners.len() {
                let (a, b) = (corners[k], corners[(k + 1) % corners.len()]);
                let entry = uses.entry(edge(a, b)).or_default();
                *entry = (entry.0 + 1, a.distance(b));
            }
        }
        uses.values().filter(|(n, _)| *n == 1).map(|(_, length)| length).sum()
    }

    proptest! {
        #[test]
        fn refined_meshes_conform_and_keep_their_area(marks in prop::collection::vec(prop::collection::vec(0..5usize, 1..40), 1..4)) {
            let scene = scene();
            let mut mesh = AdaptiveMesh::new(&scene, &Meshing::MaxEdge(1.0)).unwrap();
            let (coarse, _) = mesh.patches();
            for marks in marks {
                let leaves = mesh.leaves();
                let marked: Vec<u8> = (0..leaves).map(|i| [1, 2, 0, 0, 0][marks[i % marks.len()]]).collect();
                mesh.refine(&scene, &marked).unwrap();
            }
            let (patches, leaf) = mesh.patches();
            prop_assert!((patches.area.iter().sum::<f64>() - coarse.area.iter().sum::<f64>()).abs() < 1e-12);
            // An edge that hangs is there once as a whole and once in halves.
            prop_assert!((outline(&patches) - outline(&coarse)).abs() < 1e-12);
            prop_assert!(patches.polygons.iter().all(is_convex));
            prop_assert!(leaf.windows(2).all(|w| w[1] == w[0] || w[1] == w[0] + 1));
            for i in 0..patches.len() {
                let face = [DVec3::Z, -DVec3::X, DVec3::Z][patches.face[i] as usize];
                prop_assert!((patches.normal[i] - face).length() < 1e-12);
            }
        }
    }

    #[test]
    fn one_mark_cuts_one_leaf_and_closes_its_neighbours() {
        let scene = scene();
        let mut mesh = AdaptiveMesh::new(&scene, &Meshing::MaxEdge(2.0)).unwrap();
        let before = mesh.leaves();
        let marked: Vec<u8> = (0..before).map(|i| u8::from(i == 0)).collect();
        assert_eq!(mesh.refine(&scene, &marked).unwrap(), before + 3);
        let (patches, leaf) = mesh.patches();
        assert_eq!(leaf.iter().filter(|&&l| l < 4).count(), 4);
        assert!(patches.len() > before + 3, "neighbours are closed by pieces");
        assert_eq!(open_edges(&patches) % 2, 0);
    }

    #[test]
    fn nothing_marked_changes_nothing() {
        let scene = scene();
        let mut mesh = AdaptiveMesh::new(&scene, &Meshing::MaxEdge(0.5)).unwrap();
        let (before, _) = mesh.patches();
        mesh.refine(&scene, &vec![0; before.len()]).unwrap();
        assert_eq!(mesh.patches().0.polygons, before.polygons);
        assert_eq!(before.polygons, super::super::patches(&scene, &Meshing::MaxEdge(0.5)).unwrap().polygons);
    }
}
