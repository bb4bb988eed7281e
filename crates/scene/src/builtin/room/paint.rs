//! What the room is painted with: diffuse reflectances and radiances in R, G, B.

use std::f64::consts::PI;

use crate::model::Material;

pub(super) fn plaster() -> Material {
    paint("plaster", [0.78, 0.75, 0.70])
}

pub(super) fn ceiling() -> Material {
    paint("ceiling", [0.84, 0.83, 0.80])
}

pub(super) fn sage() -> Material {
    paint("sage", [0.38, 0.46, 0.37])
}

pub(super) fn lacquer() -> Material {
    paint("lacquer", [0.76, 0.74, 0.70])
}

pub(super) fn oak() -> Material {
    paint("oak", [0.46, 0.31, 0.18])
}

pub(super) fn walnut() -> Material {
    paint("walnut", [0.30, 0.18, 0.10])
}

pub(super) fn terracotta() -> Material {
    paint("terracotta", [0.55, 0.24, 0.15])
}

pub(super) fn wool() -> Material {
    paint("wool", [0.68, 0.62, 0.52])
}

pub(super) fn denim() -> Material {
    paint("denim", [0.17, 0.25, 0.36])
}

pub(super) fn mustard() -> Material {
    paint("mustard", [0.64, 0.43, 0.10])
}

pub(super) fn brass() -> Material {
    paint("brass", [0.45, 0.34, 0.16])
}

pub(super) fn ceramic() -> Material {
    paint("ceramic", [0.72, 0.72, 0.70])
}

pub(super) fn soil() -> Material {
    paint("soil", [0.10, 0.07, 0.05])
}

pub(super) fn leaf() -> Material {
    paint("leaf", [0.10, 0.28, 0.08]).on_both_sides()
}

pub(super) fn linen() -> Material {
    paint("linen", [0.70, 0.67, 0.60]).on_both_sides()
}

pub(super) fn parchment() -> Material {
    paint("parchment", [0.74, 0.66, 0.50]).on_both_sides()
}

/// Cloth and paper of the books.
pub(super) fn books() -> [Material; 5] {
    [
        paint("book red", [0.48, 0.10, 0.08]),
        paint("book blue", [0.10, 0.18, 0.40]),
        paint("book green", [0.14, 0.32, 0.20]),
        paint("book cream", [0.70, 0.62, 0.45]),
        paint("book black", [0.06, 0.06, 0.07]),
    ]
}

/// An overcast sky behind glass.
pub(super) fn daylight() -> Material {
    glowing("daylight", [0.10; 3], [6.0, 7.0, 8.2])
}

/// A warm lamp behind opal glass.
pub(super) fn lamplight() -> Material {
    glowing("lamplight", [0.50; 3], [150.0, 105.0, 60.0])
}

fn paint(name: &str, reflectance: [f64; 3]) -> Material {
    Material::new(name, &reflectance, &[0.0; 3])
}

fn glowing(name: &str, reflectance: [f64; 3], radiance: [f64; 3]) -> Material {
    Material::new(name, &reflectance, &radiance.map(|l| PI * l))
}
