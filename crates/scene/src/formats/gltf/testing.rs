//! Builds .glb files in memory.

use serde_json::{Value, json};

/// A glTF file in the making: JSON as it will be, and the binary chunk.
pub struct Glb {
    pub json: Value,
    binary: Vec<u8>,
}

/// Corners of the unit square in the xy plane.
pub const SQUARE: [[f32; 3]; 4] = [[0., 0., 0.], [1., 0., 0.], [1., 1., 0.], [0., 1., 0.]];

impl Glb {
    pub fn new() -> Self {
        Self { json: json!({"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": []}]}), binary: vec![] }
    }

    /// A node with the unit square, lit by its own emission.
    pub fn square() -> Self {
        let mut glb = Self::new();
        let material = glb.push("materials", paint([0.5, 0.6, 0.7]));
        let (position, indices) = (glb.vectors(&SQUARE), glb.shorts(&[0, 1, 2, 0, 2, 3]));
        let primitive = json!({"attributes": {"POSITION": position}, "indices": indices, "material": material});
        let mesh = glb.push("meshes", json!({"name": "square mesh", "primitives": [primitive]}));
        glb.root(json!({"name": "square", "mesh": mesh}));
        glb
    }

    /// Appends to one of glTF's lists and returns the index.
    pub fn push(&mut self, list: &str, value: Value) -> usize {
        if self.json[list].is_null() {
            self.json[list] = json!([]);
        }
        let list = self.json[list].as_array_mut().unwrap();
        list.push(value);
        list.len() - 1
    }

    /// Adds a node to the scene.
    pub fn root(&mut self, node: Value) -> usize {
        let index = self.push("nodes", node);
        self.json["scenes"][0]["nodes"].as_array_mut().unwrap().push(json!(index));
        index
    }

    pub fn view(&mut self, bytes: &[u8]) -> usize {
        self.binary.resize(self.binary.len().next_multiple_of(4), 0);
        let offset = self.binary.len();
        self.binary.extend(bytes);
        self.push("bufferViews", json!({"buffer": 0, "byteOffset": offset, "byteLength": bytes.len()}))
    }

    pub fn accessor(&mut self, bytes: &[u8], component: u32, kind: &str, count: usize) -> usize {
        let view = self.view(bytes);
        let accessor = json!({"bufferView": view, "componentType": component, "type": kind, "count": count});
        self.push("accessors", accessor)
    }

    pub fn vectors(&mut self, rows: &[[f32; 3]]) -> usize {
        let bytes: Vec<u8> = rows.iter().flatten().flat_map(|x| x.to_le_bytes()).collect();
        self.accessor(&bytes, 5126, "VEC3", rows.len())
    }

    pub fn bytes(&mut self, indices: &[u8]) -> usize {
        self.accessor(indices, 5121, "SCALAR", indices.len())
    }

    pub fn shorts(&mut self, indices: &[u16]) -> usize {
        let bytes: Vec<u8> = indices.iter().flat_map(|i| i.to_le_bytes()).collect();
        self.accessor(&bytes, 5123, "SCALAR", indices.len())
    }

    pub fn words(&mut self, indices: &[u32]) -> usize {
        let bytes: Vec<u8> = indices.iter().flat_map(|i| i.to_le_bytes()).collect();
        self.accessor(&bytes, 5125, "SCALAR", indices.len())
    }

    /// The binary chunk, for files that keep it elsewhere.
    pub fn binary(&self) -> &[u8] {
        &self.binary
    }

    pub fn to_bytes(&self) -> Vec<u8> {
        let mut json = self.json.clone();
        if !self.binary.is_empty() {
            json["buffers"] = json!([{"byteLength": self.binary.len()}]);
        }
        container(&json.to_string(), &self.binary)
    }
}

/// A non-metal that emits a little.
fn paint(colour: [f64; 3]) -> Value {
    let [r, g, b] = colour;
    json!({
        "name": "paint",
        "pbrMetallicRoughness": {"baseColorFactor": [r, g, b, 1.0], "metallicFactor": 0.0},
        "emissiveFactor": [0.1, 0.2, 0.3],
    })
}

/// Wraps JSON and binary data as .glb.
pub fn container(json: &str, binary: &[u8]) -> Vec<u8> {
    let json = padded(json.as_bytes(), b' ');
    let binary = padded(binary, 0);
    let mut bytes = b"glTF\x02\0\0\0".to_vec();
    let length = 12 + 8 + json.len() + if binary.is_empty() { 0 } else { 8 + binary.len() };
    bytes.extend((length as u32).to_le_bytes());
    bytes.extend((json.len() as u32).to_le_bytes());
    bytes.extend(b"JSON");
    bytes.extend(json);
    if !binary.is_empty() {
        bytes.extend((binary.len() as u32).to_le_bytes());
        bytes.extend(b"BIN\0");
        bytes.extend(binary);
    }
    bytes
}

fn padded(bytes: &[u8], with: u8) -> Vec<u8> {
    let mut bytes = bytes.to_vec();
    bytes.resize(bytes.len().next_multiple_of(4), with);
    bytes
}
