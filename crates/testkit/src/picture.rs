//! Pixels of a picture that was written.

use std::io::Cursor;

/// Red, green and blue, row by row from the top.
pub struct Picture {
    /// Columns and rows.
    pub size: [u32; 2],
    /// All of them.
    pub pixels: Vec<[u8; 3]>,
}

impl Picture {
    /// That of a PNG.
    pub fn of(png: &[u8]) -> Self {
        let mut decoder = png::Decoder::new(Cursor::new(png));
        decoder.set_transformations(png::Transformations::normalize_to_color8());
        let mut reader = decoder.read_info().unwrap();
        let mut bytes = vec![0; reader.output_buffer_size().unwrap()];
        let info = reader.next_frame(&mut bytes).unwrap();
        let colour = |samples: &[u8]| match *samples {
            [red, green, blue, ..] => [red, green, blue],
            [grey, ..] => [grey; 3],
            [] => panic!("a pixel without samples"),
        };
        let pixels: Vec<_> = bytes[..info.buffer_size()].chunks_exact(info.color_type.samples()).map(colour).collect();
        assert_eq!(pixels.len(), (info.width * info.height) as usize);
        Self { size: [info.width, info.height], pixels }
    }

    /// One pixel.
    pub fn at(&self, x: u32, y: u32) -> [u8; 3] {
        self.pixels[(y * self.size[0] + x) as usize]
    }
}
