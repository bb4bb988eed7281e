//! Methods for one form factor, a file each.

pub mod hemicube;
pub mod point_to_polygon;
