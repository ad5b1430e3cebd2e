//! Renders the figures of `scenes/report` small and writes the page that shows them.
//!
//! `cargo run --release --example gallery -- [--only 23] [--out DIR] [--times]`

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::Parser;
use glam::Vec2;
use solidtrace::color::Rgb;
use solidtrace::film::PixelSum;
use solidtrace::image::Image;
use solidtrace::integrator::{CameraRay, Integrator, integrator};
use solidtrace::io::{WriteOptions, write_atomically, write_image};
use solidtrace::light::Source;
use solidtrace::math::Ray;
use solidtrace::render::{RenderSettings, Rendered, render};
use solidtrace::scene::{IntegratorSettings, Scene, SceneDescription};
use solidtrace::world::World;
use solidtrace::{Error, Result};

/// Renders the report's figures small, and the page that shows them.
#[derive(Parser)]
struct Options {
    /// Render only figures whose number starts so, as 23 or 23a
    #[arg(long, default_value = "")]
    only: String,
    /// Folder for gallery.md and the folder gallery
    #[arg(long, default_value = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes"))]
    out: PathBuf,
    /// Also time the report's table 2 and measure the noise of figure 21, which takes minutes
    #[arg(long)]
    times: bool,
}

/// Pixels across a picture at most.
const WIDTH: u32 = 240;

/// Where the page's measured part begins; it stays as it is until it is measured again.
const MEASURED: &str = "\n## Table 2";

/// The report's table 2: rays a pixel, threads (0 is all), seconds.
const TABLE_2: [(u32, usize, f64); 8] = [
    (1, 1, 11.966),
    (1, 0, 5.356),
    (3, 0, 15.198),
    (5, 0, 23.832),
    (10, 0, 42.945),
    (25, 0, 106.929),
    (50, 0, 221.369),
    (100, 0, 443.161),
];

/// The picture of figure 8 without the offset.
const ACNE: &str = "gallery/figure_08_acne.png";

struct Figure {
    /// As the report has it, `23a`.
    number: String,
    caption: String,
    scene: PathBuf,
}

impl Figure {
    /// The scene file's first line says which figure it is and what it shows.
    fn read(scene: PathBuf) -> Result<Self> {
        let text = std::fs::read_to_string(&scene).map_err(|e| Error::read(&scene, &e))?;
        let line = text.lines().next().unwrap_or_default();
        let parts = line
            .strip_prefix("// Figure ")
            .and_then(|line| line.split_once(": "));
        let (number, caption) = parts.ok_or_else(|| {
            let message = format!("{} does not begin with `// Figure`", scene.display());
            Error::input(message).help("write `// Figure 23a: what it shows.` in its first line")
        })?;
        Ok(Self {
            number: number.to_owned(),
            caption: caption.to_owned(),
            scene,
        })
    }

    fn load(&self) -> Result<Scene> {
        SceneDescription::read(&self.scene)?.load()
    }

    /// `gallery/figure_23a.png`.
    fn picture(&self) -> PathBuf {
        let name = self.scene.with_extension("png");
        Path::new("gallery").join(name.file_name().unwrap_or_default())
    }
}

fn main() -> ExitCode {
    match gallery(&Options::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}

fn gallery(options: &Options) -> Result<()> {
    let folder = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/report"));
    let entries = std::fs::read_dir(folder).map_err(|e| Error::read(folder, &e))?;
    let mut scenes: Vec<PathBuf> = (entries.flatten().map(|entry| entry.path()))
        .filter(|path| path.extension().is_some_and(|e| e == "ron"))
        .collect();
    scenes.sort();
    let figures = (scenes.into_iter().map(Figure::read)).collect::<Result<Vec<_>>>()?;
    let pictures = options.out.join("gallery");
    std::fs::create_dir_all(&pictures).map_err(|e| Error::read(&pictures, &e))?;
    let wanted = |figure: &&Figure| figure.number.starts_with(&options.only);
    for figure in figures.iter().filter(wanted) {
        let seconds = draw(figure, &options.out.join(figure.picture()))?;
        println!("figure {:>3} {seconds:6.1} s", figure.number);
    }
    if "8".starts_with(&options.only)
        && let Some(figure) = figures.iter().find(|figure| figure.number == "8")
    {
        let world = World::build(small(figure)?)?;
        let rendered = shoot_with(&Touching, &world, 0, 0)?;
        keep(&rendered, &world, &options.out.join(ACNE))?;
    }
    let page = options.out.join("gallery.md");
    let measured = if options.times {
        measured(&figures)?
    } else {
        let old = std::fs::read_to_string(&page).unwrap_or_default();
        old.find(MEASURED)
            .map_or(String::new(), |at| old[at..].to_owned())
    };
    let text = table(&figures) + &measured;
    write_atomically(&page, text.as_bytes(), true)
}

/// Renders a figure into a file; seconds.
fn draw(figure: &Figure, file: &Path) -> Result<f64> {
    let world = World::build(small(figure)?)?;
    let rendered = shoot(&world, 0, 0)?;
    keep(&rendered, &world, file)?;
    Ok(rendered.time.as_secs_f64())
}

fn small(figure: &Figure) -> Result<Scene> {
    let mut scene = figure.load()?;
    let (width, height) = scene.film.size;
    scene.film.size = (width.min(WIDTH), height * width.min(WIDTH) / width);
    Ok(scene)
}

fn keep(rendered: &Rendered, world: &World, file: &Path) -> Result<()> {
    let options = WriteOptions {
        overwrite: true,
        tonemap: world.scene().film.tonemap,
        ..WriteOptions::default()
    };
    write_image(file, &enlarged(rendered), &options)
}

fn shoot(world: &World, threads: usize, seed: u64) -> Result<Rendered> {
    let integrator = integrator(&world.scene().integrator);
    shoot_with(integrator.as_ref(), world, threads, seed)
}

fn shoot_with(
    integrator: &dyn Integrator,
    world: &World,
    threads: usize,
    seed: u64,
) -> Result<Rendered> {
    let scene = world.scene();
    let settings = RenderSettings {
        threads,
        seed,
        ..RenderSettings::of(scene)
    };
    let lens = scene.cameras[0].lens(scene.film.size)?;
    render(world, &lens, integrator, &settings, &())
}

/// As the report's program was at first: point lights, and shadow rays that start right where the surface was hit, which
/// rounding puts on either side of it.
struct Touching;

impl Integrator for Touching {
    fn radiance(&self, world: &World, batch: &[CameraRay], radiance: &mut [Rgb]) -> u64 {
        let IntegratorSettings::Whitted { shadow_factor, .. } = world.scene().integrator else {
            return 0;
        };
        for (camera, radiance) in batch.iter().zip(radiance) {
            *radiance = Rgb::ZERO;
            let Some(hit) = world.intersect(&camera.ray) else {
                continue;
            };
            let touched = camera.ray.at(hit.t);
            let point = world.surface(&camera.ray, &hit);
            let bsdf = world.bsdf(&point, &world.media_at(camera.ray.origin));
            for light in world.lights().lights() {
                if let Some(sample) = light.sample(touched, Vec2::ZERO)
                    && let Source::Point(source) = sample.source
                {
                    let shadow = Ray {
                        tmax: 1.0,
                        ..Ray::new(touched, source - touched)
                    };
                    let open = if world.occluded(&shadow) {
                        shadow_factor
                    } else {
                        1.0
                    };
                    let wi = (source - touched).as_vec3().normalize();
                    let (f_cos, _) = bsdf.eval(-camera.ray.direction.as_vec3(), wi);
                    *radiance += open * f_cos * sample.li;
                }
            }
        }
        2 * batch.len() as u64
    }
}

fn pixels(rendered: &Rendered) -> Vec<Rgb> {
    rendered.film.pixels().iter().map(PixelSum::mean).collect()
}

/// The picture; one of few pixels, which is there to show them, with each of them as a square.
fn enlarged(rendered: &Rendered) -> Image {
    let rect = rendered.film.rect();
    let (width, height) = (rect.width as usize, rect.height as usize);
    let (pixels, edge) = (pixels(rendered), (WIDTH as usize / width).max(1));
    Image::of_channels(edge * width, edge * height, |at, channel| {
        let (x, y) = (at % (edge * width) / edge, at / (edge * width) / edge);
        pixels[y * width + x][channel]
    })
}

fn table(figures: &[Figure]) -> String {
    let mut text = String::from(
        "# The report's figures\n\n\
         `cargo run --release --example gallery` renders `report/*.ron` and writes this page.\n\n\
         | figure | | what it shows |\n|---|---|---|\n",
    );
    for figure in figures {
        let Figure {
            number, caption, ..
        } = figure;
        let picture = figure.picture();
        let scene = figure.scene.file_name().unwrap_or_default().display();
        let _ = writeln!(
            text,
            "| [{number}](report/{scene}) | ![figure {number}]({}) | {caption} |",
            picture.display()
        );
    }
    let _ = write!(
        text,
        "\n## Figure 8 without an offset\n\nShadow rays that start right where a surface was hit meet that surface again \
         wherever rounding put the hit behind it. Ours start off the surface by a little more than what rounding can \
         do.\n\n![figure 8 without an offset]({ACNE})\n"
    );
    text
}

/// Table 2 with this machine's times, and the noise of point and sphere lights.
fn measured(figures: &[Figure]) -> Result<String> {
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let mut text = format!(
        "{MEASURED}\n\nSeconds for figure 19 at 350x350 and 5 bounces: the report's machine in 2017, and {}, {cores} \
         cores.\n\n| rays a pixel | threads | report | solidtrace | million rays a second |\n|---|---|---|---|---|\n",
        processor()
    );
    let of = |number: &'static str| figures.iter().filter(move |f| f.number.starts_with(number));
    let mut runs = Vec::new();
    for figure in of("19") {
        runs.push(World::build(figure.load()?)?);
    }
    for (rays, threads, report) in TABLE_2 {
        for world in runs.iter().filter(|w| w.scene().film.spp == rays) {
            let rendered = shoot(world, threads, 0)?;
            let seconds = rendered.time.as_secs_f64();
            let speed = rendered.rays as f64 / seconds * 1e-6;
            let threads = if threads == 0 { cores } else { threads };
            let _ = writeln!(
                text,
                "| {rays} | {threads} | {report:.3} | {seconds:.3} | {speed:.1} |"
            );
        }
    }
    text += "\n## Noise of figure 21\n\nStandard deviation of a pixel from one render to another, over the picture's mean.\n\n\
             | figure | rays a pixel | noise |\n|---|---|---|\n";
    for figure in of("21") {
        let mut scene = figure.load()?;
        scene.film.size = (WIDTH / 2, WIDTH / 2);
        let world = World::build(scene)?;
        let _ = writeln!(
            text,
            "| {} | {} | {:.2} % |",
            figure.number,
            world.scene().film.spp,
            100.0 * noise(&world)?
        );
    }
    Ok(text)
}

/// The deviation of a pixel from one render to another, by two of them: the variance is half of their mean squared
/// difference.
fn noise(world: &World) -> Result<f64> {
    let [a, b] = [shoot(world, 0, 1)?, shoot(world, 0, 2)?].map(|rendered| pixels(&rendered));
    let sum = |value: &dyn Fn(Rgb, Rgb) -> f32| -> f64 {
        (a.iter().zip(&b))
            .map(|(&a, &b)| f64::from(value(a, b)))
            .sum::<f64>()
            / (3 * a.len()) as f64
    };
    let variance = sum(&|a, b| 0.5 * (a - b).length_squared());
    Ok(variance.sqrt() / sum(&|a, b| 0.5 * (a + b).element_sum()))
}

/// What the system calls the processor.
fn processor() -> String {
    let text = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let line = text.lines().find(|line| line.starts_with("model name"));
    let name = line.and_then(|line| line.split_once(": "));
    name.map_or("an unnamed processor", |(_, name)| name)
        .to_owned()
}
