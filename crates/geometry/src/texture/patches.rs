//! Patches and the textures on them.

use std::sync::Arc;

use glam::DVec3;
use rayon::prelude::*;

use super::faces::{TexturedFaces, Values};
use crate::Patches;

/// No texture.
const NONE: u32 = u32::MAX;

/// What textures say of patches, or of sides: whatever is numbered. Some have none.
#[derive(Clone, Debug, Default)]
pub struct TexturedPatches {
    textures: Vec<Arc<TexturedFaces>>,
    /// The texture of each, and the face on it.
    places: Vec<(u32, u32)>,
}

impl TexturedPatches {
    /// Finds the texture of each patch by its surface, and its place by its face; patches of surfaces beyond the given
    /// begin again with the first, as backs that are surfaces of their own do.
    pub fn new(patches: &Patches, of_surfaces: &[Option<Arc<TexturedFaces>>]) -> Self {
        let textures: Vec<_> = of_surfaces.iter().flatten().cloned().collect();
        let mut numbers = 0..;
        let number: Vec<u32> =
            of_surfaces.iter().map(|of| of.as_ref().map_or(NONE, |_| numbers.next().unwrap_or(NONE))).collect();
        let place = |(&surface, &face): (&u32, &u32)| {
            let texture = number.get(surface as usize % number.len().max(1)).copied().unwrap_or(NONE);
            match textures.get(texture as usize) {
                Some(faces) if (face as usize) < faces.len() => (texture, face),
                _ => (NONE, 0),
            }
        };
        let places = patches.surface.iter().zip(&patches.face).map(place).collect();
        Self { textures, places }
    }

    /// The same for others: the `k`-th of them is the `which[k]`-th of these.
    pub fn picked(&self, which: &[u32]) -> Self {
        Self { textures: self.textures.clone(), places: which.iter().map(|&i| self.places[i as usize]).collect() }
    }

    /// The same without those that are not kept.
    ///
    /// # Panics
    /// If there is not one mark for each.
    pub fn kept(mut self, keep: &[bool]) -> Self {
        assert_eq!(keep.len(), self.places.len(), "one mark for each");
        self.places.iter_mut().zip(keep).filter(|(_, keep)| !**keep).for_each(|(place, _)| *place = (NONE, 0));
        self
    }

    /// How many are numbered.
    pub fn len(&self) -> usize {
        self.places.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.places.is_empty()
    }

    /// Whether one has a texture.
    #[inline]
    pub fn has(&self, index: usize) -> bool {
        self.places[index].0 != NONE
    }

    /// Whether any has.
    pub fn any(&self) -> bool {
        self.places.iter().any(|place| place.0 != NONE)
    }

    /// The values at a point of one of them, if it has a texture.
    #[inline]
    pub fn at(&self, index: usize, point: DVec3) -> Option<Values<'_>> {
        let (texture, face) = self.places[index];
        self.textures.get(texture as usize).map(|faces| faces.at(face as usize, point))
    }

    /// Replaces values of patches, n x bands, by the means of the textures over those that have one.
    ///
    /// # Panics
    /// If values do not fit the patches, or these do not those it was made for.
    pub fn set_means(&self, patches: &Patches, values: &mut [f64], bands: usize) {
        assert_eq!((self.len(), values.len()), (patches.len(), bands * patches.len()), "values fit the patches");
        values.par_chunks_exact_mut(bands.max(1)).enumerate().filter(|(patch, _)| self.has(*patch)).for_each(
            |(patch, values)| {
                let (texture, face) = self.places[patch];
                self.textures[texture as usize].mean(face as usize, patches.corners(patch), values);
            },
        );
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::texture::{Raster, unwrapped};

    const SQUARE: [DVec3; 4] = [DVec3::ZERO, DVec3::X, DVec3::new(1.0, 1.0, 0.0), DVec3::Y];

    /// The left half of the image is 0, the right half 1, on a plain and a textured surface.
    fn textured(surface: Vec<u32>) -> (Patches, TexturedPatches) {
        let image = Raster::of_values([64, 1], 1, (0..64).map(|x| if x < 32 { 0.0 } else { 1.0 }).collect());
        let faces = unwrapped(&SQUARE, &[[0, 1, 2, 3]], &[[0., 0.], [1., 0.], [1., 1.], [0., 1.]]);
        let of = [None, Some(Arc::new(TexturedFaces::new(Arc::new(image), faces, &[0.5])))];
        let n = surface.len();
        let patches = Patches::new(vec![SQUARE; n], surface, vec![0; n], vec![false; n]);
        let textured = TexturedPatches::new(&patches, &of);
        (patches, textured)
    }

    #[test]
    fn means_and_values_are_of_those_with_a_texture() {
        let (patches, textured) = textured(vec![0, 1, 3]);
        let mut means = [0.1; 3];
        textured.set_means(&patches, &mut means, 1);
        assert!(means[0] == 0.1 && (means[1] - 0.25).abs() < 1e-12 && means[1] == means[2], "{means:?}");
        assert!(textured.at(0, SQUARE[1]).is_none());
        assert_eq!(textured.at(1, DVec3::new(0.75, 0.5, 0.0)).unwrap().band(0), 0.5);
    }

    #[test]
    fn some_are_picked_and_some_kept() {
        let (_, textured) = textured(vec![0, 1, 1]);
        let picked = textured.picked(&[2, 0, 1, 1]);
        assert_eq!([0, 1, 2, 3].map(|i| picked.has(i)), [true, false, true, true]);
        let kept = picked.kept(&[false, true, true, false]);
        assert_eq!([0, 1, 2, 3].map(|i| kept.has(i)), [false, false, true, false]);
        assert!(kept.any() && !kept.kept(&[false; 4]).any());
    }

    #[test]
    fn faces_that_are_not_there_have_none() {
        let (mut patches, _) = textured(vec![1]);
        patches.face = vec![1];
        assert!(!TexturedPatches::new(&patches, &[]).has(0));
    }
}
