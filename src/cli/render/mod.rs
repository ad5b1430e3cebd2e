mod film;
mod names;
mod report;

use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Duration;

use clap::Args;
use rayon::prelude::*;

use crate::camera::Camera;
use crate::error::{Error, ErrorKind, Result};
use crate::film::Rect;
use crate::image::Image;
use crate::integrator::{Integrator, LayerKind, layered_integrator};
use crate::io::{Precision, WriteOptions, check_image_path, write_image};
use crate::render::{RenderSettings, render};
use crate::scene::{IntegratorSettings, Scene};

use self::film::FilmArgs;
use self::names::{IntegratorName, LayerName, SamplerName, TonemapName};
use self::report::{figures, names, report_bad};
use super::progress::{Progress, catch_interrupts, interrupted};
use super::values::{parse_crop, parse_noise, parse_samples, parse_size, parse_time};
use super::{INTERRUPTED, InputArgs, is_png, warn};

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
    /// Give no more samples to parts whose relative error is estimated to be at most this, as 0.02
    #[arg(long, value_name = "ERROR", value_parser = parse_noise)]
    noise: Option<f64>,
    /// What the EXR holds beside the picture
    #[arg(
        long,
        value_enum,
        value_name = "LAYER,..",
        visible_alias = "aov",
        value_delimiter = ','
    )]
    layers: Vec<LayerName>,
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
    let integrator = args.integrator(&scene, &outputs)?;
    let world = args.input.build(scene)?;
    let settings = args.settings(world.scene())?;
    let scene = world.scene();

    catch_interrupts();
    let pixels = u64::from(settings.area.width) * u64::from(settings.area.height);
    let total = pixels * u64::from(settings.samples.end - settings.samples.start);
    let progress = Progress::new(total, args.quiet, args.time);
    let rendered = render(&world, &lens, integrator.as_ref(), &settings, &progress)?;
    progress.finish();
    report_bad(&rendered);

    let mut image = rendered.to_image();
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
        film.tonemap = self.tonemap.map_or(film.tonemap, TonemapName::tonemap);
        if let Some(name) = self.integrator {
            name.choose(&mut scene.integrator);
        }
        if let Some(most) = self.max_depth {
            match &mut scene.integrator {
                IntegratorSettings::Path { max_depth, .. } => *max_depth = Some(most),
                IntegratorSettings::Direct { max_depth }
                | IntegratorSettings::Whitted { max_depth, .. } => *max_depth = most,
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

    /// The scene's integrator, with the layers that an EXR among `outputs` is to hold.
    fn integrator(&self, scene: &Scene, outputs: &[PathBuf]) -> Result<Box<dyn Integrator>> {
        if !self.layers.is_empty() && outputs.iter().all(|path| is_png(path)) {
            return Err(
                Error::new(ErrorKind::Usage, "there is no EXR for the layers")
                    .help("name one with -o NAME.exr, or leave --layers out"),
            );
        }
        let layers: Vec<LayerKind> = self.layers.iter().map(|layer| layer.kind()).collect();
        layered_integrator(&scene.integrator, &layers)
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
            sampler: self.sampler.kind(),
            seed: self.seed,
            noise: self.noise,
            threads: self.threads,
            tile_size: self.tile_size,
            ..whole
        })
    }
}

/// Distances have no place in a PNG's 0..=1: they are shown against the largest.
fn for_looking(integrator: &IntegratorSettings, image: &Image) -> Option<Image> {
    if *integrator != IntegratorSettings::Depth {
        return None;
    }
    let mut shown = image.clone();
    shown.channels.truncate(3);
    let values = shown.channels.iter().flat_map(|c| &c.values);
    let largest = values.copied().fold(f32::MIN_POSITIVE, f32::max);
    for value in shown.channels.iter_mut().flat_map(|c| &mut c.values) {
        *value /= largest;
    }
    Some(shown)
}
