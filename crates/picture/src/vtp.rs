//! VTK PolyData files (.vtp) for ParaView and its kind.
//!
//! XML with raw appended data, as the chapter on file formats of the VTK User's Guide describes it. Cells are patches
//! in order of their ids; corners at the same place are one point. Cell data: `irradiance`, `radiosity`, `emission`
//! and `error` (float64, one component per band), `surface`, `face` and `patch` (integers). Field data:
//! `surface_names`, `material_names`, `bands` and `report` (strings).

use std::collections::HashMap;
use std::io::{self, Write};
use std::path::Path;

use glam::DVec3;

use crate::LitModel;
use radiosity_store::files::{FileError, atomic_write};

/// Writes a solution as VTK PolyData.
///
/// # Errors
/// If the parts of the model do not fit together or the file cannot be written; then nothing is left behind.
pub fn write_vtp(path: &Path, model: &LitModel) -> Result<(), FileError> {
    model.check().map_err(|message| FileError::invalid(path, message))?;
    atomic_write(path, |out| encode(model, out))
}

/// The arrays of the file: what is appended, in order.
#[derive(Default)]
struct Appended {
    arrays: Vec<Vec<u8>>,
    offset: usize,
}

impl Appended {
    /// Keeps an array for the end of the file and returns the element that refers to it.
    fn add<const N: usize>(
        &mut self,
        kind: &str,
        name: &str,
        components: &str,
        values: impl Iterator<Item = [u8; N]>,
    ) -> String {
        let bytes: Vec<u8> = values.flatten().collect();
        let element = format!(
            "<DataArray type=\"{kind}\" Name=\"{name}\"{components} format=\"appended\" offset=\"{}\"/>\n",
            self.offset
        );
        // Each array is preceded by its length.
        self.offset += size_of::<u64>() + bytes.len();
        self.arrays.push(bytes);
        element
    }

    fn write(&self, out: &mut impl Write) -> io::Result<()> {
        for array in &self.arrays {
            out.write_all(&(array.len() as u64).to_le_bytes())?;
            out.write_all(array)?;
        }
        Ok(())
    }
}

fn encode(model: &LitModel, out: &mut impl Write) -> io::Result<()> {
    let mut appended = Appended::default();
    let (points, connectivity, offsets) = topology(model);
    let n_points = points.len();
    let coordinates = points.iter().flat_map(|p| p.to_array()).map(f64::to_le_bytes);
    let points = appended.add("Float64", "points", " NumberOfComponents=\"3\"", coordinates);
    let polygons = appended.add("Int64", "connectivity", "", connectivity.iter().map(|i| i.to_le_bytes()))
        + &appended.add("Int64", "offsets", "", offsets.iter().map(|i| i.to_le_bytes()));
    let cells = cell_data(model, &mut appended);
    writeln!(out, "<?xml version=\"1.0\"?>")?;
    writeln!(out, "<VTKFile type=\"PolyData\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\">")?;
    write!(out, "<PolyData>\n<FieldData>\n{}</FieldData>\n", field_data(model))?;
    writeln!(out, "<Piece NumberOfPoints=\"{n_points}\" NumberOfPolys=\"{}\">", model.patches.len())?;
    write!(out, "<Points>\n{points}</Points>\n<Polys>\n{polygons}</Polys>\n<CellData>\n{cells}</CellData>\n")?;
    write!(out, "</Piece>\n</PolyData>\n<AppendedData encoding=\"raw\">\n_")?;
    appended.write(out)?;
    write!(out, "\n</AppendedData>\n</VTKFile>\n")
}

/// Points, the points of each polygon, and where each polygon ends among those.
fn topology(model: &LitModel) -> (Vec<DVec3>, Vec<i64>, Vec<i64>) {
    let (mut points, mut connectivity, mut offsets) = (Vec::new(), Vec::new(), Vec::new());
    let mut ids = HashMap::new();
    for patch in 0..model.patches.len() {
        for &corner in model.patches.corners(patch) {
            let id = *ids.entry(corner.to_array().map(f64::to_bits)).or_insert_with(|| {
                points.push(corner);
                points.len() as i64 - 1
            });
            connectivity.push(id);
        }
        offsets.push(connectivity.len() as i64);
    }
    (points, connectivity, offsets)
}

fn cell_data(model: &LitModel, appended: &mut Appended) -> String {
    let patches = model.patches;
    let mut elements = String::new();
    if !model.bands.is_empty() {
        let mut components = format!(" NumberOfComponents=\"{}\"", model.bands.len());
        for (k, band) in model.bands.iter().enumerate() {
            components += &format!(" ComponentName{k}=\"{}\"", escaped(band));
        }
        let quantities = [
            ("irradiance", model.irradiance),
            ("radiosity", model.radiosity),
            ("emission", model.emission),
            ("error", model.error),
        ];
        for (name, values) in quantities {
            elements += &appended.add("Float64", name, &components, values.iter().map(|v| v.to_le_bytes()));
        }
    }
    elements += &appended.add("UInt32", "surface", "", patches.surface.iter().map(|s| s.to_le_bytes()));
    elements += &appended.add("UInt32", "face", "", patches.face.iter().map(|f| f.to_le_bytes()));
    elements + &appended.add("Int64", "patch", "", (0..patches.len() as i64).map(|i| i.to_le_bytes()))
}

fn field_data(model: &LitModel) -> String {
    let of_surfaces = |name: fn(&crate::LitSurface) -> &str| model.surfaces.iter().map(name).collect::<Vec<_>>();
    strings("surface_names", &of_surfaces(|s| &s.name))
        + &strings("material_names", &of_surfaces(|s| &s.material))
        + &strings("bands", &model.bands.iter().map(String::as_str).collect::<Vec<_>>())
        + &strings("report", &[model.report_json])
}

/// An array of strings: their bytes as numbers, each string ended by a zero.
fn strings(name: &str, values: &[&str]) -> String {
    let bytes = values.iter().flat_map(|value| value.bytes().filter(|&b| b != 0).chain([0]));
    let numbers: Vec<String> = bytes.map(|b| b.to_string()).collect();
    let numbers = numbers.join(" ");
    let n = values.len();
    format!(
        "<DataArray type=\"String\" Name=\"{name}\" NumberOfTuples=\"{n}\" format=\"ascii\">{numbers}</DataArray>\n"
    )
}

/// Text for an XML attribute; control characters, which XML cannot hold, become blanks.
fn escaped(text: &str) -> String {
    let mut out = String::new();
    for c in text.chars() {
        match c {
            '&' => out += "&amp;",
            '<' => out += "&lt;",
            '>' => out += "&gt;",
            '"' => out += "&quot;",
            c if c.is_control() => out.push(' '),
            c => out.push(c),
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;
    use crate::test_scenes::cube;
    use crate::{LitData, LitSurface};

    fn sample() -> LitData {
        let patches = cube(2);
        let n = patches.len();
        let surface = LitSurface {
            name: "wände <1>".into(),
            material: "paint".into(),
            reflectance: vec![0.5, 0.25],
            ..LitSurface::default()
        };
        LitData {
            patches,
            surfaces: vec![surface],
            bands: vec!["a<b".into(), "\"c\"".into()],
            emission: vec![0.0; 2 * n],
            irradiance: (0..2 * n).map(|i| i as f64).collect(),
            radiosity: vec![1.5; 2 * n],
            error: vec![0.125; 2 * n],
            report_json: "{\"rays\": 7}".into(),
            exposure: 1.0,
            ..LitData::default()
        }
    }

    #[test]
    fn arrays_lie_where_the_header_says() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.vtp");
        let data = sample();
        write_vtp(&path, &data.model()).unwrap();
        let bytes = fs::read(&path).unwrap();
        if let Ok(folder) = std::env::var("LIT_SAMPLES") {
            fs::write(Path::new(&folder).join("lit.vtp"), &bytes).unwrap();
        }
        let text = String::from_utf8_lossy(&bytes);
        let start = bytes.windows(5).position(|w| w == b"raw\">").unwrap() + 7;
        let array = |name: &str| {
            let element = text.split("Name=\"").find(|part| part.starts_with(&format!("{name}\""))).unwrap();
            let offset = element.split("offset=\"").nth(1).unwrap().split('"').next().unwrap();
            let at = start + offset.parse::<usize>().unwrap();
            let length = u64::from_le_bytes(bytes[at..at + 8].try_into().unwrap()) as usize;
            &bytes[at + 8..at + 8 + length]
        };
        let floats = |name| array(name).as_chunks().0.iter().map(|b| f64::from_le_bytes(*b)).collect::<Vec<_>>();
        assert_eq!(floats("irradiance"), data.irradiance);
        assert_eq!(floats("error"), data.error);
        // A cube of 2 x 2 patches per side has 26 points on its surface.
        assert_eq!((floats("points").len(), array("connectivity").len()), (3 * 26, 24 * 4 * 8));
        assert!(text.contains("ComponentName0=\"a&lt;b\" ComponentName1=\"&quot;c&quot;\""));
    }

    #[test]
    fn models_that_do_not_fit_together_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let mut data = sample();
        data.emission.pop();
        assert!(write_vtp(&folder.path().join("a.vtp"), &data.model()).is_err());
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
    }
}
