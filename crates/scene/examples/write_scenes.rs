//! Writes the sample scenes in `scenes/`: `cargo run -p radiosity-scene --example write_scenes -- scenes`.
//!
//! One small study with a window, a desk, two chairs of one mesh, a lamp and a camera, in three forms:
//! `study.glb`, `study.gltf` with `study.bin`, and `study.obj` with `study.mtl`. And one enclosure in two forms:
//! `corner.stl` and `corner.ply`. `room.vs3` is written by hand.

use std::error::Error;
use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use serde_json::{Value, json};

fn main() -> Result<(), Box<dyn Error>> {
    let folder = std::env::args().nth(1).unwrap_or_else(|| "scenes".into());
    let folder = Path::new(&folder);
    let study = study();
    let (mut document, binary) = document(&study);
    document["buffers"][0]["uri"] = json!("study.bin");
    fs::write(folder.join("study.gltf"), format!("{}\n", serde_json::to_string_pretty(&document)?))?;
    fs::write(folder.join("study.bin"), &binary)?;
    document["buffers"][0].as_object_mut().ok_or("a buffer is an object")?.remove("uri");
    fs::write(folder.join("study.glb"), container(&document.to_string(), &binary))?;
    let (obj, mtl) = wavefront(&study);
    fs::write(folder.join("study.obj"), obj)?;
    fs::write(folder.join("study.mtl"), mtl)?;
    fs::write(folder.join("corner.stl"), stereolithography())?;
    fs::write(folder.join("corner.ply"), polygon_file())?;
    Ok(())
}

/// A rectangle as its corners, counter-clockwise seen from the front.
type Quad = [[f32; 3]; 4];

/// Quads of one paint.
struct Part {
    paint: &'static str,
    quads: Vec<Quad>,
}

/// A mesh and the places where it stands: position and turn about the vertical in radians.
struct Object {
    name: &'static str,
    parts: Vec<Part>,
    places: Vec<([f32; 3], f32)>,
}

/// Name, reflectance, radiance in nits.
type Paint = (&'static str, [f32; 3], [f32; 3]);

const PAINTS: [Paint; 8] = [
    ("plaster", [0.78, 0.76, 0.72], [0.0; 3]),
    ("clay", [0.58, 0.30, 0.20], [0.0; 3]),
    ("floorboards", [0.42, 0.29, 0.18], [0.0; 3]),
    ("birch", [0.66, 0.52, 0.36], [0.0; 3]),
    ("steel blue", [0.18, 0.28, 0.40], [0.0; 3]),
    ("paper", [0.80, 0.78, 0.70], [0.0; 3]),
    ("sky", [0.10, 0.10, 0.10], [2400.0, 2800.0, 3300.0]),
    ("lamp", [0.50, 0.50, 0.50], [9000.0, 6500.0, 3800.0]),
];

const OPEN: [bool; 6] = [true; 6];
/// Without the bottom, for what stands.
const STANDING: [bool; 6] = [false, true, true, true, true, true];
/// Without bottom and top, for legs.
const LEG: [bool; 6] = [false, false, true, true, true, true];

/// A box; `sides` says which of bottom, top, low z, high z, low x, high x exist.
fn block(low: [f32; 3], high: [f32; 3], sides: [bool; 6]) -> Vec<Quad> {
    const FACES: [[usize; 4]; 6] = [[0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6], [0, 4, 6, 2], [1, 3, 7, 5]];
    let corner = |i: usize| std::array::from_fn(|axis| if i >> axis & 1 == 1 { high[axis] } else { low[axis] });
    FACES.iter().zip(sides).filter(|(_, exists)| *exists).map(|(face, _)| face.map(corner)).collect()
}

fn part(paint: &'static str, quads: impl IntoIterator<Item = Vec<Quad>>) -> Part {
    Part { paint, quads: quads.into_iter().flatten().collect() }
}

fn object(name: &'static str, parts: Vec<Part>) -> Object {
    Object { name, parts, places: vec![([0.0; 3], 0.0)] }
}

/// A study of 4 m x 2.6 m x 3 m, y up.
fn study() -> Vec<Object> {
    let (x, y, z) = (4.0, 2.6, 3.0);
    let (sill, head, from, to) = (0.9, 2.1, 0.9, 2.3);
    let left = |[y0, y1]: [f32; 2], [z0, z1]: [f32; 2]| vec![[[0., y0, z1], [0., y0, z0], [0., y1, z0], [0., y1, z1]]];
    let shell = vec![
        part("floorboards", [vec![[[0., 0., 0.], [0., 0., z], [x, 0., z], [x, 0., 0.]]]]),
        part(
            "plaster",
            [
                vec![[[0., y, 0.], [x, y, 0.], [x, y, z], [0., y, z]]],
                vec![[[0., 0., 0.], [x, 0., 0.], [x, y, 0.], [0., y, 0.]]],
                vec![[[x, 0., 0.], [x, 0., z], [x, y, z], [x, y, 0.]]],
                left([0., sill], [0., z]),
                left([head, y], [0., z]),
                left([sill, head], [0., from]),
                left([sill, head], [to, z]),
            ],
        ),
        part("clay", [vec![[[x, 0., z], [0., 0., z], [0., y, z], [x, y, z]]]]),
    ];
    let legs = |dx: f32, dz: f32, side: f32, height: f32| {
        [(-dx, -dz), (-dx, dz), (dx, -dz), (dx, dz)]
            .map(|(x, z)| block([x - side, 0., z - side], [x + side, height, z + side], LEG))
    };
    let desk = vec![
        part("birch", [block([-0.7, 0.71, -0.35], [0.7, 0.74, 0.35], OPEN)]),
        part("steel blue", legs(0.62, 0.28, 0.025, 0.71)),
        part("paper", [block([-0.15, 0.741, -0.1], [0.06, 0.746, 0.2], OPEN)]),
    ];
    let chair = vec![
        part(
            "birch",
            [block([-0.21, 0.43, -0.21], [0.21, 0.46, 0.21], OPEN), block([-0.2, 0.66, -0.2], [0.2, 0.9, -0.18], OPEN)],
        ),
        part("steel blue", legs(0.18, 0.18, 0.015, 0.43)),
        part("steel blue", [-0.15, 0.15].map(|x| block([x - 0.015, 0.46, -0.2], [x + 0.015, 0.66, -0.18], LEG))),
    ];
    let lamp = vec![
        part(
            "steel blue",
            [
                block([-0.08, 0.741, -0.08], [0.08, 0.755, 0.08], STANDING),
                block([-0.008, 0.755, -0.008], [0.008, 1.05, 0.008], LEG),
            ],
        ),
        part("lamp", [block([-0.07, 1.05, -0.07], [0.07, 1.2, 0.07], OPEN)]),
    ];
    let shelf = vec![
        part("birch", [0.0_f32, 0.35].map(|y| block([-0.6, 1.3 + y, 2.78], [0.6, 1.33 + y, 3.0], STANDING_OFF_WALL))),
        part(
            "paper",
            (0..9).map(|i| {
                let (x, height) = (-0.55 + 0.06 * i as f32, 0.18 + 0.01 * ((i * 7) % 5) as f32);
                block([x, 1.33, 2.82], [x + 0.05, 1.33 + height, 2.98], STANDING)
            }),
        ),
    ];
    let mut objects = vec![
        object("room", shell),
        object("window", vec![part("sky", [left([sill, head], [from, to])])]),
        Object { places: vec![([1.2, 0., 1.6], 0.0)], ..object("desk", desk) },
        Object { places: vec![([1.1, 0., 0.95], 0.1), ([3.1, 0., 2.2], 3.6)], ..object("chair", chair) },
        Object { places: vec![([1.7, 0., 1.75], 0.4)], ..object("desk lamp", lamp) },
    ];
    objects.push(Object { places: vec![([2.2, 0., 0.], 0.0)], ..object("shelf", shelf) });
    objects
}

/// Boards whose back edge touches the wall.
const STANDING_OFF_WALL: [bool; 6] = [true, true, true, false, true, true];

/// The glTF document and its buffer; places of one mesh are nodes.
fn document(objects: &[Object]) -> (Value, Vec<u8>) {
    let mut buffer = Buffer::default();
    let (mut meshes, mut nodes) = (Vec::new(), Vec::new());
    for object in objects {
        let primitives: Vec<_> = object.parts.iter().map(|part| buffer.primitive(part)).collect();
        for (place, (position, turn)) in object.places.iter().enumerate() {
            let name = if place == 0 { object.name.to_string() } else { format!("{} {}", object.name, place + 1) };
            let rotation = [0.0, (turn / 2.0).sin(), 0.0, (turn / 2.0).cos()];
            nodes.push(json!({"name": name, "mesh": meshes.len(), "translation": position, "rotation": rotation}));
        }
        meshes.push(json!({"name": object.name, "primitives": primitives}));
    }
    nodes.extend(camera_and_bulb());
    let document = json!({
        "asset": {"version": "2.0", "generator": "radiosity write_scenes", "copyright": "CC0 1.0"},
        "extensionsUsed": ["KHR_lights_punctual", "KHR_materials_emissive_strength"],
        "extensions": {"KHR_lights_punctual": {"lights":
            [{"name": "bulb", "type": "point", "color": [1.0, 0.82, 0.6], "intensity": 60.0}]}},
        "scene": 0,
        "scenes": [{"name": "study", "nodes": (0..nodes.len()).collect::<Vec<_>>()}],
        "nodes": nodes,
        "meshes": meshes,
        "cameras": [{"name": "desk", "type": "perspective",
            "perspective": {"yfov": 0.9, "aspectRatio": 1.5, "znear": 0.05}}],
        "materials": PAINTS.iter().map(material).collect::<Vec<_>>(),
        "accessors": buffer.accessors,
        "bufferViews": buffer.views,
        "buffers": [{"byteLength": buffer.bytes.len()}],
    });
    (document, buffer.bytes)
}

/// A camera in the corner that looks at the desk, and a bare bulb under the ceiling.
fn camera_and_bulb() -> [Value; 2] {
    // Turned by 0.6 pi about the vertical and tilted down by 0.15.
    let (yaw, pitch) = (0.3 * std::f64::consts::PI, -0.075_f64);
    let rotation =
        [yaw.cos() * pitch.sin(), yaw.sin() * pitch.cos(), -yaw.sin() * pitch.sin(), yaw.cos() * pitch.cos()];
    [
        json!({"name": "desk view", "camera": 0, "translation": [3.75, 1.55, 0.35], "rotation": rotation}),
        json!({"name": "bulb", "translation": [2.4, 2.3, 1.5], "extensions": {"KHR_lights_punctual": {"light": 0}}}),
    ]
}

fn material(&(name, reflectance, radiance): &Paint) -> Value {
    let [r, g, b] = reflectance;
    let mut material = json!({
        "name": name,
        "pbrMetallicRoughness": {"baseColorFactor": [r, g, b, 1.0], "metallicFactor": 0.0, "roughnessFactor": 1.0},
    });
    let strength = radiance.iter().copied().fold(0.0, f32::max);
    if strength > 0.0 {
        material["emissiveFactor"] = json!(radiance.map(|l| l / strength));
        material["extensions"] = json!({"KHR_materials_emissive_strength": {"emissiveStrength": strength}});
    }
    material
}

/// The binary data so far.
#[derive(Default)]
struct Buffer {
    bytes: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
}

impl Buffer {
    fn view(&mut self, bytes: &[u8], target: u32) -> usize {
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        let view = json!({"buffer": 0, "byteOffset": self.bytes.len(), "byteLength": bytes.len(), "target": target});
        self.bytes.extend(bytes);
        self.views.push(view);
        self.views.len() - 1
    }

    fn accessor(&mut self, accessor: Value) -> usize {
        self.accessors.push(accessor);
        self.accessors.len() - 1
    }

    fn primitive(&mut self, part: &Part) -> Value {
        let points: Vec<_> = part.quads.iter().flatten().collect();
        let bound = |pick: fn(f32, f32) -> f32, start: f32| -> [f32; 3] {
            std::array::from_fn(|axis| points.iter().map(|point| point[axis]).fold(start, pick))
        };
        let (min, max) = (bound(f32::min, f32::INFINITY), bound(f32::max, f32::NEG_INFINITY));
        let bytes: Vec<u8> = points.iter().flat_map(|point| point.iter()).flat_map(|x| x.to_le_bytes()).collect();
        let view = self.view(&bytes, 34_962);
        let position = self.accessor(json!({"bufferView": view, "componentType": 5126, "type": "VEC3",
            "count": points.len(), "min": min, "max": max}));
        let corners = (0..part.quads.len() as u16).flat_map(|quad| [0, 1, 2, 0, 2, 3].map(|i| 4 * quad + i));
        let bytes: Vec<u8> = corners.flat_map(u16::to_le_bytes).collect();
        let view = self.view(&bytes, 34_963);
        let indices = self.accessor(json!({"bufferView": view, "componentType": 5123, "type": "SCALAR",
            "count": 6 * part.quads.len()}));
        let material = PAINTS.iter().position(|paint| paint.0 == part.paint);
        json!({"attributes": {"POSITION": position}, "indices": indices, "material": material})
    }
}

/// Wraps JSON and binary data as .glb.
fn container(json: &str, binary: &[u8]) -> Vec<u8> {
    let padded = |bytes: &[u8], with: u8| {
        let mut bytes = bytes.to_vec();
        bytes.resize(bytes.len().next_multiple_of(4), with);
        bytes
    };
    let (json, binary) = (padded(json.as_bytes(), b' '), padded(binary, 0));
    let mut bytes = b"glTF\x02\0\0\0".to_vec();
    bytes.extend((28 + json.len() as u32 + binary.len() as u32).to_le_bytes());
    for (kind, payload) in [(b"JSON", json), (b"BIN\0", binary)] {
        bytes.extend((payload.len() as u32).to_le_bytes());
        bytes.extend(kind);
        bytes.extend(payload);
    }
    bytes
}

/// The same scene as OBJ and MTL, whose quads stay quads. OBJ knows no instances, cameras or bulbs.
fn wavefront(objects: &[Object]) -> (String, String) {
    let mut obj = String::from("# A study, metres, y up. CC0 1.0.\nmtllib study.mtl\n");
    let mut corners = 0;
    for object in objects {
        for (place, &(position, turn)) in object.places.iter().enumerate() {
            let _ = writeln!(obj, "o {}{}", object.name, if place == 0 { "" } else { " 2" });
            for part in &object.parts {
                let _ = writeln!(obj, "usemtl {}", part.paint);
                for quad in &part.quads {
                    for &corner in quad {
                        let [x, y, z] = placed(corner, position, turn);
                        let _ = writeln!(obj, "v {x} {y} {z}");
                    }
                    corners += 4;
                    let _ = writeln!(obj, "f {} {} {} {}", corners - 3, corners - 2, corners - 1, corners);
                }
            }
        }
    }
    let mut mtl = String::from("# Materials of study.obj. Ke is radiance in nits. CC0 1.0.\n");
    for (name, kd, ke) in PAINTS {
        let _ = writeln!(mtl, "\nnewmtl {name}\nKd {} {} {}\nKe {} {} {}", kd[0], kd[1], kd[2], ke[0], ke[1], ke[2]);
    }
    (obj, mtl)
}

fn placed([x, y, z]: [f32; 3], position: [f32; 3], turn: f32) -> [f32; 3] {
    let (sin, cos) = turn.sin_cos();
    [cos * x + sin * z + position[0], y + position[1], cos * z - sin * x + position[2]]
}

/// A duct around a corner, closed at its ends: its outline (x, z), seen from below counter-clockwise, 1 m high.
const CORNER: [[f32; 2]; 6] = [[0., 0.], [2., 0.], [2., 1.], [1., 1.], [1., 2.], [0., 2.]];

/// Its corners, the lower ones first, and its faces as indices, looking inward.
fn corner() -> (Vec<[f32; 3]>, Vec<Vec<usize>>) {
    let n = CORNER.len();
    let points = [0.0, 1.0].iter().flat_map(|&y| CORNER.map(|[x, z]| [x, y, z])).collect();
    let walls = (0..n).map(|i| vec![i, (i + 1) % n, (i + 1) % n + n, i + n]);
    let (floor, ceiling) = ((0..n).rev().collect(), (n..2 * n).collect());
    (points, walls.chain([floor, ceiling]).collect())
}

/// The enclosure as STL, which knows triangles only.
fn stereolithography() -> String {
    let (points, faces) = corner();
    let mut stl = String::from("solid corner\n");
    for face in faces {
        // All of the outline can be seen from its inner corner.
        let start = face.iter().position(|&point| point % CORNER.len() == 3 && face.len() > 4).unwrap_or(0);
        for i in 1..face.len() - 1 {
            let triangle = [0, i, i + 1].map(|k| points[face[(start + k) % face.len()]]);
            let _ = writeln!(stl, "facet normal 0 0 0\n outer loop");
            for [x, y, z] in triangle {
                let _ = writeln!(stl, "  vertex {x} {y} {z}");
            }
            stl.push_str(" endloop\nendfacet\n");
        }
    }
    stl + "endsolid corner\n"
}

/// The enclosure as binary PLY, whose floor and ceiling are hexagons.
fn polygon_file() -> Vec<u8> {
    let (points, faces) = corner();
    let mut ply = format!(
        "ply\nformat binary_little_endian 1.0\ncomment A duct around a corner, metres, y up. CC0 1.0.\n\
         element vertex {}\nproperty float x\nproperty float y\nproperty float z\n\
         element face {}\nproperty list uchar int vertex_indices\nend_header\n",
        points.len(),
        faces.len()
    )
    .into_bytes();
    ply.extend(points.iter().flatten().flat_map(|x| x.to_le_bytes()));
    for face in faces {
        ply.push(face.len() as u8);
        ply.extend(face.iter().flat_map(|&point| (point as i32).to_le_bytes()));
    }
    ply
}
