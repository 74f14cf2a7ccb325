//! Line plots as SVG: methods over pictures (as the paper's Figures 4 and 7 to 9), errors over steps.

use std::fmt::Write as _;

const WIDTH: f64 = 860.0;
const HEIGHT: f64 = 300.0;
const LEFT: f64 = 58.0;
const RIGHT: f64 = 14.0;
const TOP: f64 = 14.0;
const BOTTOM: f64 = 34.0;

/// More height for labels that are names: they are slanted.
const NAMES: f64 = 62.0;

/// Letters of a label that is a number.
const NUMBER: usize = 4;

/// Colours: first those that colour-blind readers tell apart (Okabe and Ito, "Color Universal Design", 2008).
pub(crate) const COLOURS: [&str; 15] = [
    "#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#7a4fb5", "#8c6d31",
    "#c0392b", "#5f6b6d", "#2ca089", "#9acd32", "#b03a78", "#3f51b5", "#795548",
];

/// A tick of the horizontal axis.
pub(crate) struct Place {
    /// The label below the axis.
    pub(crate) label: String,
    /// The meaning of the values at the tick.
    pub(crate) name: String,
}

/// A line: its name and look, and its value at each tick, if any.
pub(crate) struct Line {
    pub(crate) name: String,
    pub(crate) colour: &'static str,
    pub(crate) dashed: bool,
    pub(crate) values: Vec<Option<f64>>,
}

/// The plot of `lines` over `places`, for a page with its own styles. Empty without values.
pub(crate) fn svg(title: &str, places: &[Place], lines: &[Line]) -> String {
    match drawn(places, lines) {
        drawn if drawn.is_empty() => drawn,
        drawn => format!(
            "<svg class=\"plot\" viewBox=\"0 0 {WIDTH} {}\" role=\"img\" \
             aria-label=\"{}\">\n{drawn}</svg>\n",
            if is_named(places) { HEIGHT + NAMES } else { HEIGHT },
            escaped(title)
        ),
    }
}

/// The plot as an SVG file, below its title.
pub(crate) fn file(title: &str, places: &[Place], lines: &[Line]) -> String {
    const HEAD: f64 = 34.0;
    let whole = HEIGHT + HEAD;
    let title = escaped(title);
    format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{WIDTH}\" height=\"{whole}\" \
         viewBox=\"0 0 {WIDTH} {whole}\">\n<title>{title}</title>\n\
         <style>text {{ fill: #667; font: 12px system-ui, sans-serif }} .rule {{ stroke: #dcd9d3; fill: \
         none }} .title {{ fill: #1d2129; font-size: 15px }}</style>\n\
         <rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>\n\
         <text class=\"title\" x=\"{LEFT}\" y=\"24\">{title}</text>\n\
         <g transform=\"translate(0 {HEAD})\">\n{}</g>\n</svg>\n",
        drawn(places, lines)
    )
}

/// Whether labels are names, not numbers.
fn is_named(places: &[Place]) -> bool {
    places.iter().any(|place| place.label.chars().count() > NUMBER)
}

fn drawn(places: &[Place], lines: &[Line]) -> String {
    let all = || lines.iter().flat_map(|line| line.values.iter().flatten().copied());
    let most = all().fold(f64::NEG_INFINITY, f64::max);
    if !most.is_finite() {
        return String::new();
    }
    let (low, step) = (all().fold(0.0, f64::min), nice_step(most - all().fold(0.0, f64::min)));
    let high = ((most / step).ceil() * step).max(low + step);
    let share = (WIDTH - LEFT - RIGHT) / places.len().max(1) as f64;
    let x = |i: usize| LEFT + share * (i as f64 + 0.5);
    let y = |v: f64| TOP + (HEIGHT - TOP - BOTTOM) * (high - v) / (high - low);
    let mut svg = String::new();
    // Writing to a string cannot fail, here and below.
    let mut tick = (low / step).ceil() * step;
    while tick <= high + step * 0.01 {
        let (at, right) = (y(tick), WIDTH - RIGHT);
        let _ = writeln!(
            svg,
            "<path class=\"rule\" d=\"M{LEFT} {at:.1}H{right}\"/>\
             <text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"end\">{}</text>",
            LEFT - 8.0,
            at + 4.0,
            trimmed(tick)
        );
        tick += step;
    }
    let every = places.len().div_ceil(24).max(1);
    let is_named = is_named(places);
    for (i, place) in places.iter().enumerate().step_by(every) {
        let (x, y, label) = (x(i), HEIGHT - BOTTOM + 20.0, escaped(&place.label));
        let _ = if is_named {
            writeln!(
                svg,
                "<text transform=\"translate({:.1} {:.1}) rotate(-35)\" text-anchor=\"end\">{label}</text>",
                x + 4.0,
                y - 2.0
            )
        } else {
            writeln!(svg, "<text x=\"{x:.1}\" y=\"{y:.1}\" text-anchor=\"middle\">{label}</text>")
        };
    }
    for line in lines {
        draw(&mut svg, line, places, &x, &y);
    }
    svg
}

fn draw(
    svg: &mut String,
    line: &Line,
    places: &[Place],
    x: &impl Fn(usize) -> f64,
    y: &impl Fn(f64) -> f64,
) {
    let points: Vec<_> =
        line.values.iter().enumerate().filter_map(|(i, v)| v.map(|v| (i, v))).collect();
    let path: Vec<_> = points.iter().map(|&(i, v)| format!("{:.1},{:.1}", x(i), y(v))).collect();
    let colour = line.colour;
    let dashes = if line.dashed { " stroke-dasharray=\"7 5\"" } else { "" };
    let dot = match line.dashed {
        true => format!("fill=\"none\" stroke=\"{colour}\" stroke-width=\"2\""),
        false => format!("fill=\"{colour}\""),
    };
    let _ = writeln!(
        svg,
        "<g data-line=\"{}\">\n<polyline points=\"{}\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"2\" \
         stroke-linejoin=\"round\"{dashes}/>",
        escaped(&line.name),
        path.join(" ")
    );
    for (i, v) in points {
        let _ = writeln!(
            svg,
            "<circle cx=\"{:.1}\" cy=\"{:.1}\" r=\"3.5\" {dot}><title>{}, {}: {}</title></circle>",
            x(i),
            y(v),
            escaped(&places[i].name),
            escaped(&line.name),
            trimmed(v)
        );
    }
    svg.push_str("</g>\n");
}

/// `text` with the characters that HTML and SVG give a meaning written as entities.
pub(crate) fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

/// 1, 2 or 5 times a power of ten, about a fifth of `span`.
fn nice_step(span: f64) -> f64 {
    let rough = (span / 5.0).max(1e-9);
    let power = 10f64.powf(rough.log10().floor());
    let times = [1.0, 2.0, 5.0, 10.0].into_iter().find(|t| t * power >= rough * 0.999);
    times.unwrap_or(10.0) * power
}

fn trimmed(value: f64) -> String {
    let text = if value.abs() >= 100.0 { format!("{value:.0}") } else { format!("{value:.4}") };
    if text.contains('.') {
        text.trim_end_matches('0').trim_end_matches('.').to_owned()
    } else {
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_are_round() {
        assert_eq!(nice_step(1.0), 0.2);
        assert_eq!(nice_step(890.0), 200.0);
        assert_eq!(trimmed(0.6), "0.6");
        assert_eq!(trimmed(1200.0), "1200");
        assert_eq!(trimmed(0.0), "0");
    }

    #[test]
    fn a_plot_draws_every_value_and_survives_none() {
        let place = |name: &str| Place { label: "1".to_owned(), name: name.to_owned() };
        let places = [place("a<b"), place("c")];
        let line = |values: &[Option<f64>]| Line {
            name: "hrlp".to_owned(),
            colour: COLOURS[0],
            dashed: true,
            values: values.to_vec(),
        };
        let plot = svg("SSIM", &places, &[line(&[Some(0.5), Some(0.7)])]);
        assert_eq!(plot.matches("<circle").count(), 2);
        assert!(plot.contains("a&lt;b") && !plot.contains("NaN"), "{plot}");
        assert_eq!(svg("SSIM", &places, &[line(&[None, None])]), "");
        assert!(file("SSIM", &places, &[line(&[Some(0.0), None])]).matches("<circle").count() == 1);
    }

    #[test]
    fn markup_is_escaped() {
        assert_eq!(escaped("<a & \"b\">"), "&lt;a &amp; &quot;b&quot;&gt;");
    }
}
