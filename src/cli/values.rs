//! Argument values that are more than a number.

use std::time::Duration;

/// What clap shows where a value is wrong.
type Parsed<T> = std::result::Result<T, String>;

pub(super) fn parse_size(text: &str) -> Parsed<(u32, u32)> {
    let side = |s: &str| s.parse().ok().filter(|n| (1..=65536).contains(n));
    text.split_once('x')
        .and_then(|(w, h)| Some((side(w)?, side(h)?)))
        .ok_or_else(|| "expected width and height from 1 to 65536, as 1280x720".to_owned())
}

pub(super) fn parse_samples(text: &str) -> Parsed<(u32, u32)> {
    range(text).ok_or_else(|| "expected a first sample and a larger end, as 0..64".to_owned())
}

/// Most frames of a film: more than an hour.
pub(super) const MOST_FRAMES: u32 = 100_000;

pub(super) fn parse_frames(text: &str) -> Parsed<(u32, u32)> {
    range(text)
        .filter(|(a, b)| b - a <= MOST_FRAMES)
        .ok_or_else(|| {
            format!(
                "expected a first frame and a larger end, as 0..48, at most {MOST_FRAMES} apart"
            )
        })
}

/// `A..B` with `A` below `B`.
fn range(text: &str) -> Option<(u32, u32)> {
    let (a, b) = text.split_once("..")?;
    let range = (a.parse().ok()?, b.parse().ok()?);
    (range.0 < range.1).then_some(range)
}

pub(super) fn parse_crop(text: &str) -> Parsed<[u32; 4]> {
    let numbers: Option<Vec<u32>> = text.split(',').map(|s| s.trim().parse().ok()).collect();
    numbers
        .and_then(|n| <[u32; 4]>::try_from(n).ok())
        .filter(|[x0, y0, x1, y1]| x0 < x1 && y0 < y1)
        .ok_or_else(|| "expected left,top,right,bottom in pixels, as 0,0,640,360".to_owned())
}

pub(super) fn parse_time(text: &str) -> Parsed<Duration> {
    let (number, seconds) = match text.char_indices().last() {
        Some((end, 's')) => (&text[..end], 1.0),
        Some((end, 'm')) => (&text[..end], 60.0),
        Some((end, 'h')) => (&text[..end], 3600.0),
        _ => (text, 1.0),
    };
    (number.parse::<f64>().ok())
        .and_then(|n| Duration::try_from_secs_f64(n * seconds).ok())
        .ok_or_else(|| "expected a time as 90s, 10m or 1h".to_owned())
}

pub(super) fn parse_noise(text: &str) -> Parsed<f64> {
    (text.parse().ok())
        .filter(|noise| *noise > 0.0 && *noise <= 1.0)
        .ok_or_else(|| "expected a relative error above 0 and at most 1, as 0.02".to_owned())
}
