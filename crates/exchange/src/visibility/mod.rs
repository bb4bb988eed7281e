//! What stands between two facets, and how much of their exchange it hides.
//!
//! Everything here errs toward "perhaps": a blocker leaves the list of candidates only when it is proven not to block.
//!
//! 1. [`blockers`]: the polygons that could block anything, patches of one flat face merged again.
//! 2. [`shaft`]: which of them could block between two boxes, or between two facets.
//! 3. [`fragments`]: what is visible of a polygon from a point, exactly, as convex fragments.
//! 4. [`hidden`]: the exchange that blockers hide between two polygons, by adaptive cubature over one of them.
//! 5. [`rays`]: the same by a few rays, where that is accurate enough.

pub mod blockers;
pub mod fragments;
pub mod hidden;
pub mod rays;
pub mod shaft;

pub use blockers::{Blocker, Blockers};
pub use shaft::Shaft;
