//! Light by random paths.
//!
//! A path starts at a point and finds out what arrives there: from lamps by points on them, from the rest by
//! cosine-distributed rays. Where it ends tells two methods apart. A *gather* ends where it first lands, and takes what
//! a solution says leaves there. A *path tracer* goes on until nothing is left, takes from surfaces only what they emit,
//! and so needs no solution: an independent check of every solver.
//!
//! Nothing here knows cameras or pictures; whoever wants the light at points brings the points.

mod exitance;
mod gloss;
mod lamps;
mod lights;
mod means;
mod meter;
mod rounds;
mod scatter;
#[cfg(test)]
mod tests;
mod tracer;
mod walk;

pub use exitance::Exitance;
pub use gloss::{Gloss, Lobe, Way};
pub use lights::Light;
pub use means::Means;
pub use meter::{Measured, at_points, direct_of_sides, of_sides, rest_of_sides};
pub use rounds::{Effort, Rounds, rounds};
pub use tracer::{LampSight, Start, Tracer};
pub use walk::Walk;
