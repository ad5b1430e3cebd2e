use std::fmt::Write;

use super::report::{KindReport, REFERENCE, Report, Row};

/// Panels side by side.
const COLUMNS: usize = 2;
const PANEL_WIDTH: f64 = 450.0;
/// From the left edge of a panel to where its bars start.
const LABELS: f64 = 104.0;
/// From the end of the longest bar to the right edge of its panel.
const VALUES: f64 = 96.0;
const BAR: f64 = 12.0;
const LINE: f64 = 16.0;
const HEADING: f64 = 30.0;
const MARGIN: f64 = 20.0;
const TOP: f64 = 56.0;

/// The ratios to Embree as an SVG of horizontal bars, a panel for each kind of rays. It stands on a card of its own,
/// so that it can be read on a page of any colour.
pub fn plot(report: &Report, title: &str) -> String {
    let most = report
        .kinds
        .iter()
        .map(|kind| kind.rows.len())
        .max()
        .unwrap_or(0);
    let panel_height = HEADING + LINE * most as f64 + MARGIN;
    let lines = report.kinds.len().div_ceil(COLUMNS);
    let width = 2.0 * MARGIN + COLUMNS as f64 * PANEL_WIDTH;
    let height = TOP + lines as f64 * panel_height;
    let longest =
        (report.kinds.iter().flat_map(|kind| &kind.rows)).fold(1.0, |r: f64, row| r.max(row.ratio));
    let scale = (PANEL_WIDTH - LABELS - VALUES) / longest;
    let mut svg = format!(
        r##"<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" width="{width}" height="{height}" font-family="sans-serif" font-size="12" fill="#24292f">
<rect x="0.5" y="0.5" width="{}" height="{}" rx="8" fill="#ffffff" stroke="#d0d7de"/>
<text x="{MARGIN}" y="26" font-size="13" font-weight="bold">{}</text>
<text x="{MARGIN}" y="43" fill="#57606a">rays a second as a multiple of Embree's, median of the rounds; longer is faster</text>
"##,
        width - 1.0,
        height - 1.0,
        escaped(title),
    );
    for (i, kind) in report.kinds.iter().enumerate() {
        let x = MARGIN + (i % COLUMNS) as f64 * PANEL_WIDTH;
        let y = TOP + (i / COLUMNS) as f64 * panel_height;
        panel(&mut svg, kind, x, y, scale);
    }
    svg += "</svg>\n";
    svg
}

fn panel(svg: &mut String, kind: &KindReport, x: f64, y: f64, scale: f64) {
    let any = if kind.kind.any_hit() {
        "any hit"
    } else {
        "closest hit"
    };
    let speed = kind
        .rows
        .iter()
        .find(|row| row.engine == REFERENCE)
        .map_or(0.0, |row| row.median);
    let _ = writeln!(
        svg,
        r##"<text x="{x}" y="{}"><tspan font-weight="bold">{}</tspan> {any}<tspan fill="#57606a">, 1 is {speed:.2} Mrays/s</tspan></text>"##,
        y + 18.0,
        kind.kind.name(),
    );
    let start = x + LABELS;
    for (i, row) in kind.rows.iter().enumerate() {
        bar(svg, row, start, y + HEADING + LINE * i as f64, scale);
    }
    let one = start + scale;
    let _ = writeln!(
        svg,
        r##"<line x1="{one:.1}" y1="{}" x2="{one:.1}" y2="{}" stroke="#24292f" stroke-dasharray="3 3"/>"##,
        y + HEADING - 4.0,
        y + HEADING + LINE * kind.rows.len() as f64,
    );
}

fn bar(svg: &mut String, row: &Row, start: f64, y: f64, scale: f64) {
    let ours = ["single", "batch", "portable"]
        .iter()
        .any(|name| row.engine.starts_with(name));
    let color = match () {
        () if ours => "#0969da",
        () if row.engine.starts_with(REFERENCE) => "#8c959f",
        () => "#d4a72c",
    };
    let (length, base) = (scale * row.ratio, y + BAR - 2.0);
    let _ = writeln!(
        svg,
        r#"<text x="{:.1}" y="{base:.1}" text-anchor="end">{}</text><rect x="{start:.1}" y="{y:.1}" width="{length:.1}" height="{BAR}" fill="{color}"><title>{:.2} Mrays/s, {:.2} to {:.2}</title></rect><text x="{:.1}" y="{base:.1}">{:.2}{}</text>"#,
        start - 6.0,
        escaped(&row.engine),
        row.median,
        row.min,
        row.max,
        start + length + 5.0,
        row.ratio,
        if row.agrees { "" } else { " other hits" },
    );
}

fn escaped(text: &str) -> String {
    (text.replace('&', "&amp;"))
        .replace('<', "&lt;")
        .replace('>', "&gt;")
}
