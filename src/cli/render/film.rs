//! Many pictures of one world: numbered files, and films.

use std::f64::consts::TAU;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Duration;

use clap::Args;

use crate::camera::Camera;
use crate::color::Encoding;
use crate::error::{Error, ErrorKind, Place, Result};
use crate::io::{Video, VideoSettings, check_image_path, read_bitmap, screen_bytes};
use crate::render::{RenderSettings, render};

use super::super::progress::{Progress, catch_interrupts, interrupted};
use super::super::values::{MOST_FRAMES, parse_frames};
use super::super::{INTERRUPTED, is_png};
use super::report::{report_bad, speed};
use super::{RenderArgs, for_looking};

#[derive(Args)]
pub(super) struct FilmArgs {
    /// Frames A to B-1 of the camera's motion, to numbered files; those that exist are kept unless forced
    #[arg(long, value_name = "A..B", value_parser = parse_frames, group = "moving")]
    frames: Option<(u32, u32)>,
    /// So many frames once around what the camera looks at [default output: the input's stem as .mp4]
    #[arg(long, value_name = "N", group = "moving",
          value_parser = clap::value_parser!(u32).range(1..=i64::from(MOST_FRAMES)))]
    turntable: Option<u32>,
    /// Film to write, .mp4 (by ffmpeg; where that is not installed a .png instead) or .png (animated)
    #[arg(long, value_name = "FILE", requires = "moving")]
    video: Option<PathBuf>,
    /// Frames a second
    #[arg(long, default_value_t = 24, requires = "moving", value_parser = clap::value_parser!(u16).range(1..=1000))]
    fps: u16,
}

/// One frame.
struct Shot {
    number: u32,
    camera: Camera,
    /// All its pictures.
    files: Vec<PathBuf>,
    /// Those that are not there yet, or are to be replaced.
    missing: Vec<PathBuf>,
}

impl FilmArgs {
    /// Whether there is more than one picture to take.
    pub(super) fn wanted(&self) -> bool {
        self.frames.is_some() || self.turntable.is_some()
    }

    /// Numbers and cameras of all frames.
    fn cameras(&self, camera: &Camera) -> Result<Vec<(u32, Camera)>> {
        if let Some(count) = self.turntable {
            let turned = |i| camera.turned(TAU * f64::from(i) / f64::from(count));
            return Ok((0..count).map(|i| (i, turned(i))).collect());
        }
        if camera.motion.is_none() {
            return Err(Error::new(ErrorKind::Usage, "the camera does not move")
                .help("give it a `motion` in the scene file, or pass --turntable N"));
        }
        let (start, end) = self.frames.unwrap_or_default();
        Ok((start..end).map(|i| (i, camera.at(f64::from(i)))).collect())
    }
}

impl RenderArgs {
    /// The files that the frames' names are made of, and the film.
    fn film_outputs(&self) -> Result<(Vec<PathBuf>, Option<PathBuf>)> {
        let named = self.output.is_some() || self.png.is_some();
        let video = self.film.video.clone();
        Ok(
            if named || (video.is_none() && self.film.frames.is_some()) {
                (self.outputs()?, video)
            } else if video.is_some() {
                (Vec::new(), video)
            } else {
                let stem = self.outputs()?.remove(0);
                (Vec::new(), Some(stem.with_extension("mp4")))
            },
        )
    }

    fn shots(&self, camera: &Camera, size: (u32, u32), outputs: &[PathBuf]) -> Result<Vec<Shot>> {
        let shot = |(number, camera): (u32, Camera)| {
            // Where it cannot look there is no picture, which should be known before the first one is taken.
            (camera.lens(size))
                .map_err(|e| Error::new(e.kind(), format!("at frame {number} {}", e.message())))?;
            let files: Vec<PathBuf> = outputs.iter().map(|path| numbered(path, number)).collect();
            let missing = files.iter().filter(|path| self.force || !path.is_file());
            let missing: Vec<PathBuf> = missing.cloned().collect();
            for path in &missing {
                check_image_path(path, self.force)?;
            }
            Ok(Shot {
                number,
                camera,
                files,
                missing,
            })
        };
        self.film.cameras(camera)?.into_iter().map(shot).collect()
    }
}

pub(super) fn run(args: &RenderArgs) -> Result<ExitCode> {
    let (outputs, video) = args.film_outputs()?;
    let scene = args.scene()?;
    let size = scene.film.size;
    let integrator = args.integrator(&scene, &outputs)?;
    let shots = args.shots(args.camera(&scene)?, size, &outputs)?;
    let film = VideoSettings {
        size,
        frames: shots.len() as u32,
        fps: args.film.fps,
        tonemap: scene.film.tonemap,
        overwrite: args.force,
    };
    let mut video = (video.map(|path| Ok((Video::create(&path, &film)?, path)))).transpose()?;
    let world = args.input.build(scene)?;
    let scene = world.scene();
    let settings = args.settings(scene)?;

    catch_interrupts();
    let taken = |shot: &Shot| !shot.is_there(video.is_some());
    let count = shots.iter().filter(|shot| taken(shot)).count();
    let samples = settings.samples.end - settings.samples.start;
    let pixels = u64::from(settings.area.width) * u64::from(settings.area.height);
    let total = count as u64 * pixels * u64::from(samples);
    let progress = Progress::new(total, args.quiet, None);
    let (mut rays, mut time) = (0, Duration::ZERO);
    for shot in &shots {
        if shot.is_there(video.is_some()) {
            if let Some((video, _)) = &mut video {
                video.add(&shot.read_back(size)?)?;
            }
            continue;
        }
        // Noise that stands still while the picture moves looks like a dirty window.
        let settings = RenderSettings {
            seed: settings.seed.wrapping_add(u64::from(shot.number)),
            ..settings.clone()
        };
        let lens = shot.camera.lens(size)?;
        let rendered = render(&world, &lens, integrator.as_ref(), &settings, &progress)?;
        report_bad(&rendered);
        rays += rendered.rays;
        time += rendered.time;
        let mut image = rendered.to_image();
        image.metadata = args.metadata(scene, &shot.camera, &settings, &rendered);
        let number = ("frame".to_owned(), shot.number.to_string());
        image.metadata.push(number);
        if rendered.complete {
            args.write(scene, &image, &shot.missing)?;
        }
        // Ctrl-C reaches ffmpeg as well: whatever is complete, the film is not.
        if !rendered.complete || interrupted() {
            progress.finish();
            let rest = match (outputs.is_empty(), args.force) {
                (true, _) => "no film is left; with --png NAME.png it could go on later",
                (_, true) => "those before it are there; without --force the rest follows",
                (_, false) => "those before it are there; the same command goes on with the rest",
            };
            eprintln!("interrupted at frame {}: {rest}", shot.number);
            return Ok(ExitCode::from(INTERRUPTED));
        }
        if let Some((video, _)) = &mut video {
            let shown = for_looking(&scene.integrator, &image);
            let shown = shown.as_ref().unwrap_or(&image);
            video.add(&screen_bytes(shown, film.tonemap)?)?;
        }
    }
    progress.finish();

    let mut made = file_names(&shots);
    if let Some((video, asked)) = video {
        let path = video.path().to_owned();
        video.finish()?;
        made.push(if path == asked {
            path.display().to_string()
        } else {
            format!("{} (animated, as ffmpeg is not installed)", path.display())
        });
    }
    if !args.quiet {
        let kept = match shots.len() - count {
            0 => String::new(),
            kept => format!(" of which {kept} were there"),
        };
        println!(
            "{}: {} frames{kept}, {}x{}, {samples} spp{}, {}",
            made.join(", "),
            shots.len(),
            size.0,
            size.1,
            settings.noise.map_or("", |_| " at most"),
            speed(rays, time)
        );
    }
    Ok(ExitCode::SUCCESS)
}

/// The first and last file of each kind.
fn file_names(shots: &[Shot]) -> Vec<String> {
    let (first, last) = (shots.first(), shots.last());
    let pairs = (first.zip(last))
        .into_iter()
        .flat_map(|(a, b)| a.files.iter().zip(&b.files));
    pairs
        .map(|(first, last)| format!("{} to {}", first.display(), last.display()))
        .collect()
}

impl Shot {
    /// Whether nothing is left to do but to read it back, where a film needs it.
    fn is_there(&self, for_video: bool) -> bool {
        let complete = !self.files.is_empty() && self.missing.is_empty();
        complete && (!for_video || self.files.iter().any(|path| is_png(path)))
    }

    /// The bytes of its PNG.
    fn read_back(&self, size: (u32, u32)) -> Result<Vec<u8>> {
        let Some(path) = self.files.iter().find(|path| is_png(path)) else {
            return Ok(Vec::new());
        };
        let bitmap = read_bitmap(path, Encoding::Linear)?;
        if (bitmap.width, bitmap.height) != (size.0 as usize, size.1 as usize) {
            let (width, height) = (bitmap.width, bitmap.height);
            let message = format!(
                "this frame is {width}x{height}, and the film {}x{}",
                size.0, size.1
            );
            return Err(Error::input(message)
                .at(Place::file(path))
                .help("pass --force to render it again, or choose another name"));
        }
        let byte = |share: f32| (255.0 * share).round() as u8;
        Ok((bitmap.pixels.iter())
            .flat_map(|pixel| pixel.to_array().map(byte))
            .collect())
    }
}

/// `out.png` as `out_0007.png`.
fn numbered(path: &Path, number: u32) -> PathBuf {
    let mut name = path.file_stem().unwrap_or_default().to_owned();
    name.push(format!("_{number:04}"));
    if let Some(extension) = path.extension() {
        name.push(".");
        name.push(extension);
    }
    path.with_file_name(name)
}
