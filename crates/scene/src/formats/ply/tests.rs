use proptest::prelude::*;

use super::*;

const HEADER: &str = "comment made by hand
element vertex 5
property float x
property float y
property double z
property uchar red
element face 3
property uchar flags
property list uchar int vertex_indices
element edge 1
property list ushort short chain
end_header
";
const BODY: &str = "0 0 0 255\n1 0 0 9\n1 1 0 9\n0 1 0 9\n0.5 2 0 9\n0 4 0 1 2 3\n0 5 0 1 2 4 3\n1 3 3 2 4\n2 7 8\n";

fn text() -> Vec<u8> {
    format!("ply\nformat ascii 1.0\n{HEADER}{BODY}").into()
}

/// The same as bytes.
fn binary(is_big_endian: bool) -> Vec<u8> {
    let name = if is_big_endian { "big" } else { "little" };
    let mut bytes = format!("ply\r\nformat binary_{name}_endian 1.0\r\n{}", HEADER.replace('\n', "\r\n")).into_bytes();
    let mut put = |mut value: Vec<u8>| {
        if is_big_endian {
            value.reverse();
        }
        bytes.extend(value);
    };
    for (x, y) in [(0.0_f32, 0.0_f32), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0), (0.5, 2.0)] {
        [x, y].into_iter().for_each(|x| put(x.to_le_bytes().into()));
        put(0.0_f64.to_le_bytes().into());
        put(vec![9]);
    }
    for corners in [&[0, 1, 2, 3][..], &[0, 1, 2, 4, 3], &[3, 2, 4]] {
        put(vec![0]);
        put(vec![corners.len() as u8]);
        corners.iter().for_each(|&corner: &i32| put(corner.to_le_bytes().into()));
    }
    put(2_u16.to_le_bytes().into());
    [7_i16, 8].into_iter().for_each(|x| put(x.to_le_bytes().into()));
    bytes
}

fn try_parse(bytes: &[u8]) -> Result<Scene, SceneError> {
    parse(Path::new("nowhere/house.ply"), bytes, &LoadOptions::default())
}

fn refusal(bytes: &[u8]) -> String {
    try_parse(bytes).unwrap_err().to_string()
}

fn replaced(from: &str, to: &str) -> Vec<u8> {
    String::from_utf8(text()).unwrap().replacen(from, to, 1).into()
}

#[test]
fn all_encodings_agree() {
    let scene = try_parse(&text()).unwrap();
    let [house] = &scene.surfaces[..] else { panic!("{:?}", scene.surfaces) };
    assert_eq!((house.name.as_str(), house.vertices.len()), ("house", 5));
    assert_eq!((house.faces[0], house.faces[house.faces.len() - 1]), ([0, 1, 2, 3], [3, 2, 4, 4]));
    assert!(!house.material.two_sided);
    assert_eq!(house.material.reflectance, [0.5; 3]);
    for is_big_endian in [false, true] {
        let same = try_parse(&binary(is_big_endian)).unwrap();
        assert_eq!((&same.surfaces[0].vertices, &same.surfaces[0].faces), (&house.vertices, &house.faces));
    }
}

#[test]
fn polygons_are_cut_and_slender_ones_left_out() {
    let scene = try_parse(&replaced("1 3 3 2 4", "1 2 3 2")).unwrap();
    let codes: Vec<_> = scene.findings.iter().map(|finding| finding.code).collect();
    assert_eq!(codes, ["no-material", "slender-faces"]);
    assert_eq!(scene.findings[1].element, "face 2");
}

#[test]
fn headers_that_lie_are_refused() {
    let cases = [
        ("element vertex 5", "element vertex 18446744073709551615", ": the file ends within element"),
        ("element face 3", "element face 999999999999", "face 3: the file ends within element 3 of 999999999999"),
        ("element edge 1", "element edge 2", "edge 1: the file ends within"),
        ("element edge 1", "element edge -1", "line 12: '-1' is no number of elements"),
        ("format ascii 1.0", "format ebcdic 1.0", "line 2: there is no format 'ebcdic'"),
        ("format ascii 1.0\n", "", "header: it has no line 'format'"),
        ("end_header\n", "", "line 14: '0 0 0 255' is no statement"),
        ("property float x", "property quad x", "line 5: there is no type 'quad'"),
        ("property float x", "property float u", "vertex: vertices need the properties x, y and z"),
        ("vertex_indices", "corners", "face: faces need a property list"),
        ("list uchar int", "list", "line 11: there is no type 'list'"),
        ("element vertex 5\n", "", "line 4: a property comes before any element"),
    ];
    for (from, to, expected) in cases {
        let message = refusal(&replaced(from, to));
        assert!(message.contains(expected), "{message}");
    }
    let empty = "ply\nformat ascii 1.0\nelement nothing 18446744073709551615\nend_header\n";
    assert!(refusal(empty.as_bytes()).contains("no faces with an area"));
}

#[test]
fn values_that_make_no_sense_are_refused() {
    let cases = [
        ("1 1 0 9", "1 nan 0 9", "vertex 2: its coordinates are not three finite numbers"),
        ("1 1 0 9", "1 inf 0 9", "vertex 2: its coordinates"),
        ("1 1 0 9", "1 1e300 0 9", "vertex 2: its coordinates"),
        ("1 1 0 9", "1 one 0 9", "vertex 2: 'one' is no number"),
        ("0 4 0 1 2 3", "0 4 0 1 2 5", "face 0: it refers to a vertex beyond the 5"),
        ("0 4 0 1 2 3", "0 4 0 1 2 -3", "face 0: -3 is no index"),
        ("0 4 0 1 2 3", "0 4.5 0 1 2 3", "face 0: 4.5 is no index or length"),
        ("0 4 0 1 2 3", "0 nan 0 1 2 3", "face 0: NaN is no index or length"),
        ("0 4 0 1 2 3", "0 4000000000 0 1 2 3", "face 0: the file ends within"),
    ];
    for (from, to, expected) in cases {
        let message = refusal(&replaced(from, to));
        assert!(message.starts_with(&format!("nowhere/house.ply: {expected}")), "{message}");
    }
}

#[test]
fn truncated_files_are_refused() {
    for bytes in [text(), binary(false), binary(true)] {
        for length in 4..bytes.len() - 2 {
            let message = refusal(&bytes[..length]);
            assert!(message.contains("cut short") || message.contains("no statement"), "{length}: {message}");
        }
    }
}

proptest! {
    #[test]
    fn no_damage_panics(cut in 0_usize..600, place in 0_usize..600, byte: u8, encoding in 0..3) {
        let mut bytes = match encoding { 0 => text(), 1 => binary(false), _ => binary(true) };
        bytes.truncate(cut);
        if let Some(damaged) = bytes.get_mut(place) {
            *damaged = byte;
        }
        let _ = try_parse(&bytes).map(|scene| scene.findings());
    }

    #[test]
    fn noise_does_not_panic(mut bytes in prop::collection::vec(any::<u8>(), 0..400), has_header: bool) {
        if has_header {
            bytes.splice(0..0, format!("ply\nformat binary_big_endian 1.0\n{HEADER}").into_bytes());
        }
        let _ = try_parse(&bytes).map(|scene| scene.findings());
    }
}
