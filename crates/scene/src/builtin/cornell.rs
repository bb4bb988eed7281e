//! The Cornell box.
//!
//! Goral, Torrance, Greenberg, Battaile, "Modeling the interaction of light between diffuse surfaces", SIGGRAPH 1984,
//! as measured later by the Cornell University Program of Computer Graphics
//! (<https://www.graphics.cornell.edu/online/box/data.html>). y points up, z into the box, which is open at z = 0.

use std::f64::consts::PI;
use std::str::FromStr;

use glam::DVec3;
use radiosity_geometry::Patches;

use super::rectangle::{Rectangle, surface};
use crate::model::{Camera, Material, Scene, Surface, band_names};

const WHITE: [f64; 3] = [0.73, 0.73, 0.73];
const RED: [f64; 3] = [0.63, 0.065, 0.05];
const GREEN: [f64; 3] = [0.14, 0.45, 0.091];
const BLACK: [f64; 3] = [0.0; 3];
/// The flat reflectance that the published data give the lamp.
const LAMP: [f64; 3] = [0.78; 3];
/// Radiance of the lamp, W/(m2 sr): the published emission spectrum reduced to RGB.
const RADIANCE: [f64; 3] = [17.0, 12.0, 4.0];

const METRES_PER_MILLIMETRE: f64 = 1e-3;

/// Which of the two boxes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum CornellVariant {
    /// The measured box, whose walls are not quite at right angles.
    Original,
    /// The box squared to 555 x 548.8 x 559.2 mm with a black lamp, one surface per face.
    #[default]
    Rgb,
}

impl FromStr for CornellVariant {
    type Err = String;

    fn from_str(name: &str) -> Result<Self, String> {
        match name {
            "original" => Ok(Self::Original),
            "rgb" => Ok(Self::Rgb),
            _ => Err(format!("there is no Cornell box '{name}'; choose 'original' or 'rgb'")),
        }
    }
}

/// The Cornell box with its camera.
///
/// # Example
/// ```
/// use radiosity_scene::builtin::{CornellVariant, cornell_box};
/// let scene = cornell_box(CornellVariant::Rgb);
/// assert_eq!(scene.surfaces.len(), 23);
/// ```
pub fn cornell_box(variant: CornellVariant) -> Scene {
    let (name, surfaces) = match variant {
        CornellVariant::Original => ("cornell-box-original", original()),
        CornellVariant::Rgb => ("cornell-box", squared().iter().map(GridFace::surface).collect()),
    };
    Scene { name: name.into(), bands: band_names(3), surfaces, cameras: vec![camera()], ..Scene::default() }
}

/// How many patches along u and v each surface of the squared box is cut into, in the order of its surfaces.
///
/// Patch (i, j) of a surface with corners o, o + u, .. covers o + [i, i + 1]/nu u + [j, j + 1]/nv v; i runs fastest.
pub fn cornell_grid() -> Vec<[u32; 2]> {
    squared().iter().map(|face| [face.nu, face.nv]).collect()
}

/// The 1,920 patches of the squared box on [`cornell_grid`], metres.
pub fn cornell_patches() -> Patches {
    let faces = squared();
    let mut polygons = Vec::new();
    let mut surface = Vec::new();
    for (index, face) in faces.iter().enumerate() {
        let quads = face.patches();
        surface.extend(std::iter::repeat_n(index as u32, quads.len()));
        polygons.extend(quads);
    }
    let n = polygons.len();
    Patches::new(polygons, surface, vec![0; n], vec![false; n])
}

/// The published viewpoint: focal length 35 mm, film 25 mm x 25 mm.
fn camera() -> Camera {
    Camera {
        name: "camera".into(),
        position: METRES_PER_MILLIMETRE * DVec3::new(278.0, 273.0, -800.0),
        forward: DVec3::Z,
        up: DVec3::Y,
        vertical_fov: 2.0 * (12.5_f64 / 35.0).atan(),
        aspect: Some(1.0),
    }
}

fn exitance(radiance: [f64; 3]) -> [f64; 3] {
    radiance.map(|l| PI * l)
}

/// A face with its grid, millimetres.
struct GridFace {
    name: String,
    rectangle: Rectangle,
    nu: u32,
    nv: u32,
    material: Material,
}

impl GridFace {
    fn surface(&self) -> Surface {
        surface(&self.name, &[to_metres(self.rectangle.corners())], &self.material)
    }

    fn patches(&self) -> Vec<[DVec3; 4]> {
        let (du, dv) = (self.rectangle.u / f64::from(self.nu), self.rectangle.v / f64::from(self.nv));
        let cell = |i: u32, j: u32| {
            let o = self.rectangle.o + f64::from(i) * du + f64::from(j) * dv;
            to_metres(Rectangle { o, u: du, v: dv }.corners())
        };
        (0..self.nv).flat_map(|j| (0..self.nu).map(move |i| (i, j))).map(|(i, j)| cell(i, j)).collect()
    }
}

fn to_metres(corners: [DVec3; 4]) -> [DVec3; 4] {
    corners.map(|corner| METRES_PER_MILLIMETRE * corner)
}

/// The squared box: room, ceiling in 3 x 3 around the lamp, short block, tall block.
fn squared() -> Vec<GridFace> {
    let mut faces = room();
    faces.extend(ceiling());
    faces.extend(block("short", [130.0, 65.0], [-48.0, 160.0], [160.0, 48.0], 165.0));
    faces.extend(block("tall", [423.0, 247.0], [-158.0, 49.0], [49.0, 158.0], 330.0));
    faces
}

const WIDTH: f64 = 555.0;
const HEIGHT: f64 = 548.8;
const DEPTH: f64 = 559.2;

fn room() -> Vec<GridFace> {
    let (x, y, z) = ([WIDTH, 0.0, 0.0], [0.0, HEIGHT, 0.0], [0.0, 0.0, DEPTH]);
    let wall = |name: &str, rectangle, paint| grid_face(name, rectangle, 16, 16, "wall", paint);
    vec![
        wall("floor", Rectangle::new([0.0; 3], z, x), WHITE),
        wall("back", Rectangle::new([WIDTH, 0.0, DEPTH], [-WIDTH, 0.0, 0.0], y), WHITE),
        wall("left_red", Rectangle::new(x, z, y), RED),
        wall("right_green", Rectangle::new([0.0; 3], y, z), GREEN),
    ]
}

fn ceiling() -> Vec<GridFace> {
    let (xs, nx) = ([0.0, 213.0, 343.0, WIDTH], [6, 4, 6]);
    let (zs, nz) = ([0.0, 227.0, 332.0, DEPTH], [6, 3, 7]);
    let mut faces = Vec::new();
    for a in 0..3 {
        for b in 0..3 {
            let (u, v) = ([xs[a + 1] - xs[a], 0.0, 0.0], [0.0, 0.0, zs[b + 1] - zs[b]]);
            let rectangle = Rectangle::new([xs[a], HEIGHT, zs[b]], u, v);
            let name = format!("ceiling{a}{b}");
            let mut face = grid_face(&name, rectangle, nx[a], nz[b], "wall", WHITE);
            if (a, b) == (1, 1) {
                face.name = "light".into();
                face.material = Material::new("light", &BLACK, &exitance(RADIANCE));
            }
            faces.push(face);
        }
    }
    faces
}

/// The top and four sides of an upright block: a footprint corner and two edges in (x, z), height above the floor.
fn block(name: &str, corner: [f64; 2], edge_x: [f64; 2], edge_z: [f64; 2], height: f64) -> Vec<GridFace> {
    let at = |[x, z]: [f64; 2], y: f64| DVec3::new(x, y, z);
    let (c, ex, ez) = (at(corner, 0.0), at(edge_x, 0.0), at(edge_z, 0.0));
    let (up, centre) = (DVec3::new(0.0, height, 0.0), c + ex / 2.0 + ez / 2.0);
    let face = |side: &str, rectangle: Rectangle, outward| {
        let name = format!("{name}.{side}");
        grid_face(&name, rectangle.facing(outward), 8, 8, "block", WHITE)
    };
    let mut faces = vec![face("top", Rectangle { o: c + up, u: ex, v: ez }, DVec3::Y)];
    let sides = [("s0", c, ex), ("s1", c + ex, ez), ("s2", c + ez, ex), ("s3", c, ez)];
    for (side, o, edge) in sides {
        let outward = o + edge / 2.0 - centre;
        faces.push(face(side, Rectangle { o, u: edge, v: up }, outward));
    }
    faces
}

fn grid_face(name: &str, rectangle: Rectangle, nu: u32, nv: u32, paint: &str, rho: [f64; 3]) -> GridFace {
    let material = Material::new(paint, &rho, &BLACK);
    GridFace { name: name.into(), rectangle, nu, nv, material }
}

/// The measured vertices in millimetres, in the order in which they are published.
///
/// Two departures: the ceiling is cut in eight around its published hole, in which the lamp sits; the red wall, whose
/// published corners lie 0.8 mm off a plane, is cut in two triangles.
fn original() -> Vec<Surface> {
    let white = Material::new("white", &WHITE, &BLACK);
    let red = Material::new("red", &RED, &BLACK);
    let green = Material::new("green", &GREEN, &BLACK);
    let lamp = Material::new("light", &LAMP, &exitance(RADIANCE));
    vec![
        published("floor", &[FLOOR], &white),
        published("light", &[LIGHT], &lamp),
        published("ceiling", &ceiling_around_hole(), &white),
        published("back_wall", &[BACK_WALL], &white),
        published("right_wall", &[RIGHT_WALL], &green),
        cut_in_triangles(published("left_wall", &[LEFT_WALL], &red)),
        published("short_block", &SHORT_BLOCK, &white),
        published("tall_block", &TALL_BLOCK, &white),
    ]
}

type Quad = [[f64; 3]; 4];

fn published(name: &str, quads: &[Quad], material: &Material) -> Surface {
    let quads: Vec<_> = quads.iter().map(|quad| to_metres(quad.map(DVec3::from_array))).collect();
    surface(name, &quads, material)
}

fn cut_in_triangles(mut surface: Surface) -> Surface {
    surface.faces = surface.faces.iter().flat_map(|&[a, b, c, d]| [[a, b, c, c], [a, c, d, d]]).collect();
    surface
}

/// The published ceiling, 556 mm wide, without its hole.
fn ceiling_around_hole() -> Vec<Quad> {
    let (xs, zs) = ([0.0, 213.0, 343.0, 556.0], [0.0, 227.0, 332.0, 559.2]);
    let cell = |a: usize, b: usize| {
        let corner = |x: usize, z: usize| [xs[x], HEIGHT, zs[z]];
        [corner(a, b), corner(a + 1, b), corner(a + 1, b + 1), corner(a, b + 1)]
    };
    let cells = (0..3).flat_map(|a| (0..3).map(move |b| (a, b)));
    cells.filter(|&cell| cell != (1, 1)).map(|(a, b)| cell(a, b)).collect()
}

const FLOOR: Quad = [[552.8, 0.0, 0.0], [0.0, 0.0, 0.0], [0.0, 0.0, 559.2], [549.6, 0.0, 559.2]];
const LIGHT: Quad = [[343.0, 548.8, 227.0], [343.0, 548.8, 332.0], [213.0, 548.8, 332.0], [213.0, 548.8, 227.0]];
const BACK_WALL: Quad = [[549.6, 0.0, 559.2], [0.0, 0.0, 559.2], [0.0, 548.8, 559.2], [556.0, 548.8, 559.2]];
const RIGHT_WALL: Quad = [[0.0, 0.0, 559.2], [0.0, 0.0, 0.0], [0.0, 548.8, 0.0], [0.0, 548.8, 559.2]];
const LEFT_WALL: Quad = [[552.8, 0.0, 0.0], [549.6, 0.0, 559.2], [556.0, 548.8, 559.2], [556.0, 548.8, 0.0]];
const SHORT_BLOCK: [Quad; 5] = [
    [[130.0, 165.0, 65.0], [82.0, 165.0, 225.0], [240.0, 165.0, 272.0], [290.0, 165.0, 114.0]],
    [[290.0, 0.0, 114.0], [290.0, 165.0, 114.0], [240.0, 165.0, 272.0], [240.0, 0.0, 272.0]],
    [[130.0, 0.0, 65.0], [130.0, 165.0, 65.0], [290.0, 165.0, 114.0], [290.0, 0.0, 114.0]],
    [[82.0, 0.0, 225.0], [82.0, 165.0, 225.0], [130.0, 165.0, 65.0], [130.0, 0.0, 65.0]],
    [[240.0, 0.0, 272.0], [240.0, 165.0, 272.0], [82.0, 165.0, 225.0], [82.0, 0.0, 225.0]],
];
const TALL_BLOCK: [Quad; 5] = [
    [[423.0, 330.0, 247.0], [265.0, 330.0, 296.0], [314.0, 330.0, 456.0], [472.0, 330.0, 406.0]],
    [[423.0, 0.0, 247.0], [423.0, 330.0, 247.0], [472.0, 330.0, 406.0], [472.0, 0.0, 406.0]],
    [[472.0, 0.0, 406.0], [472.0, 330.0, 406.0], [314.0, 330.0, 456.0], [314.0, 0.0, 456.0]],
    [[314.0, 0.0, 456.0], [314.0, 330.0, 456.0], [265.0, 330.0, 296.0], [265.0, 0.0, 296.0]],
    [[265.0, 0.0, 296.0], [265.0, 330.0, 296.0], [423.0, 330.0, 247.0], [423.0, 0.0, 247.0]],
];

#[cfg(test)]
mod tests {
    use super::*;

    fn normal_and_centre(surface: &Surface, face: [u32; 4]) -> (DVec3, DVec3) {
        let [a, b, c, d] = surface.corners(face);
        ((c - a).cross(d - b).normalize(), 0.25 * (a + b + c + d))
    }

    #[test]
    fn both_boxes_are_sound() {
        for variant in [CornellVariant::Original, CornellVariant::Rgb] {
            assert_eq!(cornell_box(variant).findings(), vec![], "{variant:?}");
        }
    }

    #[test]
    fn walls_look_inward_and_blocks_outward() {
        for variant in [CornellVariant::Original, CornellVariant::Rgb] {
            let middle = DVec3::new(0.278, 0.274, 0.28);
            for surface in &cornell_box(variant).surfaces {
                let inside = match &surface.name {
                    name if name.starts_with("short") => DVec3::new(0.185, 0.08, 0.17),
                    name if name.starts_with("tall") => DVec3::new(0.368, 0.16, 0.35),
                    _ => middle,
                };
                let block = inside != middle;
                for &face in &surface.faces {
                    let (normal, centre) = normal_and_centre(surface, face);
                    assert_eq!(normal.dot(centre - inside) > 0.0, block, "{variant:?} {}", surface.name);
                }
            }
        }
    }

    #[test]
    fn squared_box_has_its_faces_in_order() {
        let names: Vec<_> = cornell_box(CornellVariant::Rgb).surfaces.into_iter().map(|s| s.name).collect();
        let expected = "floor back left_red right_green ceiling00 ceiling01 ceiling02 ceiling10 light ceiling12 \
                        ceiling20 ceiling21 ceiling22 short.top short.s0 short.s1 short.s2 short.s3 tall.top tall.s0 \
                        tall.s1 tall.s2 tall.s3";
        assert_eq!(names.join(" "), expected);
    }

    #[test]
    fn patches_tile_the_faces() {
        let (scene, patches) = (cornell_box(CornellVariant::Rgb), cornell_patches());
        assert_eq!(patches.len(), 1920);
        assert_eq!(cornell_grid().iter().map(|[nu, nv]| nu * nv).sum::<u32>(), 1920);
        for (index, surface) in scene.surfaces.iter().enumerate() {
            let [a, b, c, d] = surface.corners(surface.faces[0]);
            let whole = 0.5 * (c - a).cross(d - b).length();
            let parts: f64 =
                (0..patches.len()).filter(|&i| patches.surface[i] as usize == index).map(|i| patches.area[i]).sum();
            assert!((whole - parts).abs() < 1e-14, "{}", surface.name);
        }
    }

    #[test]
    fn second_patch_of_the_floor_lies_along_z() {
        let patches = cornell_patches();
        let step = DVec3::new(0.0, 0.0, 0.5592 / 16.0);
        assert!((patches.centre[1] - patches.centre[0] - step).length() < 1e-15);
    }

    #[test]
    fn lamp_is_black_and_emits_pi_times_its_radiance() {
        let scene = cornell_box(CornellVariant::Rgb);
        let lamp = &scene.surfaces[8];
        assert_eq!(lamp.material.reflectance, [0.0; 3]);
        assert_eq!(lamp.material.emission, [17.0 * PI, 12.0 * PI, 4.0 * PI]);
    }

    #[test]
    fn film_spans_39_degrees() {
        assert!((camera().vertical_fov.to_degrees() - 39.3077).abs() < 1e-3);
    }
}
