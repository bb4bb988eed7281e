//! The textures of a scene, to be read at points and averaged over patches.

use std::sync::Arc;

use radiosity_geometry::texture::{TexturedFaces, unwrapped};

use crate::model::{Scene, SceneError, Surface, Texture};

impl Scene {
    /// Of each surface, if it has a texture, the diffuse reflectance at every point of its faces.
    ///
    /// # Errors
    /// If the shapes are unsound, or a texture does not fit its surface or the bands.
    pub fn textured_faces(&self) -> Result<Vec<Option<Arc<TexturedFaces>>>, SceneError> {
        if self.surfaces.iter().all(|surface| surface.texture.is_none()) {
            return Ok(vec![None; self.surfaces.len()]);
        }
        self.validate_geometry()?;
        self.validate_textures()?;
        Ok(self.surfaces.iter().map(|surface| of_surface(surface).map(Arc::new)).collect())
    }
}

fn of_surface(surface: &Surface) -> Option<TexturedFaces> {
    let Texture { image, coordinates } = surface.texture.as_ref()?;
    let faces = unwrapped(&surface.vertices, &surface.faces, coordinates);
    Some(TexturedFaces::new(Arc::clone(image), faces, &surface.material.reflectance))
}
