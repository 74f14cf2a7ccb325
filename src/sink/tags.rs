//! What a video says of its colours.

use std::ffi::OsString;

use crate::ffmpeg::command::arguments;
use crate::frame::Colorimetry;

/// The tags of the output: those of the source, or BT.709 for what was RGB.
pub(crate) fn tags(source: Option<&Colorimetry>) -> Colorimetry {
    let bt709 = || Some("bt709".to_string());
    source.cloned().unwrap_or_else(|| Colorimetry {
        matrix: bt709(),
        range: Some("tv".into()),
        primaries: bt709(),
        transfer: bt709(),
    })
}

/// Code points of ITU-T H.273 by the names that ffprobe prints: ffmpeg's options know some of them by other names
/// (`bt470bg` is `gamma28` to -color_trc), but all take the numbers. What is not here is left out.
const PRIMARIES: [(&str, u8); 12] = [
    ("bt709", 1),
    ("bt470m", 4),
    ("bt470bg", 5),
    ("smpte170m", 6),
    ("smpte240m", 7),
    ("film", 8),
    ("bt2020", 9),
    ("smpte428", 10),
    ("smpte431", 11),
    ("smpte432", 12),
    ("ebu3213", 22),
    ("jedec-p22", 22),
];
const TRANSFERS: [(&str, u8); 16] = [
    ("bt709", 1),
    ("bt470m", 4),
    ("bt470bg", 5),
    ("smpte170m", 6),
    ("smpte240m", 7),
    ("linear", 8),
    ("log100", 9),
    ("log316", 10),
    ("iec61966-2-4", 11),
    ("bt1361e", 12),
    ("iec61966-2-1", 13),
    ("bt2020-10", 14),
    ("bt2020-12", 15),
    ("smpte2084", 16),
    ("smpte428", 17),
    ("arib-std-b67", 18),
];
/// Without `gbr`, which our 4:2:0 never is.
const MATRICES: [(&str, u8); 15] = [
    ("bt709", 1),
    ("fcc", 4),
    ("bt470bg", 5),
    ("smpte170m", 6),
    ("smpte240m", 7),
    ("ycgco", 8),
    ("bt2020nc", 9),
    ("bt2020c", 10),
    ("smpte2085", 11),
    ("chroma-derived-nc", 12),
    ("chroma-derived-c", 13),
    ("ictcp", 14),
    ("ipt-c2", 15),
    ("ycgco-re", 16),
    ("ycgco-ro", 17),
];
const RANGES: [(&str, u8); 2] = [("tv", 1), ("pc", 2)];

/// ffmpeg's names of code points.
type Names = [(&'static str, u8)];

/// Options that tag a stream.
pub(crate) fn tag_arguments(tags: &Colorimetry) -> Vec<OsString> {
    let named: [(&str, &Option<String>, &Names); 4] = [
        ("-colorspace", &tags.matrix, &MATRICES),
        ("-color_range", &tags.range, &RANGES),
        ("-color_primaries", &tags.primaries, &PRIMARIES),
        ("-color_trc", &tags.transfer, &TRANSFERS),
    ];
    let numbered = named.iter().filter_map(|(option, tag, table)| {
        let tag = tag.as_deref()?;
        table.iter().find(|(name, _)| *name == tag).map(|(_, number)| (option, number.to_string()))
    });
    numbered.flat_map(|(option, number)| arguments([option, &number])).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::colour::{Coding, Matrix, Range};
    use crate::geom::Size;

    /// The constants of an option in `ffmpeg -h full`, in whose first group it stands.
    fn constants(help: &str, option: &str) -> Vec<(String, u8)> {
        let lines = help.lines().skip_while(|line| !line.starts_with(&format!("  -{option} ")));
        let lines = lines.skip(1).take_while(|line| line.starts_with("     "));
        let words = lines.map(|line| line.split_whitespace().collect::<Vec<_>>());
        words.filter_map(|words| Some((words[0].into(), words.get(1)?.parse().ok()?))).collect()
    }

    #[test]
    fn numbers_of_tags_are_those_of_ffmpeg() {
        let help =
            std::process::Command::new("ffmpeg").args(["-hide_banner", "-h", "full"]).output();
        let Ok(help) = help else { return };
        let help = String::from_utf8_lossy(&help.stdout);
        let tables: [(&str, &[(&str, u8)]); 4] = [
            ("colorspace", &MATRICES),
            ("color_range", &RANGES),
            ("color_primaries", &PRIMARIES),
            ("color_trc", &TRANSFERS),
        ];
        for (option, table) in tables {
            let known = constants(&help, option);
            assert!(known.len() > 4, "{option}: {known:?}");
            for (name, number) in known {
                // Several names of one number mean the same: one of them is in the table.
                let unsaid = ["unknown", "unspecified", "rgb"].contains(&name.as_str());
                assert!(unsaid || table.iter().any(|(_, own)| *own == number), "{option} {name}");
                let ours = table.iter().find(|(own, _)| *own == name);
                assert!(ours.is_none_or(|(_, own)| *own == number), "{option} {name}");
            }
        }
    }

    #[test]
    fn names_that_options_do_not_know_are_numbers() {
        let tags = Colorimetry {
            transfer: Some("bt470bg".into()),
            matrix: Some("gbr".into()),
            ..Colorimetry::default()
        };
        assert_eq!(tag_arguments(&tags), ["-color_trc", "5"]);
    }

    #[test]
    fn rgb_is_tagged_and_missing_tags_stay_missing() {
        assert_eq!(tag_arguments(&tags(None)).len(), 8);
        assert!(tag_arguments(&tags(Some(&Colorimetry::default()))).is_empty());
        let coding = Coding::of(&tags(None), Size::new(10, 10));
        assert_eq!(coding, Coding { matrix: Matrix::Bt709, range: Range::Limited });
    }
}
