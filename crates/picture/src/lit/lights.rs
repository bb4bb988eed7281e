//! Lights without area as they stand in lit models.

use glam::DVec3;
use radiosity_scene::Light;
use serde::{Deserialize, Serialize};

/// A light in `extras.radiosity.lights`: metres, unit vectors, radians; W/sr or, of parallel light, W/m2.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "lowercase")]
pub(super) enum FileLight {
    Point {
        name: String,
        position: [f64; 3],
        intensity: Vec<f64>,
    },
    Spot {
        name: String,
        position: [f64; 3],
        direction: [f64; 3],
        intensity: Vec<f64>,
        inner_angle: f64,
        outer_angle: f64,
    },
    Directional {
        name: String,
        direction: [f64; 3],
        irradiance: Vec<f64>,
    },
}

impl From<&Light> for FileLight {
    fn from(light: &Light) -> Self {
        match light.clone() {
            Light::Point { name, position, intensity } => {
                Self::Point { name, position: position.to_array(), intensity }
            }
            Light::Spot { name, position, direction, intensity, inner_angle, outer_angle } => {
                let (position, direction) = (position.to_array(), direction.to_array());
                Self::Spot { name, position, direction, intensity, inner_angle, outer_angle }
            }
            Light::Directional { name, direction, irradiance } => {
                Self::Directional { name, direction: direction.to_array(), irradiance }
            }
        }
    }
}

impl From<FileLight> for Light {
    fn from(light: FileLight) -> Self {
        match light {
            FileLight::Point { name, position, intensity } => {
                Self::Point { name, position: DVec3::from_array(position), intensity }
            }
            FileLight::Spot { name, position, direction, intensity, inner_angle, outer_angle } => {
                let (position, direction) = (DVec3::from_array(position), DVec3::from_array(direction));
                Self::Spot { name, position, direction, intensity, inner_angle, outer_angle }
            }
            FileLight::Directional { name, direction, irradiance } => {
                Self::Directional { name, direction: DVec3::from_array(direction), irradiance }
            }
        }
    }
}

/// Says what is wrong with a light.
pub(super) fn check(light: &Light, bands: usize) -> Result<(), String> {
    let (name, power) = (light.name(), light.power());
    if power.len() != bands {
        return Err(format!("light '{name}' has {} strengths for {bands} bands", power.len()));
    }
    let vectors = match light {
        Light::Point { position, .. } => [*position, DVec3::ZERO],
        Light::Spot { position, direction, .. } => [*position, *direction],
        Light::Directional { direction, .. } => [DVec3::ZERO, *direction],
    };
    let angles = match light {
        Light::Spot { inner_angle, outer_angle, .. } => [*inner_angle, *outer_angle],
        _ => [0.0; 2],
    };
    let is_sound = power.iter().all(|p| p.is_finite() && *p >= 0.0)
        && vectors.iter().all(|v| v.is_finite())
        && angles.iter().all(|a| a.is_finite());
    if is_sound {
        Ok(())
    } else {
        Err(format!("light '{name}' has a number that is not finite or a negative strength"))
    }
}
