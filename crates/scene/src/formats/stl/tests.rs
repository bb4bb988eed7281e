use glam::DVec3;
use proptest::prelude::*;

use super::*;
use crate::formats::Unit;

const TRIANGLES: &str = "solid lower  plate
 facet normal 0 0 1
  outer loop
   vertex 0 0 0
   vertex 1 0 0
   vertex 1 1 0
  endloop
 endfacet
 FACET NORMAL 0 0 0
  OUTER LOOP
   VERTEX 0 0 0
   VERTEX 1 1 0
   VERTEX 0 1e0 -0
  ENDLOOP
 ENDFACET
endsolid lower  plate
solid
 facet normal 0 0 1
  outer loop
   vertex 0 0 2
   vertex 0 1 2
   vertex 1 0 2
  endloop
 endfacet
endsolid
";

fn try_parse(bytes: &[u8]) -> Result<Scene, SceneError> {
    parse(Path::new("nowhere/plates.stl"), bytes, &LoadOptions::default())
}

fn refusal(bytes: &[u8]) -> String {
    try_parse(bytes).unwrap_err().to_string()
}

fn codes(scene: &Scene) -> Vec<&str> {
    scene.findings.iter().map(|finding| finding.code).collect()
}

/// A binary file with a header, its triangles and their number.
fn binary(header: &str, triangles: &[[[f32; 3]; 4]]) -> Vec<u8> {
    let mut bytes = header.as_bytes().to_vec();
    bytes.resize(80, b' ');
    bytes.extend((triangles.len() as u32).to_le_bytes());
    for triangle in triangles {
        bytes.extend(triangle.iter().flatten().flat_map(|x| x.to_le_bytes()));
        bytes.extend([0, 0]);
    }
    bytes
}

const ONE: [[f32; 3]; 4] = [[0., 0., 1.], [0., 0., 0.], [1., 0., 0.], [1., 1., 0.]];
const TWO: [[f32; 3]; 4] = [[0., 0., 1.], [0., 0., 0.], [1., 1., 0.], [0., 1., -0.]];

#[test]
fn solids_become_one_sided_surfaces_with_shared_vertices() {
    let scene = try_parse(TRIANGLES.as_bytes()).unwrap();
    let [lower, upper] = &scene.surfaces[..] else { panic!("{:?}", scene.surfaces) };
    assert_eq!((lower.name.as_str(), upper.name.as_str()), ("lower plate", "plates"));
    assert_eq!((lower.vertices.len(), &lower.faces[..]), (4, &[[0, 1, 2, 2], [0, 2, 3, 3]][..]));
    assert!(!lower.material.two_sided);
    assert_eq!(lower.material.reflectance, [0.5; 3]);
    // The order of corners turns the upper one downward, whatever its normal says.
    assert_eq!(codes(&scene), ["no-material", "contradicting-normals"]);
    assert_eq!(scene.findings[1].element, "surface 'plates'");
    assert!(scene.validate_geometry().is_ok());
}

#[test]
fn binary_files_may_begin_like_text() {
    for header in ["solid or not", "made by hand", ""] {
        let scene = try_parse(&binary(header, &[ONE, TWO])).unwrap();
        let [surface] = &scene.surfaces[..] else { panic!("{:?}", scene.surfaces) };
        assert_eq!((surface.name.as_str(), surface.vertices.len(), surface.faces.len()), ("plates", 4, 2));
        assert_eq!(codes(&scene), ["no-material"]);
    }
}

#[test]
fn units_and_sides_follow_the_options() {
    let options = LoadOptions { unit: Unit::Millimetre, two_sided: Some(true), ..LoadOptions::default() };
    let scene = parse(Path::new("a.stl"), &binary("", &[ONE]), &options).unwrap();
    assert_eq!(scene.surfaces[0].vertices[1], DVec3::new(0.001, 0.0, 0.0));
    assert!(scene.surfaces[0].material.two_sided);

    let few = LoadOptions { max_faces: 1, ..LoadOptions::default() };
    let error = parse(Path::new("a.stl"), &binary("", &[ONE, TWO]), &few).unwrap_err().to_string();
    assert!(error.contains("more than 1 faces"), "{error}");
}

#[test]
fn headers_that_lie_are_refused() {
    let mut bytes = binary("", &[ONE, TWO]);
    bytes[80..84].copy_from_slice(&u32::MAX.to_le_bytes());
    assert!(refusal(&bytes).contains("ends after 2 of 4294967295 triangles"));
    assert!(refusal(&binary("", &[ONE, TWO])[..150]).contains("ends after 1 of 2 triangles"));
    assert!(refusal(&binary("", &[])).contains("no triangles with an area"));
    assert!(refusal(b"hello").contains("neither text"));

    let mut bytes = binary("", &[ONE]);
    bytes.extend([1; 7]);
    assert_eq!(codes(&try_parse(&bytes).unwrap()), ["no-material", "trailing-bytes"]);
}

#[test]
fn coordinates_are_finite() {
    for bad in [f32::NAN, f32::INFINITY] {
        let mut broken = TWO;
        broken[2][1] = bad;
        assert!(refusal(&binary("", &[ONE, broken])).contains("triangle 1: it has a corner that is not finite"));
    }
    for bad in ["nan 0 0", "1 2", "1e999 0 0", "a b c"] {
        let text = TRIANGLES.replacen("1 0 0", bad, 1);
        assert!(refusal(text.as_bytes()).contains(&format!("line 5: '{bad}' are not three finite")), "{bad}");
    }
}

#[test]
fn bad_statements_name_their_line() {
    let cases = [
        ("endloop", "", "line 10: a loop begins before the last one ends"),
        ("vertex 1 1 0", "", "line 7: the facet has 2 corners"),
        ("vertex 1 1 0", "vortex 1 1 0", "line 6: 'vortex' is no keyword"),
        ("\nsolid\n", "\n", "line 22: a facet lies outside of any solid"),
        ("endloop", "solid", "line 7: a solid begins within a facet"),
    ];
    for (from, to, expected) in cases {
        let message = refusal(TRIANGLES.replacen(from, to, 1).as_bytes());
        assert!(message.starts_with(&format!("nowhere/plates.stl: {expected}")), "{message}");
    }
    let cut = &TRIANGLES[..TRIANGLES.len() - "endsolid\n".len()];
    assert!(codes(&try_parse(cut.as_bytes()).unwrap()).contains(&"no-endsolid"));
    assert!(refusal(&TRIANGLES.as_bytes()[..100]).contains("ends within a facet"));
}

proptest! {
    #[test]
    fn no_damage_panics(cut in 0_usize..600, place in 0_usize..600, byte: u8, is_text: bool) {
        let mut bytes = if is_text { TRIANGLES.into() } else { binary("solid", &[ONE, TWO]) };
        bytes.truncate(cut);
        if let Some(damaged) = bytes.get_mut(place) {
            *damaged = byte;
        }
        let _ = try_parse(&bytes).map(|scene| scene.findings());
    }

    #[test]
    fn noise_does_not_panic(bytes in prop::collection::vec(any::<u8>(), 0..400)) {
        let _ = try_parse(&bytes).map(|scene| scene.findings());
    }
}
