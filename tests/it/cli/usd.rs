//! USD files in the programs that read them: the reference library, and Blender.

use std::process::{Command, Output};

use super::{Folder, stderr};

/// Runs Python in the folder; `PYTHON` names another one than `python3`.
fn python(folder: &Folder, code: &str) -> std::io::Result<Output> {
    let python = std::env::var("PYTHON").unwrap_or_else(|_| "python3".to_owned());
    Command::new(python).args(["-c", code]).current_dir(folder.0.path()).output()
}

/// Whether Python has `module`, of the package `package`. Its absence is said.
fn has(folder: &Folder, module: &str, package: &str) -> bool {
    let found = python(folder, &format!("import {module}")).is_ok_and(|done| done.status.success());
    if !found {
        eprintln!("SKIPPED: Python has no {package} (pip install {package})");
    }
    found
}

fn succeed(folder: &Folder, code: &str) {
    let done = python(folder, code).expect("it ran before");
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
}

/// Needs usd-core; with `REQUIRE_PYTHON=1` its absence is a failure.
#[test]
fn the_reference_library_reads_every_frame() {
    let folder = Folder::new();
    if !has(&folder, "pxr", "usd-core") {
        assert!(std::env::var("REQUIRE_PYTHON").is_err(), "usd-core is required");
        return;
    }
    folder.gif("in.gif", &[100, 100, 100]);
    folder.run("render in.gif -o out.usda --points 40").success();
    succeed(
        &folder,
        "
from pxr import Usd, UsdGeom
stage = Usd.Stage.Open('out.usda')
mesh = UsdGeom.Mesh(stage.GetDefaultPrim())
assert UsdGeom.GetStageUpAxis(stage) == 'Y'
times = mesh.GetPointsAttr().GetTimeSamples()
assert len(times) == 3, times
for time in times:
    points, counts = mesh.GetPointsAttr().Get(time), mesh.GetFaceVertexCountsAttr().Get(time)
    indices, colours = mesh.GetFaceVertexIndicesAttr().Get(time), mesh.GetDisplayColorPrimvar()
    assert UsdGeom.Mesh.ValidateTopology(indices, counts, len(points))[0]
    assert colours.GetInterpolation() == 'uniform' and len(colours.Get(time)) == len(counts)
",
    );
}

/// Blender draws the first, the second and the third frame as it shows them: upright, with their colours. Needs the package
/// bpy, which is large: it is skipped without it, also where Python is required.
#[test]
fn blender_draws_the_frames_upright_with_their_colours() {
    let folder = Folder::new();
    if !has(&folder, "bpy", "bpy") {
        return;
    }
    folder.gif("in.gif", &[100, 100, 100]);
    folder.run("render in.gif -o out.usda --points 60 --edges hard").success();
    folder.run("render in.gif -o ours_%d.png --points 60 --edges hard").success();
    succeed(&folder, BLENDER);
    for frame in 1..=3 {
        let [ours, theirs] =
            ["ours", "theirs"].map(|name| folder.open(&format!("{name}_{frame}.png")));
        assert_eq!(ours.dimensions(), theirs.dimensions());
        let apart: u64 = ours
            .pixels()
            .zip(theirs.pixels())
            .flat_map(|(a, b)| (0..3).map(move |c| u64::from(a[c].abs_diff(b[c]))))
            .sum();
        let mean = apart as f64 / f64::from(3 * ours.width() * ours.height());
        // Blender's edges are smooth.
        assert!(mean < 6.0, "frame {frame}: {mean}");
    }
}

/// A camera before the picture, and the colours of its faces as light.
const BLENDER: &str = "
import bpy, os
bpy.ops.wm.read_factory_settings(use_empty=True)
bpy.ops.wm.usd_import(filepath=os.path.abspath('out.usda'))
scene = bpy.context.scene
mesh = next(o for o in bpy.data.objects if o.type == 'MESH')
material = bpy.data.materials.new('colours')
material.use_nodes = True
tree = material.node_tree
tree.nodes.clear()
colours = tree.nodes.new('ShaderNodeAttribute')
colours.attribute_name = 'displayColor'
light = tree.nodes.new('ShaderNodeEmission')
out = tree.nodes.new('ShaderNodeOutputMaterial')
tree.links.new(colours.outputs['Color'], light.inputs['Color'])
tree.links.new(light.outputs[0], out.inputs[0])
mesh.data.materials.append(material)
width, _, height = mesh.dimensions.x, 0, mesh.dimensions.y
camera = bpy.data.objects.new('camera', bpy.data.cameras.new('camera'))
camera.data.type = 'ORTHO'
camera.data.ortho_scale = max(width, height)
camera.location = (width / 2, -10, height / 2)
camera.rotation_euler = (3.14159265 / 2, 0, 0)
scene.collection.objects.link(camera)
scene.camera = camera
scene.render.engine = 'CYCLES'
scene.cycles.samples = 16
scene.view_settings.view_transform = 'Standard'
scene.render.resolution_x = round(100 * width)
scene.render.resolution_y = round(100 * height)
for frame in range(3):
    scene.frame_set(frame)
    scene.render.filepath = os.path.abspath(f'theirs_{frame + 1}.png')
    bpy.ops.render.render(write_still=True)
";

#[test]
fn refusals_name_what_holds_frames() {
    let folder = Folder::new();
    folder.gif("in.gif", &[100, 100]);
    let refused = folder.run("render in.gif -o out.usda --fill linear").failure();
    assert!(stderr(&refused).contains("linear"), "{}", stderr(&refused));
}
