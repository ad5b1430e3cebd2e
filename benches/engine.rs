//! The ray engine for those who work on it: closest and any hit of each kernel, ray by ray and in batches, on a mesh
//! that fits into the caches and on one that does not; with Embree beside them where the feature `embree` is on.
//!
//! `cargo bench --bench engine` measures all; `-- scan:70k/bounce` what a name holds. `solidtrace bench` races against
//! more peers, interleaved.

use std::hint::black_box;
use std::time::Duration;

use criterion::measurement::WallTime;
use criterion::{BenchmarkGroup, Criterion, Throughput, criterion_group, criterion_main};
use solidtrace::accel::{Accel, AccelOptions, Kernel};
use solidtrace::bench::{RayKind, RaySets, Subject};
use solidtrace::io::bare_scene;
use solidtrace::math::Ray;
use solidtrace::scene::generated;

/// Rays of each kind: every so many of a picture's.
const RAYS: usize = 32_768;

fn engine(criterion: &mut Criterion) {
    for name in ["scan:70k", "sphere:2M"] {
        let model = generated(name).expect("a name").expect("a count");
        let scene = bare_scene(model, false).expect("something to see");
        let subject = Subject::of_scene(scene).expect("a sound mesh");
        let accels = Kernel::available().into_iter().map(|kernel| {
            let options = AccelOptions {
                kernel,
                ..AccelOptions::default()
            };
            let accel = Accel::build_with(&subject.meshes, &[], subject.placed(), options);
            (kernel, accel.expect("the mesh is sound"))
        });
        let accels: Vec<_> = accels.collect();
        let sets =
            RaySets::new(&subject, &accels[0].1, (512, 512)).expect("the camera sees the mesh");
        for kind in RayKind::ALL {
            let rays: Vec<Ray> = thinned(sets.of(kind));
            let mut group = criterion.benchmark_group(format!("{name}/{}", kind.name()));
            group.throughput(Throughput::Elements(rays.len() as u64));
            for (kernel, accel) in &accels {
                ours(&mut group, kernel.name(), accel, &rays, kind.any_hit());
            }
            embree(&mut group, &subject, &rays, kind.any_hit());
        }
    }
}

/// About [`RAYS`] of them, whole tiles of 64.
fn thinned(rays: &[Ray]) -> Vec<Ray> {
    let step = (rays.len() / RAYS).max(1);
    rays.chunks(64).step_by(step).flatten().copied().collect()
}

fn ours(
    group: &mut BenchmarkGroup<WallTime>,
    kernel: &str,
    accel: &Accel,
    rays: &[Ray],
    any: bool,
) {
    group.bench_function(format!("single {kernel}"), |bencher| {
        if any {
            bencher.iter(|| rays.iter().filter(|ray| accel.occluded(ray)).count());
        } else {
            bencher.iter(|| rays.iter().filter_map(|ray| accel.intersect(ray)).count());
        }
    });
    let (mut hits, mut blocked) = (vec![None; rays.len()], vec![false; rays.len()]);
    group.bench_function(format!("batch {kernel}"), |bencher| {
        if any {
            bencher.iter(|| accel.occluded_batch(rays, black_box(&mut blocked)));
        } else {
            bencher.iter(|| accel.intersect_batch(rays, black_box(&mut hits)));
        }
    });
}

#[cfg(feature = "embree")]
fn embree(group: &mut BenchmarkGroup<WallTime>, subject: &Subject, rays: &[Ray], any: bool) {
    use solidtrace::embree::{EmbreeOptions, EmbreeRay, EmbreeScene};
    use solidtrace::math::Transform;

    let meshes = [(&subject.meshes[0], &Transform::IDENTITY)];
    let scene = EmbreeScene::new(&meshes, EmbreeOptions::default()).expect("the mesh is sound");
    let rays: Vec<EmbreeRay> = rays.iter().map(EmbreeRay::new).collect();
    let (mut distances, mut blocked) = (vec![0.0; rays.len()], vec![false; rays.len()]);
    group.bench_function("embree", |bencher| {
        if any {
            bencher.iter(|| scene.occluded_all(&rays, black_box(&mut blocked)));
        } else {
            bencher.iter(|| scene.intersect_all(&rays, black_box(&mut distances)));
        }
    });
}

#[cfg(not(feature = "embree"))]
fn embree(_: &mut BenchmarkGroup<WallTime>, _: &Subject, _: &[Ray], _: bool) {}

criterion_group! {
    name = benches;
    config = Criterion::default()
        .sample_size(10)
        .warm_up_time(Duration::from_millis(200))
        .measurement_time(Duration::from_secs(1));
    targets = engine
}
criterion_main!(benches);
