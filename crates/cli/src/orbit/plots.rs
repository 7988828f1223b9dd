//! Pictures of a chain's orbits. `mapgen orbit --all-plots`: seven of each solution, six of one with impacts at several sites or not on a ring.
//!
//! | file | shows |
//! |---|---|
//! | `solution-K-profile` | displacements of all masses at the impacts |
//! | `solution-K-spacetime` | displacements of all masses over a period, and its impacts |
//! | `solution-K-trace` | the impacting mass and its neighbour over a period |
//! | `solution-K-phase` | phase portrait of the impacting mass, impacts as jumps |
//! | `solution-K-multipliers` | Floquet multipliers and the unit circle |
//! | `solution-K-eigenvector` | the perturbation that belongs to the leading multiplier |
//! | `solution-K-decay` | of one impact site on a ring: distance from the uniform motion, site by site, on a logarithmic axis |

use std::path::Path;

use vibrochain_breather::{BreatherError, Finder, LatticeOrbit, Motion};
use vibrochain_floquet::{Complex, FloquetMode, leading_modes};
use vibrochain_lattice::{Decay, Spectrum, decay};

use crate::common::caption::beside;
use crate::common::error::CliError;
use crate::common::solution::Solution;
use crate::orbit::pictures::{Folder, Pictured};
use vibrochain_maps::caption::describe;
use vibrochain_plot::field::FieldWriter;
use vibrochain_plot::{
    Mark, OrbitPanels, Page, Pane, Scale, Series, Spacetime, Stroke, along, impact_name, multiplier_pane,
    orbit_flights, orbit_panes, orbit_profile, rows, spacetime_picture, state,
};

/// Harmonics among which the slowest decay is looked for: later ones decay faster.
const HARMONICS: u64 = 1000;

impl Pictured for Solution {
    fn is_physical(&self) -> bool {
        self.admissibility.is_physical()
    }

    fn panels(&self, number: usize) -> Result<OrbitPanels, CliError> {
        let orbit = self.orbit.lattice()?;
        let verdict = self.multipliers.as_ref().ok().map(|all| &all.verdict);
        let state = state(self.admissibility.is_physical(), verdict);
        let caption = format!("{} breather {number}: {}; {state}", orbit.name(), describe(orbit.model()));
        Ok(OrbitPanels { caption, panes: orbit_panes(&orbit)?.to_vec() })
    }

    /// Without stability those of multipliers and eigenvector are left out.
    fn write(&self, folder: &Path, page: Page, number: usize) -> Result<(), CliError> {
        let orbit = self.orbit.lattice()?;
        let title = format!("{} breather {number}: {}", orbit.name(), describe(orbit.model()));
        let folder = Folder { path: folder, page, number, title };
        folder.save("profile", (960, 480), vec![orbit_profile(&orbit)?])?;
        let (trace, phase) = orbit_flights(&orbit)?;
        folder.save("trace", (960, 480), vec![trace])?;
        folder.save("phase", (960, 560), vec![phase])?;
        let picture = spacetime_picture(&spacetime(orbit, folder.title.clone())?, page);
        folder.write("spacetime", &picture.map_err(|error| CliError::Computation(error.to_string()))?)?;
        if orbit.centre().is_some() {
            folder.save("decay", (960, 520), vec![decay_pane(orbit)?])?;
        }
        if let Ok(all) = &self.multipliers {
            folder.save(
                "multipliers",
                (960, 760),
                vec![multiplier_pane(&all.sorted().collect::<Vec<_>>(), &all.verdict)],
            )?;
            folder.save("eigenvector", (660, 480), eigenvector(orbit, all.verdict.leading)?)?;
        }
        Ok(())
    }
}

/// Samples of a period in space and time: a column for every other pixel.
const COLUMNS: u64 = 450;

fn spacetime(orbit: LatticeOrbit<'_>, title: String) -> Result<Spacetime, BreatherError> {
    let mut motion = Motion::of(&orbit)?;
    let mut field = FieldWriter::new(orbit.model().chain(), 1.0, COLUMNS);
    for k in 0..=COLUMNS {
        let part = k as f64 / COLUMNS as f64;
        field.see(&motion.displacements(part * orbit.period()), part);
    }
    let a = orbit.model().asymmetry();
    let impacts = orbit.impacts().iter().map(|impact| (impact.time / orbit.period(), impact.site)).collect();
    Ok(Spacetime { title, barriers: (a - 1.0, a + 1.0), field: field.finish(), impacts })
}

fn eigenvector(orbit: LatticeOrbit<'_>, leading: Complex<f64>) -> Result<Vec<Pane>, CliError> {
    let mut finder = Finder::default();
    let mode = match FloquetMode::of(&orbit, &mut finder, leading) {
        Ok(mode) => Some(mode),
        // The secular form does not know it: by a dense matrix.
        Err(_) => leading_modes(&orbit, 1)?.pop(),
    };
    let Some(mode) = mode else { return Ok(Vec::new()) };
    let turning = mode.multiplier.im != 0.0;
    // Layer upon layer the x axis goes on.
    let row: Vec<(f64, usize)> = match rows(orbit) {
        mut rows if rows.len() == 1 => rows.remove(0),
        _ => (0..orbit.model().chain().sites()).map(|n| (n as f64, n)).collect(),
    };
    let x = if orbit.model().chain().layers() == 1 { along(orbit) } else { "site, layer after layer" };
    let part = |name: &str, colour, stroke, mark, of: &dyn Fn(usize) -> f64| {
        let points = row.iter().map(|&(n, site)| (n, of(site)));
        Series { mark, ..Series::line(name, colour, stroke, points) }
    };
    let panel = |caption: &str, letter: &str, values: &[Complex<f64>]| {
        let mut series = vec![part("real part", 0, Stroke::Solid(2), Mark::Filled(0), &|n| values[n].re)];
        if turning {
            series.push(part("imaginary part", 1, Stroke::Dashed(2), Mark::Hollow(3), &|n| values[n].im));
        }
        Pane::titled(caption, x, letter, series)
    };
    let caption = format!("leading perturbation just before the first impact, |μ| = {:.6}", mode.multiplier.norm());
    Ok(vec![
        panel(&caption, "displacement δuₙ", &mode.displacement),
        panel("its velocities", "velocity δu\u{307}ₙ", &mode.velocity),
    ])
}

/// |v_n − G| at the impacts, each site in full relative accuracy: by harmonics, of which every one falls from site to site
/// by its own factor. The modal sum, which keeps absolute accuracy, stands beside it.
fn decay_pane(orbit: LatticeOrbit<'_>) -> Result<Pane, BreatherError> {
    let model = orbit.model();
    let chain = model.chain();
    let spectrum = Spectrum::new(*chain);
    let mut motion = Motion::of(&orbit)?;
    let home = orbit.impact_site().unwrap_or(0);
    let mut all = Vec::new();
    for (i, impact) in orbit.impacts().iter().enumerate() {
        let uniform = orbit.steady().at(impact.site).value(impact.time + orbit.psi().unwrap_or(0.0));
        let v = motion.displacements(impact.time);
        let field = |n: usize| if n == 0 { v[home] - uniform } else { beside(orbit, &spectrum, n, impact.time) };
        let points = (0..chain.even_modes()).map(|n| (n as f64, field(n).abs()));
        let name = format!("impact on the {}", impact_name(&orbit, impact));
        all.push(Series { mark: Mark::Filled(3 * i.min(1)), ..Series::line(name, i, Stroke::Solid(2), points) });
        if i == 0 {
            let modal = (0..chain.even_modes()).map(|n| (n as f64, (v[(home + n) % chain.sites()] - uniform).abs()));
            all.push(Series::marks("the same by the sum over modes", 4, Mark::Hollow(1), modal));
        }
    }
    let caption = match slowest(orbit) {
        None => "a harmonic of the breather lies in the band of the ring: no decay".to_owned(),
        Some((0, factor)) => format!("slowest decay: the mean over a period, factor {factor:.6} from site to site"),
        Some((j, factor)) => format!("slowest decay: harmonic {j}, factor {factor:.6} from site to site"),
    };
    let pane = Pane::titled(&caption, "distance from the impacting mass, in sites", "|uₙ − uniform motion|", all);
    Ok(Pane { scale: Scale::Logarithmic, ..pane })
}

/// The harmonic present that decays the slowest, and its factor per site; `None` if one propagates.
fn slowest(orbit: LatticeOrbit<'_>) -> Option<(u64, f64)> {
    let chain = orbit.model().chain();
    let mut slowest = (0, 0.0_f64);
    // Equal and opposite impulses half a period apart make odd harmonics alone.
    let present = |j: u64| {
        let phase = |t: f64| std::f64::consts::TAU * j as f64 * t / orbit.period();
        let (re, im) = orbit.impacts().iter().fold((0.0, 0.0), |(re, im), impact| {
            let (sin, cos) = phase(impact.time).sin_cos();
            (re + impact.impulse * cos, im + impact.impulse * sin)
        });
        let most = orbit.impacts().iter().map(|impact| impact.impulse.abs()).fold(0.0, f64::max);
        f64::hypot(re, im) > 1e-12 * most
    };
    for j in (0..HARMONICS).filter(|&j| (j > 0 || chain.gamma1() > 0.0) && present(j)) {
        match decay(chain, j as f64 * orbit.frequency()) {
            Decay::Propagating(_) => return None,
            Decay::Evanescent(factor) if factor.abs() > slowest.1.abs() => slowest = (j, factor),
            Decay::Evanescent(_) => {}
        }
    }
    Some(slowest)
}
