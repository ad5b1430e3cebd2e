//! What a CSG object costs as it grows: a block minus N spheres that fill a fifth of it, on one thread.
//!
//! `cargo bench --bench csg` prints a table; every figure is the median of interleaved rounds, with the least and
//! the greatest.

use std::hint::black_box;
use std::time::Instant;

use glam::{DAffine3, DVec3};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use solidtrace::accel::CsgTree;
use solidtrace::geometry::{Csg, CsgOp, Operand, Solid};
use solidtrace::math::{Ray, Transform};

const SIZES: [usize; 5] = [100, 1_000, 10_000, 100_000, 1_000_000];
/// Share of the block's volume that the spheres would have if none overlapped.
const FILL: f64 = 0.2;
const PIXELS: u32 = 256;
const ROUNDS: usize = 7;

fn at(p: DVec3) -> Transform {
    Transform::new(DAffine3::from_translation(p)).expect("a translation")
}

fn sphere(radius: f64) -> Operand {
    Operand::Solid(Solid::Sphere { radius })
}

/// The unit cube around the origin.
fn block(csg: &mut Csg) {
    let half = DVec3::splat(0.5);
    csg.push(
        Operand::Solid(Solid::Box { half }),
        &Transform::IDENTITY,
        0..1,
    );
}

/// The block minus `n` spheres: one operator.
fn swiss_cheese(n: usize) -> Csg {
    let mut rng = Pcg64Mcg::seed_from_u64(n as u64);
    let radius = (FILL / n as f64 * 0.75 / std::f64::consts::PI).cbrt();
    let mut csg = Csg::default();
    block(&mut csg);
    for _ in 0..n {
        let center = DVec3::from_array(std::array::from_fn(|_| rng.random_range(-0.5..0.5)));
        csg.push(sphere(radius), &at(center), 0..1);
    }
    csg.combine(CsgOp::Difference, n + 1);
    csg
}

/// The same solid as [`swiss_cheese`], written as one difference inside another, `n` deep.
fn nest(n: usize) -> Csg {
    let flat = swiss_cheese(n);
    let mut csg = Csg::default();
    block(&mut csg);
    for i in 1..=n as u32 {
        let (operand, transform) = flat.operand(i);
        csg.push(operand, &transform, 0..1);
        csg.combine(CsgOp::Difference, 2);
    }
    csg
}

/// One ray a pixel of a camera close enough that all rays meet the block.
fn camera() -> Vec<Ray> {
    let eye = DVec3::new(1.1, 0.9, 1.6);
    let forward = -eye.normalize();
    let right = forward.cross(DVec3::Y).normalize();
    let up = right.cross(forward);
    let scale = |i: u32| (f64::from(i) + 0.5) / f64::from(PIXELS) - 0.5;
    (0..PIXELS * PIXELS)
        .map(|i| {
            let (x, y) = (scale(i % PIXELS), scale(i / PIXELS));
            Ray::new(eye, (forward + 0.45 * (x * right + y * up)).normalize())
        })
        .collect()
}

/// Microseconds a call.
fn time(calls: usize, work: impl FnOnce()) -> f64 {
    let start = Instant::now();
    work();
    start.elapsed().as_secs_f64() * 1e6 / calls as f64
}

struct Subject {
    name: String,
    tree: CsgTree,
    build_seconds: f64,
    shadow: Vec<Ray>,
    closest: Vec<f64>,
    any: Vec<f64>,
}

impl Subject {
    fn new(name: String, csg: &Csg, camera: &[Ray]) -> Self {
        let start = Instant::now();
        let tree = CsgTree::build(csg, &[]).expect("the tree is whole");
        let build_seconds = start.elapsed().as_secs_f64();
        let light = DVec3::new(2.0, 3.0, 1.0);
        let lit = |ray: &Ray| {
            let origin = ray.at(tree.intersect(ray)?.t * (1.0 - 1e-9));
            Some(Ray {
                tmax: 1.0,
                ..Ray::new(origin, light - origin)
            })
        };
        Self {
            shadow: camera.iter().filter_map(lit).collect(),
            name,
            tree,
            build_seconds,
            closest: Vec::new(),
            any: Vec::new(),
        }
    }

    fn measure(&mut self, camera: &[Ray]) {
        let tree = &self.tree;
        self.closest.push(time(camera.len(), || {
            for ray in camera {
                black_box(tree.intersect(ray));
            }
        }));
        self.any.push(time(self.shadow.len(), || {
            for ray in &self.shadow {
                black_box(tree.occluded(ray));
            }
        }));
    }
}

/// Median, least and greatest.
fn spread(values: &mut [f64]) -> String {
    values.sort_by(f64::total_cmp);
    let median = values[values.len() / 2];
    format!(
        "{median:.2} ({:.2}-{:.2})",
        values[0],
        values[values.len() - 1]
    )
}

fn main() {
    let camera = camera();
    let mut subjects: Vec<Subject> = (SIZES.iter())
        .map(|&n| Subject::new(n.to_string(), &swiss_cheese(n), &camera))
        .collect();
    subjects.push(Subject::new("10,000 nested".into(), &nest(10_000), &camera));
    for _ in 0..ROUNDS {
        for subject in &mut subjects {
            subject.measure(&camera);
        }
    }
    println!("| spheres | build s | bytes an operand | closest hit us | any hit us |");
    println!("|---|---|---|---|---|");
    for subject in &mut subjects {
        let report = subject.tree.report();
        println!(
            "| {} | {:.2} | {} | {} | {} |",
            subject.name,
            subject.build_seconds,
            report.bytes / report.operands,
            spread(&mut subject.closest),
            spread(&mut subject.any),
        );
    }
}
