use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::Instant;

use clap::Args;
use rayon::prelude::*;

use crate::error::Result;
use crate::geometry::Shape;
use crate::io::{
    HitRecord, RayReader, check_writable, write_atomically, write_blocked, write_hit_header,
    write_hits,
};
use crate::math::Ray;
use crate::world::World;

use super::{InputArgs, grouped, warn};

#[derive(Args)]
pub(super) struct TraceArgs {
    #[command(flatten)]
    input: InputArgs,
    /// CSV with the columns ox,oy,oz,dx,dy,dz and optionally tmin,tmax
    rays: PathBuf,
    /// CSV to write, one line a ray in the same order [default: stdout]
    #[arg(short, long, value_name = "HITS.csv")]
    output: Option<PathBuf>,
    /// Only tell whether anything is hit
    #[arg(long)]
    any: bool,
    /// Replace a file that exists
    #[arg(long)]
    force: bool,
}

/// Rays read, traced and written together.
const CHUNK: usize = 1 << 16;

pub(super) fn run(args: &TraceArgs) -> Result<()> {
    if let Some(path) = &args.output {
        check_writable(path, args.force)?;
    }
    let scene = args.input.read()?;
    warn(&scene.warnings);
    let world = args.input.build(scene)?;
    let start = Instant::now();
    let count = match &args.output {
        Some(path) => {
            // An error in a late line must leave an old file alone: write all or nothing.
            let mut bytes = Vec::new();
            let count = trace(&world, &args.rays, args.any, &mut bytes)?;
            write_atomically(path, &bytes, args.force)?;
            count
        }
        None => trace(&world, &args.rays, args.any, &mut std::io::stdout().lock())?,
    };
    eprintln!(
        "{} rays answered in {:.2} s",
        grouped(count),
        start.elapsed().as_secs_f64()
    );
    Ok(())
}

fn trace(world: &World, rays: &Path, any: bool, out: &mut dyn Write) -> Result<u64> {
    let mut reader = RayReader::open(rays)?;
    let mut count = 0;
    write_hit_header(out)?;
    loop {
        let rays = reader.read(CHUNK)?;
        if rays.is_empty() {
            return Ok(count);
        }
        count += rays.len() as u64;
        if any {
            let blocked: Vec<bool> = rays.par_iter().map(|ray| world.occluded(ray)).collect();
            write_blocked(out, &blocked)?;
        } else {
            let hits: Vec<_> = rays.par_iter().map(|ray| answer(world, ray)).collect();
            write_hits(out, &hits)?;
        }
    }
}

fn answer(world: &World, ray: &Ray) -> Option<HitRecord> {
    let hit = world.intersect(ray)?;
    let point = world.surface(ray, &hit);
    let instance = world.instance(&hit);
    let outward = point.ng.as_dvec3();
    let is_mesh = matches!(instance.shape, Shape::Mesh(_));
    let is_surface = is_mesh || matches!(instance.shape, Shape::Solid(solid) if solid.is_surface());
    let n = if is_surface && outward.dot(ray.direction) > 0.0 {
        -outward
    } else {
        outward
    };
    Some(HitRecord {
        t: hit.t,
        p: point.p,
        n,
        uv: if is_mesh { hit.uv } else { point.texture.uv }.to_array(),
        object: (instance.name.clone()).unwrap_or_else(|| hit.instance.to_string()),
        primitive: hit.primitive,
        material: world.material(&point).name.clone(),
    })
}
