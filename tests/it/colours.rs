//! Colours of 16 bits in wide profiles, which become what LittleCMS makes of them. Profiles and figures are in
//! `tests/reference`, with their origin.

use std::path::{Path, PathBuf};

use polyreel::source::{self, SourceOptions};
use tiff::encoder::{TiffEncoder, colortype};
use tiff::tags::Tag;

/// Profiles, with the mean and the largest difference from LittleCMS, in levels of 8 bits. Rounding alone is 0.25
/// and 0.5. Tables are sampled again by `moxcms`, with 33 points a side.
const PROFILES: [(&str, f64, f64); 8] = [
    ("display-p3", 0.3, 1.0),
    ("adobe-rgb", 0.3, 1.0),
    ("prophoto", 0.3, 1.0),
    ("linear-p3", 0.3, 1.0),
    ("table-16", 0.5, 7.0),
    ("table-8", 0.6, 10.0),
    ("table-4", 0.5, 7.0),
    ("lightness", 0.3, 1.0),
];

/// A row of pixels in a profile, and the same in sRGB.
struct Colours {
    icc: Vec<u8>,
    channels: usize,
    values: Vec<u16>,
    wanted: Vec<[f64; 3]>,
}

impl Colours {
    fn of(profile: &str) -> Self {
        let file = |extension| {
            let path = format!("tests/reference/colours-{profile}.{extension}");
            std::fs::read(Path::new(env!("CARGO_MANIFEST_DIR")).join(path)).expect("a reference")
        };
        let text = String::from_utf8(file("txt")).expect("figures");
        let lines = text.lines().map(|line| {
            let numbers = line.split(' ').map(|number| number.parse().expect("a number"));
            numbers.collect::<Vec<f64>>()
        });
        let lines: Vec<Vec<f64>> = lines.collect();
        let channels = lines[0].len() - 3;
        let values = lines.iter().flat_map(|line| line[..channels].iter().map(|&v| v as u16));
        let wanted = lines.iter().map(|line| [0, 1, 2].map(|i| line[channels + i]));
        Self { icc: file("icc"), channels, values: values.collect(), wanted: wanted.collect() }
    }

    fn png(&self, path: &Path) {
        let mut info = png::Info::with_size(self.wanted.len() as u32, 1);
        info.icc_profile = Some(self.icc.clone().into());
        info.bit_depth = png::BitDepth::Sixteen;
        info.color_type =
            if self.channels == 1 { png::ColorType::Grayscale } else { png::ColorType::Rgb };
        let file = std::fs::File::create(path).expect("a writable folder");
        let mut writer =
            png::Encoder::with_info(file, info).expect("sound").write_header().expect("a header");
        let bytes: Vec<u8> = self.values.iter().flat_map(|v| v.to_be_bytes()).collect();
        writer.write_image_data(&bytes).expect("pixels");
    }

    fn tiff(&self, path: &Path) {
        let file = std::fs::File::create(path).expect("a writable folder");
        let mut encoder = TiffEncoder::new(file).expect("a TIFF");
        let width = self.wanted.len() as u32;
        if self.channels == 1 {
            let mut image = encoder.new_image::<colortype::Gray16>(width, 1).expect("an image");
            image.encoder().write_tag(Tag::IccProfile, &self.icc[..]).expect("a tag");
            image.write_data(&self.values).expect("pixels");
        } else {
            let mut image = encoder.new_image::<colortype::RGB16>(width, 1).expect("an image");
            image.encoder().write_tag(Tag::IccProfile, &self.icc[..]).expect("a tag");
            image.write_data(&self.values).expect("pixels");
        }
    }

    /// The mean and the largest difference of the picture in `path`.
    fn difference(&self, path: &Path) -> (f64, f64) {
        let input = source::open(&[path], &SourceOptions::default()).expect("a picture");
        let mut pictures = input.start().expect("a picture");
        let frame = pictures.next().expect("a picture").expect("a picture").frame;
        let pixels = frame.pixels().iter().zip(&self.wanted);
        let apart = pixels.flat_map(|(ours, wanted)| {
            (0..3).map(move |i| (f64::from(ours[i]) - wanted[i]).abs()).collect::<Vec<f64>>()
        });
        let apart: Vec<f64> = apart.collect();
        (apart.iter().sum::<f64>() / apart.len() as f64, apart.iter().copied().fold(0.0, f64::max))
    }
}

fn check(extension: &str, write: impl Fn(&Colours, &Path)) {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let apart = PROFILES.map(|(profile, ..)| {
        let colours = Colours::of(profile);
        let path: PathBuf = folder.path().join(format!("{profile}.{extension}"));
        write(&colours, &path);
        let (mean, most) = colours.difference(&path);
        println!("{profile}: {mean:.2} and at most {most:.2} levels");
        (mean, most)
    });
    for ((profile, mean, most), apart) in PROFILES.iter().zip(apart) {
        assert!(apart.0 <= *mean && apart.1 <= *most, "{profile}: {apart:?}");
    }
}

#[test]
fn profiles_of_deep_pngs_are_converted_as_by_littlecms() {
    check("png", Colours::png);
}

/// LittleCMS gives the same figures for either version.
#[test]
fn the_version_of_a_profile_does_not_change_what_its_table_means() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("table.png");
    for (profile, mean, most) in
        PROFILES.into_iter().filter(|p| ["table-16", "table-8"].contains(&p.0))
    {
        for version in [2, 4] {
            let mut colours = Colours::of(profile);
            colours.icc[8] = version;
            colours.png(&path);
            let apart = colours.difference(&path);
            assert!(apart.0 <= mean && apart.1 <= most, "{profile}, version {version}: {apart:?}");
        }
    }
}

#[test]
fn profiles_of_deep_tiffs_are_converted_as_by_littlecms() {
    check("tiff", Colours::tiff);
}
