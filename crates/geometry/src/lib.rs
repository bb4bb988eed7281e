//! Surfaces cut into patches, rays that find them, and the points and directions to shoot.
//!
//! This crate knows shapes, and images laid over them, only: no light, no colour, no files.

pub mod bvh;
pub mod chart;
pub mod corners;
pub mod patches;
pub mod sampling;
pub mod texture;

pub use chart::Chart;
pub use corners::Corners;
pub use glam::{DVec3, Vec3};
pub use patches::Patches;
