//! Pictures of a table that is being written, from its rows.

#[cfg(feature = "plot")]
pub(crate) use with_pictures::Pictures;
#[cfg(not(feature = "plot"))]
pub(crate) use without_pictures::Pictures;

#[cfg(feature = "plot")]
mod with_pictures {
    use std::path::PathBuf;

    use crate::args::{PaletteName, PictureArgs};
    use crate::error::CliError;
    use vibrochain_maps::cell::Cell;
    use vibrochain_maps::files::Output;
    use vibrochain_maps::scene::Scene;
    use vibrochain_maps::sweep::Watcher;
    use vibrochain_plot::{Format, MapPicture, Palette, Tile, is_shown, map_picture};

    /// Pictures to draw once all rows are known; no more is kept of them than is shown.
    pub(crate) struct Pictures<'a> {
        scene: &'a Scene,
        files: Vec<(Format, PathBuf)>,
        palette: Palette,
        tiles: Vec<Tile>,
    }

    impl<'a> Pictures<'a> {
        /// Makes sure that they can be drawn and written.
        pub(crate) fn plan(wanted: &PictureArgs, scene: &'a Scene) -> Result<Self, CliError> {
            let mut files = Vec::new();
            for (path, format) in [(&wanted.png, Format::Png), (&wanted.svg, Format::Svg)] {
                let Some(path) = path else { continue };
                format.promised(path)?;
                if scene.plane().is_none() {
                    let axes = scene.axes.len();
                    let message = format!("pictures need two axes, the scene has {axes}: leave out --png and --svg");
                    return Err(CliError::Request(message));
                }
                Output::create(path)?;
                files.push((format, path.to_owned()));
            }
            let palette = match wanted.palette {
                PaletteName::Colour => Palette::Colour,
                PaletteName::Paper => Palette::Paper,
            };
            Ok(Self { scene, files, palette, tiles: Vec::new() })
        }

        /// Draws and writes them.
        pub(crate) fn finish(self) -> Result<(), CliError> {
            let picture = MapPicture { scene: self.scene, tiles: &self.tiles, palette: self.palette };
            for (format, path) in self.files {
                let bytes = map_picture(&picture, format).map_err(|error| CliError::Computation(error.to_string()))?;
                Output::create(&path)?.finish_with(&bytes)?;
            }
            Ok(())
        }
    }

    impl Watcher for Pictures<'_> {
        fn looks(&self) -> bool {
            !self.files.is_empty()
        }

        fn begin(&mut self) {
            self.tiles.clear();
        }

        fn cell(&mut self, number: u64, cell: &Cell) {
            if self.looks() && is_shown(self.scene, number) {
                self.tiles.push(Tile { class: cell.class, mechanism: cell.mechanism });
            }
        }
    }
}

#[cfg(not(feature = "plot"))]
mod without_pictures {
    use std::marker::PhantomData;

    use crate::args::PictureArgs;
    use crate::error::CliError;
    use vibrochain_maps::cell::Cell;
    use vibrochain_maps::scene::Scene;
    use vibrochain_maps::sweep::Watcher;

    /// This build draws nothing.
    pub(crate) struct Pictures<'a>(PhantomData<&'a Scene>);

    impl<'a> Pictures<'a> {
        pub(crate) fn plan(wanted: &PictureArgs, _: &'a Scene) -> Result<Self, CliError> {
            if wanted.png.is_some() || wanted.svg.is_some() {
                return Err(CliError::Request("--png and --svg need a build with the feature `plot`".to_owned()));
            }
            Ok(Self(PhantomData))
        }

        pub(crate) fn finish(self) -> Result<(), CliError> {
            Ok(())
        }
    }

    impl Watcher for Pictures<'_> {
        fn looks(&self) -> bool {
            false
        }

        fn begin(&mut self) {}

        fn cell(&mut self, _: u64, _: &Cell) {}
    }
}
