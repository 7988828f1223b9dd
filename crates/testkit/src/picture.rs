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

/// Where a map lies in its picture: the black frame about it.
pub struct Cells {
    /// The picture.
    pub picture: Picture,
    /// The first pixel of the map.
    pub corner: (u32, u32),
    /// Pixels of a cell.
    pub cell: (u32, u32),
    rows: u32,
}

impl Cells {
    /// Of a map with so many cells.
    pub fn of(png: &[u8], columns: u32, rows: u32) -> Self {
        let picture = Picture::of(png);
        let [across, down] = picture.size;
        let black = |x: u32, y: u32| picture.at(x, y) == [0; 3];
        // The longest black line down is the left side of the frame; no letter is as high.
        let run = |x: u32, y: u32| (y..down).take_while(|y| black(x, *y)).count() as u32;
        let (left, top) = (0..across)
            .flat_map(|x| (0..down).map(move |y| (x, y)))
            .find(|&(x, y)| black(x, y) && run(x, y) > 400)
            .unwrap();
        let width = (left..across).take_while(|x| black(*x, top)).count() as u32 - 2;
        // A tick may carry the left side on below the corner.
        let closed = |y: &u32| (left..left + width).all(|x| black(x, *y));
        let height = (top + 1..down).find(closed).unwrap() - top - 1;
        assert_eq!((width % columns, height % rows), (0, 0));
        Self { picture, corner: (left + 1, top + 1), cell: (width / columns, height / rows), rows }
    }

    /// The middle pixel of the cell in a column and a row, counted from below.
    pub fn middle(&self, column: u32, row: u32) -> [u8; 3] {
        let x = self.corner.0 + column * self.cell.0 + self.cell.0 / 2;
        let y = self.corner.1 + (self.rows - 1 - row) * self.cell.1 + self.cell.1 / 2;
        self.picture.at(x, y)
    }

    /// The same of a cell by its number.
    pub fn of_cell(&self, cell: usize, columns: usize) -> [u8; 3] {
        self.middle((cell % columns) as u32, (cell / columns) as u32)
    }
}
