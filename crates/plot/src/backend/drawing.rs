//! A picture as vectors: shapes, circles, words and rasters in the order in which they lie on each other. What writes SVG, PNG and PDF
//! knows nothing else.

/// A place from the upper left corner, in units of 1/96 inch, which is a pixel of a screen.
pub type Place = [f64; 2];

/// Red, green, blue.
pub type Rgb = [u8; 3];

pub(crate) const BLACK: Rgb = [0, 0, 0];
pub(crate) const WHITE: Rgb = [255, 255, 255];
/// What is said beside the matter.
pub(crate) const DIM: Rgb = [60, 60, 60];

/// A picture.
#[derive(Debug, Clone, PartialEq)]
pub struct Drawing {
    /// Width and height.
    pub size: Place,
    /// What is on it, from the lowest.
    pub elements: Vec<Element>,
    /// What fills may refer to.
    pub patterns: Vec<Pattern>,
    /// What it is called, for those who do not see it.
    pub title: String,
}

/// What a drawing consists of.
#[derive(Debug, Clone, PartialEq)]
pub enum Element {
    /// Lines, or what they enclose.
    Shape(Shape),
    /// A circle.
    Circle(Circle),
    /// A line of text.
    Words(Words),
    /// A raster.
    Image(Image),
    /// Elements of which only what lies in a box is seen: its upper left and lower right corner.
    Clipped([Place; 2], Vec<Element>),
}

/// Lines through places, or what they enclose by the rule of turns.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Shape {
    /// Each from its first place to its last.
    pub outlines: Vec<Vec<Place>>,
    /// Whether they return to their first place.
    pub closed: bool,
    /// What fills them.
    pub fill: Option<Fill>,
    /// What goes along them.
    pub line: Option<Line>,
    /// What a viewer says of it when one hovers over it; nothing if empty.
    pub title: String,
}

/// What fills a shape.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Fill {
    /// A colour.
    Colour(Rgb),
    /// A pattern by its number.
    Pattern(usize),
}

/// A colour with marks on it, again and again.
#[derive(Debug, Clone, PartialEq)]
pub struct Pattern {
    /// What lies under the marks.
    pub ground: Rgb,
    /// The colour of the marks.
    pub marks: Rgb,
    /// Squares of one unit by their upper left corner.
    pub squares: Vec<Place>,
    /// After so many units all comes again.
    pub period: f64,
}

/// A stroke.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Line {
    /// Its colour.
    pub colour: Rgb,
    /// Its width.
    pub width: f64,
    /// Length of dashes and gaps.
    pub dash: Option<[f64; 2]>,
    /// How much of what lies under it is hidden, from 0 to 1.
    pub opacity: f64,
    /// Lies along an axis, and is drawn on whole pixels where there are pixels.
    pub crisp: bool,
}

impl Line {
    pub(crate) fn new(colour: Rgb, width: f64) -> Self {
        Self { colour, width, dash: None, opacity: 1.0, crisp: false }
    }

    pub(crate) fn dashed(self, dash: f64, gap: f64) -> Self {
        Self { dash: Some([dash, gap]), ..self }
    }

    pub(crate) fn crisp(self) -> Self {
        Self { crisp: true, ..self }
    }
}

/// A circle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Circle {
    /// Its centre.
    pub centre: Place,
    /// Its radius.
    pub radius: f64,
    /// What fills it.
    pub fill: Option<Rgb>,
    /// What goes round it.
    pub line: Option<Line>,
}

/// A line of text.
#[derive(Debug, Clone, PartialEq)]
pub struct Words {
    /// What it says.
    pub text: String,
    /// Where it stands.
    pub at: Place,
    /// Height of an em.
    pub size: f64,
    /// Its colour.
    pub colour: Rgb,
    /// Which part of it stands there.
    pub anchor: (Across, Upright),
    /// Turned to be read from below upwards.
    pub upwards: bool,
}

/// The part of a text, from left to right, that stands at its place.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Across {
    /// Where it begins.
    Left,
    /// Its middle.
    Centre,
    /// Where it ends.
    Right,
}

/// The part of a text, from top to bottom, that stands at its place.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Upright {
    /// The upper end of its line.
    Top,
    /// The middle of its small letters and numerals.
    Middle,
    /// Where its letters stand.
    Base,
}

/// A raster in a box.
#[derive(Debug, Clone, PartialEq)]
pub struct Image {
    /// Its upper left corner.
    pub at: Place,
    /// Its width and height.
    pub size: Place,
    /// Columns and rows.
    pub pixels: [u32; 2],
    /// Three bytes each, by rows from above.
    pub rgb: Vec<u8>,
}

/// Width and height of the box between two corners.
pub(crate) fn sides([[left, top], [right, bottom]]: [Place; 2]) -> [f64; 2] {
    [right - left, bottom - top]
}

impl Drawing {
    pub(crate) fn new(size: Place, title: &str) -> Self {
        Self { size, elements: Vec::new(), patterns: Vec::new(), title: title.to_owned() }
    }

    pub(crate) fn line(&mut self, points: Vec<Place>, line: Line) {
        self.shape(Shape { outlines: vec![points], line: Some(line), ..Shape::default() });
    }

    /// The edges of a box.
    pub(crate) fn frame(&mut self, [[left, top], [right, bottom]]: [Place; 2], line: Line) {
        let outline = vec![[left, top], [right, top], [right, bottom], [left, bottom]];
        self.shape(Shape { outlines: vec![outline], closed: true, line: Some(line), ..Shape::default() });
    }

    pub(crate) fn shape(&mut self, shape: Shape) {
        self.elements.push(Element::Shape(shape));
    }

    pub(crate) fn circle(&mut self, centre: Place, radius: f64, fill: Option<Rgb>, line: Option<Line>) {
        self.elements.push(Element::Circle(Circle { centre, radius, fill, line }));
    }

    /// Words that begin at a place, in the middle of their height.
    pub(crate) fn words(&mut self, text: &str, at: Place, size: f64, colour: Rgb) {
        self.anchored(text, at, size, colour, (Across::Left, Upright::Middle));
    }

    pub(crate) fn anchored(&mut self, text: &str, at: Place, size: f64, colour: Rgb, anchor: (Across, Upright)) {
        let text = text.to_owned();
        self.elements.push(Element::Words(Words { text, at, size, colour, anchor, upwards: false }));
    }

    /// A raster in the box between two corners.
    pub(crate) fn image(&mut self, corners: [Place; 2], pixels: [u32; 2], rgb: Vec<u8>) {
        self.elements.push(Element::Image(Image { at: corners[0], size: sides(corners), pixels, rgb }));
    }

    /// Draws with what `draw` adds seen only within a box.
    pub(crate) fn clipped(&mut self, seen: [Place; 2], draw: impl FnOnce(&mut Self)) {
        let below = std::mem::take(&mut self.elements);
        draw(self);
        let inside = std::mem::replace(&mut self.elements, below);
        self.elements.push(Element::Clipped(seen, inside));
    }
}
