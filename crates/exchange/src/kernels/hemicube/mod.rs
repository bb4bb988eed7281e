//! The hemicube: form factors from one point to everything it sees, by drawing it.
//!
//! Cohen and Greenberg 1985, *The hemi-cube: a radiosity solution for complex environments*. The polygons of the scene
//! are drawn on the five faces of half a cube about a point of a side, with a z-buffer that keeps which side is nearest
//! in every pixel; a pixel is worth its delta form factor. What differs from the article:
//!
//! - Delta form factors are integrated exactly over each pixel, so a row of a closed room sums to 1 to rounding.
//! - The cube is turned about the normal by a random angle, so that the aliasing of regular rows and columns of pixels
//!   with walls parallel to them varies from side to side instead of adding up.
//! - Several positions on a side can be averaged. One position is blind to how the view varies over the side: near
//!   what touches it, that error is far larger than that of the pixels (Baum, Rushmeier and Winget 1989).
//! - Nothing is clipped, see `raster.rs`.
//!
//! A pixel belongs to what covers its centre, so the error of one form factor is that of counting pixels: it falls as
//! 1/resolution where edges run along rows of pixels, as 1/resolution^1.5 or faster over random turns, and what is
//! smaller than a pixel is hit or missed as a whole.
//!
//! Deliberately absent: subpixel coverage; a hierarchical z-buffer, because rooms are few layers deep and what costs is
//! to set up small polygons; solids that stand on a side: a position inside one sees the solid's inside.

mod delta;
mod face;
mod merge;
mod polygons;
mod raster;
mod single_plane;
mod tally;
#[cfg(test)]
mod tests;
mod view;

pub use delta::delta_form_factors;
pub use single_plane::{single_plane_rows_of, single_plane_share};

use crate::enclosure::Enclosure;
use crate::rows::Rows;
use delta::Strips;
use face::{FACES, Grid, TOP, from_face};
use glam::DVec3;
#[cfg(target_arch = "x86_64")]
use merge::Avx2;
use merge::{Merge, Plain};
use polygons::Polygons;
use radiosity_geometry::Chart;
use radiosity_geometry::bvh::Kernel;
use radiosity_geometry::sampling::Sequence;
use radiosity_operator::{Cancelled, Control};
use raster::Pixels;
use rayon::prelude::*;
use tally::Tally;
use view::{Stand, View};

/// How finely a hemicube is drawn, and where.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Settings {
    /// Pixels along an edge: even, 8 to 4096. The top has `resolution` squared, each side half as many.
    pub resolution: usize,
    /// Hemicubes per side: 1 stands on the centroid, more are spread over the side evenly in area.
    pub positions: usize,
    /// Turns the hemicubes, and places them if there are several.
    pub seed: u64,
}

impl Default for Settings {
    fn default() -> Self {
        Self { resolution: 512, positions: 1, seed: 0 }
    }
}

impl Settings {
    /// # Panics
    /// If a field is out of its range.
    pub(crate) fn check(&self) {
        let Self { resolution, positions, .. } = *self;
        assert!(
            resolution % 2 == 0 && (8..=4096).contains(&resolution),
            "the resolution of a hemicube is even and in 8..=4096, not {resolution}"
        );
        assert!(positions > 0, "a hemicube needs a position");
    }
}

/// The rows of all sides.
///
/// A row sums to 1 where nothing escapes and no back or obstruction is seen. Patches without area have empty rows.
/// Progress counts sides. The same seed gives the same bits on any number of threads and with every instruction set.
///
/// # Panics
/// If a field of `settings` is out of its range.
pub fn rows(enclosure: &Enclosure, settings: &Settings, control: &Control) -> Result<Rows, Cancelled> {
    rows_of(enclosure, &(0..enclosure.sides()).collect::<Vec<_>>(), settings, control)
}

/// The rows of some sides, in their order; as [`rows`] otherwise.
pub fn rows_of(
    enclosure: &Enclosure,
    sides: &[usize],
    settings: &Settings,
    control: &Control,
) -> Result<Rows, Cancelled> {
    settings.check();
    Scene::new(enclosure, settings, Kernel::detect()).rows_of(sides, control)
}

/// The rows of some sides by independent sets of hemicubes, `positions` in all: by side, then by set.
///
/// # Panics
/// If a field of `settings` is out of its range, or the sets are not equally many of the positions.
pub fn replicates_of(enclosure: &Enclosure, sides: &[usize], settings: &Settings, replicates: usize) -> Vec<Vec<Row>> {
    settings.check();
    assert!(
        settings.positions.is_multiple_of(replicates),
        "{replicates} equal sets of {} hemicubes",
        settings.positions
    );
    let scene = Scene::new(enclosure, settings, Kernel::detect());
    let rows = |hemicube: &mut Hemicube, &side: &usize| hemicube.replicates(&scene, side, replicates);
    sides.par_iter().map_init(|| Hemicube::new(&scene), rows).collect()
}

/// `(side, F)` in ascending order.
type Row = Vec<(u32, f64)>;

/// What the hemicube at the first position of a side sees, pixel by pixel.
///
/// # Panics
/// If a field of `settings` is out of its range.
pub fn item_buffer(enclosure: &Enclosure, side: usize, settings: &Settings) -> ItemBuffer {
    settings.check();
    let scene = Scene::new(enclosure, settings, Kernel::detect());
    let stand = stand(enclosure, side, settings, (0, 0));
    let mut buffer = ItemBuffer {
        resolution: settings.resolution,
        position: stand.position,
        axes: stand.axes,
        owner: Default::default(),
        depth: Default::default(),
    };
    if enclosure.area(side) > 0.0 {
        let mut hemicube = Hemicube::new(&scene);
        hemicube.view.look(&scene.polygons, &stand);
        for face in 0..FACES {
            let grid = Grid::new(face, settings.resolution);
            raster::draw::<Plain>(face, &grid, &hemicube.view, &scene.polygons, &mut hemicube.pixels);
            buffer.copy(face, &grid, &hemicube.pixels, &scene.polygons);
        }
    }
    buffer
}

/// What all hemicubes share.
struct Scene<'a> {
    enclosure: &'a Enclosure,
    settings: &'a Settings,
    polygons: Polygons,
    strips: Strips,
    kernel: Kernel,
    /// How many faces are drawn: all, or the top alone.
    faces: usize,
    /// How far the top reaches to either side, in units of its distance.
    half_width: f64,
}

impl<'a> Scene<'a> {
    fn new(enclosure: &'a Enclosure, settings: &'a Settings, kernel: Kernel) -> Self {
        let (polygons, strips) = (Polygons::new(enclosure), Strips::new(settings.resolution));
        Self { enclosure, settings, polygons, strips, kernel, faces: FACES, half_width: 1.0 }
    }

    fn rows_of(&self, sides: &[usize], control: &Control) -> Result<Rows, Cancelled> {
        control.expect(sides.len() as u64);
        let row = |hemicube: &mut Hemicube, &side: &usize| {
            control.check()?;
            let row = hemicube.row(self, side);
            control.advance(1);
            Ok(row)
        };
        let rows = sides.par_iter().map_init(|| Hemicube::new(self), row).collect::<Result<_, _>>()?;
        Ok(Rows::from_rows(rows))
    }
}

/// Buffers for one hemicube after another.
struct Hemicube {
    view: View,
    pixels: Pixels,
    tally: Tally,
}

impl Hemicube {
    fn new(scene: &Scene) -> Self {
        let resolution = scene.settings.resolution;
        Self {
            view: View::new(resolution),
            pixels: Pixels::new(resolution),
            tally: Tally::new(scene.polygons.nothing() as usize + 1),
        }
    }

    /// The row of a side.
    fn row(&mut self, scene: &Scene, side: usize) -> Vec<(u32, f64)> {
        if scene.enclosure.area(side) > 0.0 {
            for index in 0..scene.settings.positions {
                self.see(scene, &stand(scene.enclosure, side, scene.settings, (0, index)).widened(scene.half_width));
            }
        }
        self.tally.take(scene.enclosure.sides(), 1.0 / scene.settings.positions as f64)
    }

    /// The rows of a side by independent sets of positions.
    fn replicates(&mut self, scene: &Scene, side: usize, replicates: usize) -> Vec<Row> {
        let each = scene.settings.positions / replicates;
        let row = |replicate| {
            for index in (0..each).filter(|_| scene.enclosure.area(side) > 0.0) {
                self.see(scene, &stand(scene.enclosure, side, scene.settings, (replicate, index)));
            }
            self.tally.take(scene.enclosure.sides(), 1.0 / each as f64)
        };
        (0..replicates as u32).map(row).collect()
    }

    /// Adds what is seen from one position to the tally.
    fn see(&mut self, scene: &Scene, stand: &Stand) {
        match scene.kernel {
            #[cfg(target_arch = "x86_64")]
            // SAFETY: the kernel comes from `Kernel::available`, which lists AVX2 only where the processor has it.
            Kernel::Avx2 => unsafe { self.see_avx2(scene, stand) },
            _ => self.see_with::<Plain>(scene, stand),
        }
    }

    /// All of it is inlined here and so compiled for AVX2; without fused operations, so that bits do not change.
    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx2")]
    fn see_avx2(&mut self, scene: &Scene, stand: &Stand) {
        self.see_with::<Avx2>(scene, stand);
    }

    #[inline(always)]
    fn see_with<M: Merge>(&mut self, scene: &Scene, stand: &Stand) {
        self.view.look(&scene.polygons, stand);
        for face in 0..scene.faces {
            let grid = Grid::new(face, scene.settings.resolution);
            raster::draw::<M>(face, &grid, &self.view, &scene.polygons, &mut self.pixels);
            self.tally.add(face, &grid, &scene.strips, &self.pixels);
        }
    }
}

/// The stream of the sequence that places and turns hemicubes.
const STREAM: u32 = 3;

/// The place and turn of one of a side's hemicubes, by replicate and index.
fn stand(enclosure: &Enclosure, side: usize, settings: &Settings, (replicate, index): (u32, usize)) -> Stand {
    let patch = enclosure.patch_of(side);
    let patches = enclosure.patches();
    let [s, t, turn, _] = Sequence::new(settings.seed, side as u32, replicate, STREAM).point(index as u32);
    let position = match settings.positions {
        1 => patches.centre[patch],
        _ => Chart::new(&patches.polygons[patch]).point(s, t),
    };
    Stand::new(position, enclosure.normal(side), std::f64::consts::TAU * turn, patch)
}

/// What each pixel of a hemicube sees.
///
/// Faces in order: top, then the sides along the first axis, against it, along the second, against it. The top has
/// `resolution` rows along the second axis of as many pixels along the first. Sides have half as many rows, from
/// the horizon up, of as many pixels along the other tangent. A side without area has no pixels at all.
#[derive(Clone, Debug, PartialEq)]
pub struct ItemBuffer {
    /// Pixels along an edge.
    pub resolution: usize,
    /// Where the hemicube stands, metres.
    pub position: DVec3,
    /// Its axes: two tangents and the normal.
    pub axes: [DVec3; 3],
    /// The side seen, or one of the codes below.
    pub owner: [Vec<u32>; 5],
    /// How far along the axis of the face what is seen lies, metres; infinite where there is nothing.
    pub depth: [Vec<f32>; 5],
}

impl ItemBuffer {
    /// Nothing is there.
    pub const NOTHING: u32 = u32::MAX;
    /// The black back of a one-sided patch, or an obstruction.
    pub const BACK: u32 = u32::MAX - 1;

    /// The direction through the centre of a pixel, not of unit length.
    pub fn direction(&self, face: usize, row: usize, column: usize) -> DVec3 {
        let grid = Grid::new(face, self.resolution);
        let [x, y, z] = from_face(face, [grid.u(column as f64), grid.v(row as f64), 1.0]);
        x * self.axes[0] + y * self.axes[1] + z * self.axes[2]
    }

    /// Owners on the unfolded hemicube, `2 resolution` rows of as many: the top in the middle, each side folded down
    /// from the edge it shares with it, nothing in the corners. Rows run along the second axis.
    pub fn unfolded(&self) -> Vec<u32> {
        let (size, half) = (2 * self.resolution, self.resolution / 2);
        let mut picture = vec![Self::NOTHING; size * size];
        for (face, owners) in self.owner.iter().enumerate() {
            for (pixel, &owner) in owners.iter().enumerate() {
                let (row, column) = (pixel / self.resolution, pixel % self.resolution);
                let (x, y) = match face {
                    TOP => (half + column, half + row),
                    1 => (size - 1 - row, half + column),
                    2 => (row, half + column),
                    3 => (half + column, size - 1 - row),
                    _ => (half + column, row),
                };
                picture[y * size + x] = owner;
            }
        }
        picture
    }

    fn copy(&mut self, face: usize, grid: &Grid, pixels: &Pixels, polygons: &Polygons) {
        let code = |owner: u32| match owner {
            owner if owner == polygons.black() => Self::BACK,
            owner if owner == polygons.nothing() => Self::NOTHING,
            side => side,
        };
        for row in 0..grid.rows {
            self.owner[face].extend(pixels.owners(row)[..grid.columns].iter().map(|&owner| code(owner)));
            let depths =
                pixels.nearness(row)[..grid.columns].iter().map(|&near| (polygons.extent / f64::from(near)) as f32);
            self.depth[face].extend(depths);
        }
    }
}
