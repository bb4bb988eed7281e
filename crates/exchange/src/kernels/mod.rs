//! Methods for one form factor, a file each.

pub mod areas;
pub mod contour;
pub mod nusselt;
pub mod point_to_polygon;
