//! Sides that shine much brighter than the rest, found by points on them.
//!
//! Lamps of one surface that look one way are a group. From a point, a group is chosen by what it could send there at
//! best, a lamp of it by its power, a point of that evenly. Rays find lamps too; the two ways are weighed by the power
//! heuristic (Veach and Guibas 1995, *Optimally combining sampling techniques for Monte Carlo rendering*), so that every
//! path counts once, and neither a lamp nearby nor one far away makes noise that the other way would not.

use std::collections::BTreeMap;
use std::f64::consts::FRAC_1_PI;

use glam::DVec3;
use radiosity_exchange::Enclosure;

use crate::exitance::Exitance;

/// A side is a lamp when its exitance exceeds the mean of all sides this many times: rays find others often enough,
/// and in a scene where everything glows nothing is a lamp.
const CONTRAST: f64 = 6.0;

/// At most so many sides are lamps, the strongest.
const MOST_LAMPS: usize = 1 << 16;

/// At most so many groups, as a point looks at each; the weakest beyond are one together.
const MOST_GROUPS: usize = 32;

/// A surface whose lamps look more ways than this is one group, whichever way they look.
const MOST_WAYS: usize = 6;

/// No lamp.
const NONE: u32 = u32::MAX;

/// All lamps of a scene.
pub struct Lamps {
    groups: Vec<Group>,
    /// Side -> group.
    group_of: Vec<u32>,
    /// Side -> density of points on it, per m2, once its group is chosen.
    density: Vec<f32>,
}

/// Lamps of one surface.
struct Group {
    centre: DVec3,
    /// Of a ball around all of it, metres.
    radius: f64,
    /// Mean exitance times area, W.
    power: f64,
    /// The plane it lies in, and shines from, if it does.
    normal: Option<DVec3>,
    sides: Vec<u32>,
    /// Share of the power of the sides up to each.
    cumulative: Vec<f64>,
}

/// A point on a lamp, as a point elsewhere sees it.
pub struct LampPoint {
    /// Side and chart coordinates.
    pub on: (u32, f64, f64),
    /// Just off the lamp.
    pub point: DVec3,
    /// What its exitance weighs in the irradiance, if it is in sight.
    pub weight: f32,
}

impl Lamps {
    /// Chooses lamps by what leaves sides.
    pub fn new(enclosure: &Enclosure, exitance: &Exitance, bands: usize) -> Self {
        let sides = enclosure.sides();
        let mean: Vec<f64> = (0..sides).map(|side| exitance.mean(side, bands)).collect();
        let power = |side: usize| enclosure.area(side) * mean[side];
        let threshold =
            CONTRAST * (0..sides).map(power).sum::<f64>() / (0..sides).map(|s| enclosure.area(s)).sum::<f64>();
        let mut lamps: Vec<usize> = (0..sides).filter(|&s| enclosure.area(s) > 0.0 && mean[s] > threshold).collect();
        lamps.sort_by(|&a, &b| power(b).total_cmp(&power(a)).then(a.cmp(&b)));
        lamps.truncate(MOST_LAMPS);
        lamps.sort_unstable();
        let groups: Vec<Group> =
            grouped(enclosure, &lamps, power).into_iter().map(|sides| Group::new(enclosure, sides, power)).collect();
        let (mut group_of, mut density) = (vec![NONE; sides], vec![0.0; sides]);
        for (g, group) in groups.iter().enumerate() {
            for &side in &group.sides {
                group_of[side as usize] = g as u32;
                density[side as usize] = (mean[side as usize] / group.power) as f32;
            }
        }
        Self { groups, group_of, density }
    }

    /// What all groups together could send to a point: what [`Lamps::sample`] and [`Lamps::weight`] want to know.
    #[inline]
    pub fn importance(&self, at: DVec3, normal: DVec3) -> f64 {
        self.groups.iter().map(|group| group.importance(at, normal)).sum()
    }

    /// A point on a lamp for three numbers in (0, 1); none if no lamp can be seen, or this one sends nothing here.
    #[inline]
    pub fn sample(
        &self,
        enclosure: &Enclosure,
        (at, normal): (DVec3, DVec3),
        importance: f64,
        [choice, u, v]: [f64; 3],
    ) -> Option<LampPoint> {
        let (side, density) = self.side(at, normal, importance, choice)?;
        let point = enclosure.point_off(side, u, v);
        let to = point - at;
        let distance2 = to.length_squared();
        let cosines = normal.dot(to).max(0.0) * (-enclosure.normal(side).dot(to)).max(0.0);
        let kernel = cosines * FRAC_1_PI / (distance2 * distance2);
        let weight = if kernel > 0.0 { (kernel / density) as f32 * preferred(density, kernel) } else { 0.0 };
        (weight > 0.0).then_some(LampPoint { on: (side as u32, u, v), point, weight })
    }

    /// A lamp for a number in (0, 1), and the density per m2 of points on it; none if no lamp can be seen.
    #[inline]
    pub fn side(&self, at: DVec3, normal: DVec3, importance: f64, choice: f64) -> Option<(usize, f64)> {
        if importance <= 0.0 {
            return None;
        }
        let (group, share, rest) = self.choose(at, normal, importance, choice)?;
        let k = group.cumulative.partition_point(|&c| c < rest).min(group.sides.len() - 1);
        let side = group.sides[k] as usize;
        Some((side, share * f64::from(self.density[side])))
    }

    /// The density per m2 of points on a side, as [`Lamps::side`] has it; zero unless it is a lamp.
    pub fn density(&self, at: DVec3, normal: DVec3, side: usize) -> f64 {
        let (group, importance) = (self.group_of[side], self.importance(at, normal));
        if group == NONE || importance <= 0.0 {
            return 0.0;
        }
        self.groups[group as usize].importance(at, normal) / importance * f64::from(self.density[side])
    }

    /// What the exitance weighs that a cosine-distributed ray found on a side; one unless that is a lamp.
    #[inline]
    pub fn weight(
        &self,
        enclosure: &Enclosure,
        (at, normal): (DVec3, DVec3),
        importance: f64,
        (side, direction, distance): (usize, DVec3, f64),
    ) -> f32 {
        let group = self.group_of[side];
        if group == NONE || importance <= 0.0 {
            return 1.0;
        }
        let cosines = normal.dot(direction).max(0.0) * (-enclosure.normal(side).dot(direction)).max(0.0);
        let kernel = cosines * FRAC_1_PI / (distance * distance).max(f64::MIN_POSITIVE);
        let share = self.groups[group as usize].importance(at, normal) / importance;
        preferred(kernel, share * f64::from(self.density[side]))
    }

    /// The group at a place in the sum of importances, its share, and how far into it the place is.
    #[inline]
    fn choose(&self, at: DVec3, normal: DVec3, importance: f64, choice: f64) -> Option<(&Group, f64, f64)> {
        let mut left = choice * importance;
        let mut last = None;
        for group in &self.groups {
            let own = group.importance(at, normal);
            if own <= 0.0 {
                continue;
            }
            last = Some((group, own / importance, (left / own).min(1.0)));
            if left < own {
                break;
            }
            left -= own;
        }
        last
    }
}

/// The power heuristic: what a find counts that was made with one density and could have been with another.
#[inline]
fn preferred(own: f64, other: f64) -> f32 {
    // By the ratio, as squares of densities would overflow beside a lamp.
    let ratio = other / own;
    if own > 0.0 { (1.0 / (1.0 + ratio * ratio)) as f32 } else { 0.0 }
}

impl Group {
    fn new(enclosure: &Enclosure, sides: Vec<u32>, power: impl Fn(usize) -> f64) -> Self {
        let total: f64 = sides.iter().map(|&s| power(s as usize)).sum();
        let patches = enclosure.patches();
        let corners = |s: &u32| patches.corners(enclosure.patch_of(*s as usize));
        let count: usize = sides.iter().map(|s| corners(s).len()).sum();
        let centre = sides.iter().flat_map(corners).sum::<DVec3>() / count as f64;
        let radius = sides.iter().flat_map(corners).map(|c| c.distance(centre)).fold(0.0, f64::max);
        let normal = enclosure.normal(sides[0] as usize);
        let is_flat = sides.iter().flat_map(corners).all(|c| (*c - centre).dot(normal).abs() <= 1e-6 * radius)
            && sides.iter().all(|&s| enclosure.normal(s as usize).dot(normal) > 1.0 - 1e-9);
        let mut sum = 0.0;
        let cumulative = sides
            .iter()
            .map(|&s| {
                sum += power(s as usize);
                sum / total
            })
            .collect();
        Self { centre, radius, power: total, normal: is_flat.then_some(normal), sides, cumulative }
    }

    /// At most this much of its power may arrive, per m2 and but for a factor; nothing where either is behind the other.
    #[inline]
    fn importance(&self, at: DVec3, normal: DVec3) -> f64 {
        let to = self.centre - at;
        let is_behind = to.dot(normal) <= -self.radius || self.normal.is_some_and(|n| to.dot(n) >= 0.0);
        if is_behind { 0.0 } else { self.power / (to.length_squared() + self.radius * self.radius) }
    }
}

/// Sides by surface and, for few, by the way they look; strongest groups first.
fn grouped(enclosure: &Enclosure, lamps: &[usize], power: impl Fn(usize) -> f64) -> Vec<Vec<u32>> {
    let mut surfaces: BTreeMap<u32, BTreeMap<[i64; 3], Vec<u32>>> = BTreeMap::new();
    for &side in lamps {
        let surface = enclosure.patches().surface[enclosure.patch_of(side)];
        let way = (enclosure.normal(side) * 1e4).round().to_array().map(|x| x as i64);
        surfaces.entry(surface).or_default().entry(way).or_default().push(side as u32);
    }
    let mut groups: Vec<Vec<u32>> = Vec::new();
    for ways in surfaces.into_values() {
        if ways.len() <= MOST_WAYS {
            groups.extend(ways.into_values());
        } else {
            groups.push(ways.into_values().flatten().collect());
        }
    }
    let strength = |group: &Vec<u32>| group.iter().map(|&s| power(s as usize)).sum::<f64>();
    // Stable, so that equals stay in the order of their surfaces.
    groups.sort_by(|a, b| strength(b).total_cmp(&strength(a)));
    if groups.len() > MOST_GROUPS {
        let rest = groups.split_off(MOST_GROUPS - 1).concat();
        groups.push(rest);
    }
    groups
}
