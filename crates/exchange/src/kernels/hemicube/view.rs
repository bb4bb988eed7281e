//! The polygons as seen from one position: vertices in the frame of the source, and which faces each polygon may touch.

use super::face::{FACES, Grid, TOP, Window, on_face};
use super::polygons::{COPLANAR, Polygons};
use glam::DVec3;
use radiosity_geometry::sampling::Frame;

/// Where a hemicube stands and how it is turned.
#[derive(Clone, Copy, Debug)]
pub(super) struct Stand {
    pub position: DVec3,
    /// Its axes: the normal of the source is the hemicube's z. Of unit length unless widened.
    pub axes: [DVec3; 3],
    /// The patch it stands on, which it does not see.
    pub patch: usize,
}

impl Stand {
    /// Turns the hemicube about a normal by an angle.
    pub fn new(position: DVec3, normal: DVec3, angle: f64, patch: usize) -> Self {
        let frame = Frame::new(normal);
        let (sine, cosine) = angle.sin_cos();
        let x = cosine * frame.tangent + sine * frame.bitangent;
        let y = cosine * frame.bitangent - sine * frame.tangent;
        Self { position, axes: [x, y, normal], patch }
    }

    /// Draws everything in to the axis, so that the top of the hemicube shows what lies within `half_width` of it.
    ///
    /// The map is linear: lines stay lines, the order along them stays, and so does height.
    pub fn widened(self, half_width: f64) -> Self {
        let [x, y, z] = self.axes;
        Self { axes: [x / half_width, y / half_width, z], ..self }
    }
}

/// Bits of [`Place::code`].
///
/// Where a vertex is: on which side of the horizon and of the six planes through the source that bound the faces.
const BELOW: u32 = 1;
const X_OVER_Z: u32 = 1 << 1;
const MINUS_X_OVER_Z: u32 = 1 << 2;
const Y_OVER_Z: u32 = 1 << 3;
const MINUS_Y_OVER_Z: u32 = 1 << 4;
const X_OVER_Y: u32 = 1 << 5;
const X_OVER_MINUS_Y: u32 = 1 << 6;
/// From here one bit a face: the one whose axis is nearest. None where no face has the vertex in front of it.
const HOME: u32 = 8;

/// A vertex on the face whose axis is nearest.
#[derive(Clone, Copy, Default)]
struct Place {
    /// In pixels of that face, see [`Grid`]; single precision, so off by less than [`View::pad`].
    column: f32,
    row: f32,
    code: u32,
}

/// A polygon that may cover pixels of a face.
#[derive(Clone, Copy)]
pub(super) struct Item {
    pub polygon: u32,
    /// Holds every pixel that it can cover.
    pub window: Window,
}

/// Scratch for one position after another.
pub(super) struct View {
    resolution: usize,
    /// Vertices in the frame of the source, coordinate by coordinate, in extents of the scene; filled up to whole chunks.
    pub vertices: [Vec<f64>; 3],
    places: Vec<Place>,
    /// What to draw on each face, in the order of the polygons.
    pub items: [Vec<Item>; FACES],
}

/// How many vertices are placed together.
const LANES: usize = 8;

impl View {
    pub fn new(resolution: usize) -> Self {
        Self { resolution, vertices: Default::default(), places: Vec::new(), items: Default::default() }
    }

    /// Takes a position: fills everything.
    #[inline(always)]
    pub fn look(&mut self, polygons: &Polygons, stand: &Stand) {
        self.place_vertices(polygons, stand);
        for items in &mut self.items {
            items.clear();
        }
        let own = polygons.of_patch(stand.patch);
        self.choose(polygons, 0..own.start);
        self.choose(polygons, own.end..polygons.len());
    }

    #[inline(always)]
    fn place_vertices(&mut self, polygons: &Polygons, stand: &Stand) {
        let count = polygons.vertices[0].len();
        let filled = count.next_multiple_of(LANES);
        for list in &mut self.vertices {
            list.resize(filled, 0.0);
        }
        self.places.resize(filled, Place::default());
        let axes = stand.axes.map(|axis| axis / polygons.extent);
        let grids = [Grid::new(TOP, self.resolution), Grid::new(TOP + 1, self.resolution)];
        for first in (0..count).step_by(LANES) {
            let mut world = [[0.0; LANES]; 3];
            let some = LANES.min(count - first);
            for (lanes, list) in world.iter_mut().zip(&polygons.vertices) {
                lanes[..some].copy_from_slice(&list[first..first + some]);
            }
            let local = to_frame(&world, stand.position, &axes);
            for (list, lanes) in self.vertices.iter_mut().zip(&local) {
                list[first..first + LANES].copy_from_slice(lanes);
            }
            place(&local, &grids, (&mut self.places[first..first + LANES]).try_into().unwrap());
        }
    }

    /// Lists polygons on the faces that they may touch.
    #[inline(always)]
    fn choose(&mut self, polygons: &Polygons, range: std::ops::Range<usize>) {
        let pad = self.pad();
        for (polygon, corners) in range.clone().zip(&polygons.corners[range]) {
            let place = |corner: usize| &self.places[corners[corner] as usize];
            let (a, b, c, d) = (place(0), place(1), place(2), place(3));
            let all = a.code & b.code & c.code & d.code;
            if all & BELOW != 0 {
                continue;
            }
            let polygon = polygon as u32;
            if all >> HOME == 0 {
                self.choose_across(polygon, corners, all, a.code | b.code | c.code | d.code);
                continue;
            }
            let face = (all >> HOME).trailing_zeros() as usize;
            let grid = Grid::new(face, self.resolution);
            let (left, right) = bounds([a.column, b.column, c.column, d.column]);
            let (low, high) = bounds([a.row, b.row, c.row, d.row]);
            let window = Window {
                columns: between(left - pad, right + pad, grid.columns),
                rows: between(low - pad, high + pad, grid.rows),
            };
            if !window.is_empty() {
                self.items[face].push(Item { polygon, window });
            }
        }
    }

    /// Lists a polygon whose vertices are not all at home on one face.
    #[inline(never)]
    fn choose_across(&mut self, polygon: u32, corners: &[u32; 4], all: u32, any: u32) {
        for face in (0..FACES).filter(|&face| may_touch(face, all, any)) {
            let window = self.window(face, corners);
            if !window.is_empty() {
                self.items[face].push(Item { polygon, window });
            }
        }
    }

    /// The pixels between the corners' own; all, where a corner is not in front of the face.
    fn window(&self, face: usize, corners: &[u32; 4]) -> Window {
        let grid = Grid::new(face, self.resolution);
        let points = corners.map(|corner| on_face(face, self.vertex(corner)));
        if points.iter().any(|&[_, _, depth]| depth.is_nan() || depth <= 0.0) {
            return Window::all(&grid);
        }
        let (left, right) = bounds(points.map(|[u, _, depth]| grid.column(u / depth) as f32));
        let (low, high) = bounds(points.map(|[_, v, depth]| grid.row(v / depth) as f32));
        let pad = self.pad();
        Window {
            columns: between(left - pad, right + pad, grid.columns),
            rows: between(low - pad, high + pad, grid.rows),
        }
    }

    /// A vertex in the frame of the source, in extents of the scene.
    #[inline(always)]
    pub fn vertex(&self, index: u32) -> [f64; 3] {
        let [x, y, z] = &self.vertices;
        [x[index as usize], y[index as usize], z[index as usize]]
    }

    /// What single precision may be off by, in pixels: two units in the last place of the largest pixel.
    #[inline(always)]
    fn pad(&self) -> f32 {
        2.0 * f32::EPSILON * self.resolution as f32
    }
}

/// Coordinates of points along axes from a position.
#[inline(always)]
fn to_frame(world: &[[f64; LANES]; 3], eye: DVec3, axes: &[DVec3; 3]) -> [[f64; LANES]; 3] {
    let mut local = [[0.0; LANES]; 3];
    for (lanes, axis) in local.iter_mut().zip(axes) {
        for k in 0..LANES {
            let (x, y, z) = (world[0][k] - eye.x, world[1][k] - eye.y, world[2][k] - eye.z);
            lanes[k] = x * axis.x + y * axis.y + z * axis.z;
        }
    }
    local
}

/// Finds the home and the code of each vertex.
#[inline(always)]
fn place(local: &[[f64; LANES]; 3], [top, side]: &[Grid; 2], places: &mut [Place; LANES]) {
    let [x, y, z] = local;
    let (mut column, mut row, mut code) = ([0f32; LANES], [0f32; LANES], [0u32; LANES]);
    for k in 0..LANES {
        let (x, y, z) = (x[k], y[k], z[k]);
        let bit = |holds: bool, bit: u32| if holds { bit } else { 0 };
        let (beside_x, beside_y) = (x.abs(), y.abs());
        let on_top = z >= beside_x && z >= beside_y;
        let along_x = beside_x >= beside_y;
        let depth = if on_top {
            z
        } else if along_x {
            beside_x
        } else {
            beside_y
        };
        let u = if on_top | !along_x { x } else { y };
        let v = if on_top { y } else { z };
        let scale = top.scale / depth;
        column[k] = (u * scale + (top.scale - 0.5)) as f32;
        row[k] = (v * scale + if on_top { top.scale - 0.5 } else { -side.lowest * side.scale - 0.5 }) as f32;
        let home_x = if x > 0.0 { 1 << 1 } else { 1 << 2 };
        let home_y = if y > 0.0 { 1 << 3 } else { 1 << 4 };
        let home = if on_top {
            1 << TOP
        } else if along_x {
            home_x
        } else {
            home_y
        };
        let home = if depth > 0.0 { home << HOME } else { 0 };
        code[k] = home
            | bit(z <= COPLANAR, BELOW)
            | bit(x > z, X_OVER_Z)
            | bit(-x > z, MINUS_X_OVER_Z)
            | bit(y > z, Y_OVER_Z)
            | bit(-y > z, MINUS_Y_OVER_Z)
            | bit(x > y, X_OVER_Y)
            | bit(x > -y, X_OVER_MINUS_Y);
    }
    for (k, place) in places.iter_mut().enumerate() {
        *place = Place { column: column[k], row: row[k], code: code[k] };
    }
}

/// Whether a polygon can reach into the pyramid of a face, by what all of its corners and what any of them have.
fn may_touch(face: usize, all: u32, any: u32) -> bool {
    match face {
        TOP => all & (X_OVER_Z | MINUS_X_OVER_Z | Y_OVER_Z | MINUS_Y_OVER_Z) == 0,
        1 => any & X_OVER_Z != 0 && any & X_OVER_Y != 0 && any & X_OVER_MINUS_Y != 0,
        2 => any & MINUS_X_OVER_Z != 0 && all & (X_OVER_Y | X_OVER_MINUS_Y) == 0,
        3 => any & Y_OVER_Z != 0 && all & X_OVER_Y == 0 && any & X_OVER_MINUS_Y != 0,
        _ => any & MINUS_Y_OVER_Z != 0 && any & X_OVER_Y != 0 && all & X_OVER_MINUS_Y == 0,
    }
}

/// The least and the greatest.
#[inline(always)]
fn bounds([a, b, c, d]: [f32; 4]) -> (f32, f32) {
    let less = |p: f32, q: f32| if p < q { p } else { q };
    let more = |p: f32, q: f32| if p > q { p } else { q };
    (less(less(a, b), less(c, d)), more(more(a, b), more(c, d)))
}

/// The whole numbers after `low`, to `high`, as pixels out of `count`, end excluded.
#[inline(always)]
fn between(low: f32, high: f32, count: usize) -> [u16; 2] {
    // Truncation rounds down what is not negative, so this is the first whole number above `x`.
    let after = |x: f32| (x.clamp(-1.0, count as f32 - 1.0) + 1.0) as u32 as u16;
    [after(low), after(high)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn windows_hold_whole_numbers_between() {
        assert_eq!(between(-0.5, 3.5, 8), [0, 4]);
        assert_eq!(between(2.1, 2.9, 8), [3, 3]);
        assert_eq!(between(2.9, 3.1, 8), [3, 4]);
        assert_eq!(between(-7.0, -3.0, 8), [0, 0]);
        assert_eq!(between(-1e30, f32::INFINITY, 8), [0, 8]);
        assert_eq!(between(9.0, 12.0, 8), [8, 8]);
    }
}
