//! Pixels as a PNG: a picture of its own, or a raster in an SVG.

/// The bytes of a PNG; it tells how many dots of it make an inch.
pub(crate) fn png([width, height]: [u32; 2], rgb: &[u8], dpi: Option<f64>) -> Option<Vec<u8>> {
    let mut file = Vec::new();
    let mut encoder = png::Encoder::new(&mut file, width, height);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_compression(png::Compression::Balanced);
    if let Some(dpi) = dpi {
        let dots = (dpi / 0.0254).round() as u32;
        encoder.set_pixel_dims(Some(png::PixelDimensions { xppu: dots, yppu: dots, unit: png::Unit::Meter }));
    }
    encoder.write_header().ok()?.write_image_data(rgb).ok()?;
    Some(file)
}
