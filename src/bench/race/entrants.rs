use std::sync::Arc;
use std::time::{Duration, Instant};

use ::obvhs::bvh2::Bvh2;
use ::obvhs::cwbvh::CwBvh;
use rayon::ThreadPool;

use crate::accel::{Accel, AccelOptions, Kernel, Quality};
use crate::bench::{RayKind, Subject};
use crate::embree::{EmbreeOptions, EmbreeScene};
use crate::error::Result;

use super::bvh::BvhCrate;
use super::embree::{Embree, EmbreePackets, scene};
use super::engine::{Engine, Racer};
use super::memory::peak_of;
use super::obvhs::Obvhs;
use super::ours::{Batch, Single};
use super::parry::Parry;

/// An engine at the start.
pub(super) struct Entrant {
    pub name: String,
    /// The rays that it is asked.
    pub kinds: &'static [RayKind],
    pub racer: Box<dyn Racer>,
}

/// What building a tree took, from triangles in memory to a tree that answers.
#[derive(Clone, Debug, PartialEq)]
pub struct Build {
    /// Of the engine, and how it built.
    pub engine: String,
    /// Median of three builds, or the time of one that takes long.
    pub seconds: f64,
    /// Of the tree with its own copy of the triangles, where the engine tells.
    pub bytes_per_triangle: Option<f64>,
    /// By how much the program grew at most while it was built, where the system tells: of the first build alone, as
    /// later ones find memory that earlier ones gave back.
    pub peak_bytes_per_triangle: Option<f64>,
}

/// A tree with what it took.
struct Built<T> {
    tree: T,
    time: Duration,
    bytes: Option<usize>,
}

/// All engines, ready to race.
pub(super) struct Field<'a> {
    pub entrants: Vec<Entrant>,
    pub builds: Vec<Build>,
    pub notes: Vec<String>,
    /// Ours, to aim rays with.
    pub accel: Arc<Accel>,
    pool: &'a ThreadPool,
    tell: &'a dyn Fn(&str),
}

/// Copies of all instances beyond this many triangles do not race.
const MOST_FLAT: usize = 5_000_000;

/// Builds shorter than this are repeated.
const SHORT: Duration = Duration::from_millis(500);

impl<'a> Field<'a> {
    pub(super) fn build(
        subject: &Subject,
        pool: &'a ThreadPool,
        tell: &'a dyn Fn(&str),
    ) -> Result<Self> {
        let mut field = Self {
            entrants: Vec::new(),
            builds: Vec::new(),
            notes: Vec::new(),
            accel: Arc::new(Accel::build(&[], &[], Vec::new())?),
            pool,
            tell,
        };
        field.enter_ours(subject)?;
        field.enter_embree(subject)?;
        field.enter_flat(subject)?;
        Ok(field)
    }

    fn enter_ours(&mut self, subject: &Subject) -> Result<()> {
        let triangles = subject.triangles();
        for (name, quality) in [
            ("ours-balanced", Quality::Balanced),
            ("ours-fast", Quality::Fast),
            ("ours-best", Quality::Best),
        ] {
            let kernel = Kernel::default();
            let options = AccelOptions { quality, kernel };
            let tree = self.timed(name, triangles, || ours(subject, options))?;
            if quality == Quality::default() {
                self.accel = Arc::new(tree);
            }
        }
        self.enter("single", Single(self.accel.clone()));
        self.enter("batch", Batch(self.accel.clone()));
        for kernel in Kernel::available().into_iter().rev() {
            if kernel == Kernel::default() {
                continue;
            }
            let options = AccelOptions {
                kernel,
                ..AccelOptions::default()
            };
            let accel = Arc::new(ours(subject, options)?.tree);
            if kernel == Kernel::Portable {
                self.enter("portable", Single(accel));
            } else {
                self.enter(&format!("single-{}", kernel.name()), Single(accel.clone()));
                self.enter(&format!("batch-{}", kernel.name()), Batch(accel));
            }
        }
        Ok(())
    }

    fn enter_embree(&mut self, subject: &Subject) -> Result<()> {
        let medium = EmbreeOptions {
            threads: self.pool.current_num_threads(),
            ..EmbreeOptions::default()
        };
        let robust = EmbreeOptions {
            robust: true,
            ..medium
        };
        let high = EmbreeOptions {
            high_quality: true,
            ..medium
        };
        let avx2 = EmbreeOptions {
            avx2: true,
            ..medium
        };
        let triangles = subject.triangles();
        let mut timed = |name, options| {
            let scene = self.timed(name, triangles, || embree(subject, options));
            scene.map(Arc::new)
        };
        let scene = timed("embree-medium", medium)?;
        let high = timed("embree-high", high)?;
        let robust = Arc::new(embree(subject, robust)?.tree);
        self.enter("embree", Embree(scene.clone()));
        self.enter("embree-robust", Embree(robust));
        self.enter("embree-high", Embree(high));
        #[cfg(target_arch = "x86_64")]
        if std::arch::is_x86_feature_detected!("avx2") {
            self.enter("embree-avx2", Embree(Arc::new(embree(subject, avx2)?.tree)));
        }
        self.enter("embree-packet", EmbreePackets(scene));
        if let Some(packets) = self.entrants.last_mut() {
            packets.kinds = &[RayKind::Camera, RayKind::Shadow];
        }
        Ok(())
    }

    /// The peers without instances.
    fn enter_flat(&mut self, subject: &Subject) -> Result<()> {
        let triangles = subject.placed_triangles();
        if triangles > MOST_FLAT && subject.is_instanced() {
            self.notes.push(format!(
                "obvhs, bvh and parry3d have no instances and stay out: a copy of all would be {triangles} triangles"
            ));
            return Ok(());
        }
        if subject.is_instanced() {
            self.notes.push(format!(
                "obvhs, bvh and parry3d have no instances: they get a copy of all, {triangles} triangles"
            ));
        }
        let flat = subject.flat();
        let bvh2 = || {
            clocked(
                || Ok(Obvhs::<Bvh2>::build(&flat)),
                |tree| Some(tree.bytes()),
            )
        };
        let bvh2 = self.timed("obvhs-bvh2", triangles, bvh2)?;
        self.enter("obvhs-bvh2", bvh2);
        let cwbvh = || {
            clocked(
                || Ok(Obvhs::<CwBvh>::build(&flat)),
                |tree| Some(tree.bytes()),
            )
        };
        let cwbvh = self.timed("obvhs-cwbvh", triangles, cwbvh)?;
        self.enter("obvhs-cwbvh", cwbvh);
        let bvh = || clocked(|| Ok(BvhCrate::build(&flat)), |tree| Some(tree.bytes()));
        let bvh = self.timed("bvh", triangles, bvh)?;
        self.enter("bvh", bvh);
        let parry = self.timed("parry3d", triangles, || {
            clocked(|| Parry::build(&flat), |_| None)
        })?;
        self.enter("parry3d", parry);
        Ok(())
    }

    fn enter(&mut self, name: &str, engine: impl Engine + 'static) {
        self.entrants.push(Entrant {
            name: name.to_owned(),
            kinds: &RayKind::ALL,
            racer: Box::new(engine),
        });
    }

    /// Builds a tree over so many triangles, a few times if that is quickly done, on the threads of the race.
    fn timed<T: Send>(
        &mut self,
        name: &str,
        triangles: usize,
        build: impl Fn() -> Result<Built<T>> + Sync,
    ) -> Result<T> {
        (self.tell)(&format!("building {name}"));
        let (first, peak) = peak_of(|| self.pool.install(&build));
        let peak = peak.filter(|_| self.builds.is_empty());
        let mut built = first?;
        let mut times = vec![built.time];
        if built.time < SHORT {
            for _ in 0..2 {
                drop(built);
                built = self.pool.install(&build)?;
                times.push(built.time);
            }
        }
        times.sort_unstable();
        let a_triangle = |bytes: usize| bytes as f64 / triangles as f64;
        self.builds.push(Build {
            engine: name.to_owned(),
            seconds: times[times.len() / 2].as_secs_f64(),
            bytes_per_triangle: built.bytes.map(a_triangle),
            peak_bytes_per_triangle: peak.map(a_triangle),
        });
        Ok(built.tree)
    }
}

fn ours(subject: &Subject, options: AccelOptions) -> Result<Built<Accel>> {
    let build = || Accel::build_with(&subject.meshes, &[], subject.placed(), options);
    clocked(build, |tree| {
        Some(tree.mesh_reports().map(|mesh| mesh.bytes).sum())
    })
}

/// Only what Embree does itself counts, without the copy of triangles into its buffers.
fn embree(subject: &Subject, options: EmbreeOptions) -> Result<Built<EmbreeScene>> {
    let tree = scene(subject, options)?;
    let report = tree.report();
    Ok(Built {
        tree,
        time: report.time,
        bytes: Some(report.bytes),
    })
}

fn clocked<T>(
    build: impl FnOnce() -> Result<T>,
    bytes: impl FnOnce(&T) -> Option<usize>,
) -> Result<Built<T>> {
    let start = Instant::now();
    let tree = build()?;
    let time = start.elapsed();
    Ok(Built {
        bytes: bytes(&tree),
        tree,
        time,
    })
}
