//! What a render tells about itself: in its files, and at its end.

use std::path::PathBuf;
use std::time::Duration;

use crate::camera::{Camera, Projection};
use crate::film::PixelSum;
use crate::render::{RenderSettings, Rendered};
use crate::scene::Scene;

use super::super::grouped;
use super::RenderArgs;

impl RenderArgs {
    /// What made the picture. Threads, tiles and time are left out: the file is the same for all.
    pub(super) fn metadata(
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
        if let Some(noise) = settings.noise {
            metadata.push(("noise", noise.to_string()));
        }
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

pub(super) fn report_bad(rendered: &Rendered) {
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
pub(super) fn names(paths: &[PathBuf]) -> String {
    let names: Vec<String> = paths
        .iter()
        .map(|path| path.display().to_string())
        .collect();
    names.join(", ")
}

/// What the closing line tells.
pub(super) fn figures(rendered: &Rendered, settings: &RenderSettings, size: (u32, u32)) -> String {
    let most = settings.samples.end - settings.samples.start;
    let pixels = f64::from(settings.area.width) * f64::from(settings.area.height);
    let samples = match rendered.converged {
        None => format!("{most} spp"),
        Some(converged) => {
            let counts = rendered.film.pixels().iter().map(PixelSum::count);
            format!(
                "{:.1} of {most} spp in the mean, {:.1} % of the pixels down to the noise",
                counts.map(f64::from).sum::<f64>() / pixels,
                100.0 * converged as f64 / pixels,
            )
        }
    };
    format!(
        "{}x{}, {samples}{}, {}",
        size.0,
        size.1,
        match (rendered.complete, rendered.converged) {
            (true, _) => "",
            (false, None) => " at most, stopped early",
            (false, Some(_)) => ", stopped early",
        },
        speed(rendered.rays, rendered.time),
    )
}

pub(super) fn speed(rays: u64, time: Duration) -> String {
    let seconds = time.as_secs_f64();
    format!(
        "{} rays in {seconds:.2} s, {:.2} Mrays/s",
        grouped(rays),
        rays as f64 / seconds.max(1e-9) / 1e6,
    )
}
