//! A plate with N holes that fills the picture, rendered by POV-Ray and by solidtrace: 512x512, one light with
//! shadows, two threads.
//!
//! `cargo bench --bench povray [-- N ...]` (squares; 100, 1,024 and 10,000 where none is given) writes the same scene
//! for both into a temporary folder, times whole commands, and compares the pictures. It needs `povray` 3.7.

use std::fmt::Write;
use std::path::Path;
use std::process::{Command, ExitCode, Stdio};
use std::time::Instant;

use tempfile::TempDir;

/// Our command is timed this often; POV-Ray's once, or as often as fits into some seconds.
const ROUNDS: usize = 5;
/// Pixels further apart than this, in 256 steps, differ.
const APART: u8 = 3;

/// The plate is a square of this edge around the origin.
const EDGE: f64 = 4.0;
/// The light is so far away that its distance does not vary over the plate: POV-Ray's does not fall off.
const LIGHT: [f64; 3] = [-6e4, 1e5, 4e4];

fn solidtrace_scene(rows: u32) -> String {
    let (step, radius, start) = holes(rows);
    let [x, y, z] = LIGHT;
    let intensity = std::f64::consts::PI * (x * x + y * y + z * z);
    format!(
        r#"Scene(
    film: (size: (512, 512), spp: 1, filter: Box(radius: 0.001)),
    camera: Perspective(eye: (0, 6, 3.5), look_at: (0, 0, 0), vfov: 27),
    integrator: Whitted(max_depth: 1),
    environment: Constant(color: (0, 0, 0)),
    materials: {{ "plate": Diffuse(color: (0.8, 0.6, 0.3)), "floor": Diffuse(color: (0.4, 0.4, 0.5)) }},
    lights: [ Point(position: ({x}, {y}, {z}), intensity: ({intensity}, {intensity}, {intensity})) ],
    objects: [
        Plane(point: (0, -0.6, 0), normal: (0, 1, 0), material: "floor"),
        Difference(
            from: Box(size: ({EDGE}, 0.2, {EDGE})),
            subtract: [Repeat(count: ({rows}, 1, {rows}), step: (({step}, 0, 0), (0, 1, 0), (0, 0, {step})),
                of: Cylinder(from: ({start}, -0.2, {start}), to: ({start}, 0.2, {start}), radius: {radius}))],
            material: "plate",
        ),
    ],
)
"#
    )
}

fn povray_scene(rows: u32) -> String {
    let (step, radius, start) = holes(rows);
    let [x, y, z] = LIGHT;
    let half = 0.5 * EDGE;
    // A left-handed world: z is mirrored.
    let mut text = format!(
        "#version 3.7; global_settings {{ assumed_gamma 1 }}\n\
         camera {{ perspective location <0, 6, -3.5> up y right x look_at 0 angle 27 }}\n\
         light_source {{ <{x}, {y}, {}> rgb 1 }}\n\
         plane {{ y, -0.6 pigment {{ rgb <0.4, 0.4, 0.5> }} finish {{ ambient 0 diffuse 1 }} }}\n\
         difference {{ box {{ <-{half}, -0.1, -{half}>, <{half}, 0.1, {half}> }}\n",
        -z
    );
    for i in 0..rows * rows {
        let (x, z) = (
            start + step * f64::from(i % rows),
            start + step * f64::from(i / rows),
        );
        writeln!(
            text,
            "cylinder {{ <{x}, -0.2, {z}>, <{x}, 0.2, {z}>, {radius} }}"
        )
        .expect("a string takes all");
    }
    text + "pigment { rgb <0.8, 0.6, 0.3> } finish { ambient 0 diffuse 1 } }\n"
}

/// From one hole to the next, the holes' radius, and the place of the first in both directions.
fn holes(rows: u32) -> (f64, f64, f64) {
    let step = EDGE / f64::from(rows);
    (step, 0.35 * step, 0.5 * (step - EDGE))
}

/// Seconds that the command takes.
fn time(command: &mut Command) -> f64 {
    let start = Instant::now();
    let status = command.stdout(Stdio::null()).stderr(Stdio::null()).status();
    assert!(status.is_ok_and(|s| s.success()), "{command:?} failed");
    start.elapsed().as_secs_f64()
}

fn median(values: &mut [f64]) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

/// The share of pixels that differ, in per cent. Both look through the middle of each.
fn difference(ours: &Path, theirs: &Path) -> f64 {
    let [ours, theirs] = [ours, theirs].map(|path| image::open(path).expect("a picture").to_rgb8());
    assert_eq!(ours.dimensions(), theirs.dimensions());
    let apart = |(a, b): &(&image::Rgb<u8>, &image::Rgb<u8>)| {
        (a.0.iter().zip(b.0)).any(|(&a, b)| a.abs_diff(b) > APART)
    };
    let differing = ours.pixels().zip(theirs.pixels()).filter(apart).count();
    100.0 * differing as f64 / f64::from(ours.width() * ours.height())
}

fn main() -> ExitCode {
    if Command::new("povray").arg("--version").output().is_err() {
        eprintln!("povray is not installed");
        return ExitCode::FAILURE;
    }
    let given: Vec<u32> = std::env::args()
        .filter_map(|arg| arg.parse().ok())
        .collect();
    let counts = if given.is_empty() {
        vec![100, 1_024, 10_000]
    } else {
        given
    };
    let folder = TempDir::new().expect("a temporary folder");
    let file = |name: &str| folder.path().join(name);
    println!("| holes | POV-Ray s | solidtrace s | ratio | pixels that differ |");
    println!("|---|---|---|---|---|");
    for count in counts {
        let rows = count.isqrt();
        std::fs::write(file("plate.ron"), solidtrace_scene(rows)).expect("the scene is written");
        std::fs::write(file("plate.pov"), povray_scene(rows)).expect("the scene is written");
        let mut ours = Vec::new();
        let mut theirs = Vec::new();
        for _ in 0..ROUNDS {
            if theirs.iter().sum::<f64>() < 10.0 {
                theirs.push(time(
                    Command::new("povray")
                        .args(["+W512", "+H512", "+WT2", "-D", "-A", "File_Gamma=srgb"])
                        .arg(format!("+I{}", file("plate.pov").display()))
                        .arg(format!("+O{}", file("theirs.png").display())),
                ));
            }
            ours.push(time(
                Command::new(env!("CARGO_BIN_EXE_solidtrace"))
                    .args(["render", "--threads", "2", "--force", "--quiet"])
                    .arg(file("plate.ron"))
                    .arg("-o")
                    .arg(file("ours.png")),
            ));
        }
        let (theirs, ours) = (median(&mut theirs), median(&mut ours));
        println!(
            "| {} | {theirs:.2} | {ours:.3} | {:.1} | {:.2} % |",
            rows * rows,
            theirs / ours,
            difference(&file("ours.png"), &file("theirs.png")),
        );
    }
    ExitCode::SUCCESS
}
