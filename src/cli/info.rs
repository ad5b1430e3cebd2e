use clap::Args;
use serde_json::json;

use crate::accel::{CsgReport, MeshReport};
use crate::error::{Place, Result};
use crate::geometry::{Shape, Solid};
use crate::scene::Scene;
use crate::world::World;

use super::{InputArgs, csg_name, csgs, grouped, size_text, warn};

#[derive(Args)]
pub(super) struct InfoArgs {
    #[command(flatten)]
    input: InputArgs,
    /// Print one JSON object
    #[arg(long)]
    json: bool,
}

/// What there is to tell.
struct Summary {
    instances: usize,
    mesh_instances: usize,
    solids: usize,
    planes: usize,
    csg_instances: usize,
    mesh: MeshReport,
    csgs: Vec<CsgSummary>,
    bounds: Option<[[f64; 3]; 2]>,
}

/// One CSG object.
struct CsgSummary {
    name: String,
    report: CsgReport,
    coincident: usize,
    empty: bool,
}

pub(super) fn run(args: &InfoArgs) -> Result<()> {
    let scene = args.input.read()?;
    let world = World::build(scene).map_err(|e| e.at(Place::file(&args.input.input)))?;
    let summary = Summary::of(&world);
    if args.json {
        println!("{}", summary.json(&world));
    } else {
        warn(&world.scene().warnings);
        print!("{}", summary.text(&world));
    }
    Ok(())
}

impl Summary {
    fn of(world: &World) -> Self {
        let scene = world.scene();
        let shapes = || scene.instances.iter().map(|i| i.shape);
        let planes = shapes()
            .filter(|s| *s == Shape::Solid(Solid::Plane))
            .count();
        let meshes = shapes().filter(|s| matches!(s, Shape::Mesh(_))).count();
        let csg_instances = shapes().filter(|s| matches!(s, Shape::Csg(_))).count();
        let bounds = world.bounds();
        let csgs = csgs(scene).map(|id| {
            let csg = world.csg(id);
            CsgSummary {
                name: csg_name(scene, id),
                report: csg.report(),
                coincident: csg.coincident_faces(),
                empty: csg.bounds().is_empty(),
            }
        });
        Self {
            instances: scene.instances.len(),
            mesh_instances: meshes,
            solids: scene.instances.len() - meshes - planes - csg_instances,
            planes,
            csg_instances,
            csgs: csgs.collect(),
            mesh: world.mesh_report(),
            bounds: (!bounds.is_empty()).then(|| [bounds.min.to_array(), bounds.max.to_array()]),
        }
    }

    fn json(&self, world: &World) -> serde_json::Value {
        let scene = world.scene();
        json!({
            "instances": self.instances,
            "mesh_instances": self.mesh_instances,
            "solids": self.solids,
            "planes": self.planes,
            "csg_instances": self.csg_instances,
            "csg_objects": self.csgs.iter().map(CsgSummary::json).collect::<Vec<_>>(),
            "meshes": scene.meshes.len(),
            "vertices": vertices(scene),
            "triangles": self.mesh.triangles,
            "degenerate_triangles": self.mesh.degenerate,
            "duplicate_triangles": self.mesh.duplicate,
            "tree_bytes": self.mesh.bytes,
            "materials": scene.materials.iter().map(|m| &m.name).collect::<Vec<_>>(),
            "cameras": scene.cameras.len(),
            "lights": world.lights().lights().len(),
            "bounds": self.bounds,
            "size": [scene.film.size.0, scene.film.size.1],
            "spp": scene.film.spp,
            "warnings": scene.warnings,
        })
    }

    fn text(&self, world: &World) -> String {
        let scene = world.scene();
        let n = |count: usize| grouped(count as u64);
        let mut lines = vec![
            format!(
                "objects    {} ({} meshes, {} solids, {} planes, {} of CSG)",
                n(self.instances),
                n(self.mesh_instances),
                n(self.solids),
                n(self.planes),
                n(self.csg_instances)
            ),
            format!(
                "triangles  {} of {} meshes, {} vertices",
                n(self.mesh.triangles),
                n(scene.meshes.len()),
                n(vertices(scene))
            ),
        ];
        if self.mesh.degenerate + self.mesh.duplicate > 0 {
            lines.push(format!(
                "left out   {} triangles without area, {} duplicates",
                n(self.mesh.degenerate),
                n(self.mesh.duplicate)
            ));
        }
        lines.push(format!("trees      {}", size_text(self.mesh.bytes)));
        lines.extend(self.csgs.iter().map(CsgSummary::text));
        let names: Vec<&str> = scene.materials.iter().map(|m| m.name.as_str()).collect();
        lines.push(format!("materials  {} ({})", names.len(), names.join(", ")));
        lines.push(format!("lights     {}", n(world.lights().lights().len())));
        lines.push(format!("cameras    {}", n(scene.cameras.len())));
        if let Some([min, max]) = self.bounds {
            lines.push(format!("bounds     {min:?} to {max:?}"));
        }
        let (w, h) = scene.film.size;
        lines.push(format!("picture    {w}x{h}, {} spp", scene.film.spp));
        lines.join("\n") + "\n"
    }
}

impl CsgSummary {
    fn json(&self) -> serde_json::Value {
        json!({
            "name": self.name.trim_matches('`'),
            "operands": self.report.operands,
            "dropped_operands": self.report.dropped,
            "operators": self.report.operators,
            "operators_flattened": self.report.flattened,
            "depth": self.report.depth,
            "coincident_faces": self.coincident,
            "empty": self.empty,
            "bytes": self.report.bytes,
        })
    }

    fn text(&self) -> String {
        let n = |count: usize| grouped(count as u64);
        let CsgReport {
            operands,
            dropped,
            operators,
            flattened,
            depth,
            bytes,
        } = self.report;
        let mut notes = vec![format!(
            "csg        {}: {} operands, {} operators (flattened {}), depth {}, {}",
            self.name,
            n(operands),
            n(operators),
            n(flattened),
            n(depth),
            size_text(bytes)
        )];
        if self.empty {
            notes.push("nothing is left of it".to_owned());
        } else if dropped > 0 {
            notes.push(format!("{} operands dropped as empty", n(dropped)));
        }
        if self.coincident > 0 {
            notes.push(format!(
                "note: {} pairs of coincident faces",
                n(self.coincident)
            ));
        }
        notes.join("; ")
    }
}

fn vertices(scene: &Scene) -> usize {
    scene.meshes.iter().map(|mesh| mesh.positions.len()).sum()
}
