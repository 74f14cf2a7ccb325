//! All figures as comma-separated values (RFC 4180): one line an input and method.

use std::path::Path;

use polyreel::evaluate::Evaluation;
use polyreel::evaluate::disturb::Disturbance;
use polyreel::evaluate::still::MethodScores;

const HEAD: [&str; 30] = [
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
    "fps",
    "fdb",
    "e_warp",
    "source_e_warp",
    "seeds_kept",
];

/// The figures of `found`; fields without a figure are empty.
pub(super) fn csv(found: &Evaluation) -> String {
    let mut text = HEAD.join(",") + "\n";
    for still in &found.stills {
        for s in &still.methods {
            let mut fields = vec![
                quoted(&still.path),
                "still".to_owned(),
                s.method.name().to_owned(),
                still.size.width.to_string(),
                still.size.height.to_string(),
                "1".to_owned(),
                still.file_bytes.map_or_else(String::new, |bytes| bytes.to_string()),
                s.candidates.to_string(),
                s.candidates_rate.to_string(),
                s.seeds.to_string(),
                s.seeds_rate.to_string(),
                s.triangles.to_string(),
                s.mesh_bytes.to_string(),
                optional(s.reduction),
                optional(s.likeness.ssim),
                optional(s.likeness.ssim_gaussian),
                s.likeness.mse.to_string(),
                optional(s.likeness.psnr),
                s.ms.to_string(),
            ];
            fields.extend(Disturbance::ALL.iter().flat_map(|&d| disturbed(s, d)));
            line(&mut text, fields);
        }
    }
    for clip in &found.clips {
        for s in &clip.methods {
            let mut fields = vec![String::new(); HEAD.len()];
            let mut put = |name: &str, value: String| {
                if let Some(i) = HEAD.iter().position(|&head| head == name) {
                    fields[i] = value;
                }
            };
            put("input", quoted(&clip.path));
            put("kind", "clip".to_owned());
            put("method", s.method.name().to_owned());
            put("width", clip.size.width.to_string());
            put("height", clip.size.height.to_string());
            put("frames", clip.frames.to_string());
            put("seeds", s.seeds.to_string());
            put("ssim", optional(s.ssim));
            put("mse", s.mse.to_string());
            put("fps", s.fps.to_string());
            put("fdb", optional(s.fdb));
            put("e_warp", optional(s.warp_error));
            put("source_e_warp", optional(clip.source_warp_error));
            put("seeds_kept", s.seeds_kept.to_string());
            line(&mut text, fields);
        }
    }
    text
}

fn line(text: &mut String, mut fields: Vec<String>) {
    fields.resize(HEAD.len(), String::new());
    text.push_str(&fields.join(","));
    text.push('\n');
}

fn optional(value: Option<f64>) -> String {
    value.map_or_else(String::new, |v| v.to_string())
}

fn disturbed(scores: &MethodScores, disturbance: Disturbance) -> [String; 2] {
    let found = scores.robustness.iter().find(|(d, _)| *d == disturbance).map(|(_, l)| *l);
    [optional(found.and_then(|l| l.ssim)), optional(found.map(|l| l.mse))]
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
