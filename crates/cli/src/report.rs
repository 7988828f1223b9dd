//! What a sweep has found, in a few lines for people.

use crate::cell::{Class, Status};
use crate::manifest::Effort;
use crate::scene::Scene;
use crate::sweep::Summary;

/// "400 × 300": the points of the axes.
pub(crate) fn grid(scene: &Scene) -> String {
    scene.axes.iter().map(|axis| axis.points().to_string()).collect::<Vec<_>>().join(" × ")
}

/// The summary of a finished table.
pub(crate) fn report(scene: &Scene, summary: &Summary, effort: Option<&Effort>) -> String {
    let cells = scene.cells();
    let mut lines = vec![format!("{cells} cells ({})", grid(scene))];
    let share = |count: u64| 100.0 * count as f64 / cells as f64;
    for (class, &count) in Class::ALL.iter().zip(&summary.classes).filter(|(_, count)| **count > 0) {
        lines.push(format!("  {:<16} {count:>9}  {:5.1} %", class.name(), share(count)));
    }
    for (status, &count) in Status::ALL.iter().zip(&summary.statuses).skip(1).filter(|(_, count)| **count > 0) {
        lines.push(format!("  status {:<16} {count:>9}", status.name()));
    }
    lines.extend(effort.map(speed));
    lines.push(format!("worst residual of an orbit {:.1e}", summary.worst_residual));
    lines.join("\n")
}

/// How fast it went.
pub(crate) fn speed(effort: &Effort) -> String {
    let Effort { threads, computed_cells, wall_seconds } = *effort;
    let per_cell = wall_seconds * 1e6 * threads as f64 / computed_cells.max(1) as f64;
    format!("{wall_seconds:.3} s on {threads} threads, {per_cell:.2} µs per cell and core")
}
