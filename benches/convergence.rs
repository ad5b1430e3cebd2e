//! How fast the noise of the Cornell box falls with samples, drawn from Sobol's sequence and independently.
//!
//! `cargo bench --bench convergence [-- OUT.svg]`: variance of a pixel, mean over the picture and over channels, between
//! renders with different seeds, at powers of two of samples a pixel; as a table, and as a plot where a file is named.

use std::fmt::Write;
use std::path::Path;

use solidtrace::film::Rect;
use solidtrace::integrator::integrator;
use solidtrace::io::{ReadOptions, read_scene};
use solidtrace::render::{RenderSettings, render};
use solidtrace::sampling::SamplerKind;
use solidtrace::world::World;

const SIZE: (u32, u32) = (96, 96);
/// Renders with different seeds.
const SEEDS: u64 = 12;
const MOST: u32 = 256;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    // Cargo adds flags of its own.
    let out = std::env::args()
        .skip(1)
        .find(|argument| !argument.starts_with("--"));
    let scene = read_scene(Path::new("scenes/cornell.ron"), &ReadOptions::default())?;
    let world = World::build(scene)?;
    let counts: Vec<u32> = (0..=MOST.ilog2()).map(|i| 1 << i).collect();
    let mut curves = Vec::new();
    println!(
        "{:>6} {:>12} {:>12} {:>7}",
        "spp", "Sobol", "independent", "ratio"
    );
    for &spp in &counts {
        let of = |sampler| variance(&world, sampler, spp);
        let (sobol, independent) = (of(SamplerKind::Sobol)?, of(SamplerKind::Independent)?);
        println!(
            "{spp:>6} {sobol:>12.3e} {independent:>12.3e} {:>7.2}",
            independent / sobol
        );
        curves.push([sobol, independent]);
    }
    if let Some(out) = out {
        std::fs::write(&out, plot(&counts, &curves))?;
        println!("{out} written");
    }
    Ok(())
}

fn variance(world: &World, sampler: SamplerKind, spp: u32) -> solidtrace::error::Result<f64> {
    let scene = world.scene();
    let lens = scene.cameras[0].lens(SIZE)?;
    let integrator = integrator(&scene.integrator);
    // Sums of values and of their squares, by pixel and channel.
    let mut sums = vec![[0.0_f64; 2]; (SIZE.0 * SIZE.1 * 3) as usize];
    for seed in 0..SEEDS {
        let mut settings = RenderSettings::of(scene);
        settings.size = SIZE;
        settings.area = Rect::of_size(SIZE);
        (settings.samples, settings.sampler, settings.seed) = (0..spp, sampler, seed);
        let rendered = render(world, &lens, &*integrator, &settings, &())?;
        let pixels = rendered.film.pixels().iter();
        let values = pixels.flat_map(|pixel| pixel.mean().to_array());
        for (sum, value) in sums.iter_mut().zip(values) {
            sum[0] += f64::from(value);
            sum[1] += f64::from(value).powi(2);
        }
    }
    let seeds = SEEDS as f64;
    let each = |[sum, squares]: &[f64; 2]| (squares - sum * sum / seeds) / (seeds - 1.0);
    Ok(sums.iter().map(each).sum::<f64>() / sums.len() as f64)
}

/// Both axes logarithmic.
fn plot(counts: &[u32], curves: &[[f64; 2]]) -> String {
    const SIZE: (f64, f64) = (640.0, 400.0);
    const EDGE: f64 = 60.0;
    let all = || curves.iter().flatten().copied();
    let low = all().fold(f64::INFINITY, f64::min).log10().floor();
    let high = all().fold(0.0, f64::max).log10().ceil();
    let last = (counts.len() - 1) as f64;
    let x = |i: usize| EDGE + i as f64 / last * (SIZE.0 - 2.0 * EDGE);
    let y = |log: f64| EDGE + (high - log) / (high - low) * (SIZE.1 - 2.0 * EDGE);
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {} {}\" font-family=\"sans-serif\" font-size=\"13\">\n\
         <rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n\
         <text x=\"{EDGE}\" y=\"30\" font-size=\"16\">Variance of a pixel of the Cornell box, by samples a pixel</text>\n",
        SIZE.0, SIZE.1
    );
    for log in low as i32..=high as i32 {
        let y = y(f64::from(log));
        let _ = writeln!(
            svg,
            "<path d=\"M{EDGE} {y}H{}\" stroke=\"#ddd\"/><text x=\"{}\" y=\"{}\" text-anchor=\"end\">1e{log}</text>",
            SIZE.0 - EDGE,
            EDGE - 6.0,
            y + 4.0
        );
    }
    for (i, count) in counts.iter().enumerate() {
        let _ = writeln!(
            svg,
            "<text x=\"{}\" y=\"{}\" text-anchor=\"middle\">{count}</text>",
            x(i),
            SIZE.1 - EDGE + 20.0
        );
    }
    for (k, (name, color)) in [("Sobol", "#0969da"), ("independent", "#cf222e")]
        .into_iter()
        .enumerate()
    {
        let points: Vec<String> = (curves.iter().enumerate())
            .map(|(i, curve)| format!("{:.1},{:.1}", x(i), y(curve[k].log10())))
            .collect();
        let at = y(curves[0][k].log10()) + if k == 0 { 24.0 } else { -10.0 };
        let _ = writeln!(
            svg,
            "<polyline points=\"{}\" fill=\"none\" stroke=\"{color}\" stroke-width=\"2\"/>\
             <text x=\"{}\" y=\"{at}\" fill=\"{color}\">{name}</text>",
            points.join(" "),
            x(0) + 6.0
        );
    }
    svg + "</svg>\n"
}
