use std::fs;
use std::path::PathBuf;

use super::gltf::testing::Glb;
use super::*;

/// A folder that goes when the test does.
pub(super) struct Scratch(PathBuf);

impl Scratch {
    pub fn new(name: &str) -> Self {
        let path = std::env::temp_dir().join(format!("radiosity-scene-{name}-{}", std::process::id()));
        fs::create_dir_all(&path).unwrap();
        Self(path)
    }

    pub fn write(&self, name: &str, bytes: impl AsRef<[u8]>) -> PathBuf {
        let path = self.0.join(name);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(&path, bytes).unwrap();
        path
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

fn refusal(path: &Path) -> String {
    let error = load(path, &LoadOptions::default()).unwrap_err().to_string();
    assert!(error.starts_with(&path.display().to_string()), "{error}");
    error
}

#[test]
fn each_unusable_file_has_its_own_sentence() {
    let scratch = Scratch::new("refusals");
    let cases: [(&str, &[u8], &str); 15] = [
        ("empty.glb", b"", "the file is empty"),
        ("text.glb", b"hello", "holds text, not glTF"),
        ("page.glb", b"<!DOCTYPE html>", "a web page"),
        ("lfs.glb", b"version https://git-lfs.github.com/spec/v1", "git lfs pull"),
        ("short.glb", b"glTF\x02\0", "ends within its header"),
        ("list.gltf", b"[1, 2]", "holds text, not glTF"),
        ("number.gltf", b"{\"asset\": 3}", "damaged or not glTF 2.0"),
        ("none.gltf", b"{\"asset\": {\"version\": \"2.0\"}}", "no triangles"),
        ("binary.obj", b"\x01\0\0", "unknown binary data"),
        ("none.obj", b"# nothing here\n", "no faces"),
        ("mesh.off", b"OFF\n", "holds text, and only .glb, .gltf, .obj, .stl, .ply and .vs3"),
        ("mesh.ply", b"solid", "named .ply but holds text"),
        ("zip.stl", b"PK\x03\x04", "named .stl but holds a zip archive"),
        ("none.vs3", b"F 3\n", "no surfaces"),
        ("binary.vs3", b"\x01\0\0", "named .vs3 but holds unknown binary data"),
    ];
    for (name, bytes, words) in cases {
        let message = refusal(&scratch.write(name, bytes));
        assert!(message.contains(words), "{message}");
    }
    assert!(refusal(&scratch.0).contains("this is a directory"));
    assert!(refusal(&scratch.0.join("missing.glb")).contains("does not exist; check the path"));
}

#[test]
fn content_counts_more_than_extension() {
    let scratch = Scratch::new("content");
    let path = scratch.write("model.bin", Glb::square().to_bytes());
    assert_eq!(load(path, &LoadOptions::default()).unwrap().name, "model.bin");
}

#[test]
fn external_buffers_lie_next_to_the_file() {
    let scratch = Scratch::new("external");
    let glb = Glb::square();
    let mut json = glb.json.clone();
    json["buffers"] = serde_json::json!([{"byteLength": glb.binary().len(), "uri": "data/my%20room.bin"}]);
    scratch.write("data/my room.bin", glb.binary());
    let path = scratch.write("room.gltf", json.to_string());
    assert_eq!(gltf::load(&path, &LoadOptions::default()).unwrap().face_count(), 2);

    scratch.write("data/my room.bin", &glb.binary()[1..]);
    assert!(refusal(&path).contains("it was cut short"));
}
