//! How much light lobes reflect in all from a direction, integrated once and looked up from then on.

use std::sync::LazyLock;

use glam::{Vec2, Vec3};

use crate::color::Rgb;
use crate::material::Fresnel;

use super::fresnel::{dielectric, edge};
use super::microfacet::Microfacets;

/// Albedos over roughness and the cosine of the direction, in layers.
pub(super) struct Table {
    /// By layer, roughness and the cosine's root.
    values: Vec<[[f32; COSINES]; ROUGHNESSES]>,
    /// Averages over the hemisphere, weighted by the cosine.
    averages: Vec<[f32; ROUGHNESSES]>,
}

const ROUGHNESSES: usize = 16;
/// Evenly spaced roots of the cosine: albedos bend most at grazing angles.
const COSINES: usize = 32;

impl Table {
    /// `albedos` gives all layers' albedos for a roughness and a cosine.
    pub(super) fn new(layers: usize, albedos: impl Fn(f32, f32) -> Vec<f32>) -> Self {
        let mut table = Self {
            values: vec![[[0.0; COSINES]; ROUGHNESSES]; layers],
            averages: vec![[0.0; ROUGHNESSES]; layers],
        };
        for r in 0..ROUGHNESSES {
            let roughness = r as f32 / (ROUGHNESSES - 1) as f32;
            for c in 0..COSINES {
                let root = c as f32 / (COSINES - 1) as f32;
                let found = albedos(roughness, (root * root).max(1e-4));
                for (layer, albedo) in found.into_iter().enumerate() {
                    table.values[layer][r][c] = albedo;
                }
            }
            for layer in 0..layers {
                let steps = 1024;
                let parts = (0..steps).map(|i| {
                    let cos = (i as f32 + 0.5) / steps as f32;
                    2.0 * cos * table.at(layer, roughness, cos) / steps as f32
                });
                table.averages[layer][r] = parts.sum();
            }
        }
        table
    }

    /// The albedo for light that leaves under an angle of cosine `cos`.
    pub(super) fn at(&self, layer: usize, roughness: f32, cos: f32) -> f32 {
        let rows = &self.values[layer];
        let along = |row: &[f32; COSINES]| between(row, cos.clamp(0.0, 1.0).sqrt());
        let (r, t) = place(ROUGHNESSES, roughness);
        let low = along(&rows[r]);
        if t == 0.0 {
            return low;
        }
        low + t * (along(&rows[r + 1]) - low)
    }

    /// Its average over the hemisphere.
    pub(super) fn average(&self, layer: usize, roughness: f32) -> f32 {
        between(&self.averages[layer], roughness)
    }
}

/// Index below `x` of 0..=1 among `count` even steps, and the rest.
fn place(count: usize, x: f32) -> (usize, f32) {
    let at = x.clamp(0.0, 1.0) * (count - 1) as f32;
    let i = (at as usize).min(count - 2);
    (i, at - i as f32)
}

fn between<const N: usize>(row: &[f32; N], x: f32) -> f32 {
    let (i, t) = place(N, x);
    row[i] + t * (row[i + 1] - row[i])
}

/// Of facets of width `alpha`, for each of the reflectances.
fn of_facets(alpha: f32, cos: f32, reflectances: &[impl Fn(f32) -> f32]) -> Vec<f32> {
    let Some(wo) = (alpha > 0.0).then(|| Vec3::new((1.0 - cos * cos).sqrt(), 0.0, cos)) else {
        return reflectances.iter().map(|f| f(cos)).collect();
    };
    const COUNT: usize = 512;
    let facets = Microfacets::isotropic(alpha);
    let mut sums = vec![0.0; reflectances.len()];
    for i in 0..COUNT {
        // The golden ratio's lattice.
        let u = (i as f32 + 0.5) / COUNT as f32;
        let v = (i as f32 * 0.618_034).fract();
        let Some(wi) = facets.reflect(wo, Vec2::new(u, v)) else {
            continue;
        };
        let once = facets.reflected(wo, wi);
        for (sum, reflectance) in sums.iter_mut().zip(reflectances) {
            *sum += reflectance(once.cos) * once.f_cos / once.pdf;
        }
    }
    sums.iter().map(|sum| sum / COUNT as f32).collect()
}

/// Layer 0: facets that reflect all light; 1: facets of Schlick's falloff. Any reflectance of Schlick's form is a sum of
/// the two.
static FACETS: LazyLock<Table> = LazyLock::new(|| {
    let reflectances: [fn(f32) -> f32; 2] = [|_| 1.0, edge];
    Table::new(2, |roughness, cos| {
        of_facets(roughness * roughness, cos, &reflectances)
    })
});

/// Reflection from the outside of a dielectric; layer `i` has the index `coat_ior(i)`.
static COATS: LazyLock<Table> = LazyLock::new(|| {
    let ior = |layer| {
        let root = layer as f32 * LARGEST_ROOT / (COATS_LAYERS - 1) as f32;
        (1.0 + root) / (1.0 - root)
    };
    let reflectance = |layer| move |cos: f32| dielectric(Fresnel::Exact, cos, ior(layer));
    let reflectances: Vec<_> = (0..COATS_LAYERS).map(reflectance).collect();
    Table::new(COATS_LAYERS, |roughness, cos| {
        of_facets(roughness * roughness, cos, &reflectances)
    })
});
const COATS_LAYERS: usize = 11;
/// Of the reflectance at normal incidence, for an index of 3. Layers are even in that root.
const LARGEST_ROOT: f32 = 0.5;

/// Reflection at a rough dielectric of index 1 to 3 from outside.
#[derive(Clone, Copy, Debug)]
pub(super) struct Coat {
    layer: usize,
    part: f32,
    roughness: f32,
}

impl Coat {
    pub(super) fn new(ior: f32, roughness: f32) -> Self {
        let root = (ior - 1.0) / (ior + 1.0);
        let (layer, part) = place(COATS_LAYERS, root / LARGEST_ROOT);
        Self {
            layer,
            part,
            roughness,
        }
    }

    /// For light that leaves under an angle of cosine `cos`.
    pub(super) fn albedo(&self, cos: f32) -> f32 {
        self.mix(|layer| COATS.at(layer, self.roughness, cos))
    }

    /// Its average over the hemisphere.
    pub(super) fn average(&self) -> f32 {
        self.mix(|layer| COATS.average(layer, self.roughness))
    }

    fn mix(&self, of: impl Fn(usize) -> f32) -> f32 {
        let low = of(self.layer);
        low + self.part * (of(self.layer + 1) - low)
    }
}

/// The albedo of facets: what comes off the surface after a single reflection.
#[derive(Clone, Copy, Debug)]
pub(super) struct Whole {
    pub(super) facets: Microfacets,
    average: f32,
}

impl Whole {
    pub(super) fn new(facets: Microfacets) -> Self {
        // Around the normal all directions count.
        let average = FACETS.average(0, facets.alpha(Vec3::Z).sqrt());
        Self { facets, average }
    }

    /// Of facets that reflect all light.
    pub(super) fn albedo(&self, w: Vec3) -> f32 {
        FACETS.at(0, self.facets.alpha(w).sqrt(), w.z)
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

/// The albedo of facets whose reflectance is Schlick's, `f0` at normal incidence and `f90` at grazing angles.
#[derive(Clone, Copy, Debug)]
pub(super) struct Schlick {
    pub(super) f0: Rgb,
    pub(super) f90: Rgb,
}

impl Schlick {
    /// Of one facet.
    pub(super) fn at(&self, cos: f32) -> Rgb {
        self.f0 + (self.f90 - self.f0) * edge(cos)
    }

    /// Of smooth or rough surfaces, for light that leaves under an angle of cosine `cos`.
    pub(super) fn albedo(&self, roughness: f32, cos: f32) -> Rgb {
        self.sum(|layer| FACETS.at(layer, roughness, cos))
    }

    /// Its average over the hemisphere.
    pub(super) fn average(&self, roughness: f32) -> Rgb {
        self.sum(|layer| FACETS.average(layer, roughness))
    }

    fn sum(&self, of: impl Fn(usize) -> f32) -> Rgb {
        self.f0 * of(0) + (self.f90 - self.f0) * of(1)
    }
}
