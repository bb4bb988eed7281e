//! What stands, hangs and lies in the room. Legs stand on the floor without a bottom face; what is covered is left out.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use glam::{DAffine3, DQuat, DVec3};

use super::paint;
use super::shape::{BACK, BOTTOM, FRONT, LEFT, NONE, RIGHT, Shape, Sides, TOP};
use super::shell::SIZE;
use crate::model::Surface;

const BACK_WALL: f64 = SIZE[2];
const RUG_TOP: f64 = 0.012;
const DINING: [f64; 2] = [1.55, 2.15];
const COFFEE: [f64; 2] = [3.75, 2.55];

pub(super) fn furniture(detail: u32) -> Vec<Surface> {
    let mut surfaces = Vec::new();
    surfaces.extend(dining_table(detail));
    surfaces.extend((0..4).map(chair));
    surfaces.extend(pendant(detail));
    surfaces.extend(sofa());
    surfaces.extend(rug());
    surfaces.extend(coffee_table(detail));
    surfaces.extend(floor_lamp(detail));
    surfaces.extend(bookcase(detail));
    surfaces.extend(plant(detail));
    surfaces.extend(painting());
    surfaces
}

/// Segments of a round thing.
fn round(detail: u32) -> u32 {
    10 + 6 * detail
}

/// A square post from the floor to the underside of what it carries.
fn leg(x: f64, z: f64, side: f64, low: f64, high: f64) -> Shape {
    let half = 0.5 * side;
    Shape::block([x - half, low, z - half], [x + half, high, z + half], TOP | BOTTOM)
}

fn dining_table(detail: u32) -> Vec<Surface> {
    let [x, z] = DINING;
    let top = Shape::block([x - 0.45, 0.72, z - 0.85], [x + 0.45, 0.755, z + 0.85], NONE);
    let corners = [(-1., -1.), (-1., 1.), (1., -1.), (1., 1.)];
    let legs = Shape::all(corners.map(|(i, j)| leg(x + 0.39 * i, z + 0.79 * j, 0.06, 0.0, 0.72)));
    let vase = [(0.05, 0.), (0.085, 0.05), (0.09, 0.11), (0.06, 0.19), (0.03, 0.24), (0.042, 0.27)];
    let cup = [(0.03, 0.), (0.04, 0.02), (0.042, 0.09)];
    let both = |shape: Shape, name: &str| shape.surface(name, &paint::ceramic().on_both_sides());
    let at = |dx: f64, dz: f64| [x + dx, 0.756, z + dz];
    vec![
        top.surface("dining table top", &paint::walnut()),
        legs.surface("dining table legs", &paint::walnut()),
        both(Shape::turned(at(0.0, 0.1), &vase, round(detail)), "vase"),
        both(Shape::turned(at(0.25, -0.4), &cup, round(detail)), "cup"),
        both(Shape::turned(at(-0.22, 0.45), &cup, round(detail)), "cup 2"),
    ]
}

/// One of four chairs about the table. In its own frame the sitter looks along +x.
fn chair(index: u32) -> Surface {
    let posts = [(-0.19, -0.19), (-0.19, 0.19), (0.19, -0.19), (0.19, 0.19)];
    let seat = Shape::block([-0.22, 0.44, -0.22], [0.22, 0.47, 0.22], NONE);
    let legs = Shape::all(posts.map(|(x, z)| leg(x, z, 0.036, 0.0, 0.44)));
    let stiles = [-0.19, 0.19].map(|z| Shape::block([-0.21, 0.47, z - 0.018], [-0.175, 0.9, z + 0.018], BOTTOM));
    let slat = |y: f64| Shape::block([-0.202, y, -0.172], [-0.183, y + 0.09, 0.172], SLAT_ENDS);
    let chair = Shape::all([seat, legs, slat(0.60), slat(0.76)]).and(Shape::all(stiles));
    let (side, along) = (if index.is_multiple_of(2) { -1.0 } else { 1.0 }, if index < 2 { -0.42 } else { 0.42 });
    let place = DVec3::new(DINING[0] + 0.55 * side, 0.0, DINING[1] + along);
    // No two chairs stand alike.
    let turn = f64::from(index) * 0.06 - 0.09 + if side > 0.0 { PI } else { 0.0 };
    let transform = DAffine3::from_rotation_translation(DQuat::from_rotation_y(turn), place);
    chair.moved(transform).surface(&format!("chair {}", index + 1), &paint::oak())
}

const SLAT_ENDS: Sides = FRONT | BACK;

fn pendant(detail: u32) -> Vec<Surface> {
    let foot = [DINING[0], 0.0, DINING[1]];
    let shade = [(0.30, 1.60), (0.24, 1.74), (0.12, 1.86), (0.012, 1.90)];
    vec![
        Shape::turned(foot, &shade, round(detail)).surface("pendant shade", &paint::parchment()),
        Shape::turned(foot, &[(0.006, 1.905), (0.006, SIZE[1])], 6).surface("pendant cord", &paint::brass()),
        Shape::ball([foot[0], 1.72, foot[2]], 0.06, round(detail)).surface("pendant lamp", &paint::lamplight()),
    ]
}

fn sofa() -> Vec<Surface> {
    let base = Shape::block([2.75, 0.12, 3.55], [4.75, 0.38, 4.40], NONE);
    let back = Shape::block([2.93, 0.38, 4.17], [4.57, 0.84, 4.40], BOTTOM | LEFT | RIGHT);
    let arms = [(2.75, 2.93), (4.57, 4.75)].map(|(x0, x1)| Shape::block([x0, 0.38, 3.55], [x1, 0.62, 4.40], BOTTOM));
    let ends = [(2.93, LEFT), (4.57, RIGHT)].map(|(x, side)| {
        // The back stands above the arms.
        Shape::block([x, 0.62, 4.17], [x, 0.84, 4.40], !side)
    });
    let seats = [(2.94, 3.745), (3.755, 4.56)].map(|(x0, x1)| Shape::block([x0, 0.38, 3.52], [x1, 0.53, 4.16], BOTTOM));
    let feet = [(2.83, 3.63), (4.67, 3.63), (2.83, 4.32), (4.67, 4.32)].map(|(x, z)| leg(x, z, 0.05, 0.0, 0.12));
    let frame = Shape::all([base, back]).and(Shape::all(arms)).and(Shape::all(ends));
    vec![
        frame.surface("sofa", &paint::denim()),
        Shape::all(seats).surface("sofa seats", &paint::denim()),
        Shape::all(feet).surface("sofa feet", &paint::walnut()),
        pillow(3.2, 0.12).surface("pillow", &paint::mustard()),
        pillow(4.28, -0.2).surface("pillow 2", &paint::terracotta()),
    ]
}

/// A pillow that leans against the back of the sofa.
fn pillow(x: f64, turn: f64) -> Shape {
    let tilt = DQuat::from_rotation_y(turn) * DQuat::from_rotation_x(0.26);
    let transform = DAffine3::from_rotation_translation(tilt, DVec3::new(x, 0.755, 4.0));
    Shape::block([-0.21, -0.21, -0.055], [0.21, 0.21, 0.055], NONE).moved(transform)
}

/// A wool rug with a terracotta border.
fn rug() -> Vec<Surface> {
    let ([x0, x1], [z0, z1], [inner_x0, inner_x1], [inner_z0, inner_z1]) =
        ([2.7, 4.8], [1.75, 3.3], [2.85, 4.65], [1.9, 3.15]);
    let flat = |[x0, x1]: [f64; 2], [z0, z1]: [f64; 2]| {
        Shape::quad([[x0, RUG_TOP, z0], [x0, RUG_TOP, z1], [x1, RUG_TOP, z1], [x1, RUG_TOP, z0]])
    };
    let border = Shape::all([
        Shape::block([x0, 0., z0], [x1, RUG_TOP, z1], TOP | BOTTOM),
        flat([x0, x1], [z0, inner_z0]),
        flat([x0, x1], [inner_z1, z1]),
        flat([x0, inner_x0], [inner_z0, inner_z1]),
        flat([inner_x1, x1], [inner_z0, inner_z1]),
    ]);
    vec![
        border.surface("rug border", &paint::terracotta()),
        flat([inner_x0, inner_x1], [inner_z0, inner_z1]).surface("rug", &paint::wool()),
    ]
}

fn coffee_table(detail: u32) -> Vec<Surface> {
    let [x, z] = COFFEE;
    let top = [(0., 0.36), (0.42, 0.36), (0.42, 0.395), (0., 0.395)];
    let legs = (0..3).map(|i| {
        let (sin, cos) = (TAU * f64::from(i) / 3.0).sin_cos();
        leg(x + 0.3 * cos, z + 0.3 * sin, 0.04, RUG_TOP, 0.36)
    });
    let bowl = [(0.05, 0.), (0.11, 0.03), (0.15, 0.08)];
    vec![
        Shape::turned([x, 0., z], &top, 2 * round(detail)).surface("coffee table top", &paint::oak()),
        Shape::all(legs).surface("coffee table legs", &paint::walnut()),
        Shape::turned([x - 0.12, 0.396, z + 0.1], &bowl, round(detail))
            .surface("bowl", &paint::terracotta().on_both_sides()),
    ]
}

fn floor_lamp(detail: u32) -> Vec<Surface> {
    let foot = [5.2, 0.0, 4.0];
    let stand = [(0.14, 0.0), (0.14, 0.02), (0.012, 0.022), (0.012, 1.42), (0.0, 1.42)];
    vec![
        Shape::turned(foot, &stand, round(detail)).surface("floor lamp stand", &paint::brass()),
        Shape::turned(foot, &[(0.22, 1.36), (0.15, 1.68)], round(detail))
            .surface("floor lamp shade", &paint::parchment()),
        Shape::ball([foot[0], 1.50, foot[2]], 0.06, round(detail)).surface("floor lamp", &paint::lamplight()),
    ]
}

/// Left and right ends, thickness of the boards, height, front.
const CASE: [f64; 2] = [0.95, 2.25];
const BOARD: f64 = 0.03;
const CASE_HEIGHT: f64 = 1.95;
const CASE_FRONT: f64 = BACK_WALL - 0.32;
const SHELVES: u32 = 5;
/// So that the top of the lowest shelf is not that of the skirting behind it.
const LOWEST_SHELF: f64 = 0.052;

fn bookcase(detail: u32) -> Vec<Surface> {
    let side = |x: f64| Shape::block([x, 0., CASE_FRONT], [x + BOARD, CASE_HEIGHT, BACK_WALL], BOTTOM | BACK);
    let shelf = |i: u32| {
        let y = shelf_height(i);
        Shape::block([CASE[0] + BOARD, y, CASE_FRONT], [CASE[1] - BOARD, y + BOARD, BACK_WALL], LEFT | RIGHT | BACK)
    };
    let boards = Shape::all((0..=SHELVES).map(shelf));
    let case = Shape::all([side(CASE[0]), side(CASE[1] - BOARD), boards]);
    let mut surfaces = vec![case.surface("bookcase", &paint::lacquer())];
    let mut by_colour = [const { Vec::new() }; 5];
    for (shape, colour) in (0..SHELVES).flat_map(|shelf| books(shelf, detail)) {
        by_colour[colour].push(shape);
    }
    for (shapes, material) in by_colour.into_iter().zip(paint::books()) {
        surfaces.push(Shape::all(shapes).surface(&material.name, &material));
    }
    surfaces
}

/// The underside of a shelf.
fn shelf_height(index: u32) -> f64 {
    LOWEST_SHELF + f64::from(index) * (CASE_HEIGHT - LOWEST_SHELF - BOARD) / f64::from(SHELVES)
}

/// Books side by side with their colour; the coarsest room has blocks of several.
fn books(shelf: u32, detail: u32) -> Vec<(Shape, usize)> {
    let y = shelf_height(shelf) + BOARD;
    let thickness = if detail == 0 { 0.16 } else { 0.036 };
    let end = CASE[1] - BOARD - 0.05 - 0.35 * vary(shelf, 99);
    let (mut x, mut books) = (CASE[0] + BOARD + 0.004, Vec::new());
    for number in 0.. {
        let size = |salt: u32| vary(1000 * shelf + number, salt);
        let width = thickness * (0.7 + 0.8 * size(1));
        if x + width > end {
            break;
        }
        let (height, depth) = (0.20 + 0.11 * size(2), 0.16 + 0.07 * size(3));
        let low = [x, y, CASE_FRONT + 0.02 + 0.02 * size(4)];
        let shape = Shape::block(low, [x + width, y + height, low[2] + depth], BOTTOM);
        books.push((shape, (size(5) * 4.999) as usize));
        x += width + 0.002;
    }
    books
}

/// A number in [0, 1) that looks random and is always the same (Steele, Lea and Flood's SplitMix64).
fn vary(index: u32, salt: u32) -> f64 {
    let mut z = (u64::from(index) << 32 | u64::from(salt)).wrapping_add(1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    z = (z ^ z >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ z >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
    ((z ^ z >> 31) >> 11) as f64 / (1_u64 << 53) as f64
}

fn plant(detail: u32) -> Vec<Surface> {
    let foot = [0.5, 0.0, 4.0];
    let pot = [(0.13, 0.0), (0.19, 0.34), (0.17, 0.34), (0.165, 0.30)];
    let leaves = 9 + 7 * detail;
    let leaf = |i: u32| {
        // Successive leaves stand a golden angle apart.
        let angle = 2.399_963 * f64::from(i);
        let rise = 1.0 - f64::from(i) / f64::from(leaves);
        leaf(DVec3::new(foot[0], 0.30, foot[2]), angle, 0.25 + 0.75 * rise)
    };
    vec![
        Shape::turned(foot, &pot, round(detail)).surface("plant pot", &paint::ceramic()),
        Shape::turned(foot, &[(0.165, 0.30), (0.0, 0.30)], round(detail)).surface("plant soil", &paint::soil()),
        Shape::all((0..leaves).map(leaf)).surface("plant leaves", &paint::leaf()),
    ]
}

/// A leaf that rises from the soil and bends over; the higher, the steeper.
fn leaf(root: DVec3, angle: f64, rise: f64) -> Shape {
    let out = DVec3::new(angle.cos(), 0.0, angle.sin());
    let across = DVec3::new(-angle.sin(), 0.0, angle.cos());
    let lean = FRAC_PI_2 * (1.0 - rise);
    let at = |along: f64, height: f64| root + out * along + DVec3::Y * height;
    let base = at(0.04, 0.0);
    let middle = at(0.08 + 0.16 * lean, 0.35 + 0.35 * rise);
    let tip = at(0.14 + 0.26 * lean, 0.42 + 0.55 * rise);
    let half = 0.055;
    Shape::triangle([base, middle + half * across, middle - half * across]).and(Shape::triangle([
        middle - half * across,
        middle + half * across,
        tip,
    ]))
}

/// An abstract in four fields, framed.
fn painting() -> Vec<Surface> {
    let ([x0, x1], [y0, y1]) = ([3.0, 4.5], [1.25, 2.1]);
    let (near, bar) = (BACK_WALL - 0.03, 0.03);
    let frame = Shape::all([
        Shape::block([x0, y0, near], [x1, y0 + bar, BACK_WALL], BACK),
        Shape::block([x0, y1 - bar, near], [x1, y1, BACK_WALL], BACK),
        Shape::block([x0, y0 + bar, near], [x0 + bar, y1 - bar, BACK_WALL], BACK | TOP | BOTTOM),
        Shape::block([x1 - bar, y0 + bar, near], [x1, y1 - bar, BACK_WALL], BACK | TOP | BOTTOM),
    ]);
    let z = BACK_WALL - 0.012;
    let field =
        |[x0, x1]: [f64; 2], [y0, y1]: [f64; 2]| Shape::quad([[x1, y0, z], [x0, y0, z], [x0, y1, z], [x1, y1, z]]);
    let (xs, ys) = ([x0 + bar, x0 + 0.62, x1 - bar], [y0 + bar, y0 + 0.3, y1 - bar]);
    let (left, right, low, high) = ([xs[0], xs[1]], [xs[1], xs[2]], [ys[0], ys[1]], [ys[1], ys[2]]);
    vec![
        frame.surface("painting frame", &paint::walnut()),
        field(left, low).surface("painting sand", &paint::wool()),
        field(left, high).surface("painting sun", &paint::mustard()),
        field(right, low).surface("painting sea", &paint::denim()),
        field(right, high).surface("painting sky", &paint::terracotta()),
    ]
}
