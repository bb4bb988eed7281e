//! Surfaces cut into patches, rays that find them, and the points and directions to shoot.
//!
//! This crate knows shapes only: no light, no colour, no files.

pub mod bvh;
pub mod patches;

pub use glam::{DVec3, Vec3};
pub use patches::Patches;
