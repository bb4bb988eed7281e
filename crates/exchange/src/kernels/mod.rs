//! Methods for one form factor, a file each.
//!
//! | | what it computes | error |
//! |---|---|---|
//! | [`areas`] | polygon to polygon, Gauss points on both | a bound by separation |
//! | [`contour`] | polygon to polygon, along both outlines | what is asked; closed for rectangles |
//! | [`nusselt`] | point to polygon as the covered share of a disk, averaged | none at a point |
//! | [`hemicube`] | point to everything, by drawing it | about 1 / resolution |
//! | [`point_to_polygon`] | point to polygon, Lambert's formula | rounding |
//!
//! Rays, the Monte Carlo method, are in [`crate::shots`].

pub mod areas;
pub mod contour;
pub mod hemicube;
pub mod nusselt;
pub mod point_to_polygon;
