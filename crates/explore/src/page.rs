//! The files of the page, in the program.

/// A file: its type, its text.
pub(crate) struct File {
    pub(crate) kind: &'static str,
    pub(crate) text: &'static str,
}

/// Types of files.
const HTML: &str = "text/html; charset=utf-8";
const STYLE: &str = "text/css; charset=utf-8";
const PICTURE: &str = "image/svg+xml";
const SCRIPT: &str = "text/javascript; charset=utf-8";

macro_rules! files {
    ($($name:literal $kind:ident $($part:literal)+),* $(,)?) => {
        /// The file of that name.
        pub(crate) fn file(name: &str) -> Option<File> {
            match name {
                $($name => Some(File { kind: $kind, text: concat!($(include_str!(concat!("../page/", $part))),+) }),)*
                _ => None,
            }
        }
    };
}

files! {
    "" HTML "head.html" "index.html",
    "icon.svg" PICTURE "icon.svg",
    "style.css" STYLE "style.css",
    "main.js" SCRIPT "main.js",
    "ask.js" SCRIPT "ask.js",
    "dom.js" SCRIPT "dom.js",
    "state.js" SCRIPT "state.js",
    "plane.js" SCRIPT "plane.js",
    "tiles.js" SCRIPT "tiles.js",
    "scale.js" SCRIPT "scale.js",
    "map.js" SCRIPT "map.js",
    "controls.js" SCRIPT "controls.js",
    "point.js" SCRIPT "point.js",
    "chart.js" SCRIPT "chart.js",
    "chain.js" SCRIPT "chain.js",
    "run.js" SCRIPT "run.js",
    "overlays.js" SCRIPT "overlays.js",
    "take.js" SCRIPT "take.js",
    "structure.html" HTML "head.html" "structure.html",
    "structure.js" SCRIPT "structure.js",
}
