//! Pictures of a structure's orbits: contacts over a period between their barriers, phase portraits, multipliers.

use std::path::Path;

use vibrochain_floquet::Verdict;
use vibrochain_plot::{OrbitPanels, Page, Pane, contact_panes, multiplier_pane, state};

use super::orbit::Drawn;
use crate::common::error::CliError;
use crate::orbit::pictures::{Folder, Pictured};

impl Drawn<'_> {
    fn verdict(&self) -> Option<&Verdict> {
        self.answered.stability.as_ref().ok().map(|stability| &stability.verdict)
    }

    fn title(&self, number: usize) -> String {
        let state = state(self.answered.admissibility.is_physical(), self.verdict());
        let (heading, fixed) = (self.scene.heading(), self.scene.here());
        format!("{heading}, {} solution {number}: {fixed}; {state}", self.word)
    }

    fn panes(&self) -> Result<Vec<[Pane; 2]>, CliError> {
        let Some(contacts) = self.answered.orbit.contacts() else { return Ok(Vec::new()) };
        Ok(contact_panes(contacts, self.answered.admissibility.obstruction.as_ref())?)
    }
}

impl Pictured for Drawn<'_> {
    fn is_physical(&self) -> bool {
        self.answered.admissibility.is_physical()
    }

    fn panels(&self, number: usize) -> Result<OrbitPanels, CliError> {
        let panes = self.panes()?.into_iter().flatten().collect();
        Ok(OrbitPanels { caption: self.title(number), panes })
    }

    fn write(&self, folder: &Path, page: Page, number: usize) -> Result<(), CliError> {
        let folder = Folder { path: folder, page, number, title: self.title(number) };
        let (traces, portraits) = self.panes()?.into_iter().map(|[trace, portrait]| (trace, portrait)).unzip();
        folder.save("trace", (960, 480), traces)?;
        folder.save("phase", (960, 560), portraits)?;
        match &self.answered.stability {
            Ok(stability) => {
                let pane = multiplier_pane(&stability.multipliers, &stability.verdict);
                folder.save("multipliers", (960, 760), vec![pane])
            }
            Err(_) => Ok(()),
        }
    }
}
