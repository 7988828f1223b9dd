//! Pictures of a table that is being written, from its rows.

#[cfg(feature = "plot")]
pub(crate) use with_pictures::Pictures;
#[cfg(not(feature = "plot"))]
pub(crate) use without_pictures::Pictures;

/// What is asked for.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Wanted<'a> {
    pub(crate) png: Option<&'a std::path::Path>,
    pub(crate) svg: Option<&'a std::path::Path>,
    pub(crate) palette: crate::args::PaletteName,
}

#[cfg(feature = "plot")]
mod with_pictures {
    use std::path::PathBuf;

    use vibrochain_floquet::Mechanism;

    use super::Wanted;
    use crate::args::PaletteName;
    use crate::cell::Class;
    use crate::error::CliError;
    use crate::output::Output;
    use crate::plot::{Format, MapPicture, Palette, Tile, map_picture};
    use crate::scene::Scene;
    use crate::table::class_column;

    /// Pictures to draw once all rows are known; without any, no row is kept.
    pub(crate) struct Pictures<'a> {
        scene: &'a Scene,
        files: Vec<(Format, PathBuf)>,
        palette: Palette,
        class_column: usize,
        tiles: Vec<Tile>,
    }

    impl<'a> Pictures<'a> {
        /// Makes sure that they can be drawn and written.
        pub(crate) fn plan(wanted: &Wanted<'_>, scene: &'a Scene) -> Result<Self, CliError> {
            let mut files = Vec::new();
            for (path, format) in [(wanted.png, Format::Png), (wanted.svg, Format::Svg)] {
                let Some(path) = path else { continue };
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
            Ok(Self { scene, files, palette, class_column: class_column(scene), tiles: Vec::new() })
        }

        /// What is to be done with each row, if anything.
        pub(crate) fn keeper(&mut self) -> Option<impl FnMut(&[u8])> {
            let (column, tiles) = (self.class_column, &mut self.tiles);
            (!self.files.is_empty()).then_some(move |row: &[u8]| {
                let mut fields = row.split(|&byte| byte == b',').skip(column);
                let class = fields.next().unwrap_or_default();
                let mechanism = fields.next().unwrap_or_default();
                let mechanisms = [Mechanism::Pitchfork, Mechanism::PeriodDoubling, Mechanism::NeimarkSacker];
                tiles.push(Tile {
                    class: Class::ALL.into_iter().find(|known| known.name().as_bytes() == class),
                    mechanism: mechanisms.into_iter().find(|known| known.name().as_bytes() == mechanism),
                });
            })
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

    use super::Wanted;
    use crate::error::CliError;
    use crate::scene::Scene;

    /// This build draws nothing.
    pub(crate) struct Pictures<'a>(PhantomData<&'a Scene>);

    impl<'a> Pictures<'a> {
        pub(crate) fn plan(wanted: &Wanted<'_>, _: &'a Scene) -> Result<Self, CliError> {
            if wanted.png.is_some() || wanted.svg.is_some() {
                return Err(CliError::Request("--png and --svg need a build with the feature `plot`".to_owned()));
            }
            Ok(Self(PhantomData))
        }

        pub(crate) fn keeper(&mut self) -> Option<fn(&[u8])> {
            None
        }

        pub(crate) fn finish(self) -> Result<(), CliError> {
            Ok(())
        }
    }
}
