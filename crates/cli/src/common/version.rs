//! What this build is, what it can do, and on what machine it runs: for reports of what went wrong.

use vibrochain_maps::manifest::{REVISION, VERSION, target};

use crate::common::threads::{VARIABLE, cores};

/// Features of the build, and whether they are in.
const FEATURES: [(&str, bool, &str); 3] = [
    ("compress", cfg!(feature = "compress"), "tables named .gz and .zst"),
    ("explore", cfg!(feature = "explore"), "maps in a browser"),
    ("parquet", cfg!(feature = "parquet"), "tables named .parquet"),
];

/// What `mapgen --version --verbose` prints.
pub(crate) fn about() -> String {
    let mut lines = vec![format!("mapgen {VERSION}, revision {}", REVISION.unwrap_or("not known"))];
    for (name, there, what) in FEATURES {
        lines.push(format!("feature {name:<9} {}  ({what})", if there { "yes" } else { "no " }));
    }
    lines.push(format!("built for {} on {}", target(), std::env::consts::OS));
    let asked = std::env::var(VARIABLE).map_or(String::new(), |value| format!(", {VARIABLE}={value}"));
    lines.push(format!("cores {}{asked}", cores()));
    lines.push(String::new());
    lines.join("\n")
}
