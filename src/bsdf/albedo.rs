//! How much light lobes reflect in all from a direction, integrated once and looked up from then on.

use std::sync::LazyLock;

use glam::{Vec2, Vec3};
use rayon::prelude::*;

use crate::color::Rgb;
use crate::material::Fresnel;

use super::fresnel::{dielectric, edge};
use super::microfacet::Microfacets;

/// A function on the unit cube of `N` dimensions, known at the nodes of a grid and linear between.
pub(super) struct Grid<const N: usize> {
    counts: [usize; N],
    values: Vec<f32>,
}

impl<const N: usize> Grid<N> {
    /// `f` at `counts` even steps from 0 to 1 along each axis.
    pub(super) fn new(counts: [usize; N], f: impl Fn([f32; N]) -> f32 + Sync) -> Self {
        let node = |mut i: usize| {
            let mut x = [0.0; N];
            for (x, &count) in x.iter_mut().zip(&counts).rev() {
                *x = (i % count) as f32 / (count - 1) as f32;
                i /= count;
            }
            f(x)
        };
        let values = (0..counts.iter().product()).into_par_iter().map(node);
        Self {
            counts,
            values: values.collect(),
        }
    }

    /// The function at a point; outside of the cube as at the nearest point of it.
    pub(super) fn at(&self, x: [f32; N]) -> f32 {
        let mut low = 0;
        let mut axes = [(0, 0.0); N];
        for ((axis, &count), x) in axes.iter_mut().zip(&self.counts).zip(x) {
            let at = x.clamp(0.0, 1.0) * (count - 1) as f32;
            let i = (at as usize).min(count - 2);
            low = low * count + i;
            axis.1 = at - i as f32;
        }
        let mut stride = 1;
        for (axis, &count) in axes.iter_mut().zip(&self.counts).rev() {
            axis.0 = stride;
            stride *= count;
        }
        let mut sum = 0.0;
        for corner in 0..1_u32 << N {
            let (mut index, mut weight) = (low, 1.0);
            for (k, (stride, part)) in axes.iter().enumerate() {
                if corner >> k & 1 == 1 {
                    index += stride;
                    weight *= part;
                } else {
                    weight *= 1.0 - part;
                }
            }
            if weight > 0.0 {
                sum += weight * self.values[index];
            }
        }
        sum
    }
}

/// The mean of an albedo over the hemisphere, weighted by the cosine, of which it takes the root.
fn average(albedo: impl Fn(f32) -> f32) -> f32 {
    const STEPS: usize = 512;
    let part = |i| {
        let root = (i as f32 + 0.5) / STEPS as f32;
        4.0 * root.powi(3) * albedo(root) / STEPS as f32
    };
    (0..STEPS).map(part).sum()
}

/// The direction, along x, whose cosine has the given root. Albedos bend most at grazing angles: tables are over the root.
pub(super) fn from_root(root: f32) -> Vec3 {
    let cos = (root * root).max(1e-4);
    Vec3::new((1.0 - cos * cos).sqrt(), 0.0, cos)
}

/// The share of light from `wo` that comes off `facets` after a single reflection.
fn of_facets(facets: &Microfacets, wo: Vec3, reflectance: impl Fn(f32) -> f32) -> f32 {
    const COUNT: usize = 512;
    let part = |u2| {
        let wi = facets.reflect(wo, u2)?;
        let once = facets.reflected(wo, wi);
        Some(reflectance(once.cos) * once.f_cos / once.pdf)
    };
    lattice(COUNT).filter_map(part).sum::<f32>() / COUNT as f32
}

/// Points spread evenly over the unit square, by the golden ratio.
pub(super) fn lattice(count: usize) -> impl Iterator<Item = Vec2> {
    (0..count).map(move |i| {
        let u = (i as f32 + 0.5) / count as f32;
        Vec2::new(u, (i as f32 * 0.618_034).fract())
    })
}

/// Of facets of a roughness, 0 for a smooth surface.
fn of_roughness(roughness: f32, root: f32, reflectance: impl Fn(f32) -> f32) -> f32 {
    let wo = from_root(root);
    if roughness == 0.0 {
        return reflectance(wo.z);
    }
    let facets = Microfacets::isotropic(roughness * roughness);
    of_facets(&facets, wo, reflectance)
}

/// A table over roughness and the root of the cosine, and its averages over the hemisphere.
struct Rough {
    albedo: Grid<2>,
    average: Grid<1>,
}

impl Rough {
    fn new(reflectance: impl Fn(f32) -> f32 + Sync) -> Self {
        let albedo = Grid::new([32, 32], |[r, root]| of_roughness(r, root, &reflectance));
        let average = Grid::new([32], |[r]| average(|root| albedo.at([r, root])));
        Self { albedo, average }
    }
}

/// Facets that reflect all light.
static WHITE: LazyLock<Rough> = LazyLock::new(|| Rough::new(|_| 1.0));
/// Facets of Schlick's falloff.
static EDGE: LazyLock<Rough> = LazyLock::new(|| Rough::new(edge));

/// Facets that reflect all light, stretched along x: over the roughness that way, the root of the ratio of widths, the
/// direction's azimuth in quarters of a turn and the root of its cosine.
static BRUSHED: LazyLock<Grid<4>> = LazyLock::new(|| {
    Grid::new([13, 7, 7, 16], |[roughness, ratio, quarter, root]| {
        if roughness == 0.0 {
            return 1.0;
        }
        let long = roughness * roughness;
        let facets = Microfacets::stretched(Vec2::new(long, long * (ratio * ratio).max(1e-3)), 0.0);
        let turn = Vec2::from_angle(quarter * std::f32::consts::FRAC_PI_2);
        let wo = from_root(root);
        of_facets(&facets, (turn * wo.x).extend(wo.z), |_| 1.0)
    })
});
/// Its averages over the hemisphere.
static BRUSHED_AVERAGE: LazyLock<Grid<2>> = LazyLock::new(|| {
    Grid::new([13, 7], |[roughness, ratio]| {
        const TURNS: usize = 24;
        let turn = |i| (i as f32 + 0.5) / TURNS as f32;
        let albedo = |i| average(|root| BRUSHED.at([roughness, ratio, turn(i), root]));
        (0..TURNS).map(albedo).sum::<f32>() / TURNS as f32
    })
});

/// Reflection from the outside of a dielectric: over the root of its reflectance at normal incidence, the roughness and
/// the root of the cosine.
static COATS: LazyLock<Grid<3>> = LazyLock::new(|| {
    Grid::new([11, 24, 32], |[f0_root, roughness, root]| {
        let part = LARGEST_ROOT * f0_root;
        let ior = (1.0 + part) / (1.0 - part);
        of_roughness(roughness, root, |cos| dielectric(Fresnel::Exact, cos, ior))
    })
});
static COATS_AVERAGE: LazyLock<Grid<2>> =
    LazyLock::new(|| Grid::new([11, 24], |[f0, r]| average(|root| COATS.at([f0, r, root]))));
/// For an index of 3.
const LARGEST_ROOT: f32 = 0.5;

/// Reflection at a rough dielectric of index 1 to 3 from outside.
#[derive(Clone, Copy, Debug)]
pub(super) struct Coat {
    f0_root: f32,
    roughness: f32,
}

impl Coat {
    pub(super) fn new(ior: f32, roughness: f32) -> Self {
        Self {
            f0_root: (ior - 1.0) / (ior + 1.0) / LARGEST_ROOT,
            roughness,
        }
    }

    /// For light that leaves under an angle of cosine `cos`.
    pub(super) fn albedo(self, cos: f32) -> f32 {
        COATS.at([self.f0_root, self.roughness, cos.max(0.0).sqrt()])
    }

    /// Its average over the hemisphere.
    pub(super) fn average(self) -> f32 {
        COATS_AVERAGE.at([self.f0_root, self.roughness])
    }
}

/// What comes off facets after a single reflection, if they reflect all light.
#[derive(Clone, Copy, Debug)]
pub(super) struct Whole {
    pub(super) facets: Microfacets,
    average: f32,
}

impl Whole {
    pub(super) fn new(facets: Microfacets) -> Self {
        let roughness = facets.widths().max_element().sqrt();
        let average = match facets.brush() {
            None => WHITE.average.at([roughness]),
            Some(_) => BRUSHED_AVERAGE.at([roughness, ratio_root(&facets)]),
        };
        Self { facets, average }
    }

    /// The albedo towards `w`.
    pub(super) fn albedo(&self, w: Vec3) -> f32 {
        let roughness = self.facets.widths().max_element().sqrt();
        let root = w.z.max(0.0).sqrt();
        let Some(brush) = self.facets.brush() else {
            return WHITE.albedo.at([roughness, root]);
        };
        let (along, across) = (w.truncate().dot(brush), w.truncate().perp_dot(brush));
        let quarter = across.abs().atan2(along.abs()) / std::f32::consts::FRAC_PI_2;
        BRUSHED.at([roughness, ratio_root(&self.facets), quarter, root])
    }

    /// The lobe of what facets send on to one another, over `cos / pi`, if they reflect all light
    /// (Kulla and Conty 2017): as bright as what is missing on the way in and on the way out.
    pub(super) fn missing(&self, wo: Vec3, wi: Vec3) -> f32 {
        let missing = |w| 1.0 - self.albedo(w);
        missing(wo) * missing(wi) / (1.0 - self.average).max(1e-6)
    }

    /// The colour of that lobe, where a facet reflects `once` on average.
    pub(super) fn further(&self, once: Rgb) -> Rgb {
        once * once * self.average / (Rgb::ONE - once * (1.0 - self.average))
    }
}

/// Root of the ratio of a brushed surface's widths.
fn ratio_root(facets: &Microfacets) -> f32 {
    let widths = facets.widths();
    (widths.min_element() / widths.max_element()).sqrt()
}

/// Facets whose reflectance is Schlick's, `f0` at normal incidence and `f90` at grazing angles.
#[derive(Clone, Copy, Debug)]
pub(super) struct Schlick {
    pub(super) f0: Rgb,
    pub(super) f90: Rgb,
}

impl Schlick {
    /// The reflectance of one facet.
    pub(super) fn at(&self, cos: f32) -> Rgb {
        self.f0 + (self.f90 - self.f0) * edge(cos)
    }

    /// The albedo of a smooth or rough surface for light that leaves under an angle of cosine `cos`.
    pub(super) fn albedo(&self, roughness: f32, cos: f32) -> Rgb {
        self.sum(|table| table.albedo.at([roughness, cos.max(0.0).sqrt()]))
    }

    /// Its average over the hemisphere.
    pub(super) fn average(&self, roughness: f32) -> Rgb {
        self.sum(|table| table.average.at([roughness]))
    }

    /// Albedos are linear in the reflectance.
    fn sum(&self, of: impl Fn(&Rough) -> f32) -> Rgb {
        self.f0 * of(&WHITE) + (self.f90 - self.f0) * of(&EDGE)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_grid_is_exact_where_the_function_is_linear_along_each_axis() {
        let f = |[x, y, z]: [f32; 3]| 1.0 + x - 2.0 * y * z + 3.0 * x * y * z;
        let grid = Grid::new([3, 2, 5], f);
        for i in 0..1000 {
            let x = [i % 10, i / 10 % 10, i / 100].map(|k| k as f32 / 9.0);
            assert!((grid.at(x) - f(x)).abs() < 1e-5, "{x:?}");
        }
        assert_eq!(grid.at([-1.0, 0.0, 0.0]), 1.0);
        assert_eq!(grid.at([2.0, 0.0, 0.0]), 2.0);
    }
}
