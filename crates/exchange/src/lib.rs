//! How much of what leaves one element arrives at another. Knows geometry and no colour.

pub mod convex;
pub mod elements;
pub mod enclosure;
pub mod exchange;
pub mod facets;
pub mod factors;
pub mod hierarchy;
pub mod images;
pub mod kernels;
pub mod looks;
pub mod luminaires;
pub mod on_demand;
pub mod operator;
pub mod pairs;
pub mod quadrature;
pub mod rows;
pub mod samples;
pub mod shots;
pub mod smoothing;
pub mod specular;
pub mod stored;
pub mod visibility;

pub use elements::Elements;
pub use enclosure::Enclosure;
pub use exchange::Exchange;
pub use factors::FormFactors;
pub use luminaires::{LightSample, Luminaire};
pub use on_demand::RowsOnDemand;
pub use rows::Rows;
pub use samples::Samples;
pub use shots::Shot;
pub use specular::Specular;
