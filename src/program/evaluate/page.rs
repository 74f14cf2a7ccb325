//! The page of `--html`: everything in one file, nothing from elsewhere.

use std::fmt::Write as _;

use crate::program::scores::still::{MethodScores, StillScores};
use crate::program::scores::tables::short_name;
use crate::program::scores::{Evaluation, Kind, Table};

use super::{Gallery, Shown};
use crate::program::plot::{COLOURS, Line, Place, escaped, svg};

const STYLE: &str = include_str!("page.css");
const SCRIPT: &str = include_str!("page.js");

/// Letters of a picture's name below a plot.
const LABEL: usize = 16;

/// Subjects that a plot can hold together with the same refined.
const TOGETHER: usize = 6;

/// The page as HTML.
pub(super) fn page(found: &Evaluation, tables: &[Table], galleries: &[Gallery]) -> String {
    let title = match found.plan.kind {
        Kind::Methods => "Methods compared",
        Kind::Studies => "Studies compared",
        Kind::Presets => "Presets compared",
    };
    let mut html = format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <title>polyreel: {}</title>\n<style>\n{STYLE}</style>\n</head>\n<body>\n\
         <header><h1>{title}</h1>\n<p>{}</p></header>\n<main>\n",
        title.to_lowercase(),
        summary(found)
    );
    // Writing to a string cannot fail, here and below.
    if !found.failures.is_empty() {
        html += "<section class=\"failures\"><h2>Passed over</h2><ul>\n";
        for failure in &found.failures {
            let _ = writeln!(html, "<li>{}</li>", escaped(&failure.error));
        }
        html += "</ul></section>\n";
    }
    html += "<section>\n<p class=\"note\">A click enlarges a picture over its source: drag the line \
             between them; the arrow keys go to the next.</p>\n";
    for gallery in galleries {
        html += &pictures(gallery);
    }
    html += "</section>\n";
    let (long, short): (Vec<_>, Vec<_>) = tables.iter().partition(|table| is_long(table));
    let is_first = |table: &&&Table| table.title.starts_with("Table 1");
    for table in short.iter().filter(is_first) {
        html += &section(table);
    }
    if !found.stills.is_empty() {
        html += &plots(found);
    }
    for table in short.iter().filter(|table| !is_first(table)) {
        html += &section(table);
    }
    for table in long {
        let _ = write!(
            html,
            "<details>\n<summary><h2>{}</h2></summary>\n{}</details>\n",
            escaped(&table.title),
            body(table)
        );
    }
    html + DIALOG + "</main>\n<script>\n" + SCRIPT + "</script>\n</body>\n</html>\n"
}

/// Where a picture is seen large.
const DIALOG: &str = "<dialog id=\"large\">\n<div class=\"stage\"><img alt=\"\"><img alt=\"\" class=\"over\">\
    <input type=\"range\" min=\"0\" max=\"1000\" value=\"500\" aria-label=\"where the source ends\">\
    <i></i></div>\n<p><b></b> <span></span></p>\n<button type=\"button\" data-go=\"-1\" \
    aria-label=\"the one before\">&#8592;</button><button type=\"button\" data-go=\"1\" \
    aria-label=\"the next\">&#8594;</button><button type=\"button\" data-go=\"0\">Close</button>\n</dialog>\n";

fn section(table: &Table) -> String {
    format!("<section>\n<h2>{}</h2>\n{}</section>\n", escaped(&table.title), body(table))
}

/// Tables with a row a picture are folded away.
fn is_long(table: &Table) -> bool {
    table.head.first().is_some_and(|name| name == "picture")
}

fn summary(found: &Evaluation) -> String {
    let names: Vec<_> = found.plan.names().collect();
    let many = |n: usize, what: &str| match n {
        1 => format!("1 {what}"),
        n => format!("{n} {what}s"),
    };
    let points = match found.plan.kind {
        Kind::Presets => "each with its own number of seeds".to_owned(),
        _ => format!("at {} seeds a frame", found.plan.options.points),
    };
    format!(
        "{} and {}; {} {points}, seed {}.",
        many(found.stills.len(), "picture"),
        many(found.clips.len(), "clip"),
        names.join(", "),
        found.plan.options.seed
    )
}

/// What stands below a picture.
pub(super) fn figures(scores: &MethodScores) -> String {
    let ssim = scores.likeness.ssim.map_or_else(String::new, |ssim| format!("SSIM {ssim:.3}, "));
    format!(
        "{ssim}MSE {:.0}, {} triangles, {:.2} s",
        scores.likeness.mse,
        scores.triangles,
        scores.ms / 1e3
    )
}

/// A figure of a rendering, if it has it.
type Value = fn(&MethodScores) -> Option<f64>;

/// A plot for each figure that the paper plots: points of both levels, SSIM, MSE and time.
fn plots(found: &Evaluation) -> String {
    let place = |still: &StillScores| {
        let name = short_name(&still.path);
        let stem = name.rsplit_once('.').map_or(name.as_str(), |(stem, _)| stem);
        let label = match stem.chars().count() {
            0..=LABEL => stem.to_owned(),
            _ => stem.chars().take(LABEL - 1).chain(['\u{2026}']).collect(),
        };
        Place { label, name }
    };
    let places: Vec<_> = found.stills.iter().map(place).collect();
    let is_crowded = found.plan.subjects.len() > TOGETHER;
    let refines = found.plan.refines();
    let mut html = String::from("<section>\n");
    let mut plot = |title: &str, shown: &[bool], value: Value| {
        let lines: Vec<_> =
            shown.iter().flat_map(|&refined| lines(found, refined, value)).collect();
        let plot = svg(title, &places, &lines);
        if !plot.is_empty() {
            let _ = write!(html, "<h2>{title}</h2>\n{}{plot}", legend(found, shown.len() > 1));
        }
    };
    plot("Feature points by picture (level 1)", &[false], |s| Some(s.candidates as f64));
    let all: [(&str, Value); 3] = [
        ("SSIM by picture", |s| s.likeness.ssim),
        ("MSE by picture", |s| Some(s.likeness.mse)),
        ("Seconds by picture", |s| Some(s.ms / 1e3)),
    ];
    for (title, value) in all {
        match (refines, is_crowded) {
            (false, _) => plot(title, &[false], value),
            (true, false) => plot(title, &[false, true], value),
            (true, true) => {
                plot(title, &[false], value);
                plot(&format!("{title}, refined"), &[true], value);
            }
        }
    }
    html + "</section>\n"
}

/// A line for each subject.
fn lines(found: &Evaluation, refined: bool, value: Value) -> impl Iterator<Item = Line> {
    let coloured = found.plan.names().zip(COLOURS.into_iter().cycle()).enumerate();
    coloured.map(move |(i, (name, colour))| Line {
        name: name.to_owned(),
        colour,
        dashed: refined,
        values: found.stills.iter().map(|still| still.of(refined).get(i).and_then(value)).collect(),
    })
}

/// The names of the lines; the script lets a click hide one.
fn legend(found: &Evaluation, has_refined: bool) -> String {
    let mut legend = String::from("<p class=\"legend\">");
    for (name, colour) in found.plan.names().zip(COLOURS.into_iter().cycle()) {
        let name = escaped(name);
        let _ = write!(
            legend,
            "<span data-name=\"{name}\"><i style=\"background:{colour}\"></i>{name}</span>"
        );
    }
    if has_refined {
        legend += "<em>dashed, hollow: refined</em>";
    }
    legend + "</p>\n"
}

fn body(table: &Table) -> String {
    let cells = |tag: &str, row: &[String]| {
        let cells = row.iter().map(|cell| format!("<{tag}>{}</{tag}>", escaped(cell)));
        format!("<tr>{}</tr>\n", cells.collect::<String>())
    };
    let rows: String = table.rows.iter().map(|row| cells("td", row)).collect();
    format!(
        "<p class=\"note\">{}</p>\n<div class=\"scroll\"><table>\n<thead>{}</thead>\n<tbody>\n{rows}\
         </tbody>\n</table></div>\n",
        escaped(&table.note),
        cells("th", &table.head)
    )
}

fn pictures(gallery: &Gallery) -> String {
    let mut html = format!("<h3>{}</h3>\n<div class=\"pictures\">\n", escaped(&gallery.name));
    for Shown { title, figures, jpeg } in &gallery.pictures {
        let _ = writeln!(
            html,
            "<figure><img alt=\"{title}\" src=\"data:image/jpeg;base64,{}\">\
             <figcaption><b>{title}</b> <span>{figures}</span></figcaption></figure>",
            base64(jpeg)
        );
    }
    html + "</div>\n"
}

/// RFC 4648, section 4.
fn base64(bytes: &[u8]) -> String {
    const DIGITS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut text = String::with_capacity(bytes.len().div_ceil(3) * 4);
    for chunk in bytes.chunks(3) {
        let bits = chunk.iter().fold(0u32, |bits, &byte| bits << 8 | u32::from(byte));
        let bits = bits << (8 * (3 - chunk.len()));
        for i in 0..4 {
            let digit = DIGITS[(bits >> (18 - 6 * i)) as usize % 64];
            text.push(if i <= chunk.len() { char::from(digit) } else { '=' });
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn base64_is_that_of_the_standard() {
        // RFC 4648, section 10.
        for (bytes, text) in [
            ("", ""),
            ("f", "Zg=="),
            ("fo", "Zm8="),
            ("foo", "Zm9v"),
            ("foob", "Zm9vYg=="),
            ("foobar", "Zm9vYmFy"),
        ] {
            assert_eq!(base64(bytes.as_bytes()), text);
        }
        assert_eq!(base64(&[255, 239, 190]), "/+++");
    }
}
