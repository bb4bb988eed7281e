//! Methods for one form factor, a file each.

pub mod contour;
pub mod point_to_polygon;
