//! The closed shell: floor, ceiling, four walls, a window in a deep reveal, a door.

use glam::DVec2;

use super::paint;
use super::shape::{BACK, BOTTOM, FRONT, LEFT, NONE, RIGHT, Shape, Sides, TOP};
use crate::model::Surface;

/// Inner size of the room along x, y (up) and z, metres.
pub(super) const SIZE: [f64; 3] = [6.0, 2.7, 4.5];
const X: f64 = SIZE[0];
const Y: f64 = SIZE[1];
const Z: f64 = SIZE[2];

/// The window's hole in the wall x = 0, as intervals of y and z.
const HOLE: [[f64; 2]; 2] = [[0.9, 2.3], [1.0, 3.4]];
/// The panes stand this far outside.
const REVEAL: f64 = 0.25;
const FRAME: f64 = 0.06;

/// The door in the wall x = 6, as intervals of y and z.
const DOOR: [[f64; 2]; 2] = [[0.0, 2.05], [0.9, 1.8]];

pub(super) fn shell(detail: u32) -> Vec<Surface> {
    let mut surfaces = vec![
        Shape::quad([[0., 0., 0.], [0., 0., Z], [X, 0., Z], [X, 0., 0.]]).surface("floor", &paint::oak()),
        Shape::quad([[0., Y, 0.], [X, Y, 0.], [X, Y, Z], [0., Y, Z]]).surface("ceiling", &paint::ceiling()),
        Shape::quad([[0., 0., 0.], [X, 0., 0.], [X, Y, 0.], [0., Y, 0.]]).surface("front wall", &paint::plaster()),
        Shape::quad([[X, 0., Z], [0., 0., Z], [0., Y, Z], [X, Y, Z]]).surface("back wall", &paint::sage()),
        Shape::quad([[X, 0., 0.], [X, 0., Z], [X, Y, Z], [X, Y, 0.]]).surface("right wall", &paint::plaster()),
        window_wall().surface("left wall", &paint::plaster()),
        reveal().surface("window reveal", &paint::lacquer()),
        skirting().surface("skirting", &paint::lacquer()),
    ];
    surfaces.extend(window());
    surfaces.extend(curtains(detail));
    surfaces.extend(door(detail));
    surfaces
}

/// A rectangle of the wall x = `x` that faces the room.
fn left_panel(x: f64, [y0, y1]: [f64; 2], [z0, z1]: [f64; 2]) -> Shape {
    Shape::quad([[x, y0, z1], [x, y0, z0], [x, y1, z0], [x, y1, z1]])
}

fn window_wall() -> Shape {
    let [[y0, y1], [z0, z1]] = HOLE;
    Shape::all([
        left_panel(0., [0., y0], [0., Z]),
        left_panel(0., [y1, Y], [0., Z]),
        left_panel(0., [y0, y1], [0., z0]),
        left_panel(0., [y0, y1], [z1, Z]),
    ])
}

/// The four sides of the hole.
fn reveal() -> Shape {
    let ([[y0, y1], [z0, z1]], x) = (HOLE, -REVEAL);
    Shape::all([
        Shape::quad([[x, y0, z0], [x, y0, z1], [0., y0, z1], [0., y0, z0]]),
        Shape::quad([[x, y1, z0], [0., y1, z0], [0., y1, z1], [x, y1, z1]]),
        Shape::quad([[x, y0, z0], [0., y0, z0], [0., y1, z0], [x, y1, z0]]),
        Shape::quad([[x, y0, z1], [x, y1, z1], [0., y1, z1], [0., y0, z1]]),
    ])
}

/// Panes two by two, the bars between them, and the board below.
fn window() -> Vec<Surface> {
    let [[y0, y1], [z0, z1]] = HOLE;
    let (ym, zm) = (y0 + 0.62 * (y1 - y0), 0.5 * (z0 + z1));
    let half = 0.5 * FRAME;
    let rows = [[y0, y0 + FRAME], [ym - half, ym + half], [y1 - FRAME, y1]];
    let columns = [[z0, z0 + FRAME], [zm - half, zm + half], [z1 - FRAME, z1]];
    let gaps = |bars: &[[f64; 2]; 3]| [[bars[0][1], bars[1][0]], [bars[1][1], bars[2][0]]];
    let (mut panes, mut bars) = (Shape::default(), Shape::default());
    for (column, against) in columns.iter().zip([FRONT, NONE, BACK]) {
        bars = bars.and(bar([y0, y1], *column, TOP | BOTTOM | against));
    }
    for column in gaps(&columns) {
        for (row, against) in rows.iter().zip([BOTTOM, NONE, TOP]) {
            bars = bars.and(bar(*row, column, FRONT | BACK | against));
        }
        for row in gaps(&rows) {
            panes = panes.and(left_panel(-REVEAL, row, column));
        }
    }
    let board = Shape::block([0., y0 - 0.04, z0 - 0.06], [0.16, y0, z1 + 0.06], LEFT);
    vec![
        panes.surface("window", &paint::daylight()),
        bars.surface("window frame", &paint::lacquer()),
        board.surface("window board", &paint::oak()),
    ]
}

fn bar([y0, y1]: [f64; 2], [z0, z1]: [f64; 2], hidden: Sides) -> Shape {
    Shape::block([-REVEAL, y0, z0], [-REVEAL + FRAME, y1, z1], LEFT | hidden)
}

fn curtains(detail: u32) -> Vec<Surface> {
    let folds = 12 + 12 * detail;
    let curtain = |name: &str, z0: f64, z1: f64| {
        let line: Vec<_> = (0..=folds)
            .map(|i| {
                let t = f64::from(i) / f64::from(folds);
                let wave = (6.0 * std::f64::consts::TAU * t).sin();
                DVec2::new(0.10 + 0.035 * wave, z0 + t * (z1 - z0))
            })
            .collect();
        Shape::sheet(&line, 0.04, 2.48).surface(name, &paint::linen())
    };
    let rod = Shape::block([0.085, 2.49, 0.4], [0.115, 2.52, 4.0], NONE);
    vec![
        curtain("curtain left", 3.42, 3.92),
        curtain("curtain right", 0.48, 0.98),
        rod.surface("curtain rod", &paint::brass()),
    ]
}

/// Boards 8 cm high along the walls, interrupted by the door.
fn skirting() -> Shape {
    const H: f64 = 0.08;
    const T: f64 = 0.015;
    let [z0, z1] = [DOOR[1][0] - 0.08, DOOR[1][1] + 0.08];
    Shape::all([
        Shape::block([0., 0., 0.], [X, H, T], BOTTOM | FRONT | LEFT | RIGHT),
        Shape::block([0., 0., Z - T], [X, H, Z], BOTTOM | BACK | LEFT | RIGHT),
        Shape::block([0., 0., T], [T, H, Z - T], BOTTOM | LEFT | FRONT | BACK),
        Shape::block([X - T, 0., T], [X, H, z0], BOTTOM | RIGHT | FRONT | BACK),
        Shape::block([X - T, 0., z1], [X, H, Z - T], BOTTOM | RIGHT | FRONT | BACK),
    ])
}

fn door(detail: u32) -> Vec<Surface> {
    let [[_, y1], [z0, z1]] = DOOR;
    let (leaf, wide) = (X - 0.03, 0.08);
    let frame = Shape::all([
        Shape::block([X - 0.05, 0., z0 - wide], [X, y1 + wide, z0], BOTTOM | RIGHT),
        Shape::block([X - 0.05, 0., z1], [X, y1 + wide, z1 + wide], BOTTOM | RIGHT),
        Shape::block([X - 0.05, y1, z0], [X, y1 + wide, z1], RIGHT | FRONT | BACK),
    ]);
    let panel = |y0: f64, y1: f64| Shape::block([leaf - 0.012, y0, z0 + 0.14], [leaf, y1, z1 - 0.14], RIGHT);
    let leaf_shape = Shape::block([leaf, 0., z0], [X, y1, z1], BOTTOM | TOP | RIGHT | FRONT | BACK);
    let knob = Shape::ball([leaf - 0.05, 1.02, z0 + 0.07], 0.028, 8 + 4 * detail);
    vec![
        frame.surface("door frame", &paint::lacquer()),
        leaf_shape.and(panel(0.2, 0.9)).and(panel(1.1, 1.85)).surface("door", &paint::walnut()),
        knob.surface("door knob", &paint::brass()),
    ]
}
