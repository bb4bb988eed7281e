//! An 8-wide bounding volume hierarchy over triangles.
