use super::*;
use crate::chance::{Purpose, rank};
use crate::frame::{Frame, Rgba};
use crate::geom::{Point, Size};
use crate::mesh::Mesh;
use crate::options::{Options, Points};
use crate::render::Renderer;

const SIZE: Size = Size::new(120, 80);

/// Frame `t` of a clip in which a disc wanders over grain; a cut at `cut`.
fn picture(t: u32, cut: u32, alpha: bool) -> Frame {
    let pixel = |i: u32| {
        let (x, y) = (i % SIZE.width, i / SIZE.width);
        let grain = (rank(4, Purpose::Noise, x, y) % 24) as u8;
        let (dx, dy) = (f64::from(x) - 30.0 - 3.0 * f64::from(t), f64::from(y) - 40.0);
        let disc = dx.hypot(dy) < 20.0;
        let base = if t < cut { [x as u8, 200 - y as u8, 90] } else { [20, y as u8, x as u8 * 2] };
        let [r, g, b] = if disc { [230, 60, 40] } else { base };
        let a = if alpha { (x as u8).saturating_mul(3) } else { 255 };
        [r ^ (grain & 7), g.wrapping_add(grain), b, a]
    };
    Frame::new(SIZE, (0..SIZE.pixels() as u32).map(pixel).collect()).expect("a picture")
}

/// The meshes of a clip of `frames` with their colours.
fn clip(frames: u32, alpha: bool) -> Vec<(Mesh, Vec<Rgba>)> {
    let options = Options { points: Points::Count(150), ..Options::default() };
    let mut renderer = Renderer::new(&options).expect("sound options");
    let render = |t| {
        let rendered = renderer.render(&picture(t, frames / 2, alpha)).expect("renders");
        let colours = rendered.mesh.fills.iter().map(|fill| fill.colour).collect();
        (rendered.mesh, colours)
    };
    (0..frames).map(render).collect()
}

fn time(t: usize) -> Time {
    let rate = |n: i64| Rational::new(n * 1001, 30000);
    Time { start: rate(t as i64), length: (!t.is_multiple_of(3)).then(|| rate(1)) }
}

fn written(clip: &[(Mesh, Vec<Rgba>)]) -> Vec<u8> {
    written_on(clip, Grid::EXACT)
}

fn written_on(clip: &[(Mesh, Vec<Rgba>)], grid: Grid) -> Vec<u8> {
    let mut header = Header::default();
    header.put("rate", "30000/1001");
    header.put("title", "two\nlines = 2");
    let (mut writer, mut bytes) = MeshWriter::new(SIZE, grid, &header);
    for (t, (mesh, colours)) in clip.iter().enumerate() {
        bytes.append(&mut writer.frame(mesh, colours, time(t)).expect("a sound mesh"));
    }
    bytes.append(&mut writer.finish());
    bytes
}

fn read(bytes: &[u8]) -> Result<Vec<MeshFrame>, ReadError> {
    let mut reader = MeshReader::new(bytes)?;
    let mut frames = Vec::new();
    while let Some(frame) = reader.next_frame()? {
        frames.push(frame);
    }
    Ok(frames)
}

/// The triangles by their corners, with their colours: the same for meshes that differ only in numbers.
fn facets(mesh: &Mesh, colours: &[Rgba]) -> Vec<([Point; 3], Rgba)> {
    let corners = |t: usize| {
        let mut corners = mesh.triangle(t);
        let first = (0..3).min_by_key(|&i| corners[i]).unwrap_or(0);
        corners.rotate_left(first);
        corners
    };
    let mut facets: Vec<_> = (0..colours.len()).map(|t| (corners(t), colours[t])).collect();
    facets.sort_unstable();
    facets
}

#[test]
fn nothing_is_lost() {
    for alpha in [false, true] {
        let clip = clip(8, alpha);
        let bytes = written(&clip);
        let reader = MeshReader::new(&bytes[..]).expect("a header");
        assert_eq!(reader.size(), SIZE);
        assert_eq!(reader.header().get("rate"), Some("30000/1001"));
        assert_eq!(reader.header().get("title"), Some("two lines = 2"));
        let frames = read(&bytes).expect("a sound stream");
        assert_eq!(frames.len(), clip.len());
        for (t, (frame, (mesh, colours))) in frames.iter().zip(&clip).enumerate() {
            assert_eq!(frame.time, self::time(t));
            assert!(facets(&frame.mesh, &frame.colours) == facets(mesh, colours), "frame {t}");
        }
        let keys: Vec<_> = frames.iter().map(|frame| frame.is_key).collect();
        assert!(keys[0] && !keys[1], "{keys:?}");
        assert!(frames[1].ids.iter().filter(|id| frames[0].ids.contains(id)).count() > 80);
    }
}

/// What each vertex is called in the mesh, by where it stands.
fn names(mesh: &Mesh, ids: &[u64]) -> std::collections::HashMap<Point, u64> {
    mesh.vertices.iter().copied().zip(ids.iter().copied()).collect()
}

#[test]
fn vertices_keep_their_numbers_as_long_as_they_live() {
    let clip = clip(8, false);
    // Frames again and again, so that a key frame comes for its time alone.
    let many: Vec<_> = (0..260usize).map(|t| clip[t.saturating_sub(240).min(3)].clone()).collect();
    for clip in [clip, many] {
        let frames = read(&written(&clip)).expect("a sound stream");
        let mut known = std::collections::HashMap::new();
        for (frame, (mesh, _)) in frames.iter().zip(&clip) {
            let own = names(mesh, &mesh.ids);
            assert_eq!(own.len(), frame.ids.len());
            for (place, id) in names(&frame.mesh, &frame.ids) {
                // One of the mesh's is one of the stream's, and the other way round.
                assert_eq!(*known.entry(own[&place]).or_insert(id), id);
            }
        }
        let mut ids: Vec<u64> = known.values().copied().collect();
        ids.sort_unstable();
        ids.dedup();
        assert_eq!(ids.len(), known.len());
    }
}

#[test]
fn key_frames_stand_at_cuts() {
    let mut clip = clip(8, false);
    for (mesh, _) in &mut clip[4..] {
        // After a cut all vertices are new, wherever they stand.
        mesh.ids.iter_mut().skip(4).for_each(|id| *id += 1 << 20);
    }
    let keys: Vec<_> = read(&written(&clip)).expect("sound").iter().map(|f| f.is_key).collect();
    assert_eq!(keys, [true, false, false, false, true, false, false, false]);
}

#[test]
fn vertices_on_a_grid_take_fewer_bytes_and_stay_near() {
    let clip = clip(8, true);
    let mut last = written(&clip).len();
    for parts in [16, 4, 1] {
        let grid = Grid::of_parts(parts).expect("a power of two");
        let bytes = written_on(&clip, grid);
        assert!(bytes.len() < last, "{} bytes at {parts}", bytes.len());
        last = bytes.len();
        let frames = read(&bytes).expect("a sound stream");
        for (frame, (mesh, colours)) in frames.iter().zip(&clip) {
            let rounded = Mesh { vertices: super::grid::rounded(mesh, grid), ..mesh.clone() };
            assert!(facets(&frame.mesh, &frame.colours) == facets(&rounded, colours));
        }
    }
}

#[test]
fn colours_that_may_be_off_take_fewer_bytes_and_are_no_further_off() {
    let clip = clip(8, true);
    let (mut writer, mut bytes) = MeshWriter::new(SIZE, Grid::EXACT, &Header::default());
    writer = writer.with_colour_error(3);
    for (t, (mesh, colours)) in clip.iter().enumerate() {
        bytes.append(&mut writer.frame(mesh, colours, time(t)).expect("a sound mesh"));
    }
    bytes.append(&mut writer.finish());
    assert!(10 * bytes.len() < 9 * written(&clip).len(), "{} bytes", bytes.len());
    for (frame, (mesh, colours)) in read(&bytes).expect("a sound stream").iter().zip(&clip) {
        let found = facets(&frame.mesh, &frame.colours);
        for ((triangle, a), (other, b)) in found.iter().zip(facets(mesh, colours)) {
            assert!(*triangle == other && a[3] == b[3]);
            assert!((0..3).all(|c| a[c].abs_diff(b[c]) <= 3), "{a:?}, not {b:?}");
        }
    }
}

#[test]
fn what_stands_still_costs_next_to_nothing() {
    let one = clip(1, false).remove(0);
    let lengths = |n: usize| written(&vec![one.clone(); n]).len();
    let each = (lengths(9) - lengths(1)) / 8;
    assert!(each < 80, "{each} bytes a frame");
}

#[test]
fn a_stream_that_breaks_off_is_read_up_to_there() {
    let bytes = written(&clip(4, false));
    for cut in [bytes.len() - 1, bytes.len() - 18, bytes.len() * 2 / 3] {
        let mut reader = MeshReader::new(&bytes[..cut]).expect("a header");
        let mut count = 0;
        let error = loop {
            match reader.next_frame() {
                Ok(Some(_)) => count += 1,
                Ok(None) => panic!("no end was there"),
                Err(error) => break error,
            }
        };
        assert!(matches!(error, ReadError::Truncated), "{error}");
        assert!(count >= 2, "{count} frames");
    }
}

/// Sets the checksum of the packet that begins at `at` right; returns where the next one begins.
fn resealed(bytes: &mut [u8], at: usize) -> Option<usize> {
    let head = bytes.get(at..at + 9)?;
    let length = u32::from_le_bytes([head[1], head[2], head[3], head[4]]) as usize;
    let payload = bytes.get(at + 9..(at + 9).checked_add(length)?)?;
    let sum = checksum(head[0], payload);
    bytes[at + 5..at + 9].copy_from_slice(&sum.to_le_bytes());
    Some(at + 9 + length)
}

/// Damaged streams are errors or sound meshes; half of them have checksums that fit. More by `POLYREEL_MUTATIONS`.
#[test]
fn damage_never_panics() {
    let sound = written(&clip(4, false));
    let count =
        std::env::var("POLYREEL_MUTATIONS").ok().and_then(|n| n.parse().ok()).unwrap_or(400);
    for seed in 0..count {
        let mut bytes = sound.clone();
        let chance = |i: u32| rank(u64::from(seed), Purpose::Noise, i, 0) as usize;
        for i in 0..1 + seed % 4 {
            let at = chance(3 * i) % bytes.len();
            bytes[at] = match seed % 3 {
                0 => bytes[at] ^ (1 << (chance(3 * i + 1) % 8)),
                1 => chance(3 * i + 2) as u8,
                _ => [0, 255][chance(3 * i + 1) % 2],
            };
        }
        if seed % 2 == 0 {
            let mut at = Some(20);
            while let Some(here) = at {
                at = resealed(&mut bytes, here);
            }
        }
        if let Ok(frames) = read(&bytes) {
            assert!(frames.iter().all(|frame| frame.mesh.check().is_ok()));
        }
    }
}

#[test]
fn what_is_no_stream_is_refused() {
    let said = |bytes: &[u8]| read(bytes).expect_err("no stream").to_string();
    assert!(said(b"").contains("no mesh stream"));
    assert!(said(b"YUV4MPEG2 W2 H2 F1:1 and more").contains("no mesh stream"));
    let mut later = written(&clip(1, false));
    later[8] = 9;
    assert!(said(&later).contains("version 9"));
    later[8] = VERSION as u8;
    later[12..16].copy_from_slice(&u32::MAX.to_le_bytes());
    assert!(said(&later).contains("size"));
}
