//! The page of `--html`: everything in one file, nothing from elsewhere.

use std::fmt::Write as _;

use crate::program::scores::still::{MethodScores, StillScores};
use crate::program::scores::tables::short_name;
use crate::program::scores::{Evaluation, Table, Variant};

use super::Gallery;
use crate::program::plot::{COLOURS, Line, Place, escaped, svg};

const STYLE: &str = include_str!("page.css");

/// The page as HTML.
pub(super) fn page(found: &Evaluation, tables: &[Table], galleries: &[Gallery]) -> String {
    let mut html = format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <title>polyreel: methods compared</title>\n<style>\n{STYLE}</style>\n</head>\n<body>\n\
         <header><h1>Methods compared</h1>\n<p>{}</p></header>\n<main>\n",
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
    if !found.stills.is_empty() {
        html += &plots(found);
    }
    let wide = tables.iter().filter(|table| is_long(table));
    for table in tables.iter().filter(|table| !is_long(table)) {
        let _ = write!(
            html,
            "<section>\n<h2>{}</h2>\n{}</section>\n",
            escaped(&table.title),
            body(table)
        );
    }
    html += "<section>\n<h2>Pictures</h2>\n";
    for gallery in galleries {
        html += &pictures(gallery);
    }
    html += "</section>\n";
    for table in wide {
        let _ = write!(
            html,
            "<details>\n<summary><h2>{}</h2></summary>\n{}</details>\n",
            escaped(&table.title),
            body(table)
        );
    }
    html + "</main>\n</body>\n</html>\n"
}

/// Tables with a row a picture are folded away.
fn is_long(table: &Table) -> bool {
    table.head.first().is_some_and(|name| name == "picture")
}

fn summary(found: &Evaluation) -> String {
    let names: Vec<_> = found.plan.methods.iter().map(|method| method.name()).collect();
    let many = |n: usize, what: &str| match n {
        1 => format!("1 {what}"),
        n => format!("{n} {what}s"),
    };
    format!(
        "{} and {}; {} at {} seeds a frame, seed {}.",
        many(found.stills.len(), "picture"),
        many(found.clips.len(), "clip"),
        names.join(", "),
        found.plan.options.points,
        found.plan.options.seed
    )
}

fn plots(found: &Evaluation) -> String {
    let place = |(number, still): (usize, &StillScores)| Place {
        label: number.to_string(),
        name: short_name(&still.path),
    };
    let places: Vec<_> = (1..).zip(&found.stills).map(place).collect();
    let lines = |value: fn(&MethodScores) -> Option<f64>| -> Vec<Line> {
        let coloured = || found.plan.methods.iter().zip(COLOURS.into_iter().cycle()).enumerate();
        let line = |refined: bool| {
            coloured().map(move |(i, (&method, colour))| Line {
                name: Variant { method, refined }.to_string(),
                colour,
                dashed: refined,
                values: found.stills.iter().map(|still| value(&still.of(refined)[i])).collect(),
            })
        };
        let refined = found.plan.refines().then(|| line(true));
        line(false).chain(refined.into_iter().flatten()).collect()
    };
    let mut legend = String::from("<p class=\"legend\">");
    for (method, colour) in found.plan.methods.iter().zip(COLOURS.into_iter().cycle()) {
        let _ =
            write!(legend, "<span><i style=\"background:{colour}\"></i>{}</span>", method.name());
    }
    if found.plan.refines() {
        legend += "<span>dashed, hollow: refined</span>";
    }
    legend += "</p>\n";
    let ssim = svg("SSIM over the pictures", &places, &lines(|s| s.likeness.ssim));
    let mse = svg("MSE over the pictures", &places, &lines(|s| Some(s.likeness.mse)));
    let time = svg("Milliseconds over the pictures", &places, &lines(|s| Some(s.ms)));
    format!(
        "<section>\n<h2>SSIM over the pictures</h2>\n{legend}{ssim}<h2>MSE over the pictures</h2>\n\
         {legend}{mse}<h2>Milliseconds over the pictures</h2>\n{legend}{time}</section>\n"
    )
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
    let mut html = format!("<h3>{}</h3>\n<div class=\"row\">\n", escaped(&gallery.name));
    for (title, jpeg) in &gallery.pictures {
        let _ = writeln!(
            html,
            "<figure><img alt=\"{title}\" src=\"data:image/jpeg;base64,{}\">\
             <figcaption>{title}</figcaption></figure>",
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
