//! All figures as comma-separated values (RFC 4180): one line an input, method, and
//! whether it is refined.

use std::path::Path;

use crate::program::scores::Evaluation;
use crate::program::scores::clip::{ClipMethodScores, ClipScores};
use crate::program::scores::disturb::Disturbance;
use crate::program::scores::still::{MethodScores, StillScores};

const HEAD: [&str; 34] = [
    "input",
    "kind",
    "method",
    "width",
    "height",
    "frames",
    "file_bytes",
    "candidates",
    "candidates_rate",
    "seeds",
    "seeds_rate",
    "triangles",
    "mesh_bytes",
    "reduction",
    "ssim",
    "ssim_gaussian",
    "mse",
    "psnr_db",
    "ms",
    "noise_ssim",
    "noise_mse",
    "occlusion_ssim",
    "occlusion_mse",
    "jpeg_ssim",
    "jpeg_mse",
    "faint_noise_ssim",
    "faint_noise_mse",
    "fps",
    "fdb",
    "e_warp",
    "source_e_warp",
    "seeds_kept",
    "refined",
    "refine_steps",
];

/// The figures of `found`; fields without a figure are empty.
pub(super) fn csv(found: &Evaluation) -> String {
    let mut text = HEAD.join(",") + "\n";
    for still in &found.stills {
        for refined in [false, true] {
            still.of(refined).iter().for_each(|s| line(&mut text, &of_still(still, s, refined)));
        }
    }
    for clip in &found.clips {
        for refined in [false, true] {
            clip.of(refined).iter().for_each(|s| line(&mut text, &of_clip(clip, s, refined)));
        }
    }
    text
}

/// Fields by the name of their column; the others stay empty.
type Fields = Vec<(&'static str, String)>;

fn of_still(still: &StillScores, s: &MethodScores, refined: bool) -> Fields {
    let mut fields = vec![
        ("input", quoted(&still.path)),
        ("kind", "still".to_owned()),
        ("method", s.method.clone()),
        ("width", still.size.width.to_string()),
        ("height", still.size.height.to_string()),
        ("frames", "1".to_owned()),
        ("file_bytes", optional(still.file_bytes)),
        ("candidates", s.candidates.to_string()),
        ("candidates_rate", s.candidates_rate.to_string()),
        ("seeds", s.seeds.to_string()),
        ("seeds_rate", s.seeds_rate.to_string()),
        ("triangles", s.triangles.to_string()),
        ("mesh_bytes", s.mesh_bytes.to_string()),
        ("reduction", optional(s.reduction)),
        ("ssim", optional(s.likeness.ssim)),
        ("ssim_gaussian", optional(s.likeness.ssim_gaussian)),
        ("mse", s.likeness.mse.to_string()),
        ("psnr_db", optional(s.likeness.psnr)),
        ("ms", s.ms.to_string()),
        ("refined", refined.to_string()),
        ("refine_steps", s.refine_steps.to_string()),
    ];
    for &(disturbance, likeness) in &s.robustness {
        let [ssim, mse] = match disturbance {
            Disturbance::FaintNoise => ["faint_noise_ssim", "faint_noise_mse"],
            Disturbance::Noise => ["noise_ssim", "noise_mse"],
            Disturbance::Occlusion => ["occlusion_ssim", "occlusion_mse"],
            Disturbance::Jpeg => ["jpeg_ssim", "jpeg_mse"],
        };
        fields.extend([(ssim, optional(likeness.ssim)), (mse, likeness.mse.to_string())]);
    }
    fields
}

fn of_clip(clip: &ClipScores, s: &ClipMethodScores, refined: bool) -> Fields {
    vec![
        ("input", quoted(&clip.path)),
        ("kind", "clip".to_owned()),
        ("method", s.method.clone()),
        ("width", clip.size.width.to_string()),
        ("height", clip.size.height.to_string()),
        ("frames", clip.frames.to_string()),
        ("seeds", s.seeds.to_string()),
        ("ssim", optional(s.ssim)),
        ("mse", s.mse.to_string()),
        ("fps", s.fps.to_string()),
        ("fdb", optional(s.fdb)),
        ("e_warp", optional(s.warp_error)),
        ("source_e_warp", optional(clip.source_warp_error)),
        ("seeds_kept", s.seeds_kept.to_string()),
        ("refined", refined.to_string()),
    ]
}

fn line(text: &mut String, fields: &Fields) {
    let field = |head: &&str| {
        let named = fields.iter().find(|(name, _)| name == head);
        named.map_or("", |(_, value)| value)
    };
    let cells: Vec<_> = HEAD.iter().map(field).collect();
    text.push_str(&cells.join(","));
    text.push('\n');
}

fn optional(value: Option<impl ToString>) -> String {
    value.map_or_else(String::new, |v| v.to_string())
}

fn quoted(path: &Path) -> String {
    let text = path.to_string_lossy();
    if text.contains([',', '"', '\n', '\r']) {
        format!("\"{}\"", text.replace('"', "\"\""))
    } else {
        text.into_owned()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_with_commas_are_quoted() {
        assert_eq!(quoted(Path::new("a,b \"c\".png")), "\"a,b \"\"c\"\".png\"");
        assert_eq!(quoted(Path::new("plain.png")), "plain.png");
    }
}
