use glam::{DVec2, DVec3};

/// Cuts a polygon into `points.len() - 2` triangles, appended to `triangles` as indices into `points`.
///
/// The polygon is seen along its dominant axis (of Newell's normal). A fan from the first corner is
/// taken where it is valid; else ears are clipped in order (Meisters 1975, "Polygons Have Ears"), so
/// concave polygons come out right, with the polygon's winding. What is left of a polygon that crosses
/// itself or has no area becomes a fan. Takes O(n²) time where the fan is not valid.
pub fn triangulate(points: &[DVec3], triangles: &mut Vec<[usize; 3]>) {
    let n = points.len();
    let flat = Flat::new(points);
    if (2..n).all(|i| flat.area(0, i - 1, i) > 0.0) {
        triangles.extend((2..n).map(|i| [0, i - 1, i]));
    } else if n >= 3 {
        clip_ears(&flat, triangles);
    }
}

/// The polygon in a plane, counter-clockwise.
struct Flat<'a> {
    points: &'a [DVec3],
    axes: (usize, usize),
}

impl<'a> Flat<'a> {
    fn new(points: &'a [DVec3]) -> Self {
        // Newell's sum, about the first corner: far from the origin nothing cancels.
        let origin = points.first().copied().unwrap_or_default();
        let normal: DVec3 = (points.windows(2))
            .map(|p| (p[0] - origin).cross(p[1] - origin))
            .sum();
        let axis = normal.abs().max_position();
        let (a, b) = ((axis + 1) % 3, (axis + 2) % 3);
        Self {
            points,
            axes: if normal[axis] < 0.0 { (b, a) } else { (a, b) },
        }
    }

    fn at(&self, i: usize) -> DVec2 {
        let p = self.points[i];
        DVec2::new(p[self.axes.0], p[self.axes.1])
    }

    /// Twice the signed area of the triangle of three corners.
    fn area(&self, a: usize, b: usize, c: usize) -> f64 {
        (self.at(b) - self.at(a)).perp_dot(self.at(c) - self.at(a))
    }

    /// Whether corner `p` lies in the closed triangle `abc` without being one of its corners.
    fn holds(&self, [a, b, c]: [usize; 3], p: usize) -> bool {
        [(a, b), (b, c), (c, a)]
            .iter()
            .all(|&(s, t)| self.area(s, t, p) >= 0.0 && self.at(s) != self.at(p))
    }
}

fn clip_ears(flat: &Flat<'_>, triangles: &mut Vec<[usize; 3]>) {
    let n = flat.points.len();
    let mut next: Vec<usize> = (1..n).chain([0]).collect();
    let mut prev: Vec<usize> = std::iter::once(n - 1).chain(0..n - 1).collect();
    let mut reflex: Vec<bool> = (0..n)
        .map(|i| flat.area(prev[i], i, next[i]) <= 0.0)
        .collect();
    // A corner that is no ear stays none until a neighbour goes (a diagonal of the rest is one of the whole).
    let mut refused = vec![false; n];
    let (mut i, mut left, mut skipped) = (1, n, 0);
    while left > 3 && skipped < left {
        let (a, c) = (prev[i], next[i]);
        let blocked = || {
            std::iter::successors(Some(next[c]), |&j| Some(next[j]))
                .take_while(|&j| j != a)
                .any(|j| reflex[j] && flat.holds([a, i, c], j))
        };
        if refused[i] || reflex[i] || blocked() {
            refused[i] = true;
            skipped += 1;
        } else {
            triangles.push([a, i, c]);
            (next[a], prev[c]) = (c, a);
            for j in [a, c] {
                reflex[j] = flat.area(prev[j], j, next[j]) <= 0.0;
                refused[j] = false;
            }
            left -= 1;
            skipped = 0;
        }
        i = c;
    }
    let (hub, mut j) = (prev[i], i);
    for _ in 2..left {
        triangles.push([hub, j, next[j]]);
        j = next[j];
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn areas(points: &[(f64, f64)]) -> (Vec<f64>, f64) {
        let points: Vec<DVec3> = points.iter().map(|&(x, y)| DVec3::new(x, y, 0.0)).collect();
        let shoelace: f64 = (0..points.len())
            .map(|i| 0.5 * points[i].cross(points[(i + 1) % points.len()]).z)
            .sum();
        let mut triangles = Vec::new();
        triangulate(&points, &mut triangles);
        assert_eq!(triangles.len(), points.len() - 2);
        let area =
            |[a, b, c]: [usize; 3]| 0.5 * (points[b] - points[a]).cross(points[c] - points[a]).z;
        (triangles.into_iter().map(area).collect(), shoelace)
    }

    fn is_exact_cover(points: &[(f64, f64)]) -> bool {
        let (areas, shoelace) = areas(points);
        let sign = shoelace.signum();
        areas.iter().all(|a| a * sign >= 0.0)
            && (areas.iter().sum::<f64>() - shoelace).abs() <= 1e-12 * shoelace.abs()
    }

    #[test]
    fn every_rotation_and_winding_of_concave_polygons_is_covered_once() {
        let arrow = vec![(0.0, 0.0), (4.0, 2.0), (0.0, 4.0), (1.0, 2.0)];
        let comb: Vec<(f64, f64)> = (0..9)
            .map(|i| (f64::from(i), if i % 2 == 0 { 5.0 } else { 1.0 }))
            .chain([(8.0, 0.0), (0.0, 0.0)])
            .rev()
            .collect();
        let star: Vec<(f64, f64)> = (0..10)
            .map(|i| {
                let (s, c) = (0.2 * std::f64::consts::PI * f64::from(i)).sin_cos();
                let r = if i % 2 == 0 { 1.0 } else { 0.2 };
                (r * c, r * s)
            })
            .collect();
        // A square with a square hole, joined by a cut that is walked twice.
        let keyhole = vec![
            (0.0, 0.0),
            (6.0, 0.0),
            (6.0, 6.0),
            (0.0, 6.0),
            (0.0, 0.0),
            (2.0, 2.0),
            (2.0, 4.0),
            (4.0, 4.0),
            (4.0, 2.0),
            (2.0, 2.0),
        ];
        let midpoints = vec![
            (0.0, 0.0),
            (1.0, 0.0),
            (2.0, 0.0),
            (2.0, 1.0),
            (2.0, 2.0),
            (1.0, 2.0),
            (0.0, 2.0),
            (0.0, 1.0),
        ];
        for polygon in [arrow, comb, star, keyhole, midpoints] {
            for start in 0..polygon.len() {
                let mut turned = polygon.clone();
                turned.rotate_left(start);
                assert!(is_exact_cover(&turned), "{turned:?}");
                turned.reverse();
                assert!(is_exact_cover(&turned), "{turned:?}");
            }
        }
    }

    #[test]
    fn a_convex_polygon_is_a_fan_from_its_first_corner() {
        let points: Vec<DVec3> = (0..6)
            .map(|i| {
                let (s, c) = f64::from(i).sin_cos();
                DVec3::new(3.0, c, s)
            })
            .collect();
        let mut triangles = Vec::new();
        triangulate(&points, &mut triangles);
        assert_eq!(triangles, [[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 5]]);
    }

    #[test]
    fn no_edge_midpoint_makes_a_flat_triangle() {
        let (areas, _) = areas(&[(0.0, 0.0), (1.0, 0.0), (2.0, 0.0), (2.0, 2.0), (0.0, 2.0)]);
        assert!(areas.iter().all(|&a| a > 0.0));
    }

    #[test]
    fn polygons_without_area_still_give_their_triangles() {
        let (areas, _) = areas(&[(0.0, 0.0), (1.0, 0.0), (2.0, 0.0), (3.0, 0.0), (1.5, 0.0)]);
        assert_eq!(areas, [0.0; 3]);
        assert_eq!(self::areas(&[(1.0, 1.0); 6]).0, [0.0; 4]);
    }
}
