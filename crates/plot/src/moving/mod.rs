//! The chain between its barriers, moving: GIF, APNG, or an SVG that moves by itself.

pub(crate) mod backdrop;
pub(crate) mod motion;
#[cfg(feature = "files")]
pub(crate) mod pixels;
pub(crate) mod svg;

use crate::backend::format::PlotError;
use crate::backend::page::Page;
use crate::moving::backdrop::Backdrop;
use crate::moving::motion::{Animation, MOST_LAYERS, MOST_MASSES, Moving};

/// The bytes of the file.
///
/// # Errors
/// [`PlotError`] of no instants, or more masses than can be told apart.
pub fn animation(picture: &Animation, moving: Moving, page: impl Into<Page>) -> Result<Vec<u8>, PlotError> {
    let page = page.into();
    let masses = picture.instants.first().map_or(0, |instant| instant.displacement.len());
    let layers = masses.checked_div(picture.length).unwrap_or(0);
    if masses == 0 || masses > MOST_MASSES || layers > MOST_LAYERS {
        let message =
            format!("{masses} masses in {layers} layers cannot be told apart: at most {MOST_MASSES} in {MOST_LAYERS}");
        return Err(PlotError(message));
    }
    let backdrop = Backdrop::new(picture, layers, page);
    page.holds(backdrop.background.size)?;
    match moving {
        #[cfg(not(feature = "files"))]
        Moving::Gif | Moving::Png => Err(PlotError::not_built()),
        _ if page.measures => Ok(Vec::new()),
        Moving::Svg => Ok(backdrop.svg()),
        #[cfg(feature = "files")]
        Moving::Gif => backdrop.gif(),
        #[cfg(feature = "files")]
        Moving::Png => backdrop.png(),
    }
}

#[cfg(test)]
#[cfg(feature = "files")]
mod tests {
    use super::*;
    use crate::backend::drawing::Place;
    use crate::backend::format::Format;
    use crate::map::palette::LINES;
    use crate::moving::motion::Instant;

    fn swing(length: usize, layers: usize, count: usize) -> Animation {
        let instant = |k: usize| {
            let angle = std::f64::consts::TAU * k as f64 / count as f64;
            let mut displacement = vec![0.1; length * layers];
            displacement[0] = 0.4 + angle.cos();
            let impacts = if k == 0 { vec![(0, true)] } else { Vec::new() };
            Instant { displacement, impacts }
        };
        let lowest = -((length - 1) as i64 / 2);
        let instants = (0..count).map(instant).collect();
        Animation { title: "γ₂ = 0.1".to_owned(), barriers: (-0.6, 1.4), length, lowest, instants }
    }

    /// The frames of a GIF as whole pictures.
    fn frames(file: &[u8]) -> Vec<Vec<u8>> {
        let mut options = gif::DecodeOptions::new();
        options.set_color_output(gif::ColorOutput::RGBA);
        let mut decoder = options.read_info(file).unwrap();
        let (width, height) = (decoder.width() as usize, decoder.height() as usize);
        let (mut canvas, mut all) = (vec![0; 4 * width * height], Vec::new());
        while let Some(frame) = decoder.read_next_frame().unwrap() {
            for row in 0..frame.height as usize {
                let wide = 4 * frame.width as usize;
                let to = 4 * ((frame.top as usize + row) * width + frame.left as usize);
                for (to, from) in canvas[to..to + wide].chunks_mut(4).zip(frame.buffer[wide * row..].chunks(4)) {
                    if from[3] > 0 {
                        to.copy_from_slice(from);
                    }
                }
            }
            all.push(canvas.clone());
        }
        all
    }

    #[test]
    fn masses_are_where_they_are_at_each_instant_and_impacts_glow() {
        let picture = swing(5, 1, 16);
        let page = Page::from(Format::Png);
        let all = frames(&animation(&picture, Moving::Gif, page).unwrap());
        assert_eq!(all.len(), 16);
        let backdrop = Backdrop::new(&picture, 1, page);
        let width = backdrop.background.size[0].round() as usize;
        let colour = |at: usize, [x, y]: Place| {
            let first = 4 * (y.round() as usize * width + x.round() as usize);
            [all[at][first], all[at][first + 1], all[at][first + 2]]
        };
        for (at, instant) in picture.instants.iter().enumerate() {
            for (mass, u) in instant.displacement.iter().enumerate() {
                let found = colour(at, backdrop.place(mass, *u).unwrap());
                assert!(found.iter().zip(LINES[0]).all(|(a, b)| a.abs_diff(b) < 8), "{at} {mass} {found:?}");
            }
        }
        let glowing: Vec<usize> = (0..16).filter(|at| backdrop.glow(*at, (0, true)) > 0.0).collect();
        assert_eq!(glowing, [0, 1, 2, 3]);
        let [x, y] = backdrop.barrier((0, true)).unwrap();
        let ring = [x, y - backdrop.radius - 4.0];
        assert!(colour(0, ring)[0] > 180 && colour(0, ring)[2] < 90 && colour(8, ring) == [255; 3]);
    }

    #[test]
    fn files_are_small_and_of_their_kinds() {
        for (length, layers, most) in [(21, 1, 150_000), (200, 1, 400_000), (9, 3, 200_000)] {
            let picture = swing(length, layers, 64);
            let of = |moving| animation(&picture, moving, Format::Png).unwrap();
            let (gif, png, svg) = (of(Moving::Gif), of(Moving::Png), of(Moving::Svg));
            assert!(gif.starts_with(b"GIF89a") && png.starts_with(b"\x89PNG") && svg.starts_with(b"<svg"));
            assert!(png.windows(4).filter(|name| *name == b"fcTL").count() == 64);
            let sizes = [gif.len(), png.len(), svg.len()];
            assert!(sizes.iter().all(|size| *size < most), "{length} {sizes:?}");
            let svg = String::from_utf8(svg).unwrap();
            assert_eq!(svg.matches("attributeName=\"cy\"").count(), length * layers);
        }
        let none = Animation { instants: Vec::new(), ..swing(3, 1, 4) };
        assert!(animation(&none, Moving::Gif, Format::Png).is_err());
        assert!(animation(&swing(401, 1, 2), Moving::Svg, Format::Svg).unwrap_err().0.contains("at most 400"));
    }
}
