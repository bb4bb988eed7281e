//! Binary STL: a header of 80 bytes, the number of triangles, 50 bytes each, little endian.

use glam::DVec3;

use super::{Content, Fault, Solid};
use crate::formats::mesh::is_coordinate;
use crate::model::Finding;

const HEADER: usize = 84;
const TRIANGLE: usize = 50;

/// The number of triangles that the header promises.
fn promised(bytes: &[u8]) -> Option<usize> {
    let count = bytes.get(80..HEADER)?;
    Some(u32::from_le_bytes([count[0], count[1], count[2], count[3]]) as usize)
}

/// Whether the file has the length that its header promises.
pub(super) fn has_exact_length(bytes: &[u8]) -> bool {
    promised(bytes).and_then(|count| count.checked_mul(TRIANGLE)?.checked_add(HEADER)) == Some(bytes.len())
}

/// Reads all triangles.
pub(super) fn read(bytes: &[u8]) -> Result<Content, Fault> {
    let Some(count) = promised(bytes) else {
        let message =
            "the file is neither text that begins with 'solid' nor long enough for binary STL; export it again";
        return Err(Fault { element: String::new(), message: message.into() });
    };
    let records = bytes[HEADER..].as_chunks::<TRIANGLE>().0;
    if records.len() < count {
        let message = format!("the file ends after {} of {count} triangles; it was cut short", records.len());
        return Err(Fault { element: String::new(), message });
    }
    let mut content = Content::default();
    if !has_exact_length(bytes) {
        let message = "more bytes follow the last triangle and were ignored; export the file again";
        content.findings.push(Finding::warning("trailing-bytes", "", message));
    }
    let mut solid = Solid::default();
    for (index, record) in records[..count].iter().enumerate() {
        let [normal, corners @ ..] = vectors(record);
        if !corners.iter().all(|corner| corner.to_array().into_iter().all(is_coordinate)) {
            let message = "it has a corner that is not finite; repair the mesh".into();
            return Err(Fault { element: format!("triangle {index}"), message });
        }
        solid.push(&corners, normal);
    }
    content.solids.push(solid);
    Ok(content)
}

/// The normal and the three corners.
fn vectors(record: &[u8; TRIANGLE]) -> [DVec3; 4] {
    let mut numbers = record.as_chunks::<4>().0.iter().map(|&bytes| f64::from(f32::from_le_bytes(bytes)));
    let mut next = || numbers.next().unwrap_or_default();
    std::array::from_fn(|_| DVec3::new(next(), next(), next()))
}
