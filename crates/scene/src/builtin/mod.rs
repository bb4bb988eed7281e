//! Scenes that need no file: known answers and familiar rooms.

mod cornell;
mod furnace;
mod plates;
mod rectangle;
mod room;

pub use cornell::{CornellVariant, cornell_box, cornell_grid, cornell_patches};
pub use furnace::furnace;
pub use plates::two_plates;
pub use room::furnished_room;
