//! The surface elements of a scene.

use crate::DVec3;

/// Planar polygons of three or four corners with what follows from them.
///
/// Patches have stable ids, their index. Parallel arrays all have one entry per patch.
#[derive(Clone, Debug, Default)]
pub struct Patches {
    /// Corners in counter-clockwise order seen from the front, metres. A triangle repeats its last corner.
    pub polygons: Vec<[DVec3; 4]>,
    /// The surface each patch was cut from.
    pub surface: Vec<u32>,
    /// The face of that surface each patch was cut from.
    pub face: Vec<u32>,
    /// Whether both sides of the patch reflect and emit.
    pub two_sided: Vec<bool>,
    /// Area in m2.
    pub area: Vec<f64>,
    /// Centroid in metres.
    pub centre: Vec<DVec3>,
    /// Unit normal by the right-hand rule; zero for a patch without area.
    pub normal: Vec<DVec3>,
    /// Polygons that block what passes and take no other part: opaque from both sides, black, without ids. A triangle
    /// repeats its last corner.
    pub obstructions: Vec<[DVec3; 4]>,
}

impl Patches {
    /// Derives area, centroid and normal of each polygon.
    ///
    /// # Panics
    /// If the arrays differ in length; callers build them together.
    pub fn new(polygons: Vec<[DVec3; 4]>, surface: Vec<u32>, face: Vec<u32>, two_sided: Vec<bool>) -> Self {
        let n = polygons.len();
        assert!(surface.len() == n && face.len() == n && two_sided.len() == n);
        let (mut area, mut centre, mut normal) = (Vec::with_capacity(n), Vec::with_capacity(n), Vec::with_capacity(n));
        for polygon in &polygons {
            let [a, b, c, d] = *polygon;
            // The vector area of any polygon abcd is half the cross product of its diagonals.
            let vector_area = 0.5 * (c - a).cross(d - b);
            let first = 0.5 * (b - a).cross(c - a);
            let second = vector_area - first;
            let n = vector_area.normalize_or_zero();
            let (w1, w2) = (first.dot(n), second.dot(n));
            area.push(vector_area.length());
            centre.push(if w1 + w2 > 0.0 {
                (w1 * (a + b + c) + w2 * (a + c + d)) / (3.0 * (w1 + w2))
            } else {
                0.25 * (a + b + c + d)
            });
            normal.push(n);
        }
        Self { polygons, surface, face, two_sided, area, centre, normal, obstructions: Vec::new() }
    }

    /// The same patches among polygons that only block.
    pub fn with_obstructions(self, obstructions: Vec<[DVec3; 4]>) -> Self {
        Self { obstructions, ..self }
    }

    /// The number of patches.
    pub fn len(&self) -> usize {
        self.polygons.len()
    }

    /// Whether there are no patches.
    pub fn is_empty(&self) -> bool {
        self.polygons.is_empty()
    }

    /// The corners of patch `i`: three for a triangle, four for a quadrilateral.
    pub fn corners(&self, i: usize) -> &[DVec3] {
        let polygon = &self.polygons[i];
        if polygon[2] == polygon[3] { &polygon[..3] } else { polygon }
    }
}
