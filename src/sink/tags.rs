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

/// Options that tag a stream.
pub(crate) fn tag_arguments(tags: &Colorimetry) -> Vec<OsString> {
    let named = [
        ("-colorspace", &tags.matrix),
        ("-color_range", &tags.range),
        ("-color_primaries", &tags.primaries),
        ("-color_trc", &tags.transfer),
    ];
    let told = named.iter().filter_map(|(name, tag)| Some((name, tag.as_ref()?)));
    told.flat_map(|(name, tag)| arguments([name, tag])).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::colour::{Coding, Matrix, Range};
    use crate::geom::Size;

    #[test]
    fn rgb_is_tagged_and_untold_stays_untold() {
        assert_eq!(tag_arguments(&tags(None)).len(), 8);
        assert!(tag_arguments(&tags(Some(&Colorimetry::default()))).is_empty());
        let coding = Coding::of(&tags(None), Size::new(10, 10));
        assert_eq!(coding, Coding { matrix: Matrix::Bt709, range: Range::Limited });
    }
}
