use std::fs;
use std::path::Path;

use glam::DVec3;
use proptest::prelude::*;
use radiosity_geometry::Patches;
use radiosity_scene::{Camera, Light};

use super::read::decode;
use super::{LitData, LitModel, LitSurface, read_lit, write_lit};
use crate::test_scenes::{camera, cube};

/// A cube of which one side is another surface, with a triangle and a patch without area, in any number of bands.
fn sample(bands: usize) -> LitData {
    let mut patches = cube(2);
    let mut polygons = patches.polygons;
    let [a, b, c, _] = polygons[3].map(|p| p + DVec3::X);
    polygons.extend([[a, b, c, c], [a, b, b, a]]);
    patches.surface[4..8].fill(2);
    patches.surface.extend([2, 2]);
    patches.face.extend([70_000, 1]);
    let two_sided = patches.surface.iter().map(|&s| s == 2).collect();
    let patches = Patches::new(polygons, patches.surface, patches.face, two_sided);
    let patches = patches.with_obstructions(vec![[a, b, c, c]]);
    let n = patches.len() * bands;
    let value = |scale: f64| (0..n).map(|i| f64::from((scale * (1.0 + i as f64).sqrt()) as f32)).collect();
    let surface = |name: &str, two_sided| LitSurface {
        name: name.into(),
        material: format!("{name} paint"),
        reflectance: (0..bands).map(|k| 0.1 + 0.1 * k as f64).collect(),
        two_sided,
        specular: if two_sided { 0.25 } else { 0.0 },
        transmittance: if two_sided { 0.5 } else { 0.0 },
        diffuse_transmittance: if two_sided { vec![0.125; bands] } else { Vec::new() },
    };
    LitData {
        patches,
        surfaces: vec![surface("cube", false), surface("empty \"ß<&", false), surface("sheet", true)],
        bands: if bands == 3 {
            ["R", "G", "B"].map(String::from).to_vec()
        } else {
            (0..bands).map(|k| format!("b{k}")).collect()
        },
        emission: value(0.0),
        irradiance: value(2.0),
        radiosity: value(1.0),
        error: value(0.01),
        cameras: vec![
            camera(DVec3::new(2.0, 1.5, 1.0), 0.6),
            Camera { aspect: Some(1.5), name: "other".into(), ..camera(DVec3::new(0.0, 0.0, 5.0), 1.0) },
        ],
        lights: Some(lights(bands)),
        report_json: "{\"closure\": 1.0, \"z\": [1, 2], \"a\": \"ß\"}".into(),
        exposure: 0.3,
    }
}

/// One of each kind.
fn lights(bands: usize) -> Vec<Light> {
    let (position, direction) = (DVec3::new(0.1, 2.0, -3.0), DVec3::new(0.6, 0.0, -0.8));
    let strength: Vec<f64> = (0..bands).map(|k| 0.1 + k as f64).collect();
    vec![
        Light::Point { name: "bulb".into(), position, intensity: strength.clone() },
        Light::Spot {
            name: "spot \"ß".into(),
            position,
            direction,
            intensity: strength.clone(),
            inner_angle: 0.1,
            outer_angle: 0.7,
        },
        Light::Directional { name: "sun".into(), direction, irradiance: strength },
    ]
}

fn assert_same(a: &LitData, b: &LitData) {
    let single = |p: &[DVec3; 4]| p.map(|v| v.as_vec3().as_dvec3());
    assert_eq!(a.patches.polygons.iter().map(single).collect::<Vec<_>>(), b.patches.polygons);
    assert_eq!(a.patches.surface, b.patches.surface);
    assert_eq!(a.patches.face, b.patches.face);
    assert_eq!(a.patches.two_sided, b.patches.two_sided);
    assert_eq!(a.patches.obstructions, b.patches.obstructions);
    assert_eq!(format!("{:?}", a.lights), format!("{:?}", b.lights));
    assert_eq!((&a.surfaces, &a.bands), (&b.surfaces, &b.bands));
    assert_eq!((&a.emission, &a.irradiance), (&b.emission, &b.irradiance));
    assert_eq!((&a.radiosity, &a.error), (&b.radiosity, &b.error));
    assert_eq!((&a.report_json, a.exposure), (&b.report_json, b.exposure));
    assert_eq!(a.cameras.len(), b.cameras.len());
    for (a, b) in a.cameras.iter().zip(&b.cameras) {
        assert_eq!((&a.name, a.aspect), (&b.name, b.aspect));
        assert!((a.vertical_fov - b.vertical_fov).abs() < 1e-6);
        let distance = |p: DVec3, q: DVec3| (p - q).length();
        assert!(distance(a.position, b.position) + distance(a.forward, b.forward) + distance(a.up, b.up) < 1e-5);
    }
}

fn bytes_of(data: &LitData) -> Vec<u8> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("lit.glb");
    write_lit(&path, &data.model()).unwrap();
    fs::read(path).unwrap()
}

#[test]
fn lit_models_go_there_and_back() {
    for bands in [3, 1, 0, 5] {
        let data = sample(bands);
        let bytes = bytes_of(&data);
        if let Ok(folder) = std::env::var("LIT_SAMPLES") {
            fs::write(Path::new(&folder).join(format!("lit_{bands}.glb")), &bytes).unwrap();
        }
        let read = decode(&bytes).unwrap().unwrap();
        assert_same(&data, &read);
        assert_same(&read, &decode(&bytes_of(&read)).unwrap().unwrap());
    }
}

#[test]
fn nothing_lit_is_a_model_too() {
    let empty = LitData { exposure: 1.0, ..LitData::default() };
    let bytes = bytes_of(&empty);
    assert_same(&empty, &decode(&bytes).unwrap().unwrap());
}

#[test]
fn files_of_before_lights_were_kept_do_not_say() {
    let unknown = LitData { lights: None, ..sample(3) };
    assert!(decode(&bytes_of(&unknown)).unwrap().unwrap().lights.is_none());
    let none = LitData { lights: Some(vec![]), ..sample(3) };
    assert_eq!(decode(&bytes_of(&none)).unwrap().unwrap().lights.map(|lights| lights.len()), Some(0));
}

#[test]
fn colours_are_fit_for_the_screen() {
    let data = sample(3);
    let glb = gltf::binary::Glb::from_slice(&bytes_of(&data)).map(|glb| glb.json.into_owned()).unwrap();
    let text = String::from_utf8(glb).unwrap();
    assert!(text.contains("KHR_materials_unlit") && text.contains("COLOR_0") && text.contains("\"doubleSided\":true"));
    let exposure = LitModel::automatic_exposure(&data.patches, &data.radiosity, 3);
    assert!(exposure > 0.0 && exposure.is_finite());
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_keeps_the_number_of_its_error() {
    let error = write_lit(Path::new("/dev/full"), &sample(3).model()).unwrap_err();
    assert_eq!(error.source.raw_os_error(), Some(28));
}

#[test]
fn lit_models_read_as_scenes_are_diffuse_and_known_for_what_they_are() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("lit.glb");
    write_lit(&path, &sample(3).model()).unwrap();
    let scene = radiosity_scene::load(&path, &radiosity_scene::LoadOptions::default()).unwrap();
    assert!(scene.findings.iter().all(|finding| finding.code != "metallic-material"), "{:?}", scene.findings);
    assert_eq!(scene.validate().unwrap_err().message, scene.findings[0].message);
    assert_eq!(scene.findings[0].code, "lit-model");
}

#[test]
fn models_that_do_not_fit_together_are_refused() {
    type Spoil = fn(&mut LitData);
    let spoils: [(Spoil, &str); 13] = [
        (|d| d.error.truncate(4), "error has 4 values"),
        (|d| d.radiosity[7] = f64::NAN, "radiosity of patch 2 is not finite"),
        (|d| d.irradiance[0] = 1e39, "irradiance of patch 0"),
        (|d| d.surfaces.truncate(2), "surface 2, but there are 2"),
        (|d| d.surfaces[1].reflectance.clear(), "0 reflectances for 3 bands"),
        (|d| d.report_json = "not json".into(), "report is no JSON"),
        (|d| d.cameras[1].vertical_fov = 4.0, "camera 'other'"),
        (|d| d.cameras[1].vertical_fov = std::f64::consts::PI - 1e-12, "camera 'other'"),
        (|d| d.cameras[1].aspect = Some(1e300), "camera 'other'"),
        (|d| d.patches.polygons[5][1].x = f64::INFINITY, "not finite"),
        (|d| d.patches.obstructions[0][1].y = f64::NAN, "obstruction 0 has a corner"),
        (|d| d.lights = Some(lights(2)), "light 'bulb' has 2 strengths for 3 bands"),
        (
            |d| {
                d.lights = Some(vec![Light::Directional {
                    name: "sun".into(),
                    direction: DVec3::X,
                    irradiance: vec![-1.0; 3],
                }])
            },
            "light 'sun'",
        ),
    ];
    let folder = tempfile::tempdir().unwrap();
    for (spoil, message) in spoils {
        let mut data = sample(3);
        spoil(&mut data);
        let error = write_lit(&folder.path().join("lit.glb"), &data.model()).unwrap_err().to_string();
        assert!(error.contains(message), "{error}");
    }
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
}

#[test]
fn other_gltf_is_none_and_other_files_are_errors() {
    let plain = br#"{"asset": {"version": "2.0"}, "extras": 5}"#;
    assert!(decode(plain).unwrap().is_none());
    assert!(decode(br#"{"asset": {"version": "2.0"}, "meshes": []}"#).unwrap().is_none());
    for garbage in [&b""[..], b"glTF", b"glTF\x02\0\0\0\x04\0\0\0", b"{}", b"[1]", b"PNG"] {
        assert!(decode(garbage).is_err(), "{garbage:?}");
    }
    let half = br#"{"asset": {"version": "2.0"}, "extras": {"radiosity": {"version": 1}}}"#;
    assert!(decode(half).is_err());
    let error = read_lit(Path::new("/nowhere/a.glb")).unwrap_err().to_string();
    assert!(error.contains("/nowhere/a.glb"), "{error}");
}

#[test]
fn absurd_numbers_in_the_file_are_errors() {
    let bytes = bytes_of(&sample(3));
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    for (from, to) in [
        ("\"count\":80", "\"count\":99"),
        ("\"count\":80", "\"count\":79"),
        ("\"byteOffset\":3840", "\"byteOffset\":3844"),
        ("\"surface\":2", "\"surface\":7"),
        ("\"patches\":26", "\"patches\":27"),
        ("\"version\":1", "\"version\":9"),
        ("VEC2", "VEC3"),
        ("_PATCH", "_PLUCK"),
    ] {
        assert!(text(&bytes).contains(from), "{from}");
        let at = (0..bytes.len()).find(|&i| bytes[i..].starts_with(from.as_bytes())).unwrap();
        let mut spoiled = bytes.clone();
        spoiled[at..at + to.len()].copy_from_slice(to.as_bytes());
        assert!(decode(&spoiled).is_err(), "{from} to {to}");
    }
}

proptest! {
    #[test]
    fn damaged_files_do_not_panic(cut in 0usize..4000, at in prop::collection::vec((0usize..20_000, any::<u8>()), 0..4)) {
        let mut bytes = bytes_of(&sample(2));
        for (i, byte) in at {
            let n = bytes.len();
            bytes[i % n] = byte;
        }
        let _ = decode(&bytes);
        bytes.truncate(cut);
        prop_assert!(decode(&bytes).is_err());
        // With a length that fits, the chunks are looked at.
        if bytes.len() >= 12 {
            bytes[8..12].copy_from_slice(&(cut as u32).to_le_bytes());
            prop_assert!(decode(&bytes).is_err());
        }
    }
}
