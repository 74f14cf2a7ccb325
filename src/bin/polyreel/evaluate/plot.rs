//! Line plots as SVG, one line a method over the pictures (as the paper's Figures 5 to 9).

use std::fmt::Write as _;

const WIDTH: f64 = 860.0;
const HEIGHT: f64 = 300.0;
const LEFT: f64 = 58.0;
const RIGHT: f64 = 14.0;
const TOP: f64 = 14.0;
const BOTTOM: f64 = 34.0;

/// Colours that colour-blind readers tell apart (Okabe and Ito, "Color Universal Design", 2008).
pub(super) const COLOURS: [&str; 6] =
    ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9"];

/// A line: its name, and its value at each place, where it has one.
pub(super) struct Line {
    pub(super) name: String,
    pub(super) values: Vec<Option<f64>>,
}

/// The plot of `lines` over the places called `names`.
pub(super) fn svg(title: &str, names: &[String], lines: &[Line]) -> String {
    let all = || lines.iter().flat_map(|line| line.values.iter().flatten().copied());
    let most = all().fold(f64::NEG_INFINITY, f64::max);
    if !most.is_finite() {
        return String::new();
    }
    let (low, step) = (all().fold(0.0, f64::min), nice_step(most - all().fold(0.0, f64::min)));
    let high = ((most / step).ceil() * step).max(low + step);
    let places = names.len().max(1) as f64;
    let x = |i: usize| LEFT + (WIDTH - LEFT - RIGHT) * (i as f64 + 0.5) / places;
    let y = |v: f64| TOP + (HEIGHT - TOP - BOTTOM) * (high - v) / (high - low);
    let mut svg = format!(
        "<svg class=\"plot\" viewBox=\"0 0 {WIDTH} {HEIGHT}\" role=\"img\" aria-label=\"{title}\">\n"
    );
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
    let every = names.len().div_ceil(24).max(1);
    for i in (0..names.len()).step_by(every) {
        let _ = writeln!(
            svg,
            "<text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{}</text>",
            x(i),
            HEIGHT - BOTTOM + 20.0,
            i + 1
        );
    }
    for (line, colour) in lines.iter().zip(COLOURS.iter().cycle()) {
        draw(&mut svg, line, colour, names, &x, &y);
    }
    svg + "</svg>\n"
}

fn draw(
    svg: &mut String,
    line: &Line,
    colour: &str,
    names: &[String],
    x: &impl Fn(usize) -> f64,
    y: &impl Fn(f64) -> f64,
) {
    let points: Vec<_> =
        line.values.iter().enumerate().filter_map(|(i, v)| v.map(|v| (i, v))).collect();
    let path: Vec<_> = points.iter().map(|&(i, v)| format!("{:.1},{:.1}", x(i), y(v))).collect();
    let _ = writeln!(
        svg,
        "<polyline points=\"{}\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"2\" \
         stroke-linejoin=\"round\"/>",
        path.join(" ")
    );
    for (i, v) in points {
        let _ = writeln!(
            svg,
            "<circle cx=\"{:.1}\" cy=\"{:.1}\" r=\"3.5\" fill=\"{colour}\"><title>{}, {}: {}</title></circle>",
            x(i),
            y(v),
            super::page::escaped(&names[i]),
            line.name,
            trimmed(v)
        );
    }
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
        let names = vec!["a<b".to_owned(), "c".to_owned()];
        let line = Line { name: "hrlp".to_owned(), values: vec![Some(0.5), Some(0.7)] };
        let plot = svg("SSIM", &names, &[line]);
        assert_eq!(plot.matches("<circle").count(), 2);
        assert!(plot.contains("a&lt;b") && !plot.contains("NaN"), "{plot}");
        let none = Line { name: "hrlp".to_owned(), values: vec![None, None] };
        assert_eq!(svg("SSIM", &names, &[none]), "");
    }
}
