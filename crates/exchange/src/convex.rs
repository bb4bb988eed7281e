//! Convex polygons cut by planes.

use glam::DVec3;

/// Splits a convex polygon where `heights` of its corners change sign: what is above goes to `front`, what is below to
/// `back`, corners of height zero to both.
pub fn split(polygon: &[DVec3], heights: &[f64], front: &mut Vec<DVec3>, back: &mut Vec<DVec3>) {
    front.clear();
    back.clear();
    let n = polygon.len();
    for k in 0..n {
        let next = if k + 1 == n { 0 } else { k + 1 };
        let (v, w, h, g) = (polygon[k], polygon[next], heights[k], heights[next]);
        if h >= 0.0 {
            front.push(v);
        }
        if h <= 0.0 {
            back.push(v);
        }
        if h * g < 0.0 {
            let crossing = v + h / (h - g) * (w - v);
            front.push(crossing);
            back.push(crossing);
        }
    }
}

/// A triangle cut at the middles of its edges.
pub fn quarters([a, b, c]: &[DVec3; 3]) -> [[DVec3; 3]; 4] {
    let (ab, bc, ca) = (0.5 * (*a + *b), 0.5 * (*b + *c), 0.5 * (*c + *a));
    [[*a, ab, ca], [ab, *b, bc], [ca, bc, *c], [ab, bc, ca]]
}

/// The least and the greatest of some numbers.
pub fn range(values: impl IntoIterator<Item = f64>) -> (f64, f64) {
    values.into_iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_parts_make_the_whole_and_share_the_cut() {
        let square = [(0., 0.), (2., 0.), (2., 2.), (0., 2.)].map(|(x, y)| DVec3::new(x, y, 0.0));
        let (mut front, mut back) = (vec![DVec3::ONE], vec![DVec3::ONE]);
        // Along the diagonal: two corners are in both parts.
        split(&square, &square.map(|c| c.x - c.y), &mut front, &mut back);
        assert_eq!((front.len(), back.len()), (3, 3));
        // At x = 0.5: two crossings are in both.
        split(&square, &square.map(|c| c.x - 0.5), &mut front, &mut back);
        assert_eq!((range(front.iter().map(|c| c.x)), range(back.iter().map(|c| c.x))), ((0.5, 2.0), (0.0, 0.5)));
    }
}
