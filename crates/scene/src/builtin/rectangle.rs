//! Rectangles and boxes, of which the built-in scenes are made.

use glam::DVec3;

use crate::model::{Face, Material, Surface};

/// A rectangle or parallelogram with corners o, o + u, o + u + v, o + v; its front is where u x v points.
#[derive(Clone, Copy, Debug)]
pub(super) struct Rectangle {
    pub o: DVec3,
    pub u: DVec3,
    pub v: DVec3,
}

impl Rectangle {
    pub fn new(o: [f64; 3], u: [f64; 3], v: [f64; 3]) -> Self {
        Self { o: o.into(), u: u.into(), v: v.into() }
    }

    pub fn corners(&self) -> [DVec3; 4] {
        let Self { o, u, v } = *self;
        [o, o + u, o + u + v, o + v]
    }

    /// Turned so that its front looks along `outward`.
    pub fn facing(self, outward: DVec3) -> Self {
        if self.u.cross(self.v).dot(outward) < 0.0 { Self { o: self.o + self.u, u: -self.u, ..self } } else { self }
    }
}

/// A surface of separate quads.
pub(super) fn surface(name: &str, quads: &[[DVec3; 4]], material: &Material) -> Surface {
    let faces = (0..quads.len() as u32).map(|i| [4 * i, 4 * i + 1, 4 * i + 2, 4 * i + 3]);
    Surface {
        name: name.to_string(),
        vertices: quads.iter().flatten().copied().collect(),
        faces: faces.collect(),
        material: material.clone(),
        texture: None,
    }
}

/// The six faces of an axis-aligned box that share eight vertices, seen from outside.
///
/// Order: bottom, top (y), front, back (z), left, right (x).
pub(super) const BOX_FACES: [Face; 6] =
    [[0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6], [0, 4, 6, 2], [1, 3, 7, 5]];

/// The corners of a box; bits 0, 1, 2 of the index choose the high x, y, z.
pub(super) fn box_corners(low: DVec3, high: DVec3) -> [DVec3; 8] {
    std::array::from_fn(|i| {
        let pick = |axis: usize| if i >> axis & 1 == 1 { high[axis] } else { low[axis] };
        DVec3::new(pick(0), pick(1), pick(2))
    })
}

/// An axis-aligned box as one surface, lit from outside.
pub(super) fn cuboid(name: &str, low: DVec3, high: DVec3, material: &Material) -> Surface {
    Surface {
        name: name.to_string(),
        vertices: box_corners(low, high).to_vec(),
        faces: BOX_FACES.to_vec(),
        material: material.clone(),
        texture: None,
    }
}

/// The same surface with every face turned over.
pub(super) fn inside_out(mut surface: Surface) -> Surface {
    for face in &mut surface.faces {
        // Keeps the repeated corner of a triangle last.
        *face = if face[2] == face[3] {
            [face[0], face[2], face[1], face[1]]
        } else {
            [face[0], face[3], face[2], face[1]]
        };
    }
    surface
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn boxes_look_outward() {
        let (low, high) = (DVec3::new(1.0, 2.0, 3.0), DVec3::new(2.0, 4.0, 6.0));
        let centre = 0.5 * (low + high);
        let solid = cuboid("box", low, high, &Material::default());
        for &face in &solid.faces {
            let [a, b, c, d] = solid.corners(face);
            let (area, middle) = (0.5 * (c - a).cross(d - b), 0.25 * (a + b + c + d));
            assert!(area.dot(middle - centre) > 0.0, "{face:?}");
        }
        let area: f64 = solid
            .faces
            .iter()
            .map(|&face| {
                let [a, b, c, d] = solid.corners(face);
                0.5 * (c - a).cross(d - b).length()
            })
            .sum();
        assert!((area - 22.0).abs() < 1e-12);
    }

    #[test]
    fn facing_keeps_the_rectangle() {
        let floor = Rectangle::new([0., 0., 0.], [1., 0., 0.], [0., 0., 1.]);
        let up = floor.facing(DVec3::Y);
        assert!(up.u.cross(up.v).y > 0.0);
        assert_eq!(up.corners()[0], DVec3::X);
    }
}
