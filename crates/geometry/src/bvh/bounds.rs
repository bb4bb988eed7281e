//! Axis-aligned boxes.

use glam::{Vec3, Vec3A};

/// An axis-aligned box; empty when its lower corner lies above its upper one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Bounds {
    pub min: Vec3A,
    pub max: Vec3A,
}

impl Bounds {
    pub const EMPTY: Self = Self { min: Vec3A::INFINITY, max: Vec3A::NEG_INFINITY };

    pub fn of_points(points: &[Vec3]) -> Self {
        points.iter().fold(Self::EMPTY, |bounds, &p| bounds.union(Self::of_point(p.into())))
    }

    #[inline]
    pub fn of_point(point: Vec3A) -> Self {
        Self { min: point, max: point }
    }

    #[inline]
    pub fn union(self, other: Self) -> Self {
        Self { min: self.min.min(other.min), max: self.max.max(other.max) }
    }

    /// Half the surface area; zero for the empty box.
    #[inline]
    pub fn half_area(self) -> f32 {
        let d = (self.max - self.min).max(Vec3A::ZERO);
        let products = d * Vec3A::new(d.y, d.z, d.x);
        products.x + products.y + products.z
    }

    #[inline]
    pub fn contains(self, other: Self) -> bool {
        self.min.cmple(other.min).all() && self.max.cmpge(other.max).all()
    }
}
