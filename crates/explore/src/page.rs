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

/// How every page begins, up to its title. (A macro: `concat!` takes no constants.)
macro_rules! head {
    () => {
        r#"<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<link rel="icon" href="icon.svg" type="image/svg+xml">
<link rel="stylesheet" href="style.css">
"#
    };
}

macro_rules! files {
    ($($name:literal $kind:ident $($head:ident)? $file:literal),* $(,)?) => {
        /// The file of that name.
        pub(crate) fn file(name: &str) -> Option<File> {
            match name {
                $($name => Some(File { kind: $kind, text: concat!($($head!(),)? include_str!(concat!("../page/", $file))) }),)*
                _ => None,
            }
        }
    };
}

files! {
    "" HTML head "index.html",
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
    "structure.html" HTML head "structure.html",
    "structure.js" SCRIPT "structure.js",
}
