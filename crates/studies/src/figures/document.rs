//! The document: each figure with its picture, its scene, what the paper says, and what is found.

use std::path::Path;

use vibrochain_floquet::Tolerance;

use crate::figures::captions::caption;
use crate::figures::drawn::file_name;
use crate::figures::scene::FigureScene;
use vibrochain_maps::manifest::VERSION;

/// The whole.
pub(super) struct Document {
    /// The folder of the pictures, as seen from the document.
    pictures: String,
    parts: Vec<String>,
}

impl Document {
    /// A document at `document` for pictures in `out`.
    pub(super) fn new(out: &Path, document: Option<&Path>, only: &[String]) -> Self {
        let beside = document.and_then(Path::parent).unwrap_or(Path::new(""));
        let pictures = out.strip_prefix(beside).unwrap_or(out).display().to_string();
        let only = if only.is_empty() { String::new() } else { format!(" --only {}", only.join(",")) };
        let preface = format!(
            "# The figures of the paper\n\n\
             Made by `studies figures --out {} --document {}{only}` ([using.md](using.md) says how to run it), mapgen \
             {VERSION}, as PNG, SVG and CSV. `--only 9` makes one figure; `--scenes DIR` takes the scenes from a folder. \
             The paper's, with all parameters, are in `scenes/figures`; `mapgen orbit --scene` finds the breather of each, of a \
             map that at one point (`--family double-sided --omega 1.5 --gamma2 .1`): that of figure 8 is the example of [how/breathers.md](how/breathers.md). Numbers are the paper's labels: the last \
             figure, 14 in print, is labelled 15 and is 15a to 15d here.\n\n\
             Impulses are signed and whole (the paper's 2p₁, −2p₂); margin is the smallest distance of any mass to a \
             barrier at a turning point; |μ| is the spectral radius, per period of the orbit. Of several solutions the one \
             with the smallest spectral radius is shown, unless all are.",
            out.display(),
            document.unwrap_or(Path::new("FILE")).display()
        );
        Self { pictures, parts: vec![preface] }
    }

    /// Adds a figure.
    pub(super) fn add(&mut self, id: &str, scene: &FigureScene, findings: &[String]) {
        let title = match scene {
            FigureScene::Map(scene) => match scene.task.tolerance {
                Tolerance::Rounding => scene.heading(),
                Tolerance::Excess(excess) => {
                    format!("{}, excess below {excess} a period counts as stable", scene.heading())
                }
            },
            FigureScene::Lines(scene) => scene.title.clone(),
        };
        self.parts.push(format!("## Figure {id}: {title}"));
        let file = file_name(id, "", "png");
        let place = if self.pictures.is_empty() { file } else { format!("{}/{file}", self.pictures) };
        self.parts.push(format!("![Figure {id}]({place})"));
        if let Some(caption) = caption(id) {
            self.parts.push(format!("*The paper:* {}", caption.paper));
            self.parts.push(format!("*Here:* {}", caption.here));
        }
        self.parts.extend(findings.iter().cloned());
    }

    /// The Markdown text.
    pub(super) fn markdown(&self) -> String {
        self.parts.join("\n\n") + "\n"
    }
}
