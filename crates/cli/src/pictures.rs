//! Pictures of a table that is being written, from its rows.

#[cfg(feature = "plot")]
pub(crate) use with_pictures::Pictures;
#[cfg(not(feature = "plot"))]
pub(crate) use without_pictures::Pictures;

#[cfg(feature = "plot")]
mod with_pictures {
    use std::path::PathBuf;

    use vibrochain_floquet::Mechanism;

    use crate::args::{PaletteName, PictureArgs};
    use crate::cell::Class;
    use crate::error::CliError;
    use crate::output::Output;
    use crate::plot::{Format, MapPicture, Palette, Tile, is_shown, map_picture};
    use crate::scene::Scene;
    use crate::table::class_column;

    /// Pictures to draw once all rows are known; no more is kept of them than is shown.
    pub(crate) struct Pictures<'a> {
        scene: &'a Scene,
        files: Vec<(Format, PathBuf)>,
        palette: Palette,
        class_column: usize,
        /// Rows seen.
        rows: u64,
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
            Ok(Self { scene, files, palette, class_column: class_column(scene), rows: 0, tiles: Vec::new() })
        }

        /// Whether there are any; they then want to see every row.
        pub(crate) fn wanted(&self) -> bool {
            !self.files.is_empty()
        }

        /// Forgets the rows it has seen.
        pub(crate) fn begin(&mut self) {
            self.rows = 0;
            self.tiles.clear();
        }

        /// Keeps what is shown of the next row.
        pub(crate) fn row(&mut self, row: &[u8]) {
            let number = self.rows;
            self.rows += 1;
            if !is_shown(self.scene, number) {
                return;
            }
            let mut fields = row.split(|&byte| byte == b',').skip(self.class_column);
            let class = fields.next().unwrap_or_default();
            let mechanism = fields.next().and_then(|field| std::str::from_utf8(field).ok()).unwrap_or_default();
            self.tiles.push(Tile {
                class: Class::ALL.into_iter().find(|known| known.name().as_bytes() == class),
                mechanism: Mechanism::from_name(mechanism),
            });
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
}

#[cfg(not(feature = "plot"))]
mod without_pictures {
    use std::marker::PhantomData;

    use crate::args::PictureArgs;
    use crate::error::CliError;
    use crate::scene::Scene;

    /// This build draws nothing.
    pub(crate) struct Pictures<'a>(PhantomData<&'a Scene>);

    impl<'a> Pictures<'a> {
        pub(crate) fn plan(wanted: &PictureArgs, _: &'a Scene) -> Result<Self, CliError> {
            if wanted.png.is_some() || wanted.svg.is_some() {
                return Err(CliError::Request("--png and --svg need a build with the feature `plot`".to_owned()));
            }
            Ok(Self(PhantomData))
        }

        pub(crate) fn wanted(&self) -> bool {
            false
        }

        pub(crate) fn begin(&mut self) {}

        pub(crate) fn row(&mut self, _: &[u8]) {}

        pub(crate) fn finish(self) -> Result<(), CliError> {
            Ok(())
        }
    }
}
