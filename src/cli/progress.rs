use std::io::{IsTerminal, stderr};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};

use crate::render::Observer;

/// Set by the first Ctrl-C.
static INTERRUPTED: AtomicBool = AtomicBool::new(false);

/// From now on the first Ctrl-C asks the render to stop, and a second one ends the program at once.
pub(super) fn catch_interrupts() {
    // Where interrupts are ignored on entry, as in the background of a script, they stay so.
    let _ = ctrlc::try_set_handler(|| {
        if INTERRUPTED.swap(true, Ordering::SeqCst) {
            std::process::exit(i32::from(super::INTERRUPTED));
        }
    });
}

/// Whether Ctrl-C was pressed.
pub(super) fn interrupted() -> bool {
    INTERRUPTED.load(Ordering::SeqCst)
}

/// Shows how a render advances: a bar on a terminal, a line now and then elsewhere, nothing if quiet.
pub(super) struct Progress {
    bar: Option<ProgressBar>,
    lines: bool,
    total: u64,
    samples: AtomicU64,
    rays: AtomicU64,
    /// Tenths of the work already told of.
    told: AtomicU64,
    start: Instant,
    deadline: Option<Instant>,
}

impl Progress {
    /// For a render of `total` pixel samples that stops after `limit`.
    pub(super) fn new(total: u64, quiet: bool, limit: Option<Duration>) -> Self {
        let terminal = stderr().is_terminal();
        let bar = (!quiet && terminal).then(|| {
            let bar = ProgressBar::new(total);
            if let Ok(style) =
                ProgressStyle::with_template("{bar:40} {percent:>3}%  {msg}  {eta} left")
            {
                bar.set_style(style);
            }
            bar
        });
        let start = Instant::now();
        Self {
            bar,
            lines: !quiet && !terminal,
            total,
            samples: AtomicU64::new(0),
            rays: AtomicU64::new(0),
            told: AtomicU64::new(0),
            start,
            deadline: limit.map(|limit| start + limit),
        }
    }

    /// Takes the bar away.
    pub(super) fn finish(&self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }
}

impl Observer for Progress {
    fn advance(&self, samples: u64, rays: u64) {
        let samples = self.samples.fetch_add(samples, Ordering::Relaxed) + samples;
        let rays = self.rays.fetch_add(rays, Ordering::Relaxed) + rays;
        let seconds = self.start.elapsed().as_secs_f64();
        let speed = format!("{:.2} Mrays/s", rays as f64 / seconds.max(1e-9) / 1e6);
        if let Some(bar) = &self.bar {
            bar.set_position(samples);
            bar.set_message(speed);
        } else if self.lines {
            let tenth = 10 * samples / self.total.max(1);
            if self.told.fetch_max(tenth, Ordering::Relaxed) < tenth {
                let left = seconds * (self.total - samples) as f64 / samples as f64;
                eprintln!("{:>3}%  {speed}  {left:.0} s left", 10 * tenth);
            }
        }
    }

    fn stop(&self) -> bool {
        interrupted() || self.deadline.is_some_and(|end| Instant::now() >= end)
    }
}

/// Says on a terminal what is going on, and nothing elsewhere.
#[cfg(feature = "bench")]
pub(super) struct Status(ProgressBar);

#[cfg(feature = "bench")]
impl Status {
    pub(super) fn new() -> Self {
        // Where stderr is no terminal, indicatif draws nothing.
        Self(ProgressBar::new_spinner())
    }

    pub(super) fn tell(&self, text: &str) {
        self.0.set_message(text.to_owned());
        self.0.tick();
    }

    pub(super) fn finish(&self) {
        self.0.finish_and_clear();
    }
}
