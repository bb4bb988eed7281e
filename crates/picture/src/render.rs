//! Pictures of patches from a viewpoint.

use std::f64::consts::FRAC_1_PI;

use glam::DVec3;
use radiosity_exchange::Enclosure;
use radiosity_geometry::Patches;
use radiosity_geometry::bvh::{Hit, Ray};
use radiosity_geometry::texture::TexturedPatches;
use radiosity_operator::{Cancelled, Control};
use radiosity_scene::Camera;
use rayon::prelude::*;

use crate::beyond::{Beyond, Shown};
use crate::view::{Facet, Frame, Visible};
use crate::{Image, Sheets};

/// What the patches show.
#[derive(Clone, Copy, Debug)]
pub enum Shading<'a> {
    /// Each patch its value: `n_patches x bands`.
    Patches(&'a [f64]),
    /// What its four corners have, interpolated: `n_patches x 4 x bands`, see [`Smoother`](crate::Smoother).
    Smooth(&'a [f64]),
    /// The same of radiosity, with textures on some patches.
    Textured(Textured<'a>),
}

/// Radiosity of which a part shows what textures reflect: E + rho(x) H(x) where there is one.
#[derive(Clone, Copy, Debug)]
pub struct Textured<'a> {
    /// Radiosity at corners: `n_patches x 4 x bands`.
    pub radiosity: &'a [f64],
    /// Irradiance at corners: `n_patches x 4 x bands`.
    pub irradiance: &'a [f64],
    /// Of patches: `n_patches x bands`.
    pub emission: &'a [f64],
    /// Of patches.
    pub textures: &'a TexturedPatches,
}

/// What patches reflect as plane mirrors do and let straight through, one part each of what meets every patch.
#[derive(Clone, Copy, Debug)]
pub struct Mirrors<'a> {
    /// Mirror reflectance.
    pub specular: &'a [f64],
    /// Clear transmittance.
    pub transmittance: &'a [f64],
}

/// How a picture is made.
#[derive(Clone, Debug, PartialEq)]
pub struct RenderSettings {
    /// Pixels per row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Rays per pixel.
    pub samples: usize,
    /// Whether the backs of one-sided patches let the view through, as into a room from outside; else they are black.
    pub culls_backs: bool,
    /// What multiplies the values: 1/pi shows radiosity as radiance, 1 shows any quantity as it is.
    pub scale: f64,
    /// What lies behind everything, per band and not scaled; black if empty.
    pub background: Vec<f32>,
}

impl Default for RenderSettings {
    fn default() -> Self {
        Self { width: 800, height: 600, samples: 16, culls_backs: true, scale: FRAC_1_PI, background: Vec::new() }
    }
}

/// Renders patches as a camera sees them; every row is a step of `control`.
///
/// The same input gives the same bytes on any number of threads.
///
/// # Errors
/// If `control` is cancelled.
///
/// # Panics
/// If the values do not fit the patches, or the background the bands.
pub fn render(
    patches: &Patches,
    shading: Shading,
    bands: usize,
    camera: &Camera,
    settings: &RenderSettings,
    control: &Control,
) -> Result<Image, Cancelled> {
    shading.check(patches, bands);
    let visible = Visible::new(patches, camera.position, settings.culls_backs, |_| false);
    let add = |_: &Ray, hit: &Hit, sum: &mut [f64]| {
        if hit.is_miss() {
            settings.add_background(1.0, sum);
        } else if let Some(facet) = visible.facet(hit) {
            let place = (facet.patch as usize, facet.point(patches, hit));
            shading.add(place, facet.corner_weights(hit), settings.scale, sum);
        }
    };
    View::new(&visible, bands, camera, settings, add).picture(control)
}

/// The same with mirrors and clear glass, in which a camera sees what there is to see; backs of two-sided patches may be
/// patches of their own, see [`Sheets`]. A ray goes on from at most 64 of them and while more than 1/4096 of it is
/// left; what remains is black.
///
/// # Errors
/// If `control` is cancelled.
///
/// # Panics
/// If the values do not fit the patches, or the background the bands.
pub fn render_with_mirrors(
    patches: &Patches,
    mirrors: Mirrors,
    shading: Shading,
    bands: usize,
    camera: &Camera,
    settings: &RenderSettings,
    control: &Control,
) -> Result<Image, Cancelled> {
    shading.check(patches, bands);
    let sheets = Sheets::new(patches);
    let of_sides = OfSides::new(&shading, &sheets, patches, bands);
    let of_sides = of_sides.shading();
    let (specular, transmittance) = (sheets.of_patches(mirrors.specular), sheets.of_patches(mirrors.transmittance));
    let enclosure = Enclosure::new(sheets.patches).with_specular(specular, transmittance);
    let Some(specular) = enclosure.specular() else {
        return render(patches, shading, bands, camera, settings, control);
    };
    let beyond = Beyond { enclosure: &enclosure, specular, culls_backs: settings.culls_backs };
    let is_glass = |patch: usize| specular.transmittance(patch) > 0.0;
    let visible = Visible::new(enclosure.patches(), camera.position, settings.culls_backs, is_glass);
    let add = |ray: &Ray, hit: &Hit, sum: &mut [f64]| {
        if hit.is_miss() {
            return settings.add_background(1.0, sum);
        }
        let Some(facet) = visible.facet(hit) else { return };
        let (patch, on) = (facet.patch as usize, facet.point(enclosure.patches(), hit));
        if let Some(side) = side_of(&enclosure, &facet) {
            of_sides.add((side, on), facet.corner_weights(hit), settings.scale, sum);
        }
        if beyond.is_of(patch) {
            beyond.all(patch, on, ray.direction, |weight, shown| match shown {
                Shown::Side { side, corners, point, .. } => {
                    of_sides.add((side, point), corners, weight * settings.scale, sum);
                }
                Shown::Nothing => settings.add_background(weight, sum),
            });
        }
    };
    View::new(&visible, bands, camera, settings, add).picture(control)
}

/// The side that a facet shows; none of the back of one-sided glass.
pub(crate) fn side_of(enclosure: &Enclosure, facet: &Facet) -> Option<usize> {
    let patch = facet.patch as usize;
    if facet.is_back { enclosure.back_of(patch) } else { Some(patch) }
}

/// Values of patches as those of sides.
struct OfSides {
    values: Vec<f64>,
    is_smooth: bool,
    /// Irradiance at corners, emission and textures.
    textured: Option<(Vec<f64>, Vec<f64>, TexturedPatches)>,
}

impl OfSides {
    fn new(shading: &Shading, sheets: &Sheets, patches: &Patches, bands: usize) -> Self {
        let double = |values: Vec<f32>| values.into_iter().map(f64::from).collect();
        let corners = |values| double(sheets.corners_of_sides(patches, values, bands));
        let plain = |values| double(sheets.of_sides(values, bands));
        match *shading {
            Shading::Patches(values) => Self { values: plain(values), is_smooth: false, textured: None },
            Shading::Smooth(values) => Self { values: corners(values), is_smooth: true, textured: None },
            Shading::Textured(Textured { radiosity, irradiance, emission, textures }) => {
                let textured = (corners(irradiance), plain(emission), textures.picked(&sheets.patch_of_side));
                Self { values: corners(radiosity), is_smooth: true, textured: Some(textured) }
            }
        }
    }

    fn shading(&self) -> Shading<'_> {
        match &self.textured {
            Some((irradiance, emission, textures)) => {
                Shading::Textured(Textured { radiosity: &self.values, irradiance, emission, textures })
            }
            None if self.is_smooth => Shading::Smooth(&self.values),
            None => Shading::Patches(&self.values),
        }
    }
}

impl Shading<'_> {
    fn check(&self, patches: &Patches, bands: usize) {
        let count = patches.len() * bands;
        match self {
            Self::Patches(values) => assert_eq!(values.len(), count, "values fit the patches"),
            Self::Smooth(values) => assert_eq!(values.len(), 4 * count, "values fit the patches"),
            Self::Textured(Textured { radiosity, irradiance, emission, textures }) => {
                let lengths = [radiosity.len(), irradiance.len(), 4 * emission.len()];
                assert_eq!(lengths, [4 * count; 3], "values fit the patches");
                assert_eq!(textures.len(), patches.len(), "textures fit the patches");
            }
        }
    }

    /// Adds `weight` times the value at a place: a point of the `index`-th patch or side of those that there are values of.
    fn add(&self, (index, point): (usize, DVec3), corner_weights: [f64; 4], weight: f64, sum: &mut [f64]) {
        let bands = sum.len();
        match self {
            Self::Patches(values) => {
                sum.iter_mut().zip(&values[index * bands..]).for_each(|(sum, v)| *sum += weight * v);
            }
            Self::Smooth(values) => add_smooth(&values[4 * index * bands..], corner_weights, weight, sum),
            Self::Textured(Textured { radiosity, irradiance, emission, textures }) => {
                let Some(reflectance) = textures.at(index, point) else {
                    return add_smooth(&radiosity[4 * index * bands..], corner_weights, weight, sum);
                };
                for (band, sum) in sum.iter_mut().enumerate() {
                    let corner = |k: usize| corner_weights[k] * irradiance[(4 * index + k) * bands + band];
                    let reflected = f64::from(reflectance.band(band)) * (0..4).map(corner).sum::<f64>();
                    *sum += weight * (emission[index * bands + band] + reflected);
                }
            }
        }
    }
}

/// Adds `weight` times what is between four corners.
fn add_smooth(corners: &[f64], corner_weights: [f64; 4], weight: f64, sum: &mut [f64]) {
    let bands = sum.len();
    for (k, share) in corner_weights.into_iter().enumerate() {
        let corner = &corners[k * bands..][..bands];
        sum.iter_mut().zip(corner).for_each(|(sum, v)| *sum += weight * share * v);
    }
}

impl RenderSettings {
    fn add_background(&self, weight: f64, sum: &mut [f64]) {
        sum.iter_mut().zip(&self.background).for_each(|(sum, b)| *sum += weight * f64::from(*b));
    }
}

/// How many rays are held in memory at once by each thread, unless a single pixel has more.
const RAYS_AT_ONCE: usize = 1 << 14;

/// Everything that one picture needs.
struct View<'a, Add> {
    visible: &'a Visible,
    frame: Frame,
    /// Where the rays of a pixel pass through it, in [0, 1).
    offsets: Vec<[f64; 2]>,
    bands: usize,
    settings: &'a RenderSettings,
    /// Adds what a ray sees.
    add: Add,
}

impl<'a, Add: Fn(&Ray, &Hit, &mut [f64]) + Sync> View<'a, Add> {
    fn new(visible: &'a Visible, bands: usize, camera: &Camera, settings: &'a RenderSettings, add: Add) -> Self {
        assert!(settings.background.is_empty() || settings.background.len() == bands, "one background value per band");
        let frame = Frame::new(camera, settings.width, settings.height);
        Self { visible, frame, offsets: offsets(settings.samples), bands, settings, add }
    }

    fn picture(&self, control: &Control) -> Result<Image, Cancelled> {
        let (width, height, bands) = (self.settings.width, self.settings.height, self.bands);
        let mut image = Image { width, height, bands, pixels: vec![0.0; width * height * bands] };
        if image.pixels.is_empty() {
            return Ok(image);
        }
        control.expect(height as u64);
        image.pixels.par_chunks_exact_mut(width * bands).enumerate().try_for_each(|(row, pixels)| {
            control.check()?;
            self.render_row(row, pixels);
            control.advance(1);
            Ok(())
        })?;
        Ok(image)
    }

    fn render_row(&self, row: usize, pixels: &mut [f32]) {
        let columns_at_once = (RAYS_AT_ONCE / self.offsets.len()).max(1);
        for (i, part) in pixels.chunks_mut(columns_at_once * self.bands).enumerate() {
            self.render_part(row, i * columns_at_once, part);
        }
    }

    /// Renders the pixels of a row from `first` on.
    fn render_part(&self, row: usize, first: usize, pixels: &mut [f32]) {
        let rays: Vec<Ray> = (first..first + pixels.len() / self.bands)
            .flat_map(|column| self.offsets.iter().map(move |[x, y]| (column as f64 + x, row as f64 + y)))
            .map(|(x, y)| self.frame.ray(x, y))
            .collect();
        let mut hits = vec![Hit::MISS; rays.len()];
        self.visible.bvh.closest_hits(&rays, &mut hits);
        let each = self.offsets.len();
        let mut sum = vec![0.0; self.bands];
        let of_pixels = rays.chunks_exact(each).zip(hits.chunks_exact(each));
        for (pixel, (rays, hits)) in pixels.chunks_exact_mut(self.bands).zip(of_pixels) {
            sum.fill(0.0);
            rays.iter().zip(hits).for_each(|(ray, hit)| (self.add)(ray, hit, &mut sum));
            for (value, sum) in pixel.iter_mut().zip(&sum) {
                *value = (sum / each as f64) as f32;
            }
        }
    }
}

/// Evenly spread points of a pixel, the same for all pixels so that edges are clean: pairs on either side of the centre,
/// so that it is their mean, which is one of them if they are odd in number.
///
/// Roberts 2018, *The unreasonable effectiveness of quasirandom sequences*: multiples of the powers of the plastic
/// number.
pub(crate) fn offsets(n: usize) -> Vec<[f64; 2]> {
    const STEPS: [f64; 2] = [0.754_877_666_246_692_7, 0.569_840_290_998_053_2];
    let (n, first) = (n.max(1), 1 - n.max(1) % 2);
    let of = |i: usize| {
        let point = STEPS.map(|step| (0.5 + step * i.div_ceil(2) as f64).fract());
        if i % 2 == 1 { point } else { point.map(|x| 1.0 - x) }
    };
    (first..first + n).map(of).collect()
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;
    use std::sync::Arc;

    use radiosity_geometry::texture::{Raster, TexturedFaces};

    use super::*;
    use crate::Smoother;
    use crate::test_scenes::{camera, cube, patches_of, sheet};

    fn settings(width: usize, height: usize) -> RenderSettings {
        RenderSettings { width, height, samples: 4, scale: 1.0, ..RenderSettings::default() }
    }

    fn shot(patches: &Patches, shading: Shading, eye: DVec3, settings: &RenderSettings) -> Image {
        render(patches, shading, 1, &camera(eye, 0.5), settings, &Control::default()).unwrap()
    }

    #[test]
    fn the_points_of_a_pixel_lie_about_its_centre() {
        for n in [1, 2, 15, 16, 128] {
            let points = offsets(n);
            let mean = points.iter().fold([0.0; 2], |sum, p| [sum[0] + p[0], sum[1] + p[1]]).map(|s| s / n as f64);
            assert!(mean.iter().all(|m| (m - 0.5).abs() < 1e-12), "{n}: {mean:?}");
            assert_eq!((points.len(), points.contains(&[0.5; 2])), (n, n % 2 == 1));
            // Spread evenly: of either half of the pixel about half.
            let left = points.iter().filter(|p| p[0] < 0.5).count();
            assert!(2 * left.abs_diff(n / 2) <= 2, "{n}: {left}");
        }
    }

    #[test]
    fn a_lit_plane_has_its_radiance() {
        let patches = sheet(4, 4);
        let settings = RenderSettings { scale: FRAC_1_PI, background: vec![7.0], ..settings(9, 5) };
        // The line of sight ends at a corner of the sheet, so this image is part background, part sheet.
        let image = shot(&patches, Shading::Patches(&[PI; 16]), DVec3::new(0.2, 0.3, 0.4), &settings);
        let is_sheet = |pixel: &[f32]| (pixel[0] - 1.0).abs() < 1e-6;
        assert!(image.iter().any(is_sheet) && image.iter().any(|pixel| pixel == [7.0]));
        let away = DVec3::new(0.2, 0.3, 40.0);
        assert_eq!(shot(&patches, Shading::Patches(&[PI; 16]), away, &settings).at(0, 0), [7.0]);
    }

    #[test]
    fn a_smooth_picture_of_a_linear_function_is_that_function() {
        for n in [1, 3] {
            let patches = sheet(n, n);
            let corners: Vec<f64> = patches.polygons.iter().flatten().map(|p| 1.0 + p.x + 2.0 * p.y).collect();
            let eye = DVec3::new(0.5, 0.5, 1.0);
            let eye_camera = Camera { forward: DVec3::NEG_Z, up: DVec3::Y, ..camera(eye, 0.8) };
            let settings = RenderSettings { samples: 1, ..settings(31, 31) };
            let image =
                render(&patches, Shading::Smooth(&corners), 1, &eye_camera, &settings, &Control::default()).unwrap();
            for (x, y) in [(0, 0), (30, 0), (15, 15), (3, 22), (20, 7)] {
                let at = |i: usize| 2.0 * 0.4f64.tan() * ((i as f64 + 0.5) / 31.0 - 0.5);
                let expected = 1.0 + (0.5 + at(x)) + 2.0 * (0.5 - at(y));
                assert!((f64::from(image.at(x, y)[0]) - expected).abs() < 1e-5, "pixel {x}, {y}");
            }
        }
    }

    #[test]
    fn textures_show_what_they_reflect_of_what_arrives() {
        // One patch of two has an image on it, black on its left and white on its right half; E = 1 and H = 1 + x.
        let mut patches = sheet(2, 1);
        patches.surface = vec![0, 1];
        let image = Raster::of_values([256, 1], 1, (0..256).map(|x| if x < 128 { 0.0 } else { 1.0 }).collect());
        let face = [(patches.polygons[1], [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])];
        let faces = TexturedFaces::new(Arc::new(image), face, &[0.5]);
        patches.face = vec![0, 0];
        let textures = TexturedPatches::new(&patches, &[None, Some(Arc::new(faces))]);
        let irradiance: Vec<f64> = patches.polygons.iter().flatten().map(|p| 1.0 + p.x).collect();
        let (radiosity, emission) = ([3.0; 8], [1.0; 2]);
        let shading = Shading::Textured(Textured {
            radiosity: &radiosity,
            irradiance: &irradiance,
            emission: &emission,
            textures: &textures,
        });
        let eye = Camera { forward: DVec3::NEG_Z, up: DVec3::Y, ..camera(DVec3::new(0.5, 0.5, 1.0), 0.8) };
        let settings = RenderSettings { samples: 1, ..settings(32, 32) };
        let mirrors = Mirrors { specular: &[0.0, 0.5], transmittance: &[0.0; 2] };
        let plain = render(&patches, shading, 1, &eye, &settings, &Control::default()).unwrap();
        let mirrored =
            render_with_mirrors(&patches, mirrors, shading, 1, &eye, &settings, &Control::default()).unwrap();
        for image in [plain, mirrored] {
            for column in [1, 8, 14, 17, 22, 30] {
                let x = 0.5 + 2.0 * 0.4f64.tan() * ((column as f64 + 0.5) / 32.0 - 0.5);
                let rho = if x > 0.75 { 0.5 } else { 0.0 };
                let expected = if x < 0.5 { 3.0 } else { 1.0 + rho * (1.0 + x) };
                let found = f64::from(image.at(column, 16)[0]);
                assert!((found - expected).abs() < 1e-5, "column {column}: {found}, not {expected}");
            }
        }
    }

    #[test]
    fn backs_let_the_view_through_or_are_black() {
        let patches = cube(2);
        let values: Vec<f64> = (0..24).map(|i| f64::from(patches.face[i]) + 1.0).collect();
        let eye = DVec3::new(0.0, 0.0, 3.0);
        let seen = |patches: &Patches, culls_backs| {
            shot(patches, Shading::Patches(&values), eye, &RenderSettings { culls_backs, ..settings(3, 3) }).at(1, 1)[0]
        };
        assert_eq!(seen(&patches, true), seen(&patches, false));
        // Inside out, the wall in front is culled and the one behind it seen.
        let mut inside_out = patches.polygons.clone();
        inside_out.iter_mut().for_each(|p| p.reverse());
        let mut room = Patches::new(inside_out, patches.surface.clone(), patches.face.clone(), vec![false; 24]);
        assert_eq!(seen(&room, false), 0.0);
        let far = seen(&room, true);
        assert!(far > 0.0 && far != seen(&patches, true));
        room.two_sided = vec![true; 24];
        assert_eq!(seen(&room, true), seen(&patches, true));
    }

    #[test]
    fn of_two_faces_back_to_back_the_front_is_seen() {
        let (x, y) = (DVec3::X, DVec3::Y);
        let up = [-x - y, x - y, x + y, y - x];
        let down = [y - x, x + y, x - y, -x - y];
        for culls_backs in [true, false] {
            let settings = RenderSettings { culls_backs, ..settings(4, 4) };
            for (order, expected) in [([up, down], 1.0), ([down, up], 2.0)] {
                let patches = patches_of(&order);
                let above = shot(&patches, Shading::Patches(&[1.0, 2.0]), DVec3::new(0.1, 0.2, 3.0), &settings);
                let below = shot(&patches, Shading::Patches(&[1.0, 2.0]), DVec3::new(0.1, 0.2, -3.0), &settings);
                assert_eq!((above.at(1, 1)[0], below.at(1, 1)[0]), (expected, 3.0 - expected));
            }
        }
    }

    #[test]
    fn interpolation_stays_within_the_corners_and_is_the_same_on_any_number_of_threads() {
        let patches = cube(3);
        let values: Vec<f64> = (0..2 * patches.len()).map(|i| (i % 7) as f64).collect();
        let corners = Smoother::new(&patches, 0.5).corner_values(&values, 2);
        let make = || {
            let eye = camera(DVec3::new(2.0, 1.5, 1.0), 0.6);
            render(&patches, Shading::Smooth(&corners), 2, &eye, &settings(40, 30), &Control::default()).unwrap()
        };
        let image = make();
        let most = corners.iter().fold(0.0, |a: f64, &b| a.max(b)) as f32;
        assert!(image.pixels.iter().all(|&v| (0.0..=most).contains(&v)) && image.pixels.iter().any(|&v| v > 0.0));
        let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
        assert_eq!(one.install(make), image);
    }

    #[test]
    fn far_from_the_origin_nothing_leaks() {
        let far = DVec3::new(4e5, -3e5, 1e3);
        let polygons: Vec<_> = sheet(20, 20).polygons.iter().map(|p| p.map(|v| v + far)).collect();
        let patches = patches_of(&polygons);
        let eye = Camera { position: far + DVec3::new(0.5, 0.5, 1.0), ..camera(DVec3::Z, 0.5) };
        let image =
            render(&patches, Shading::Patches(&[1.0; 400]), 1, &eye, &settings(64, 64), &Control::default()).unwrap();
        assert!(image.pixels.iter().all(|&v| v == 1.0));
    }

    #[test]
    fn cancelled_and_empty_pictures() {
        let (patches, control) = (sheet(1, 1), Control::default());
        control.cancel();
        let eye = camera(DVec3::Z, 1.0);
        let cancelled = render(&patches, Shading::Patches(&[1.0]), 1, &eye, &settings(4, 4), &control);
        assert_eq!(cancelled.unwrap_err(), Cancelled);
        let empty = shot(&Patches::default(), Shading::Patches(&[]), DVec3::Z, &settings(2, 2));
        assert_eq!(empty.pixels, [0.0; 4]);
        assert!(shot(&patches, Shading::Patches(&[1.0]), DVec3::Z, &settings(0, 2)).pixels.is_empty());
    }
}
