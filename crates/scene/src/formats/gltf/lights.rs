//! Lights without area, and cameras. Both look along -z of their node.

use std::f64::consts::{FRAC_PI_2, PI};

use ::gltf::json::extensions::scene::khr_lights_punctual::{self as punctual, Type};
use ::gltf::json::validation::Checked;
use ::gltf::json::{self, Index, camera};
use glam::{DAffine3, DVec3};

use super::buffers::Document;
use super::hierarchy::Placement;
use crate::formats::colour::is_power;
use crate::formats::names::Roll;
use crate::model::{Camera, Light, SceneError};

/// The light that a node carries. The scale of the node does not change how bright it is.
pub(super) fn light(
    document: &Document,
    index: Index<punctual::Light>,
    placement: &Placement,
    metres: f64,
    roll: &mut Roll,
) -> Result<Light, SceneError> {
    let name = placement.given_name();
    let fail = |message: &str| document.fail(format!("light of node '{}'", placement.name), message);
    let source = document.root.get(index).ok_or_else(|| fail("it does not exist; export the file again"))?;
    let name = name.or_else(|| source.name.clone()).unwrap_or_else(|| format!("light {}", index.value()));
    let power = source.color.map(|c| f64::from(c) * f64::from(source.intensity));
    if !is_power(power) {
        return Err(fail("its colour times intensity is negative or not finite; correct it"));
    }
    if source.range.is_some() {
        let message = "the range is ignored; light falls off with the square of the distance for ever";
        roll.note("light-range", "light", &name, message);
    }
    let position = metres * placement.world.translation;
    let (direction, intensity) = (sight(placement.world), power.to_vec());
    match source.type_ {
        Checked::Valid(Type::Point) => Ok(Light::Point { name, position, intensity }),
        Checked::Valid(Type::Directional) => {
            let direction = direction.ok_or_else(|| fail(FLATTENED))?;
            Ok(Light::Directional { name, direction, irradiance: intensity })
        }
        Checked::Valid(Type::Spot) => {
            let direction = direction.ok_or_else(|| fail(FLATTENED))?;
            let (inner_angle, outer_angle) = cone(source).map_err(|message| fail(&message))?;
            Ok(Light::Spot { name, position, direction, intensity, inner_angle, outer_angle })
        }
        Checked::Invalid => Err(fail("its type is none of point, spot and directional; correct it")),
    }
}

const FLATTENED: &str = "its node is scaled to nothing and has no direction; reset the scale";

fn cone(source: &punctual::Light) -> Result<(f64, f64), String> {
    let spot = source.spot.as_ref().ok_or("it is a spot without a cone; export the file again")?;
    let (inner, outer) = (f64::from(spot.inner_cone_angle), f64::from(spot.outer_cone_angle));
    // Single precision rounds pi/2 up.
    let outer = if outer > FRAC_PI_2 && outer < FRAC_PI_2 + 1e-6 { FRAC_PI_2 } else { outer };
    if 0.0 <= inner && inner <= outer && 0.0 < outer && outer <= FRAC_PI_2 {
        Ok((inner, outer))
    } else {
        Err(format!("its cone from {inner} to {outer} must have 0 <= inner <= outer <= pi/2; correct it"))
    }
}

/// The direction of -z.
fn sight(world: DAffine3) -> Option<DVec3> {
    world.transform_vector3(DVec3::NEG_Z).try_normalize()
}

/// The camera that a node carries, if it is a perspective one.
pub(super) fn camera(
    document: &Document,
    index: Index<json::Camera>,
    placement: &Placement,
    metres: f64,
    roll: &mut Roll,
) -> Result<Option<Camera>, SceneError> {
    let Some(source) = document.root.get(index) else {
        let element = format!("camera of node '{}'", placement.name);
        return Err(document.fail(element, "it does not exist; export the file again"));
    };
    let name = placement.given_name().or_else(|| source.name.clone());
    let name = name.unwrap_or_else(|| format!("camera {}", index.value()));
    let perspective = source.perspective.as_ref().filter(|_| source.type_ == Checked::Valid(camera::Type::Perspective));
    let Some(perspective) = perspective else {
        let message = "only perspective cameras are read; it was left out";
        roll.warn("camera-left-out", "camera", &name, message);
        return Ok(None);
    };
    let vertical_fov = f64::from(perspective.yfov);
    let forward = sight(placement.world);
    let up = forward.and_then(|forward| upright(placement.world, forward));
    let (Some(forward), Some(up), true) = (forward, up, 0.0 < vertical_fov && vertical_fov < PI) else {
        let message = "the angle of view or the transform is unusable; the camera was left out";
        roll.warn("camera-unusable", "camera", &name, message);
        return Ok(None);
    };
    let aspect = perspective.aspect_ratio.map(f64::from).filter(|aspect| aspect.is_finite() && *aspect > 0.0);
    let position = metres * placement.world.translation;
    Ok(Some(Camera { name, position, forward, up, vertical_fov, aspect }))
}

/// The direction of +y made perpendicular to the line of sight, which a skewed node may bend.
fn upright(world: DAffine3, forward: DVec3) -> Option<DVec3> {
    let up = world.transform_vector3(DVec3::Y);
    (up - up.dot(forward) * forward).try_normalize()
}
