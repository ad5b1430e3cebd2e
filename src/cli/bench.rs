use std::fs;
use std::path::PathBuf;
use std::thread::available_parallelism;

use clap::Args;
use serde_json::{Map, Value, json};

use crate::bench::{Build, REFERENCE, RaceOptions, Report, Subject, plot, race};
use crate::error::{Place, Result};
use crate::io::{check_writable, write_atomically};

use super::progress::Status;
use super::table::table;
use super::values::parse_size;
use super::{InputArgs, grouped, warn};

#[derive(Args)]
pub(super) struct BenchArgs {
    #[command(flatten)]
    input: InputArgs,
    /// Print one JSON object
    #[arg(long)]
    json: bool,
    /// SVG to draw the ratios to Embree in
    #[arg(long, value_name = "OUT.svg")]
    plot: Option<PathBuf>,
    /// Replace a file that exists
    #[arg(long)]
    force: bool,
    /// Threads that build and trace; 0 is one for each core
    #[arg(long, default_value_t = 1)]
    threads: usize,
    /// How often each engine is timed on each kind of rays
    #[arg(long, default_value_t = 5, value_parser = clap::value_parser!(u32).range(1..=1000))]
    rounds: u32,
    /// Picture whose pixels the rays start from
    #[arg(long, value_name = "WxH", value_parser = parse_size, default_value = "512x512")]
    size: (u32, u32),
}

pub(super) fn run(args: &BenchArgs) -> Result<()> {
    if let Some(path) = &args.plot {
        check_writable(path, args.force)?;
    }
    let input = args.input.input.display().to_string();
    let status = Status::new();
    status.tell("reading");
    let scene = args.input.read()?;
    warn(&scene.warnings);
    let subject = Subject::of_scene(scene).map_err(|e| e.at(Place::file(&input)))?;
    let options = RaceOptions {
        threads: args.threads,
        rounds: args.rounds as usize,
        size: args.size,
    };
    let report = race(&subject, options, &|text| status.tell(text))
        .map_err(|e| e.at(Place::file(&input)))?;
    status.finish();
    for note in &report.notes {
        eprintln!("note: {note}");
    }
    warn(&disagreements(&report));
    let name = args.input.input.file_name().unwrap_or_default();
    let title = title(&report, &name.to_string_lossy());
    if args.json {
        println!("{}", json(&report, &input));
    } else {
        print!("{}", text(&report, &title));
    }
    if let Some(path) = &args.plot {
        write_atomically(path, plot(&report, &title).as_bytes(), args.force)?;
    }
    Ok(())
}

/// One line on what ran where, `name` being that of what was raced over.
fn title(report: &Report, name: &str) -> String {
    let instances = match report.instances {
        1 => String::new(),
        n => format!(" in {} instances", grouped(n as u64)),
    };
    let threads = if report.threads == 1 {
        "thread"
    } else {
        "threads"
    };
    let cores = available_parallelism().map_or(1, usize::from);
    format!(
        "{name}: {} triangles{instances}, {} {threads}, {}, {cores} cores",
        grouped(report.triangles as u64),
        report.threads,
        processor()
    )
}

/// The engines whose hits differ from ours by more than a part in a thousand, a sentence each.
fn disagreements(report: &Report) -> Vec<String> {
    let mut found = Vec::new();
    for kind in &report.kinds {
        for row in kind.rows.iter().filter(|row| !row.agrees) {
            found.push(format!(
                "{} differs on {} rays: of {} it hits with {}, we with {}",
                row.engine,
                kind.kind.name(),
                grouped(row.rays as u64),
                grouped(row.hits),
                grouped(row.expected)
            ));
        }
    }
    found
}

/// For people.
fn text(report: &Report, title: &str) -> String {
    let number = |n: Option<f64>| n.map_or_else(|| "-".to_owned(), |n| format!("{n:.0}"));
    let builds = report.builds.iter().map(|build| {
        vec![
            build.engine.clone(),
            format!("{:.3}", build.seconds),
            number(build.bytes_per_triangle),
            number(build.peak_bytes_per_triangle),
        ]
    });
    let heads = ["build", "s", "bytes a triangle", "peak"];
    let mut parts = vec![format!("{title}\n"), table(&heads, builds)];
    for kind in &report.kinds {
        let query = if kind.kind.any_hit() {
            "any hit"
        } else {
            "closest hit"
        };
        let rows = kind.rows.iter().map(|row| {
            let mark = if row.agrees { "" } else { "other hits" };
            let mut cells = vec![row.engine.clone()];
            let speeds = [row.median, row.min, row.max, row.ratio];
            cells.extend(speeds.map(|speed| format!("{speed:.2}")));
            cells.push(mark.to_owned());
            cells
        });
        let heads = [kind.kind.name(), "Mrays/s", "least", "most", "ratio", ""];
        let rays = grouped(kind.rays as u64);
        parts.push(format!("{rays} rays, {query}\n{}", table(&heads, rows)));
    }
    parts.push(format!(
        "ratio: to {REFERENCE} in the same round, median of the rounds\n"
    ));
    parts.join("\n")
}

/// For programs.
fn json(report: &Report, input: &str) -> Value {
    let mut mrays = Map::new();
    for kind in &report.kinds {
        let rows = kind.rows.iter().map(|row| {
            let speeds = json!({
                "median": row.median,
                "min": row.min,
                "max": row.max,
                "ratio": row.ratio,
                "rays": row.rays,
                "hits": row.hits,
                "agrees": row.agrees,
            });
            (row.engine.clone(), speeds)
        });
        mrays.insert(kind.kind.name().to_owned(), Value::Object(rows.collect()));
    }
    let of_builds = |value: fn(&Build) -> Option<f64>| -> Map<String, Value> {
        (report.builds.iter())
            .filter_map(|build| Some((build.engine.clone(), json!(value(build)?))))
            .collect()
    };
    let rays = report
        .kinds
        .iter()
        .map(|kind| (kind.kind.name().to_owned(), json!(kind.rays)));
    json!({
        "input": input,
        "triangles": report.triangles,
        "instances": report.instances,
        "threads": report.threads,
        "processor": processor(),
        "build_seconds": of_builds(|build| Some(build.seconds)),
        "bytes_per_triangle": of_builds(|build| build.bytes_per_triangle),
        "peak_bytes_per_triangle": of_builds(|build| build.peak_bytes_per_triangle),
        "rays": rays.collect::<Map<_, _>>(),
        "mrays": mrays,
        "notes": report.notes,
    })
}

/// The processor's name, where the system tells.
fn processor() -> String {
    let text = fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let line = text.lines().find(|line| line.starts_with("model name"));
    let name = line.and_then(|line| line.split_once(": "));
    name.map_or(std::env::consts::ARCH, |(_, name)| name)
        .to_owned()
}
