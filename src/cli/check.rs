use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Instant;

use clap::Args;
use serde_json::{Value, json};

use crate::accel::Kernel;
use crate::check::{
    Answer, Answers, CheckSettings, Checker, Claim, Query, RayClass, Report, Spot, Tally,
};
use crate::error::{Error, ErrorKind, Place, Result};
use crate::io::{WriteOptions, check_image_path, write_image};
use crate::math::Ray;

use super::progress::{Progress, catch_interrupts, interrupted};
use super::table::table;
use super::{INTERRUPTED, InputArgs, grouped, is_png, warn};

#[derive(Args)]
pub(super) struct CheckArgs {
    #[command(flatten)]
    input: InputArgs,
    /// Rays, shared out evenly to the classes
    #[arg(long, default_value_t = 1_000_000, value_parser = clap::value_parser!(u64).range(1..))]
    rays: u64,
    /// Another seed, other rays
    #[arg(long, default_value_t = 0)]
    seed: u64,
    /// Print one JSON object
    #[arg(long)]
    json: bool,
    /// EXR to write: what the rays of each of the camera's pixels show, at least one a pixel
    #[arg(long, value_name = "OUT.exr")]
    heatmap: Option<PathBuf>,
    /// Replace a file that exists
    #[arg(long)]
    force: bool,
}

pub(super) fn run(args: &CheckArgs) -> Result<ExitCode> {
    if let Some(path) = &args.heatmap {
        if is_png(path) {
            return Err(Error::new(ErrorKind::Usage, "a heat map is an EXR")
                .at(Place::file(path))
                .help("use a name that ends in .exr"));
        }
        check_image_path(path, args.force)?;
    }
    let scene = args.input.read()?;
    warn(&scene.warnings);
    let world = args.input.build(scene)?;
    let checker = Checker::new(&world).map_err(|e| e.at(Place::file(&args.input.input)))?;
    let left_out = checker.arbiter().meshes().left_out();
    if left_out > 0 {
        let count = grouped(left_out as u64);
        eprintln!("note: objects left out, because Embree knows meshes alone: {count}");
    }
    let kernels: Vec<&str> = checker.kernels().map(Kernel::name).collect();
    catch_interrupts();
    let settings = CheckSettings {
        rays: args.rays,
        seed: args.seed,
        heat_map: args.heatmap.is_some(),
    };
    let size = world.scene().film.size;
    let rays = RayClass::ALL.map(|class| settings.rays_of(class, size));
    let progress = Progress::new(rays.iter().sum(), args.json, None);
    let start = Instant::now();
    let report = checker.run(&settings, &progress);
    let seconds = start.elapsed().as_secs_f64();
    progress.finish();
    if let (Some(path), Some(map)) = (&args.heatmap, &report.heat_map) {
        let options = WriteOptions {
            overwrite: args.force,
            ..WriteOptions::default()
        };
        write_image(path, &map.to_image(), &options)?;
    }
    for (query, answers) in &report.wrong {
        eprintln!("{}", accusation(query, answers));
    }
    if args.json {
        let input = args.input.input.display().to_string();
        println!("{}", json(&input, &report, &kernels, seconds));
    } else {
        print!("{}", classes(&report));
        println!("{}", closing_line(&report.sum(), &kernels, seconds));
    }
    Ok(exit_code(&report))
}

/// A wrong answer of ours, so that it can be asked again.
fn accusation(query: &Query, answers: &Answers) -> String {
    let Ray {
        origin,
        direction,
        tmin,
        tmax,
    } = query.ray;
    let told = |answer: &Answer| match answer {
        Answer::Any(blocked) => format!("any hit: {blocked}"),
        Answer::Closest(None) => "no hit".to_owned(),
        Answer::Closest(Some(Claim { t, spot })) => {
            let Spot {
                instance,
                primitive,
            } = spot;
            format!("triangle {primitive} of mesh object {instance} at t {t}")
        }
    };
    let dissent = answers.dissent.map_or_else(String::new, |kernel| {
        format!(", or not, where the kernel {} is asked", kernel.name())
    });
    format!(
        "wrong: from {origin} along {direction}, {tmin} < t < {tmax}: we say {}{dissent}; Embree {}, robust {}",
        told(&answers.ours),
        told(&answers.embree[0]),
        told(&answers.embree[1])
    )
}

/// 1 where ours was ever wrong.
fn exit_code(report: &Report) -> ExitCode {
    if report.sum().ours_wrong > 0 {
        ExitCode::FAILURE
    } else if !report.complete && interrupted() {
        eprintln!("interrupted: these are the rays traced so far");
        ExitCode::from(INTERRUPTED)
    } else {
        ExitCode::SUCCESS
    }
}

/// A row for each class, and one for all.
fn classes(report: &Report) -> String {
    let heads = [
        "class",
        "rays",
        "hits",
        "ours wrong",
        "embree wrong",
        "robust wrong",
        "edge",
        "sliver",
        "grazing",
        "end",
        "ties",
        "|dt|/bound",
    ];
    let rows = report.classes.iter().map(|(class, t)| (class.name(), *t));
    let rows = rows.chain([("all", report.sum())]).map(|(name, t)| {
        let counts = [
            t.rays,
            t.hits,
            t.ours_wrong,
            t.embree_wrong,
            t.robust_wrong,
            t.edge,
            t.sliver,
            t.grazing,
            t.end,
            t.ties,
        ];
        let mut row = vec![name.to_owned()];
        row.extend(counts.map(grouped));
        row.push(format!("{:.3}", t.worst_dt));
        row
    });
    table(&heads, rows)
}

fn closing_line(sum: &Tally, kernels: &[&str], seconds: f64) -> String {
    format!(
        "{} rays checked in {seconds:.2} s, {:.2} Mrays/s; ours wrong {} ({}), Embree {}, Embree robust {}",
        grouped(sum.rays),
        sum.rays as f64 / seconds.max(1e-9) / 1e6,
        grouped(sum.ours_wrong),
        kernels.join(", "),
        grouped(sum.embree_wrong),
        grouped(sum.robust_wrong),
    )
}

fn json(input: &str, report: &Report, kernels: &[&str], seconds: f64) -> Value {
    let mut object = tally_json(&report.sum());
    let classes = (report.classes.iter())
        .map(|(class, tally)| (class.name().to_owned(), tally_json(tally)))
        .collect::<serde_json::Map<_, _>>();
    object["input"] = json!(input);
    object["seconds"] = json!(seconds);
    object["kernels"] = json!(kernels);
    object["classes"] = json!(classes);
    object
}

fn tally_json(t: &Tally) -> Value {
    json!({
        "rays": t.rays,
        "hits": t.hits,
        "differences": t.differences,
        "ours_wrong": t.ours_wrong,
        "embree_wrong": t.embree_wrong,
        "embree_robust_wrong": t.robust_wrong,
        "edge": t.edge,
        "sliver": t.sliver,
        "grazing": t.grazing,
        "end": t.end,
        "ties": t.ties,
        "worst_dt": t.worst_dt,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_wrong_hit_of_ours_is_a_failure_and_any_number_of_embrees_is_none() {
        let code = |tally| {
            let report = Report {
                classes: vec![
                    (RayClass::Camera, Tally::default()),
                    (RayClass::Axis, tally),
                ],
                heat_map: None,
                wrong: Vec::new(),
                complete: true,
            };
            format!("{:?}", exit_code(&report))
        };
        let ours = Tally {
            ours_wrong: 1,
            ..Tally::default()
        };
        let theirs = Tally {
            embree_wrong: 1000,
            robust_wrong: 1000,
            ties: 1000,
            ..Tally::default()
        };
        assert_eq!(code(ours), format!("{:?}", ExitCode::from(1)));
        assert_eq!(code(theirs), format!("{:?}", ExitCode::from(0)));
    }
}
