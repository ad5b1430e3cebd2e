mod film;

use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Duration;

use clap::{Args, ValueEnum};
use rayon::prelude::*;

use crate::camera::{Camera, Projection};
use crate::color::Tonemap;
use crate::error::{Error, ErrorKind, Result};
use crate::film::{PixelSum, Rect};
use crate::image::Image;
use crate::integrator::integrator;
use crate::io::{Precision, WriteOptions, check_image_path, write_image};
use crate::render::{RenderSettings, Rendered, render};
use crate::sampling::SamplerKind;
use crate::scene::{IntegratorSettings, Scene};

use self::film::FilmArgs;
use super::progress::{Progress, catch_interrupts, interrupted};
use super::values::{parse_crop, parse_samples, parse_size, parse_time};
use super::{INTERRUPTED, InputArgs, grouped, is_png, warn};

#[derive(Args)]
pub(super) struct RenderArgs {
    #[command(flatten)]
    input: InputArgs,
    /// Picture to write, .exr (linear) or .png [default: the input's stem in the current folder, both]
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// PNG to write as well
    #[arg(long, value_name = "FILE")]
    png: Option<PathBuf>,
    /// Pixels, as 1280x720 [default: the scene's]
    #[arg(long, value_name = "WxH", value_parser = parse_size)]
    size: Option<(u32, u32)>,
    /// Samples a pixel [default: the scene's]
    #[arg(long, value_parser = clap::value_parser!(u32).range(1..))]
    spp: Option<u32>,
    /// Only these samples of each pixel, as 0..64
    #[arg(long, value_name = "A..B", value_parser = parse_samples, conflicts_with = "spp")]
    samples: Option<(u32, u32)>,
    /// Most scattering events on a path [default: the scene's]
    #[arg(long)]
    max_depth: Option<u32>,
    /// Another seed, another noise
    #[arg(long, default_value_t = 0)]
    seed: u64,
    /// Worker threads; 0 is one for each core
    #[arg(long, default_value_t = 0)]
    threads: usize,
    /// Edge of the tiles that workers take, in pixels; never changes the picture
    #[arg(long, default_value_t = 32, value_parser = clap::value_parser!(u32).range(1..=256))]
    tile_size: u32,
    /// How light is transported [default: the scene's]
    #[arg(long, value_enum)]
    integrator: Option<IntegratorName>,
    /// Source of the samples
    #[arg(long, value_enum, default_value = "sobol")]
    sampler: SamplerName,
    /// Name of the camera [default: the first]
    #[arg(long, value_name = "NAME")]
    camera: Option<String>,
    /// Render only this part, in pixels; the rest stays black
    #[arg(long, value_name = "X0,Y0,X1,Y1", value_parser = parse_crop)]
    crop: Option<[u32; 4]>,
    /// Stop after this long with what there is, as 90s, 10m or 1h
    #[arg(long, value_parser = parse_time, conflicts_with = "moving")]
    time: Option<Duration>,
    #[command(flatten)]
    film: FilmArgs,
    /// Curve of the PNG [default: the scene's]
    #[arg(long, value_enum)]
    tonemap: Option<TonemapName>,
    /// Write 16-bit floats to the EXR
    #[arg(long)]
    half: bool,
    /// Note the render time in the files, which makes them differ from run to run
    #[arg(long)]
    record_time: bool,
    /// Replace files that exist
    #[arg(long)]
    force: bool,
    /// Print nothing but warnings and errors
    #[arg(short, long)]
    quiet: bool,
}

#[derive(Clone, Copy, ValueEnum)]
enum IntegratorName {
    Path,
    Whitted,
    Normals,
    Depth,
    Flat,
    Ao,
}

#[derive(Clone, Copy, ValueEnum)]
enum SamplerName {
    Sobol,
    Independent,
}

#[derive(Clone, Copy, ValueEnum)]
enum TonemapName {
    Srgb,
    Gamma22,
    None,
}

pub(super) fn run(args: &RenderArgs) -> Result<ExitCode> {
    if args.film.wanted() {
        return film::run(args);
    }
    let outputs = args.outputs()?;
    for path in &outputs {
        check_image_path(path, args.force)?;
    }
    let scene = args.scene()?;
    let camera = args.camera(&scene)?.clone();
    let lens = camera.lens(scene.film.size)?;
    let world = args.input.build(scene)?;
    let settings = args.settings(world.scene())?;
    let scene = world.scene();

    catch_interrupts();
    let pixels = u64::from(settings.area.width) * u64::from(settings.area.height);
    let total = pixels * u64::from(settings.samples.end - settings.samples.start);
    let progress = Progress::new(total, args.quiet, args.time);
    let integrator = integrator(&scene.integrator);
    let rendered = render(&world, &lens, integrator.as_ref(), &settings, &progress)?;
    progress.finish();
    report_bad(&rendered);

    let mut image = rendered.film.to_image();
    image.metadata = args.metadata(scene, &camera, &settings, &rendered);
    args.write(scene, &image, &outputs)?;
    if !args.quiet {
        println!(
            "{}: {}",
            names(&outputs),
            figures(&rendered, &settings, scene.film.size)
        );
    }
    if interrupted() {
        eprintln!("interrupted: the files hold the samples taken so far");
        return Ok(ExitCode::from(INTERRUPTED));
    }
    Ok(ExitCode::SUCCESS)
}

impl RenderArgs {
    fn outputs(&self) -> Result<Vec<PathBuf>> {
        if self.output.is_some() || self.png.is_some() {
            return Ok(self.output.iter().chain(&self.png).cloned().collect());
        }
        let stem = self.input.input.file_stem().ok_or_else(|| {
            let input = self.input.input.display();
            Error::new(
                ErrorKind::Usage,
                format!("{input} is not the name of a file"),
            )
        })?;
        let stem = PathBuf::from(stem);
        Ok(vec![
            stem.with_added_extension("exr"),
            stem.with_added_extension("png"),
        ])
    }

    /// The scene, overruled by the arguments.
    fn scene(&self) -> Result<Scene> {
        let mut scene = self.input.read()?;
        warn(&scene.warnings);
        self.apply(&mut scene);
        Ok(scene)
    }

    /// Writes a picture to all of `outputs`.
    fn write(&self, scene: &Scene, image: &Image, outputs: &[PathBuf]) -> Result<()> {
        let shown = for_looking(&scene.integrator, image);
        let options = WriteOptions {
            overwrite: self.force,
            tonemap: scene.film.tonemap,
            precision: if self.half {
                Precision::Half
            } else {
                Precision::Float
            },
        };
        outputs.par_iter().try_for_each(|path| {
            let shown = shown.as_ref().filter(|_| is_png(path));
            write_image(path, shown.unwrap_or(image), &options)
        })
    }

    /// Lets the arguments overrule the scene.
    fn apply(&self, scene: &mut Scene) {
        let film = &mut scene.film;
        film.size = self.size.unwrap_or(film.size);
        film.spp = self.spp.unwrap_or(film.spp);
        film.tonemap = self.tonemap.map_or(film.tonemap, |name| match name {
            TonemapName::Srgb => Tonemap::Srgb,
            TonemapName::Gamma22 => Tonemap::Gamma22,
            TonemapName::None => Tonemap::None,
        });
        if let Some(name) = self.integrator {
            name.choose(&mut scene.integrator);
        }
        if let Some(most) = self.max_depth {
            match &mut scene.integrator {
                IntegratorSettings::Path { max_depth, .. } => *max_depth = Some(most),
                IntegratorSettings::Whitted { max_depth, .. } => *max_depth = most,
                _ => {}
            }
        }
    }

    fn camera<'a>(&self, scene: &'a Scene) -> Result<&'a Camera> {
        let Some(wanted) = &self.camera else {
            return Ok(&scene.cameras[0]);
        };
        let named = |camera: &&Camera| camera.name.as_ref() == Some(wanted);
        scene.cameras.iter().find(named).ok_or_else(|| {
            let names: Vec<&str> = scene
                .cameras
                .iter()
                .filter_map(|c| c.name.as_deref())
                .collect();
            Error::new(
                ErrorKind::Usage,
                format!("there is no camera called \"{wanted}\""),
            )
            .help(if names.is_empty() {
                "the input's cameras have no names: leave --camera out".to_owned()
            } else {
                format!("its cameras are {}", names.join(", "))
            })
        })
    }

    fn settings(&self, scene: &Scene) -> Result<RenderSettings> {
        let whole = Rect::of_size(scene.film.size);
        let area = match self.crop {
            Some([x0, y0, x1, y1]) => Rect {
                x: x0,
                y: y0,
                width: x1 - x0,
                height: y1 - y0,
            },
            None => whole,
        };
        if !whole.contains(area) {
            let (w, h) = scene.film.size;
            let message = format!("--crop reaches outside of the picture, {w}x{h}");
            return Err(Error::new(ErrorKind::Usage, message));
        }
        let whole = RenderSettings::of(scene);
        Ok(RenderSettings {
            area,
            samples: self.samples.map_or(whole.samples, |(a, b)| a..b),
            sampler: match self.sampler {
                SamplerName::Sobol => SamplerKind::Sobol,
                SamplerName::Independent => SamplerKind::Independent,
            },
            seed: self.seed,
            threads: self.threads,
            tile_size: self.tile_size,
            ..whole
        })
    }

    /// What made the picture. Threads, tiles and time are left out: the file is the same for all.
    fn metadata(
        &self,
        scene: &Scene,
        camera: &Camera,
        settings: &RenderSettings,
        rendered: &Rendered,
    ) -> Vec<(String, String)> {
        let input = &self.input.input;
        let file = input
            .file_name()
            .unwrap_or(input.as_os_str())
            .to_string_lossy();
        let counts = rendered.film.pixels().iter().map(PixelSum::count);
        let spp = counts.max().unwrap_or(0);
        let mut metadata = vec![
            ("scene", file.into_owned()),
            ("camera", camera_text(camera)),
            ("integrator", format!("{:?}", scene.integrator)),
            ("spp", spp.to_string()),
            (
                "samples",
                format!("{}..{}", settings.samples.start, settings.samples.end),
            ),
            ("sampler", format!("{:?}", settings.sampler)),
            ("seed", settings.seed.to_string()),
            ("filter", format!("{:?}", settings.filter)),
            ("solidtrace", env!("CARGO_PKG_VERSION").to_owned()),
        ];
        if !rendered.complete {
            metadata.push(("incomplete", "the render was stopped early".to_owned()));
        }
        if self.record_time {
            metadata.push(("seconds", format!("{:.3}", rendered.time.as_secs_f64())));
        }
        (metadata.into_iter())
            .map(|(name, value)| (name.to_owned(), value))
            .collect()
    }
}

impl IntegratorName {
    /// Keeps the scene's parameters where it already uses this integrator.
    fn choose(self, settings: &mut IntegratorSettings) {
        match (self, &settings) {
            (Self::Path, IntegratorSettings::Path { .. })
            | (Self::Whitted, IntegratorSettings::Whitted { .. })
            | (Self::Ao, IntegratorSettings::Ao { .. }) => {}
            (Self::Path, _) => *settings = IntegratorSettings::path(),
            (Self::Whitted, _) => *settings = IntegratorSettings::whitted(),
            (Self::Normals, _) => *settings = IntegratorSettings::Normals,
            (Self::Depth, _) => *settings = IntegratorSettings::Depth,
            (Self::Flat, _) => *settings = IntegratorSettings::Flat,
            (Self::Ao, _) => *settings = IntegratorSettings::Ao { radius: None },
        }
    }
}

fn camera_text(camera: &Camera) -> String {
    let name = camera
        .name
        .as_ref()
        .map_or(String::new(), |name| format!("{name}: "));
    let (eye, look_at, up) = (camera.eye, camera.look_at, camera.up);
    let projection = match camera.projection {
        Projection::Perspective { vfov, .. } => format!("vfov {}", vfov.to_degrees()),
        Projection::Orthographic { height } => format!("orthographic height {height}"),
        Projection::Panorama => "panorama".to_owned(),
    };
    format!("{name}eye {eye} look_at {look_at} up {up} {projection}")
}

/// Distances have no place in a PNG's 0..=1: they are shown against the largest.
fn for_looking(integrator: &IntegratorSettings, image: &Image) -> Option<Image> {
    if *integrator != IntegratorSettings::Depth {
        return None;
    }
    let mut shown = image.clone();
    let values = shown.channels.iter().flat_map(|c| &c.values);
    let largest = values.copied().fold(f32::MIN_POSITIVE, f32::max);
    for value in shown.channels.iter_mut().flat_map(|c| &mut c.values) {
        *value /= largest;
    }
    Some(shown)
}

fn report_bad(rendered: &Rendered) {
    let Some(first) = rendered.bad.first() else {
        return;
    };
    eprintln!(
        "warning: {} samples were not finite numbers and were left out; the first is sample {} of pixel {:?}",
        rendered.bad.len(),
        first.index,
        first.pixel
    );
}

/// Paths as a list.
fn names(paths: &[PathBuf]) -> String {
    let names: Vec<String> = paths
        .iter()
        .map(|path| path.display().to_string())
        .collect();
    names.join(", ")
}

/// What the closing line tells.
fn figures(rendered: &Rendered, settings: &RenderSettings, size: (u32, u32)) -> String {
    format!(
        "{}x{}, {} spp{}, {}",
        size.0,
        size.1,
        settings.samples.end - settings.samples.start,
        if rendered.complete {
            ""
        } else {
            " at most, stopped early"
        },
        speed(rendered.rays, rendered.time),
    )
}

fn speed(rays: u64, time: Duration) -> String {
    let seconds = time.as_secs_f64();
    format!(
        "{} rays in {seconds:.2} s, {:.2} Mrays/s",
        grouped(rays),
        rays as f64 / seconds.max(1e-9) / 1e6,
    )
}
