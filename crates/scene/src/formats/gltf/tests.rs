use std::f64::consts::PI;

use glam::DVec3;
use radiosity_geometry::texture::Wrap;
use serde_json::{Value, json};

use super::testing::{Glb, SQUARE, container};
use super::*;
use crate::formats::colour;
use crate::formats::texture::tests::two_colour_png;
use crate::formats::{LoadOptions, Unit};
use crate::model::{Gloss, Light, Severity};

fn parsed(glb: &Glb) -> Scene {
    try_parse(&glb.to_bytes()).unwrap()
}

fn try_parse(bytes: &[u8]) -> Result<Scene, SceneError> {
    parse(Path::new("folder/test.glb"), bytes, &LoadOptions::default())
}

/// The error of a file, which must say what and where.
fn refusal(glb: &Glb) -> String {
    let error = try_parse(&glb.to_bytes()).unwrap_err();
    assert_eq!(error.file, "folder/test.glb");
    error.to_string()
}

fn codes(scene: &Scene) -> Vec<&str> {
    scene.findings.iter().map(|finding| finding.code).collect()
}

fn normal(surface: &Surface, face: usize) -> DVec3 {
    let [a, b, c, _] = surface.corners(surface.faces[face]);
    (b - a).cross(c - a)
}

fn close(a: &[f64], b: &[f64]) -> bool {
    a.len() == b.len() && a.iter().zip(b).all(|(a, b)| (a - b).abs() <= 1e-6 * b.abs().max(1e-3))
}

/// The square with one property of its primitive replaced.
fn with_primitive(change: impl FnOnce(&mut Glb, &mut Value)) -> Glb {
    let mut glb = Glb::square();
    let mut primitive = glb.json["meshes"][0]["primitives"][0].take();
    change(&mut glb, &mut primitive);
    glb.json["meshes"][0]["primitives"][0] = primitive;
    glb
}

#[test]
fn square_is_read_with_its_name_and_material() {
    let scene = parsed(&Glb::square());
    assert_eq!(scene.findings(), vec![]);
    let square = &scene.surfaces[0];
    assert_eq!((scene.name.as_str(), square.name.as_str()), ("test.glb", "square"));
    assert_eq!(square.faces, [[0, 1, 2, 2], [0, 2, 3, 3]]);
    assert_eq!(square.vertices[2], DVec3::new(1.0, 1.0, 0.0));
    assert!(close(&square.material.reflectance, &[0.5, 0.6, 0.7]));
    assert!(close(&square.material.emission, &[0.1 * PI, 0.2 * PI, 0.3 * PI]), "exitance is pi times radiance");
    assert!(!square.material.two_sided);
}

#[test]
fn indices_of_all_widths_agree() {
    let narrow = with_primitive(|glb, primitive| primitive["indices"] = json!(glb.bytes(&[0, 1, 2, 0, 2, 3])));
    let wide = with_primitive(|glb, primitive| primitive["indices"] = json!(glb.words(&[0, 1, 2, 0, 2, 3])));
    for glb in [narrow, wide] {
        assert_eq!(parsed(&glb).surfaces[0].faces, [[0, 1, 2, 2], [0, 2, 3, 3]]);
    }
}

#[test]
fn primitives_without_indices_use_vertices_in_order() {
    let glb = with_primitive(|glb, primitive| {
        primitive["attributes"]["POSITION"] = json!(glb.vectors(&SQUARE[..3]));
        primitive.as_object_mut().unwrap().remove("indices");
    });
    assert_eq!(parsed(&glb).surfaces[0].faces, [[0, 1, 2, 2]]);
}

#[test]
fn strips_and_fans_keep_their_winding() {
    let strip = with_primitive(|glb, primitive| {
        primitive["mode"] = json!(5);
        primitive["indices"] = json!(glb.bytes(&[0, 1, 3, 2]));
    });
    let fan = with_primitive(|glb, primitive| {
        primitive["mode"] = json!(6);
        primitive["indices"] = json!(glb.bytes(&[0, 1, 2, 3]));
    });
    for glb in [strip, fan] {
        let scene = parsed(&glb);
        let surface = &scene.surfaces[0];
        assert_eq!(surface.faces.len(), 2);
        assert_eq!(normal(surface, 0) + normal(surface, 1), 2.0 * DVec3::Z);
    }
}

#[test]
fn stitches_of_strips_are_dropped() {
    let glb = with_primitive(|glb, primitive| {
        primitive["mode"] = json!(5);
        primitive["indices"] = json!(glb.bytes(&[0, 1, 3, 3, 2]));
    });
    assert_eq!(parsed(&glb).surfaces[0].faces.len(), 1);
}

#[test]
fn points_and_lines_are_left_out_with_a_finding() {
    let mut glb = Glb::square();
    let mut line = glb.json["meshes"][0]["primitives"][0].clone();
    line["mode"] = json!(1);
    glb.json["meshes"][0]["primitives"].as_array_mut().unwrap().push(line);
    let scene = parsed(&glb);
    assert_eq!((scene.surfaces.len(), codes(&scene)), (1, vec!["no-area-primitives"]));

    glb.json["meshes"][0]["primitives"].as_array_mut().unwrap().remove(0);
    assert!(refusal(&glb).contains("no triangles"));
}

#[test]
fn unused_vertices_are_dropped() {
    let glb = with_primitive(|glb, primitive| primitive["indices"] = json!(glb.bytes(&[1, 2, 3])));
    let surface = &parsed(&glb).surfaces[0];
    assert_eq!((surface.vertices.len(), surface.faces[0]), (3, [0, 1, 2, 2]));
    assert_eq!(surface.vertices[0], DVec3::X);
}

#[test]
fn transforms_compose_from_parent_to_child() {
    let mut glb = Glb::square();
    // A quarter turn about z, then a shift, by parts in the parent and by matrix in the child.
    let half = 0.5_f64.sqrt();
    let child = glb.push(
        "nodes",
        json!({"name": "child", "mesh": 0, "matrix":
        [2., 0., 0., 0., 0., 2., 0., 0., 0., 0., 2., 0., 1., 0., 0., 1.]}),
    );
    glb.root(json!({"translation": [0, 0, 5], "rotation": [0, 0, half, half], "children": [child]}));
    let scene = parsed(&glb);
    let moved = &scene.surfaces[1];
    assert_eq!(moved.name, "child");
    // (1, 0, 0) -> (3, 0, 0) -> (0, 3, 0) -> (0, 3, 5)
    assert!((moved.vertices[1] - DVec3::new(0.0, 3.0, 5.0)).length() < 1e-6, "{}", moved.vertices[1]);
}

#[test]
fn mirrors_keep_fronts_in_front() {
    let mut glb = Glb::square();
    glb.root(json!({"name": "mirrored", "mesh": 0, "scale": [-1, 1, 1]}));
    let scene = parsed(&glb);
    assert!(normal(&scene.surfaces[1], 0).z > 0.0, "a mirror along x leaves the front towards +z");
}

#[test]
fn instances_have_unique_names() {
    let mut glb = Glb::square();
    glb.root(json!({"name": "square", "mesh": 0, "translation": [2, 0, 0]}));
    glb.root(json!({"mesh": 0, "translation": [4, 0, 0]}));
    let names: Vec<_> = parsed(&glb).surfaces.into_iter().map(|surface| surface.name).collect();
    assert_eq!(names, ["square", "square.2", "square mesh"]);
}

#[test]
fn units_scale_positions() {
    let options = LoadOptions { unit: Unit::Millimetre, two_sided: Some(true), ..LoadOptions::default() };
    let scene = parse(Path::new("a.glb"), &Glb::square().to_bytes(), &options).unwrap();
    assert_eq!(scene.surfaces[0].vertices[1], DVec3::new(0.001, 0.0, 0.0));
    assert!(scene.surfaces[0].material.two_sided);
}

#[test]
fn hierarchies_must_be_trees() {
    let mut own_parent = Glb::square();
    own_parent.json["nodes"][0]["children"] = json!([0]);
    assert!(refusal(&own_parent).contains("node 'square': it is reached twice"));

    let mut two_parents = Glb::square();
    let child = two_parents.push("nodes", json!({"name": "shared"}));
    two_parents.root(json!({"children": [child]}));
    two_parents.root(json!({"children": [child]}));
    assert!(refusal(&two_parents).contains("node 'shared': it is reached twice"));

    let mut missing = Glb::square();
    missing.json["nodes"][0]["children"] = json!([7]);
    assert!(refusal(&missing).contains("node 7: it does not exist"));
}

#[test]
fn absurd_depth_is_refused() {
    let mut glb = Glb::square();
    for index in 1..=1100 {
        glb.push("nodes", json!({"children": [index + 1]}));
    }
    glb.push("nodes", json!({}));
    glb.json["nodes"][0]["children"] = json!([1]);
    assert!(refusal(&glb).contains("more than 1000 levels"));
}

#[test]
fn scene_is_the_default_or_the_first_or_all_roots() {
    let mut glb = Glb::square();
    let other = glb.push("nodes", json!({"name": "other", "mesh": 0}));
    glb.push("scenes", json!({"nodes": [other]}));
    glb.json["scene"] = json!(1);
    assert_eq!(parsed(&glb).surfaces[0].name, "other");

    let object = glb.json.as_object_mut().unwrap();
    object.remove("scene");
    assert_eq!(parsed(&glb).surfaces[0].name, "square");

    glb.json.as_object_mut().unwrap().remove("scenes");
    assert_eq!(parsed(&glb).surfaces.len(), 2);

    glb.json["scene"] = json!(3);
    assert!(refusal(&glb).contains("scene 3: it does not exist"));
}

#[test]
fn bad_transforms_are_refused() {
    for (key, value, words) in [
        ("rotation", json!([0, 0, 0, 0]), "no quaternion"),
        ("matrix", json!([1, 0, 0, 1, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]), "last row"),
    ] {
        let mut glb = Glb::square();
        glb.json["nodes"][0][key] = value;
        let message = refusal(&glb);
        assert!(message.contains("node 'square'") && message.contains(words), "{message}");
    }
}

#[test]
fn numbers_beyond_single_precision_are_refused() {
    let places = [
        ("/nodes/0", "scale"),
        ("/nodes/0", "translation"),
        ("/nodes/0", "rotation"),
        ("/materials/0", "emissiveFactor"),
        ("/materials/0/pbrMetallicRoughness", "baseColorFactor"),
    ];
    for (pointer, key) in places {
        let mut glb = Glb::square();
        glb.json.pointer_mut(pointer).unwrap()[key] = json!([1e39, 0, 0, 1]);
        assert!(refusal(&glb).contains("JSON: the number that ends at line 1, column"), "{key}: {}", refusal(&glb));
    }
}

#[test]
fn transforms_that_overflow_are_refused() {
    let mut glb = Glb::square();
    glb.json["nodes"][0]["scale"] = json!([3e38, 1, 1]);
    for _ in 0..9 {
        let child = glb.json["nodes"].as_array().unwrap().len() - 1;
        glb.push("nodes", json!({"scale": [3e38, 1, 1], "children": [child]}));
    }
    glb.json["scenes"][0]["nodes"] = json!([9]);
    assert!(refusal(&glb).contains("its transform is not finite"), "{}", refusal(&glb));
}

#[test]
fn sparse_accessors_replace_elements() {
    let mut glb = Glb::square();
    let (indices, values) = (glb.view(&[2]), [9.0_f32, 1.0, 0.0].map(f32::to_le_bytes).concat());
    let values = glb.view(&values);
    glb.json["accessors"][0]["sparse"] = json!({"count": 1,
        "indices": {"bufferView": indices, "componentType": 5121}, "values": {"bufferView": values}});
    assert_eq!(parsed(&glb).surfaces[0].vertices[2], DVec3::new(9.0, 1.0, 0.0));

    glb.json["accessors"][0].as_object_mut().unwrap().remove("bufferView");
    assert_eq!(parsed(&glb).surfaces[0].vertices[1], DVec3::ZERO, "without a view the rest is zero");

    glb.json["accessors"][0]["sparse"]["indices"]["byteOffset"] = json!(1);
    assert!(refusal(&glb).contains("do not fit"));
    glb.json["accessors"][0]["sparse"]["indices"]["byteOffset"] = json!(0);
    glb.json["accessors"][0]["count"] = json!(2);
    assert!(refusal(&glb).contains("sparse index 2 is out of range"));
}

#[test]
fn interleaved_and_quantised_positions_are_read() {
    let mut glb = Glb::square();
    let rows: Vec<u8> = [[0, 0], [127, 0], [127, 127], [0, 127]].iter().flat_map(|&[x, y]| [x, y, 0, 99]).collect();
    let position = glb.accessor(&rows, 5120, "VEC3", 4);
    glb.json["accessors"][position]["normalized"] = json!(true);
    let view = glb.json["accessors"][position]["bufferView"].as_u64().unwrap() as usize;
    glb.json["bufferViews"][view]["byteStride"] = json!(4);
    glb.json["meshes"][0]["primitives"][0]["attributes"]["POSITION"] = json!(position);
    glb.json["extensionsRequired"] = json!(["KHR_mesh_quantization"]);
    assert_eq!(parsed(&glb).surfaces[0].vertices[2], DVec3::new(1.0, 1.0, 0.0));
}

#[test]
fn counts_must_fit_their_buffers() {
    let huge = [u64::from(u32::MAX), u64::MAX, 1 << 40, 5];
    for count in huge {
        let mut glb = Glb::square();
        glb.json["accessors"][0]["count"] = json!(count);
        assert!(refusal(&glb).contains("mesh 'square mesh', primitive 0: accessor 0"), "{count}");

        glb.json["accessors"][0].as_object_mut().unwrap().remove("bufferView");
        if count > 5 {
            assert!(refusal(&glb).contains("without data"), "{count}");
        }
    }
    for (key, value) in [("byteOffset", json!(u64::MAX)), ("byteLength", json!(u64::MAX)), ("buffer", json!(9))] {
        let mut glb = Glb::square();
        glb.json["bufferViews"][0][key] = value;
        assert!(refusal(&glb).contains("bufferView 0"), "{key}");
    }
    for stride in [0, 1, 11] {
        let mut glb = Glb::square();
        glb.json["bufferViews"][0]["byteStride"] = json!(stride);
        assert!(refusal(&glb).contains("overlap"), "{stride}");
    }
}

#[test]
fn references_must_exist() {
    let cases: [(&str, Value, &str); 4] = [
        ("/meshes/0/primitives/0/attributes/POSITION", json!(99), "accessor 99 does not exist"),
        ("/meshes/0/primitives/0/indices", json!(99), "accessor 99 does not exist"),
        ("/meshes/0/primitives/0/material", json!(99), "material 99: it does not exist"),
        ("/nodes/0/mesh", json!(99), "shows mesh 99"),
    ];
    for (pointer, value, words) in cases {
        let mut glb = Glb::square();
        *glb.json.pointer_mut(pointer).unwrap() = value;
        assert!(refusal(&glb).contains(words), "{pointer}");
    }
    for (key, value) in [("camera", json!(9)), ("extensions", json!({"KHR_lights_punctual": {"light": 9}}))] {
        let mut glb = Glb::square();
        glb.json["nodes"][0][key] = value;
        assert!(refusal(&glb).contains("it does not exist"), "{key}");
    }
}

#[test]
fn vertices_and_indices_are_checked() {
    let mut glb = with_primitive(|glb, primitive| primitive["indices"] = json!(glb.bytes(&[0, 1, 4])));
    assert!(refusal(&glb).contains("index 2 refers to vertex 4 of 4"));
    glb = with_primitive(|glb, primitive| {
        primitive["attributes"]["POSITION"] =
            json!(glb.vectors(&[[0., 0., 0.], [f32::NAN, 0., 0.], [0., 1., 0.], [1., 1., 0.]]));
    });
    assert!(refusal(&glb).contains("vertex 1 is not finite"));
    glb = with_primitive(|glb, primitive| primitive["indices"] = json!(glb.vectors(&SQUARE)));
    assert!(refusal(&glb).contains("unsigned scalars"));
}

#[test]
fn numbers_of_faces_are_limited() {
    let options = LoadOptions { max_faces: 3, ..LoadOptions::default() };
    let mut glb = Glb::square();
    assert!(parse(Path::new("a.glb"), &glb.to_bytes(), &options).is_ok());
    glb.root(json!({"mesh": 0}));
    let error = parse(Path::new("a.glb"), &glb.to_bytes(), &options).unwrap_err();
    assert!(error.message.contains("more than 3 triangles"), "{error}");
}

#[test]
fn compression_and_unknown_requirements_are_refused() {
    for (name, words) in [
        ("KHR_draco_mesh_compression", "without mesh compression"),
        ("EXT_meshopt_compression", "without mesh compression"),
        ("EXT_mesh_gpu_instancing", "not supported"),
    ] {
        let mut glb = Glb::square();
        glb.json["extensionsRequired"] = json!([name]);
        let message = refusal(&glb);
        assert!(message.contains(name) && message.contains(words), "{message}");
    }
    let mut glb = Glb::square();
    glb.json["extensionsUsed"] = json!(["EXT_mesh_gpu_instancing", "KHR_materials_ior"]);
    assert_eq!(codes(&parsed(&glb)), ["ignored-extensions"]);
}

#[test]
fn other_versions_are_named() {
    let mut glb = Glb::square();
    glb.json["asset"]["version"] = json!("1.0");
    assert!(refusal(&glb).contains("glTF 1.0 and only glTF 2.0"));
    let mut bytes = glb.to_bytes();
    bytes[4] = 1;
    assert!(try_parse(&bytes).unwrap_err().message.contains("binary glTF 1"));
}

#[test]
fn base_colour_one_is_limited_with_one_warning() {
    let mut glb = Glb::square();
    glb.json["materials"][0]["pbrMetallicRoughness"]["baseColorFactor"] = json!([1, 0.5, 0.96, 1]);
    glb.root(json!({"mesh": 0, "translation": [3, 0, 0]}));
    let scene = parsed(&glb);
    assert!(close(&scene.surfaces[0].material.reflectance, &[0.95, 0.5, 0.95]));
    assert_eq!(codes(&scene), ["reflectance-limited"]);
    assert_eq!(scene.findings[0].element, "material 'paint'");
    assert!(scene.validate().is_ok());
}

#[test]
fn impossible_materials_are_errors() {
    let cases = [
        ("/materials/0/pbrMetallicRoughness/baseColorFactor", json!([1.1, 0, 0, 1]), "base colour"),
        ("/materials/0/pbrMetallicRoughness/baseColorFactor", json!([-0.1, 0, 0, 1]), "base colour"),
        ("/materials/0/pbrMetallicRoughness/metallicFactor", json!(2), "metallic factor"),
        ("/materials/0/emissiveFactor", json!([-1, 0, 0]), "emission"),
    ];
    for (pointer, value, words) in cases {
        let mut glb = Glb::square();
        *glb.json.pointer_mut(pointer).unwrap() = value;
        let message = refusal(&glb);
        assert!(message.contains("material 'paint'") && message.contains(words), "{message}");
    }
}

#[test]
fn rounding_beyond_0_and_1_is_forgiven() {
    let mut glb = Glb::square();
    let pbr = &mut glb.json["materials"][0]["pbrMetallicRoughness"];
    pbr["baseColorFactor"] = json!([1.0000001, -1e-8, 0.5, 1]);
    pbr["metallicFactor"] = json!(-1e-8);
    assert_eq!(parsed(&glb).surfaces[0].material.reflectance, [0.95, 0.0, 0.5 * (1.0 + f64::from(1e-8_f32))]);
}

#[test]
fn rough_metals_are_diffuse_and_keep_their_gloss() {
    let mut glb = Glb::square();
    let pbr = &mut glb.json["materials"][0]["pbrMetallicRoughness"];
    (pbr["metallicFactor"], pbr["roughnessFactor"]) = (json!(0.75), json!(0.5));
    let scene = parsed(&glb);
    let material = &scene.surfaces[0].material;
    assert!(close(&material.reflectance, &[0.5, 0.6, 0.7]));
    assert_eq!((material.gloss, material.specular), (Gloss { metallic: 0.75, roughness: 0.5 }, 0.0));
    assert_eq!(codes(&scene), ["metallic-material"]);
}

#[test]
fn transparent_materials_are_read_as_opaque() {
    let mut blended = Glb::square();
    blended.json["materials"][0]["alphaMode"] = json!("BLEND");
    let mut transmissive = Glb::square();
    transmissive.json["materials"][0]["extensions"] = json!({"KHR_materials_transmission": {"transmissionFactor": 1}});
    for glb in [blended, transmissive] {
        assert_eq!(codes(&parsed(&glb)), ["transparent-material"]);
    }
}

#[test]
fn lit_models_are_told_from_scenes() {
    let mut glb = Glb::square();
    glb.json["extras"] = json!({"author": "radiosity"});
    assert!(codes(&parsed(&glb)).is_empty());
    glb.json["extras"] = json!({"radiosity": {"version": 1}});
    let scene = parsed(&glb);
    assert_eq!(codes(&scene), ["lit-model"]);
    assert!(scene.validate().unwrap_err().message.contains("radiosity render"));
    assert!(scene.validate_geometry().is_ok());
}

#[test]
fn surfaces_without_material_are_mid_grey() {
    let glb = with_primitive(|_, primitive| {
        primitive.as_object_mut().unwrap().remove("material");
    });
    let scene = parsed(&glb);
    assert_eq!(scene.surfaces[0].material.reflectance, [0.5; 3]);
    assert_eq!(codes(&scene), ["no-material"]);
}

#[test]
fn specular_glossiness_gives_its_diffuse_factor() {
    let mut glb = Glb::square();
    glb.json["materials"][0]["extensions"] =
        json!({"KHR_materials_pbrSpecularGlossiness": {"diffuseFactor": [0.1, 0.2, 0.3, 1]}});
    assert!(close(&parsed(&glb).surfaces[0].material.reflectance, &[0.1, 0.2, 0.3]));
}

#[test]
fn emissive_strength_multiplies() {
    let mut glb = Glb::square();
    glb.json["materials"][0]["extensions"] = json!({"KHR_materials_emissive_strength": {"emissiveStrength": 10}});
    glb.json["materials"][0]["doubleSided"] = json!(true);
    let material = &parsed(&glb).surfaces[0].material;
    assert!(close(&material.emission, &[PI, 2.0 * PI, 3.0 * PI]) && material.two_sided);
}

#[test]
fn textures_and_vertex_colours_tint() {
    let mut glb = Glb::square();
    let view = glb.view(&two_colour_png([255, 255, 255], [0, 0, 0]));
    glb.push("images", json!({"bufferView": view, "mimeType": "image/png"}));
    glb.push("textures", json!({"source": 0}));
    glb.json["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"] = json!({"index": 0});
    glb.json["materials"][0]["emissiveTexture"] = json!({"index": 0});
    let colours = glb.vectors(&[[0.5, 1.0, 0.0]; 4]);
    glb.json["meshes"][0]["primitives"][0]["attributes"]["COLOR_0"] = json!(colours);
    let scene = parsed(&glb);
    let material = &scene.surfaces[0].material;
    assert!(close(&material.reflectance, &[0.5 * 0.5 * 0.5, 0.6 * 0.5, 0.0]), "{:?}", material.reflectance);
    assert!(close(&material.emission, &[0.05 * PI, 0.1 * PI, 0.15 * PI]));
    // Without texture coordinates the mean is taken.
    assert_eq!(codes(&scene), ["no-texture-coordinates"]);
}

/// The square with an image on it, its left half of one colour and its right half of another.
fn textured(left: [u8; 3], right: [u8; 3]) -> Glb {
    let mut glb = Glb::square();
    let view = glb.view(&two_colour_png(left, right));
    glb.push("images", json!({"bufferView": view, "mimeType": "image/png"}));
    glb.push("samplers", json!({"wrapS": 33071, "wrapT": 33648}));
    glb.push("textures", json!({"source": 0, "sampler": 0}));
    glb.json["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"] = json!({"index": 0});
    let corners: Vec<u8> = [[0.0_f32, 1.0], [1.0, 1.0], [1.0, 0.0], [0.0, 0.0]]
        .as_flattened()
        .iter()
        .flat_map(|c| c.to_le_bytes())
        .collect();
    let coordinates = glb.accessor(&corners, 5126, "VEC2", 4);
    glb.json["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_0"] = json!(coordinates);
    glb
}

/// The reflectance at a point of the only surface.
fn reflectance_at(scene: &Scene, x: f64, y: f64) -> [f32; 3] {
    let faces = scene.textured_faces().unwrap()[0].clone().unwrap();
    // Its faces are the triangles below and above the diagonal.
    let found = faces.at(usize::from(y > x), DVec3::new(x, y, 0.0));
    [0, 1, 2].map(|band| found.band(band))
}

#[test]
fn textures_come_with_coordinates_wrap_modes_and_factors() {
    let scene = parsed(&textured([255; 3], [0, 0, 128]));
    assert_eq!(scene.findings(), vec![]);
    let surface = &scene.surfaces[0];
    assert!(close(&surface.material.reflectance, &[0.5, 0.6, 0.7]));
    let texture = surface.texture.as_ref().unwrap();
    assert_eq!(texture.image.wrap(), [Wrap::Clamp, Wrap::Mirror]);
    assert_eq!(texture.coordinates, [[0.0, 1.0], [1.0, 1.0], [1.0, 0.0], [0.0, 0.0]]);
    assert_eq!(reflectance_at(&scene, 0.2, 0.7), [0.5, 0.6, 0.7]);
    let [red, green, blue] = reflectance_at(&scene, 0.8, 0.7);
    assert!(red == 0.0 && green == 0.0 && (blue - 0.7 * 0.215_860_5).abs() < 1e-6);
}

#[test]
fn white_of_textures_is_limited_where_it_is_too_white() {
    let mut glb = textured([255; 3], [128; 3]);
    glb.json["materials"][0]["pbrMetallicRoughness"]["baseColorFactor"] = json!([1, 1, 1, 1]);
    let scene = parsed(&glb);
    assert_eq!(codes(&scene), ["texture-limited"]);
    assert!(scene.validate().is_ok());
    let [white, grey] = [0.2, 0.8].map(|x| reflectance_at(&scene, x, 0.5)[0]);
    assert!((white - 0.95).abs() < 1e-6 && (grey - 0.215_860_5).abs() < 1e-6, "{white} {grey}");
}

#[test]
fn textures_are_scaled_turned_and_moved() {
    let mut glb = textured([255; 3], [0; 3]);
    let transform = json!({"offset": [0.25, 1.0], "rotation": PI / 2.0, "scale": [2.0, 0.5]});
    glb.json["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"]["extensions"] =
        json!({"KHR_texture_transform": transform});
    let found = parsed(&glb).surfaces[0].texture.clone().unwrap().coordinates;
    // A quarter turn counter-clockwise takes (u, v), v down, to (v, -u).
    for ([u, v], expected) in found.iter().zip([[0.75, 1.0], [0.75, -1.0], [0.25, -1.0], [0.25, 1.0]]) {
        assert!((u - expected[0]).abs() < 1e-6 && (v - expected[1]).abs() < 1e-6, "{found:?}");
    }
}

#[test]
fn unsound_coordinates_leave_the_mean() {
    for (bytes, kind, count) in [(vec![0; 48], "VEC3", 4), (vec![0; 16], "VEC2", 2), (vec![255; 32], "VEC2", 4)] {
        let mut glb = textured([255; 3], [0; 3]);
        let coordinates = glb.accessor(&bytes, 5126, kind, count);
        glb.json["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_0"] = json!(coordinates);
        let scene = parsed(&glb);
        assert_eq!(codes(&scene), ["no-texture-coordinates"]);
        assert!(scene.surfaces[0].texture.is_none());
        assert!(close(&scene.surfaces[0].material.reflectance, &[0.25, 0.3, 0.35]));
    }
}

#[test]
fn smooth_metals_mirror_the_mean_and_half_metals_keep_half_the_texture() {
    let mut glb = textured([255; 3], [0; 3]);
    let pbr = &mut glb.json["materials"][0]["pbrMetallicRoughness"];
    (pbr["metallicFactor"], pbr["roughnessFactor"]) = (json!(0.5), json!(0.0));
    let scene = parsed(&glb);
    let material = &scene.surfaces[0].material;
    assert!(close(&material.reflectance, &[0.25, 0.3, 0.35]) && scene.surfaces[0].texture.is_some());
    assert!((material.specular - 0.25 * colour::luminance([0.5, 0.6, 0.7])).abs() < 1e-6);
    glb.json["materials"][0]["pbrMetallicRoughness"]["metallicFactor"] = json!(1);
    assert!(parsed(&glb).surfaces[0].texture.is_none());
}

#[test]
fn metalness_comes_from_the_blue_channel_as_stored() {
    let mut glb = Glb::square();
    let view = glb.view(&two_colour_png([0, 0, 255], [0, 0, 0]));
    glb.push("images", json!({"bufferView": view}));
    glb.push("textures", json!({"source": 0}));
    glb.json["materials"][0]["pbrMetallicRoughness"] =
        json!({"baseColorFactor": [0.5, 0.6, 0.7, 1], "metallicRoughnessTexture": {"index": 0}});
    assert!(close(&parsed(&glb).surfaces[0].material.reflectance, &[0.25, 0.3, 0.35]));
}

#[test]
fn unreadable_textures_are_warnings_with_file_and_remedy() {
    let images =
        [json!({"uri": "missing.png"}), json!({"uri": "../../etc/passwd"}), json!({"bufferView": 0}), json!({})];
    for image in images {
        let mut glb = Glb::square();
        glb.push("images", image);
        glb.push("textures", json!({"source": 0}));
        glb.json["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"] = json!({"index": 0});
        let scene = parsed(&glb);
        assert!(close(&scene.surfaces[0].material.reflectance, &[0.25, 0.3, 0.35]));
        let [finding] = &scene.findings[..] else { panic!("{:?}", scene.findings) };
        assert_eq!((finding.severity, finding.code), (Severity::Warning, "unreadable-texture"));
        assert!(finding.message.contains("supply it as PNG or JPEG"), "{finding}");
    }
    let mut glb = Glb::square();
    glb.push("textures", json!({"extensions": {"EXT_texture_webp": {"source": 0}}}));
    glb.json["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"] = json!({"index": 0});
    assert_eq!(codes(&parsed(&glb)), ["unreadable-texture"]);
}

fn with_light(light: Value) -> Glb {
    let mut glb = Glb::square();
    glb.json["extensions"] = json!({"KHR_lights_punctual": {"lights": [light]}});
    // A quarter turn about x takes -z to +y.
    let half = 0.5_f64.sqrt();
    glb.root(json!({"name": "lamp", "translation": [1, 2, 3], "rotation": [half, 0, 0, half],
        "extensions": {"KHR_lights_punctual": {"light": 0}}}));
    glb
}

#[test]
fn point_light_keeps_intensity_times_colour() {
    let scene = parsed(&with_light(json!({"type": "point", "color": [1, 0.5, 0.25], "intensity": 40, "range": 5})));
    let Light::Point { name, position, intensity } = &scene.lights[0] else { panic!("{:?}", scene.lights) };
    assert_eq!((name.as_str(), *position), ("lamp", DVec3::new(1.0, 2.0, 3.0)));
    assert!(close(intensity, &[40.0, 20.0, 10.0]));
    assert_eq!(codes(&scene), ["light-range"]);
}

#[test]
fn directional_and_spot_lights_look_along_minus_z() {
    let scene = parsed(&with_light(json!({"type": "directional", "intensity": 3})));
    let Light::Directional { direction, irradiance, .. } = &scene.lights[0] else { panic!("{:?}", scene.lights) };
    assert!((*direction - DVec3::Y).length() < 1e-6 && close(irradiance, &[3.0; 3]));

    let spot = json!({"type": "spot", "spot": {"innerConeAngle": 0.2, "outerConeAngle": 0.5}});
    let scene = parsed(&with_light(spot));
    let Light::Spot { direction, inner_angle, outer_angle, intensity, .. } = &scene.lights[0] else {
        panic!("{:?}", scene.lights)
    };
    assert!((*direction - DVec3::Y).length() < 1e-6 && close(&[*inner_angle, *outer_angle], &[0.2, 0.5]));
    assert!(close(intensity, &[1.0; 3]), "intensity 1 is glTF's default");
}

#[test]
fn odd_lights_are_noticed_or_refused() {
    let dark = parsed(&with_light(json!({"type": "point", "intensity": 0})));
    assert!(dark.findings().iter().any(|finding| finding.code == "dark-light"));
    for light in [
        json!({"type": "point", "intensity": -1}),
        json!({"type": "point", "color": [1, -1, 1]}),
        json!({"type": "spot"}),
        json!({"type": "spot", "spot": {"innerConeAngle": 0.6, "outerConeAngle": 0.5}}),
        json!({"type": "spot", "spot": {"outerConeAngle": 3}}),
        json!({"type": "area"}),
    ] {
        assert!(refusal(&with_light(light)).contains("light of node 'lamp'"));
    }
}

#[test]
fn cameras_are_placed_by_their_node() {
    let mut glb = Glb::square();
    glb.push("cameras", json!({"type": "perspective", "perspective": {"yfov": 0.7, "znear": 0.1, "aspectRatio": 1.5}}));
    glb.push(
        "cameras",
        json!({"type": "orthographic",
        "orthographic": {"xmag": 1, "ymag": 1, "znear": 0, "zfar": 1}}),
    );
    // Half a turn about y: looks along +z.
    glb.root(json!({"name": "view", "camera": 0, "translation": [0, 1, -5], "rotation": [0, 1, 0, 0]}));
    glb.root(json!({"name": "plan", "camera": 1}));
    let scene = parsed(&glb);
    let [camera] = &scene.cameras[..] else { panic!("{:?}", scene.cameras) };
    assert_eq!((camera.name.as_str(), camera.position), ("view", DVec3::new(0.0, 1.0, -5.0)));
    assert!((camera.forward - DVec3::Z).length() < 1e-6 && (camera.up - DVec3::Y).length() < 1e-6);
    assert!(close(&[camera.vertical_fov], &[0.7]) && camera.aspect == Some(1.5));
    assert_eq!(codes(&scene), ["camera-left-out"]);
}

#[test]
fn camera_without_its_parameters_is_left_out() {
    let mut glb = Glb::square();
    glb.push("cameras", json!({"type": "perspective"}));
    glb.root(json!({"camera": 0}));
    assert_eq!(codes(&parsed(&glb)), ["camera-left-out"]);
}

#[test]
fn text_files_embed_or_refer_to_their_buffers() {
    use base64::Engine;
    let glb = Glb::square();
    let mut json = glb.json.clone();
    let payload = base64::engine::general_purpose::STANDARD.encode(glb.binary());
    json["buffers"] =
        json!([{"byteLength": glb.binary().len(), "uri": format!("data:application/gltf-buffer;base64,{payload}")}]);
    let embedded = format!("\u{feff}\n{json}");
    assert_eq!(try_parse(embedded.as_bytes()).unwrap().surfaces[0].vertices.len(), 4);

    for (uri, words) in [("missing.bin", "does not exist"), ("../a.bin", "leads out"), ("file:///a", "scheme")] {
        json["buffers"][0]["uri"] = json!(uri);
        let error = try_parse(json.to_string().as_bytes()).unwrap_err();
        assert_eq!(error.element, "buffer 0");
        assert!(error.message.contains(words), "{error}");
    }
    json["buffers"][0].as_object_mut().unwrap().remove("uri");
    assert!(try_parse(json.to_string().as_bytes()).unwrap_err().message.contains("no data"));
}

#[test]
fn truncation_is_named_at_every_length() {
    let bytes = Glb::square().to_bytes();
    for length in 4..bytes.len() {
        let error = try_parse(&bytes[..length]).unwrap_err();
        assert!(error.message.contains("copy or export it again"), "{length}: {error}");
    }
    assert!(try_parse(&container("{\"asset\"", &[])).unwrap_err().message.contains("damaged"));
}

/// A file that exercises every reader: instances, sparse accessor, texture, colours, light, camera.
fn rich() -> Glb {
    let mut glb = with_light(json!({"type": "spot", "intensity": 4, "spot": {"outerConeAngle": 0.5}}));
    let view = glb.view(&two_colour_png([255, 255, 255], [0, 0, 0]));
    glb.push("images", json!({"bufferView": view}));
    glb.push("samplers", json!({"wrapS": 33071, "wrapT": 33648}));
    glb.push("textures", json!({"source": 0, "sampler": 0}));
    let transform = json!({"KHR_texture_transform": {"offset": [0.5, 0], "scale": [2, 1], "texCoord": 0}});
    glb.json["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"] = json!({"index": 0, "extensions": transform});
    let coordinates = glb.accessor(&[0, 0, 255, 0, 255, 255, 0, 255], 5121, "VEC2", 4);
    glb.json["accessors"][coordinates]["normalized"] = json!(true);
    glb.json["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_0"] = json!(coordinates);
    let colours = glb.bytes(&[99; 12]);
    glb.json["accessors"][colours]["type"] = json!("VEC3");
    glb.json["accessors"][colours]["count"] = json!(4);
    glb.json["accessors"][colours]["normalized"] = json!(true);
    glb.json["meshes"][0]["primitives"][0]["attributes"]["COLOR_0"] = json!(colours);
    glb.push("cameras", json!({"type": "perspective", "perspective": {"yfov": 0.7, "znear": 0.1}}));
    glb.root(json!({"camera": 0, "mesh": 0, "scale": [2, 2, -2]}));
    let (indices, values) = (glb.view(&[2]), [1.0_f32, 1.0, 0.0].map(f32::to_le_bytes).concat());
    let values = glb.view(&values);
    glb.json["accessors"][0]["sparse"] = json!({"count": 1,
        "indices": {"bufferView": indices, "componentType": 5121}, "values": {"bufferView": values}});
    glb
}

#[test]
fn no_damage_panics() {
    let whole = rich().to_bytes();
    let sound = try_parse(&whole).unwrap();
    assert!(sound.surfaces.len() == 2 && sound.surfaces.iter().all(|surface| surface.texture.is_some()));
    let options = LoadOptions { max_faces: 1000, ..LoadOptions::default() };
    let read = |bytes: &[u8]| {
        if let Ok(scene) = parse(Path::new("test.glb"), bytes, &options) {
            let _ = (scene.findings(), scene.validate(), scene.textured_faces());
        }
    };
    for position in 0..whole.len() {
        read(&whole[..position]);
        let mut damaged = whole.clone();
        for change in [1, 4, 128, 255, b'0' ^ b'9', b'1' ^ b'-'] {
            damaged[position] = whole[position] ^ change;
            read(&damaged);
        }
    }
}

#[test]
fn no_number_in_the_json_panics() {
    let whole = rich();
    let text = whole.json.to_string();
    let digits = text.char_indices().filter(|(_, c)| c.is_ascii_digit()).map(|(at, _)| at);
    for at in digits {
        for number in ["99", "-1", "4294967296", "18446744073709551615", "1e300", "0.5", "null", "[]", "\"\""] {
            let json = format!("{}{number}{}", &text[..at], &text[at + 1..]);
            let _ = try_parse(&container(&json, whole.binary()));
        }
    }
}

/// The square of a material with more of it given.
fn with_material(pbr: Value, extensions: Value) -> Glb {
    let mut glb = Glb::square();
    for (name, value) in pbr.as_object().unwrap() {
        glb.json["materials"][0]["pbrMetallicRoughness"][name] = value.clone();
    }
    glb.json["materials"][0]["extensions"] = extensions;
    glb
}

#[test]
fn smooth_metals_are_mirrors() {
    let grey = json!({"baseColorFactor": [0.8, 0.8, 0.8, 1], "metallicFactor": 0.75, "roughnessFactor": 0.1});
    let scene = parsed(&with_material(grey, json!({})));
    let material = &scene.surfaces[0].material;
    assert!(close(&material.reflectance, &[0.2; 3]) && close(&[material.specular], &[0.6]), "{material:?}");
    assert_eq!(codes(&scene), [""; 0]);
    let rough = json!({"metallicFactor": 0.75, "roughnessFactor": 0.11});
    let rough = parsed(&with_material(rough, json!({})));
    assert_eq!((rough.surfaces[0].material.specular, &codes(&rough)[..]), (0.0, &["metallic-material"][..]));
}

#[test]
fn coloured_mirrors_are_grey_and_full_ones_keep_something_to_absorb() {
    let gold = json!({"baseColorFactor": [1, 0.75, 0.3, 1], "metallicFactor": 1, "roughnessFactor": 0});
    let mut glb = with_material(gold, json!({}));
    glb.json["materials"][0]["emissiveFactor"] = json!([0, 0, 0]);
    let scene = parsed(&glb);
    let material = &scene.surfaces[0].material;
    assert!(close(&[material.specular], &[0.2126 + 0.75 * 0.7152 + 0.3 * 0.0722]), "{material:?}");
    assert_eq!((&material.reflectance[..], &codes(&scene)[..]), (&[0.0; 3][..], &["coloured-mirror"][..]));
    // A lamp that mirrors all.
    let silver = json!({"baseColorFactor": [1, 1, 1, 1], "metallicFactor": 1, "roughnessFactor": 0});
    let scene = parsed(&with_material(silver.clone(), json!({})));
    assert!(close(&[scene.surfaces[0].material.specular], &[0.95]) && codes(&scene) == ["mirror-limited"]);
    let mut ideal = with_material(silver, json!({}));
    ideal.json["materials"][0]["emissiveFactor"] = json!([0, 0, 0]);
    assert_eq!(parsed(&ideal).surfaces[0].material.specular, 1.0);
}

#[test]
fn smooth_transmission_is_clear_glass() {
    let pane = json!({"baseColorFactor": [0.9, 0.9, 0.9, 1], "metallicFactor": 0, "roughnessFactor": 0.05});
    let scene = parsed(&with_material(pane, json!({"KHR_materials_transmission": {"transmissionFactor": 0.8}})));
    let material = &scene.surfaces[0].material;
    assert!(close(&[material.transmittance], &[0.72]) && close(&material.reflectance, &[0.18; 3]), "{material:?}");
    assert_eq!((material.specular, codes(&scene)), (0.0, vec![]));
    let odd = with_material(json!({}), json!({"KHR_materials_transmission": {"transmissionFactor": 2}}));
    assert!(refusal(&odd).contains("transmission factor"));
}

#[test]
fn diffuse_transmission_is_a_part_of_what_is_diffuse() {
    let paper = json!({"baseColorFactor": [0.8, 0.6, 0.4, 1], "metallicFactor": 0});
    let through = |extension: Value| json!({"KHR_materials_diffuse_transmission": extension});
    let wanted = json!({"diffuseTransmissionFactor": 0.25, "diffuseTransmissionColorFactor": [1, 0.8, 0.4]});
    let scene = parsed(&with_material(paper.clone(), through(wanted)));
    let material = &scene.surfaces[0].material;
    assert!(close(&material.reflectance, &[0.6, 0.45, 0.3]), "{material:?}");
    assert!(close(&material.diffuse_transmittance, &[0.25, 0.2, 0.1]) && material.two_sided, "{material:?}");
    assert_eq!(codes(&scene), [""; 0]);
    // Of nothing, nothing passes, and sides stay as the file says.
    let opaque = parsed(&with_material(paper.clone(), through(json!({}))));
    let material = &opaque.surfaces[0].material;
    assert!(!material.is_translucent() && !material.two_sided && close(&material.reflectance, &[0.8, 0.6, 0.4]));
    let white = json!({"baseColorFactor": [1, 1, 1, 1], "metallicFactor": 0});
    let full = parsed(&with_material(white, through(json!({"diffuseTransmissionFactor": 0.5}))));
    let material = &full.surfaces[0].material;
    assert!(close(&material.reflectance, &[0.475; 3]) && close(&material.diffuse_transmittance, &[0.475; 3]));
    assert_eq!(codes(&full), ["mirror-limited"]);
    for odd in [json!({"diffuseTransmissionFactor": 2}), json!({"diffuseTransmissionFactor": "half"})] {
        assert!(refusal(&with_material(paper.clone(), through(odd))).contains("diffuse"));
    }
}
