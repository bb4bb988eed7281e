//! What rough metals show: a lobe of microfacets about the mirror's direction.
//!
//! Facets are distributed as GGX (Walter et al. 2007, *Microfacet models for refraction through rough surfaces*), of
//! width alpha = roughness squared (Burley 2012), shadow each other as Smith says, correlated by height (Heitz 2014), and
//! reflect as Schlick (1994) has it of metals: F0 + (1 - F0) (1 - cos)^5. Of white metal the lobe reflects 0.99 for a
//! roughness of 0.3 and 1 - ln 2 for 1, as one looks straight at it; the rest facets throw at each other, and it is for
//! those who draw to have it leave diffusely.

use glam::{DVec3, Vec3};
use radiosity_geometry::sampling::Frame;

/// What of the reflectance of sides is of a rough metal, from 0 to 1, and how rough that is: one each per side.
#[derive(Clone, Debug)]
pub struct Gloss {
    /// The part that is a metal.
    pub metallic: Vec<f32>,
    /// From 0, a mirror, to 1.
    pub roughness: Vec<f32>,
}

impl Gloss {
    /// Part and roughness of a side, if any of it is a metal.
    pub fn of(&self, side: usize) -> Option<(f64, f64)> {
        let metallic = self.metallic[side];
        (metallic > 0.0).then(|| (f64::from(metallic), f64::from(self.roughness[side])))
    }

    /// The same for others: the `k`-th of them is the `which[k]`-th of these.
    pub fn picked(&self, which: &[u32]) -> Self {
        let pick = |values: &[f32]| which.iter().map(|&i| values[i as usize]).collect();
        Self { metallic: pick(&self.metallic), roughness: pick(&self.roughness) }
    }
}

/// The narrowest lobe: what is narrower is a mirror to single precision.
const NARROWEST: f64 = 1e-4;

/// The lobe of a point as an eye sees it.
#[derive(Clone, Copy, Debug)]
pub struct Lobe {
    frame: Frame,
    alpha: f64,
    /// Toward the eye, in the frame.
    view: DVec3,
}

/// A way that light may come to the eye by a facet.
#[derive(Clone, Copy, Debug)]
pub struct Way {
    /// Where it comes from, a unit vector.
    pub direction: Vec3,
    /// If it was drawn: the part that no other facet is in the way of. Else the BRDF, 1/sr; both but for Fresnel's part.
    pub weight: f64,
    /// Of the angle between the eye and the normal of the facet.
    cosine: f64,
}

impl Way {
    /// Fresnel's part, by reflectance at right angles.
    pub fn fresnel(&self, f0: f64) -> f64 {
        f0 + (1.0 - f0) * (1.0 - self.cosine).clamp(0.0, 1.0).powi(5)
    }
}

impl Lobe {
    /// None if the eye looks at the back or along the plane; `toward_eye` is a unit vector.
    pub fn new(normal: DVec3, toward_eye: DVec3, roughness: f64) -> Option<Self> {
        let (frame, alpha) = (Frame::new(normal), (roughness * roughness).max(NARROWEST));
        let view = in_frame(&frame, toward_eye);
        (view.z > 0.0).then_some(Self { frame, alpha, view })
    }

    /// Draws a facet of those that the eye sees by two numbers in (0, 1) (Heitz 2018, *Sampling the GGX distribution of
    /// visible normals*). The density of ways is the BRDF times the cosine with the normal, over their weight.
    pub fn draw(&self, u: f64, v: f64) -> Way {
        let stretched = DVec3::new(self.alpha * self.view.x, self.alpha * self.view.y, self.view.z).normalize();
        let across = DVec3::new(-stretched.y, stretched.x, 0.0).try_normalize().unwrap_or(DVec3::X);
        let up = stretched.cross(across);
        let (radius, angle) = (u.sqrt(), std::f64::consts::TAU * v);
        let (sine, cosine) = angle.sin_cos();
        let (x, s) = (radius * cosine, 0.5 * (1.0 + stretched.z));
        let y = (1.0 - s) * (1.0 - x * x).max(0.0).sqrt() + s * radius * sine;
        let z = (1.0 - x * x - y * y).max(0.0).sqrt();
        let drawn = x * across + y * up + z * stretched;
        let facet = DVec3::new(self.alpha * drawn.x, self.alpha * drawn.y, drawn.z.max(1e-12)).normalize();
        let light = 2.0 * self.view.dot(facet) * facet - self.view;
        let (of_view, of_light) = (self.lambda(self.view), self.lambda(light));
        let Frame { tangent, bitangent, normal } = self.frame;
        let direction = (light.x * tangent + light.y * bitangent + light.z * normal).as_vec3();
        let weight = if light.z > 0.0 { (1.0 + of_view) / (1.0 + of_view + of_light) } else { 0.0 };
        Way { direction, weight, cosine: self.view.dot(facet) }
    }

    /// The way from a light in a direction, a unit vector; none from behind.
    pub fn from(&self, direction: DVec3) -> Option<Way> {
        let light = in_frame(&self.frame, direction);
        let facet = (light + self.view).try_normalize()?;
        if light.z <= 0.0 {
            return None;
        }
        let square = self.alpha * self.alpha;
        let spread = facet.z * facet.z * (square - 1.0) + 1.0;
        let density = square / (std::f64::consts::PI * spread * spread);
        let shadowing = 1.0 / (1.0 + self.lambda(self.view) + self.lambda(light));
        let weight = density * shadowing / (4.0 * self.view.z * light.z);
        Some(Way { direction: direction.as_vec3(), weight, cosine: self.view.dot(facet) })
    }

    /// Smith's auxiliary function.
    fn lambda(&self, w: DVec3) -> f64 {
        let tangent = (w.x * w.x + w.y * w.y) / (w.z * w.z);
        0.5 * ((1.0 + self.alpha * self.alpha * tangent).sqrt() - 1.0)
    }
}

fn in_frame(frame: &Frame, w: DVec3) -> DVec3 {
    DVec3::new(frame.tangent.dot(w), frame.bitangent.dot(w), frame.normal.dot(w))
}

#[cfg(test)]
mod tests {
    use super::*;
    use radiosity_geometry::sampling::Sequence;

    fn lobe(roughness: f64, sine: f64) -> Lobe {
        Lobe::new(DVec3::Y, DVec3::new(sine, (1.0 - sine * sine).sqrt(), 0.0), roughness).unwrap()
    }

    /// What is reflected of light that is everywhere one, for F = 1, by points that draw facets.
    fn albedo(lobe: &Lobe) -> f64 {
        let (sequence, n) = (Sequence::new(1, 2, 3, 4), 4096);
        let drawn = (0..n).map(|i| {
            let [u, v, ..] = sequence.point(i);
            lobe.draw(u, v).weight
        });
        drawn.sum::<f64>() / f64::from(n)
    }

    #[test]
    fn what_is_drawn_has_the_density_of_what_is_evaluated() {
        for (roughness, sine) in [(0.3, 0.2), (0.7, 0.6), (1.0, 0.9)] {
            let lobe = lobe(roughness, sine);
            // The integral of f cos over the hemisphere, by rings of equal solid angle.
            let (rings, sectors) = (2000, 400);
            let mut sum = 0.0;
            for i in 0..rings {
                let z = (f64::from(i) + 0.5) / f64::from(rings);
                for k in 0..sectors {
                    let angle = std::f64::consts::TAU * (f64::from(k) + 0.5) / f64::from(sectors);
                    let r = (1.0 - z * z).sqrt();
                    let way = lobe.from(DVec3::new(r * angle.cos(), z, r * angle.sin()));
                    sum += way.map_or(0.0, |way| way.weight * z);
                }
            }
            let integral = std::f64::consts::TAU * sum / f64::from(rings * sectors);
            let drawn = albedo(&lobe);
            assert!((integral - drawn).abs() < 3e-3, "{roughness} {sine}: {integral} {drawn}");
        }
    }

    #[test]
    fn smooth_lobes_are_mirrors_and_rough_ones_lose_light() {
        let mirror = lobe(0.0, 0.6);
        let way = mirror.draw(0.3, 0.7);
        assert!((way.direction.as_dvec3() - DVec3::new(-0.6, 0.8, 0.0)).length() < 1e-3);
        assert!((way.weight - 1.0).abs() < 1e-6);
        let albedos = [0.1, 0.3, 0.6, 1.0].map(|roughness| albedo(&lobe(roughness, 0.0)));
        assert!(albedos.windows(2).all(|pair| pair[0] > pair[1]) && albedos[0] > 0.999, "{albedos:?}");
        // The integral of f cos for alpha = 1 as one looks along the normal.
        assert!((albedos[3] - (1.0 - 2f64.ln())).abs() < 2e-3, "{albedos:?}");
    }

    #[test]
    fn it_is_reciprocal() {
        let (eye, light) = (DVec3::new(0.6, 0.8, 0.0), DVec3::new(0.0, 0.6, 0.8));
        let there = Lobe::new(DVec3::Y, eye, 0.5).unwrap().from(light).unwrap();
        let back = Lobe::new(DVec3::Y, light, 0.5).unwrap().from(eye).unwrap();
        assert!((there.weight - back.weight).abs() < 1e-12);
        assert!((there.fresnel(0.4) - back.fresnel(0.4)).abs() < 1e-12 && there.fresnel(1.0) == 1.0);
    }
}
