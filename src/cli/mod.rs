//! The command line, one file a subcommand. Messages go to stderr; stdout carries what was asked for.

#[cfg(feature = "bench")]
mod bench;
#[cfg(feature = "embree")]
mod check;
mod info;
mod progress;
mod render;
#[cfg(feature = "embree")]
mod table;
mod trace;
mod values;

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::{Args, Parser, Subcommand, ValueEnum};

#[cfg(not(feature = "bench"))]
use crate::error::Error;
use crate::error::{ErrorKind, Place, Result};
use crate::geometry::{CsgId, Shape};
use crate::io::{OpenMeshOperands, ReadOptions, bare_scene, read_scene};
use crate::scene::{Scene, generated};
use crate::world::World;

/// Renders triangle meshes and exact analytic solids.
#[derive(Parser)]
#[command(name = "solidtrace", version, arg_required_else_help = true)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Render a scene or model to EXR and PNG
    Render(Box<render::RenderArgs>),
    /// Trace the rays of a CSV file and write their hits as CSV
    Trace(trace::TraceArgs),
    /// Compare ray hits with Embree's and judge every difference
    #[cfg(feature = "embree")]
    Check(check::CheckArgs),
    /// Compare ray hits with Embree's and judge every difference (not in this build)
    #[cfg(not(feature = "embree"))]
    #[command(disable_help_flag = true)]
    Check(LeftOut),
    /// Show what a scene or model holds
    Info(info::InfoArgs),
    /// Race the ray engine against its peers over a scene's meshes
    #[cfg(feature = "bench")]
    Bench(bench::BenchArgs),
    /// Race the ray engine against its peers (not in this build)
    #[cfg(not(feature = "bench"))]
    #[command(disable_help_flag = true)]
    Bench(LeftOut),
}

/// What follows the name of a command that this build does not have.
#[cfg(not(feature = "bench"))]
#[derive(Args)]
struct LeftOut {
    #[arg(trailing_var_arg = true, allow_hyphen_values = true, hide = true)]
    _args: Vec<std::ffi::OsString>,
}

#[cfg(not(feature = "bench"))]
impl LeftOut {
    fn error(feature: &str) -> Error {
        let build = "tests/with-embree.sh cargo build --release --features";
        Error::new(
            ErrorKind::Usage,
            "this command is not in this build, which has no Embree",
        )
        .help(format!("build with `{build} {feature}`"))
    }
}

/// What every subcommand reads.
#[derive(Args)]
struct InputArgs {
    /// A scene (.ron, .json), a model (.obj, .gltf, .glb), or a generated one: scan:70k, sphere:2M or slivers:100k of
    /// about so many triangles, instances:1000
    input: PathBuf,
    /// Let the scene use files of this folder too; may be repeated
    #[arg(long, value_name = "DIR")]
    allow_path: Vec<PathBuf>,
    /// What to do with a mesh that CSG needs the inside of and that has holes
    #[arg(long, value_enum, default_value = "refuse")]
    open_mesh_operands: OpenMeshName,
}

#[derive(Clone, Copy, ValueEnum)]
enum OpenMeshName {
    /// It is an error
    Refuse,
    /// Inside is where it winds around a point, with a warning
    Winding,
}

impl InputArgs {
    fn read(&self) -> Result<Scene> {
        let name = self.input.to_str().filter(|_| !self.input.exists());
        if let Some(model) = name.and_then(generated) {
            return bare_scene(model?, false);
        }
        let options = ReadOptions {
            allow_paths: self.allow_path.clone(),
            open_mesh_operands: match self.open_mesh_operands {
                OpenMeshName::Refuse => OpenMeshOperands::Refuse,
                OpenMeshName::Winding => OpenMeshOperands::Winding,
            },
        };
        read_scene(&self.input, &options)
    }

    /// Builds the trees; errors and warnings of which nobody knows the file are the input's.
    fn build(&self, scene: Scene) -> Result<World> {
        let world = World::build(scene).map_err(|e| e.at(Place::file(&self.input)))?;
        let report = world.mesh_report();
        if report.degenerate + report.duplicate > 0 {
            eprintln!(
                "note: {} triangles without area and {} duplicates were left out",
                grouped(report.degenerate as u64),
                grouped(report.duplicate as u64)
            );
        }
        for id in csgs(world.scene()) {
            if world.csg(id).bounds().is_empty() {
                let name = csg_name(world.scene(), id);
                eprintln!("warning: nothing is left of the CSG object {name}");
            }
        }
        Ok(world)
    }
}

/// The scene's CSG objects.
fn csgs(scene: &Scene) -> impl Iterator<Item = CsgId> {
    (0..scene.csgs.len() as u32).map(CsgId)
}

/// The name of the first named instance that places a CSG object, or else its number.
fn csg_name(scene: &Scene, id: CsgId) -> String {
    let mut users = (scene.instances.iter()).filter(|i| i.shape == Shape::Csg(id));
    let name = users.find_map(|instance| instance.name.as_deref());
    name.map_or_else(
        || format!("number {}", id.0 + 1),
        |name| format!("`{name}`"),
    )
}

/// Exit code of a run that Ctrl-C ended.
const INTERRUPTED: u8 = 130;

/// Parses the arguments, runs the command, prints its error. Exit codes: 0 done, 1 an error, 2 wrong
/// usage, 130 interrupted.
pub fn run() -> ExitCode {
    let outcome = match Cli::parse().command {
        Command::Render(args) => render::run(&args),
        Command::Trace(args) => trace::run(&args).map(|()| ExitCode::SUCCESS),
        #[cfg(feature = "embree")]
        Command::Check(args) => check::run(&args),
        #[cfg(not(feature = "embree"))]
        Command::Check(_) => Err(LeftOut::error("embree")),
        Command::Info(args) => info::run(&args).map(|()| ExitCode::SUCCESS),
        #[cfg(feature = "bench")]
        Command::Bench(args) => bench::run(&args).map(|()| ExitCode::SUCCESS),
        #[cfg(not(feature = "bench"))]
        Command::Bench(_) => Err(LeftOut::error("bench")),
    };
    outcome.unwrap_or_else(|error| {
        eprintln!("error: {error}");
        ExitCode::from(if error.kind() == ErrorKind::Usage {
            2
        } else {
            1
        })
    })
}

fn is_png(path: &Path) -> bool {
    path.extension()
        .is_some_and(|e| e.eq_ignore_ascii_case("png"))
}

fn warn(warnings: &[String]) {
    for warning in warnings {
        eprintln!("warning: {warning}");
    }
}

/// `1234567` as `1,234,567`.
fn grouped(n: u64) -> String {
    let digits = n.to_string();
    let mut out = String::with_capacity(digits.len() * 4 / 3);
    for (i, c) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            out.push(',');
        }
        out.push(c);
    }
    out
}

/// Bytes in the largest unit that keeps a digit before the point.
fn size_text(bytes: usize) -> String {
    let (mut value, mut unit) = (bytes as f64, "B");
    for next in ["KiB", "MiB", "GiB"] {
        if value < 1024.0 {
            break;
        }
        (value, unit) = (value / 1024.0, next);
    }
    if unit == "B" {
        format!("{bytes} B")
    } else {
        format!("{value:.1} {unit}")
    }
}
