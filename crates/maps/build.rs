//! Notes the git revision for the manifests of sweeps; a build outside a checkout goes without.

use std::path::Path;
use std::process::Command;

fn main() {
    let git = Path::new("../../.git");
    println!("cargo:rerun-if-changed=build.rs");
    for watched in ["HEAD", "refs/heads"] {
        if git.join(watched).exists() {
            println!("cargo:rerun-if-changed=../../.git/{watched}");
        }
    }
    let revision = Command::new("git").args(["rev-parse", "--short=12", "HEAD"]).output().ok();
    let revision = revision.filter(|output| output.status.success() && git.exists());
    if let Some(revision) = revision.and_then(|output| String::from_utf8(output.stdout).ok()) {
        println!("cargo:rustc-env=VIBROCHAIN_REVISION={}", revision.trim());
    }
}
