//! Blocks, turned forms and sheets, from which furniture is put together.

use std::f64::consts::TAU;

use glam::{DAffine3, DVec2, DVec3};

use crate::builtin::rectangle::{BOX_FACES, box_corners};
use crate::model::{Face, Material, Surface};

/// A set of box faces, for those that another thing covers.
pub(super) type Sides = u8;
pub(super) const NONE: Sides = 0;
pub(super) const BOTTOM: Sides = 1;
pub(super) const TOP: Sides = 1 << 1;
/// Low z.
pub(super) const FRONT: Sides = 1 << 2;
/// High z.
pub(super) const BACK: Sides = 1 << 3;
/// Low x.
pub(super) const LEFT: Sides = 1 << 4;
/// High x.
pub(super) const RIGHT: Sides = 1 << 5;

/// Vertices and faces without a material.
#[derive(Clone, Debug, Default)]
pub(super) struct Shape {
    vertices: Vec<DVec3>,
    faces: Vec<Face>,
}

impl Shape {
    /// An axis-aligned block without the faces that are hidden.
    pub fn block(low: [f64; 3], high: [f64; 3], hidden: Sides) -> Self {
        let faces = BOX_FACES.iter().enumerate().filter(|(side, _)| hidden >> side & 1 == 0);
        Self { vertices: box_corners(low.into(), high.into()).to_vec(), faces: faces.map(|(_, &face)| face).collect() }
    }

    /// One quad, seen from where its corners run counter-clockwise.
    pub fn quad(corners: [[f64; 3]; 4]) -> Self {
        Self { vertices: corners.map(DVec3::from_array).to_vec(), faces: vec![[0, 1, 2, 3]] }
    }

    /// One triangle.
    pub fn triangle(corners: [DVec3; 3]) -> Self {
        Self { vertices: corners.to_vec(), faces: vec![[0, 1, 2, 2]] }
    }

    /// What a lathe makes: a profile of (radius, height) turned about the vertical through `foot`.
    ///
    /// A profile that rises has its front outside.
    pub fn turned(foot: [f64; 3], profile: &[(f64, f64)], segments: u32) -> Self {
        let mut shape = Self::default();
        let foot = DVec3::from_array(foot);
        for &(radius, height) in profile {
            shape.vertices.extend((0..segments).map(|i| {
                let (sin, cos) = (TAU * f64::from(i) / f64::from(segments)).sin_cos();
                foot + DVec3::new(radius * cos, height, -radius * sin)
            }));
        }
        for (ring, ends) in (0_u32..).zip(profile.windows(2)) {
            for i in 0..segments {
                let corner = |ring: u32, i: u32| ring * segments + i % segments;
                let [a, b] = [corner(ring, i), corner(ring, i + 1)];
                let [c, d] = [corner(ring + 1, i + 1), corner(ring + 1, i)];
                // A ring of radius zero is a point.
                shape.faces.push(match (ends[0].0 == 0.0, ends[1].0 == 0.0) {
                    (true, _) => [a, c, d, d],
                    (_, true) => [a, b, c, c],
                    _ => [a, b, c, d],
                });
            }
        }
        shape
    }

    /// A ball.
    pub fn ball(centre: [f64; 3], radius: f64, segments: u32) -> Self {
        let rings = segments / 2;
        let angle = |ring: u32| std::f64::consts::PI * (f64::from(ring) / f64::from(rings) - 0.5);
        let point = |ring: u32| match ring {
            0 => (0.0, -radius),
            ring if ring == rings => (0.0, radius),
            ring => (radius * angle(ring).cos(), radius * angle(ring).sin()),
        };
        Self::turned(centre, &(0..=rings).map(point).collect::<Vec<_>>(), segments)
    }

    /// A vertical sheet along a line on the floor plan (x, z), from `low` to `high`.
    pub fn sheet(line: &[DVec2], low: f64, high: f64) -> Self {
        let at = |p: &DVec2, y| DVec3::new(p.x, y, p.y);
        let vertices = line.iter().flat_map(|p| [at(p, low), at(p, high)]).collect();
        let faces = (1..line.len() as u32).map(|i| [2 * i - 2, 2 * i, 2 * i + 1, 2 * i - 1]).collect();
        Self { vertices, faces }
    }

    /// This and another.
    pub fn and(mut self, other: Self) -> Self {
        let offset = self.vertices.len() as u32;
        self.vertices.extend(other.vertices);
        self.faces.extend(other.faces.iter().map(|face| face.map(|vertex| vertex + offset)));
        self
    }

    /// All together.
    pub fn all(shapes: impl IntoIterator<Item = Self>) -> Self {
        shapes.into_iter().fold(Self::default(), Self::and)
    }

    /// Moved by a rigid transform.
    pub fn moved(mut self, transform: DAffine3) -> Self {
        self.vertices.iter_mut().for_each(|vertex| *vertex = transform.transform_point3(*vertex));
        self
    }

    /// Painted and named, without the vertices that hidden faces leave behind.
    pub fn surface(self, name: &str, material: &Material) -> Surface {
        let mut place = vec![None; self.vertices.len()];
        let mut vertices = Vec::new();
        let mut faces = self.faces;
        for corner in faces.iter_mut().flatten() {
            *corner = *place[*corner as usize].get_or_insert_with(|| {
                vertices.push(self.vertices[*corner as usize]);
                vertices.len() as u32 - 1
            });
        }
        Surface { name: name.into(), vertices, faces, material: material.clone(), texture: None }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn volume(shape: &Shape) -> f64 {
        let corner = |i: u32| shape.vertices[i as usize];
        let tetrahedra = |&[a, b, c, d]: &Face| {
            let first = corner(a).dot(corner(b).cross(corner(c)));
            first + corner(a).dot(corner(c).cross(corner(d)))
        };
        shape.faces.iter().map(tetrahedra).sum::<f64>() / 6.0
    }

    #[test]
    fn solids_enclose_their_volume() {
        assert!((volume(&Shape::block([1.; 3], [2., 3., 4.], NONE)) - 6.0).abs() < 1e-12);
        let cylinder = Shape::turned([1., 2., 3.], &[(0., 0.), (1., 0.), (1., 2.), (0., 2.)], 96);
        assert!((volume(&cylinder) - TAU).abs() < 0.01);
        let ball = Shape::ball([3., 1., 2.], 1.0, 96);
        assert!((volume(&ball) - 2.0 * TAU / 3.0).abs() < 0.02);
    }

    #[test]
    fn hidden_faces_leave_no_vertices() {
        let lid = Shape::block([0.; 3], [1.; 3], !TOP).surface("lid", &Material::default());
        assert_eq!((lid.vertices.len(), lid.faces.len()), (4, 1));
    }
}
