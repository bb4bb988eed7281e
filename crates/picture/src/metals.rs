//! What rough metals show in traced pictures, where a camera looks at them.
//!
//! A part of what a side reflects may be of a rough metal (`radiosity_paths::Gloss`). Of the paths from a point that is
//! seen, as large a part follows its lobe to what is seen in it, and the rest is diffuse. What is seen there is shown as
//! if it were seen straight, but metals in metals are diffuse, as in the solution. Lamps are also looked for by points on
//! them, weighed as in `radiosity_paths`, and lights without area one by one.
//!
//! What facets throw at each other leaves diffusely, reflected once more (after Kulla and Conty 2017, *Revisiting physically
//! based shading at Imageworks*): so white metal loses nothing, however rough it is.

use glam::DVec3;
use radiosity_geometry::sampling::Sequence;
use radiosity_paths::{LampSight, Lobe, Tracer, Way};

/// The first of two streams of the sequences that choose between paint and metal, the facet, and a point on a lamp.
const STREAM: u32 = 13;

/// A point of a metal as it is seen.
pub(crate) struct Metal {
    side: usize,
    point: DVec3,
    /// What of the reflectance is of the metal.
    share: f64,
    lobe: Lobe,
}

/// What a path does at a metal.
pub(crate) enum Choice {
    /// It is reflected by paint.
    Paint,
    /// It goes on by a facet.
    Along(Way),
    /// Another facet is in the way, and it is reflected diffusely after the first.
    Spread(Way),
}

impl Metal {
    /// None if a side is no metal; the ray comes along `direction`, to a point just off it.
    pub fn new(tracer: &Tracer, side: usize, point: DVec3, direction: DVec3) -> Option<Self> {
        let (share, roughness) = tracer.gloss_of(side)?;
        let lobe = Lobe::new(tracer.enclosure().normal(side), -direction, roughness)?;
        Some(Self { side, point, share, lobe })
    }

    /// How a path goes on, by the numbers of its key, index and round.
    pub fn choose(&self, tracer: &Tracer, (key, index): (u32, u32), round: u32) -> Choice {
        let [choice, u, v, thrown] = Sequence::new(tracer.seed(), key, round, STREAM).point(index);
        if choice >= self.share {
            return Choice::Paint;
        }
        let way = self.lobe.draw(u, v);
        if thrown < way.weight { Choice::Along(way) } else { Choice::Spread(way) }
    }

    /// What is seen of a point on a lamp by the lobe, for one of the paths: the side, its weight, and the way.
    pub fn lamp(&self, tracer: &Tracer, (key, index): (u32, u32), round: u32) -> Option<(usize, f64, Way)> {
        let [choice, u, v, _] = Sequence::new(tracer.seed(), key, round, STREAM + 1).point(index);
        let normal = tracer.enclosure().normal(self.side);
        let LampSight { side, direction, left, density } = tracer.lamp_at(self.point, normal, [choice, u, v])?;
        let way = self.lobe.from(direction)?;
        Some((side, left * balanced(self.density(&way, normal), density), way))
    }

    /// What a side weighs that a path found at a point by the lobe: less than one if it is a lamp in a straight line, as
    /// such are also looked for.
    pub fn weight(&self, tracer: &Tracer, way: &Way, (side, there): (usize, DVec3)) -> f64 {
        let (normal, direction) = (tracer.enclosure().normal(self.side), way.direction.as_dvec3());
        let to = there - self.point;
        if to.cross(direction).length() > STRAIGHT * to.length() {
            return 1.0;
        }
        let Some(way) = self.lobe.from(direction) else { return 1.0 };
        let lamp = tracer.lamp_density(self.point, normal, (side, direction, to.length()));
        balanced(self.density(&way, normal), lamp)
    }

    /// The density of ways along which paths go on, per sr.
    fn density(&self, way: &Way, normal: DVec3) -> f64 {
        self.share * way.weight * normal.dot(way.direction.as_dvec3()).max(0.0)
    }

    /// Adds `weight` times the radiance of what it shows of lights without area; `f0` is the reflectance of each band.
    pub fn add_highlights(&self, tracer: &Tracer, f0: impl Fn(usize) -> f32, weight: f64, sums: &mut [f64]) {
        tracer.lights_at(self.point, tracer.enclosure().normal(self.side), |direction, irradiance, strength| {
            let Some(way) = self.lobe.from(direction) else { return };
            for (band, sum) in sums.iter_mut().enumerate() {
                let reflected = way.fresnel(f64::from(f0(band))) * way.weight * irradiance;
                *sum += weight * self.share * reflected * f64::from(strength[band]);
            }
        });
    }
}

/// How far a path may leave the line to what it found, over its length, for rounding.
const STRAIGHT: f64 = 1e-3;

/// The balance heuristic, as in `radiosity_paths`.
fn balanced(own: f64, other: f64) -> f64 {
    if own > 0.0 { own / (own + other) } else { 0.0 }
}
