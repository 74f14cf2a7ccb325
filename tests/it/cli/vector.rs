//! Outputs that hold facets rather than pixels.

use super::{Folder, stderr};

fn text(folder: &Folder, name: &str) -> String {
    String::from_utf8(folder.read(name)).expect("text")
}

#[test]
fn a_still_becomes_an_svg() {
    let folder = Folder::new();
    folder.still("in.png", 96, 64);
    folder.run("render in.png -o out.svg --points 60 --outline=white --outline-width 2").success();
    let svg = text(&folder, "out.svg");
    assert!(
        svg.starts_with("<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"96\" height=\"64\"")
    );
    assert!(svg.contains("<title>in</title>") && svg.contains("<g id=\"facets\">"), "{svg}");
    assert!(svg.contains("<g id=\"outline\" fill=\"none\" stroke=\"#ffffff\""), "{svg}");
    folder.run("render in.png -o plain.svg --points 60 --svg-seams none").success();
    folder.run("render in.png -o stroke.svg --points 60 --svg-seams stroke").success();
    assert!(text(&folder, "stroke.svg").contains("stroke-linejoin=\"round\""));
    assert!(text(&folder, "plain.svg").len() < svg.len());
}

#[test]
fn frames_become_numbered_svgs_and_svgs_in_a_folder() {
    let folder = Folder::new();
    folder.sequence("in", 3);
    folder.run("render in -o out_%02d.svg --points 40").success();
    folder.run("render in -o out/ --format svg --points 40").success();
    for number in ["01", "02", "03"] {
        let there = folder.read(&format!("out/00{number}.svg"));
        assert_eq!(folder.read(&format!("out_{number}.svg")), there);
    }
    let bad = folder.run("render in -o other/ --format mp4").failure().code(2);
    assert!(stderr(&bad).contains(".svg"), "{}", stderr(&bad));
}

#[test]
fn an_animated_svg_plays_by_itself_and_has_a_limit() {
    let folder = Folder::new();
    folder.gif("in.gif", &[100, 40, 60]);
    folder.run("render in.gif -o out.svg --points 40").success();
    let svg = text(&folder, "out.svg");
    assert_eq!(svg.matches("<animate attributeName=\"display\"").count(), 3, "{svg}");
    assert!(svg.contains("dur=\"0.2s\"") && svg.contains("keyTimes=\"0;0.5;0.7\""), "{svg}");
    assert!(svg.contains("repeatCount=\"indefinite\"") && !svg.contains("<script"), "{svg}");
}

#[test]
fn a_mesh_stream_paints_the_same_bytes_again() {
    let folder = Folder::new();
    folder.gif("in.gif", &[100, 40, 60, 60]);
    for (name, look) in [("plain", ""), ("lined", "--outline=red --saturation 1.4 --edges hard")] {
        folder.run(&format!("render in.gif -o {name}.polyreel --points 60 {look}")).success();
        for output in ["y4m", "gif"] {
            folder.run(&format!("render in.gif -o a.{output} -y --points 60 {look}")).success();
            folder.run(&format!("render {name}.polyreel -o b.{output} -y")).success();
            assert!(folder.read(&format!("a.{output}")) == folder.read(&format!("b.{output}")));
        }
    }
    let info = folder.run("info plain.polyreel").success();
    assert!(super::stdout(&info).contains("polyreel"), "{}", super::stdout(&info));
    folder.run("render in.gif -o a_%d.svg --points 60").success();
    folder.run("render plain.polyreel -o b_%d.svg").success();
    let paths = |name: &str| text(&folder, name).matches("<path").count();
    assert_eq!(paths("a_3.svg"), paths("b_3.svg"));
}

#[test]
fn a_mesh_stream_is_painted_at_other_sizes_and_in_other_looks() {
    let folder = Folder::new();
    folder.gif("in.gif", &[100, 40, 60]);
    folder.run("render in.gif -o in.polyreel --points 60").success();
    folder.run("render in.polyreel -o big_%d.png --scale 2.5 --outline=white --frames 2").success();
    assert_eq!(folder.open("big_2.png").dimensions(), (120, 80));
    assert!(!folder.path("big_3.png").exists());
    assert!(folder.open("big_1.png").pixels().any(|pixel| pixel.0 == [255; 4]));
    folder.run("render in.gif -o direct_%d.png --scale 2.5 --points 60").success();
    assert_eq!(folder.open("direct_1.png").dimensions(), (120, 80));
    let refused = folder.run("render in.polyreel -o out.gif --points 90").failure().code(2);
    assert!(stderr(&refused).contains("--outline"), "{}", stderr(&refused));
}

#[test]
fn a_mesh_stream_comes_through_a_pipe_and_may_break_off() {
    let folder = Folder::new();
    folder.gif("in.gif", &[100, 40, 60, 60]);
    folder.run("render in.gif -o in.polyreel --points 60").success();
    let bytes = folder.read("in.polyreel");
    folder.write("cut.polyreel", &bytes[..bytes.len() - 30]);
    let broken = folder.run("render cut.polyreel -o out.gif").failure().code(1);
    assert!(stderr(&broken).contains("cut short"), "{}", stderr(&broken));
    folder.run("render cut.polyreel -o out.gif --allow-truncated").success();
    assert_eq!(folder.delays("out.gif").len(), 3);
    let mut piped = assert_cmd::Command::new(env!("CARGO_BIN_EXE_polyreel"));
    piped.current_dir(folder.0.path()).write_stdin(bytes);
    piped.args(["render", "-", "-o", "piped.gif"]).assert().success();
    assert_eq!(folder.delays("piped.gif"), [100, 40, 60, 60]);
    let mut damaged = folder.read("in.polyreel");
    let middle = damaged.len() / 2;
    damaged[middle] ^= 1;
    folder.write("damaged.polyreel", &damaged);
    let refused = folder.run("render damaged.polyreel -o none.gif").failure().code(1);
    assert!(stderr(&refused).contains("checksum"), "{}", stderr(&refused));
    assert!(!folder.path("none.gif").exists());
}

#[test]
fn a_mesh_sequence_is_written_for_3d_programs() {
    let folder = Folder::new();
    folder.gif("in.gif", &[100, 100, 100]);
    folder.run("render in.gif -o out.usda --points 40").success();
    let usd = text(&folder, "out.usda");
    assert!(usd.starts_with("#usda 1.0\n") && usd.contains("upAxis = \"Y\""));
    let samples = |name: &str| {
        let part = usd.split(&format!("{name}.timeSamples = {{\n")).nth(1).expect("an attribute");
        part.lines().take_while(|line| line.contains(": [")).count()
    };
    for name in ["points", "faceVertexCounts", "faceVertexIndices", "primvars:displayColor"] {
        assert_eq!(samples(name), 3, "{name}");
    }
}

#[test]
fn a_page_holds_the_stream_and_nothing_from_elsewhere() {
    use base64::prelude::{BASE64_STANDARD, Engine as _};
    let folder = Folder::new();
    folder.gif("a<b.gif", &[100, 40, 60]);
    folder.run("render a<b.gif -o out.html --points 40").success();
    folder.run("render a<b.gif -o out.polyreel --points 40").success();
    let page = text(&folder, "out.html");
    assert!(page.starts_with("<!DOCTYPE html>") && page.contains("<title>a&lt;b</title>"));
    assert!(!page.contains("http") && !page.contains(" src="), "it needs nothing from elsewhere");
    let start = page.find("id=\"stream\">").expect("a stream") + 12;
    let stream = page[start..].split('<').next().expect("an end");
    let stream = BASE64_STANDARD.decode(stream).expect("base64");
    assert!(stream == folder.read("out.polyreel"));
}

#[test]
fn stills_become_3d_models() {
    let folder = Folder::new();
    folder.still("in.png", 96, 64);
    folder.run("render in.png -o out.obj --points 40").success();
    folder.run("render in.png -o out.ply --points 40").success();
    let obj = text(&folder, "out.obj");
    let faces = obj.lines().filter(|line| line.starts_with("f ")).count();
    assert_eq!(obj.lines().filter(|line| line.starts_with("v ")).count(), 3 * faces);
    let ply = folder.read("out.ply");
    assert!(String::from_utf8_lossy(&ply).contains(&format!("element face {faces}\n")));
    folder.gif("in.gif", &[100, 100]);
    folder.run("render in.gif -o out_%d.ply --points 40").success();
    assert!(folder.path("out_2.ply").exists());
    let refused = folder.run("render in.gif -o many.obj --points 40").failure().code(2);
    assert!(stderr(&refused).contains("_%04d.obj"), "{}", stderr(&refused));
}

#[cfg(unix)]
#[test]
fn a_mesh_stream_and_y4m_come_through_a_named_pipe() {
    let folder = Folder::new();
    folder.gif("in.gif", &[40, 40, 40]);
    folder.run("render in.gif -o in.polyreel --points 60").success();
    folder.run("render in.gif -o in.y4m --points 60").success();
    let pipe = folder.path("pipe");
    let made = std::process::Command::new("mkfifo").arg(&pipe).status().expect("mkfifo runs");
    assert!(made.success());
    for name in ["in.polyreel", "in.y4m"] {
        let (pipe, bytes) = (pipe.clone(), folder.read(name));
        // Opens when the program does; a program that ends early is its own failure.
        let writing = std::thread::spawn(move || std::fs::write(pipe, bytes).is_ok());
        folder.run("render pipe -o out_%d.png -y --frames 3").success();
        assert!(folder.path("out_3.png").exists() && writing.join().expect("no panic"), "{name}");
        std::fs::remove_file(folder.path("out_3.png")).expect("it is there");
    }
}

#[test]
fn lines_along_what_is_faint_are_as_faint_in_an_svg() {
    let folder = Folder::new();
    let faint = image::RgbaImage::from_fn(48, 32, |x, y| {
        image::Rgba([(x * 5) as u8, (y * 8) as u8, 90, if x < 24 { 128 } else { 255 }])
    });
    faint.save(folder.path("in.png")).expect("a writable folder");
    folder.run("render in.png -o out.svg --points 30 --outline=white").success();
    let svg = text(&folder, "out.svg");
    assert!(svg.contains("stroke=\"#ffffff\" stroke-width"), "{svg}");
    assert!(svg.contains("opacity=\"0.5") && svg.contains("<mask id=\"beside-lines-1\""), "{svg}");
}
