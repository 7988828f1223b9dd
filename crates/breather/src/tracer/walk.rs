//! The one loop of steps, of all that is traced: branches, curves of events, borders and edges, words in the coupling.

use super::pace::Pace;

/// What became of a step.
#[derive(Debug)]
pub enum Stride<E> {
    /// It was made. The next may be longer by as much as is wanted, but no longer than the longest.
    Made {
        /// A factor of the length; infinite where nothing but the longest limits it.
        wanted: f64,
        /// A length.
        longest: f64,
    },
    /// Its end does not do, but that of a step of this length may.
    Shorter(f64),
    /// It leads nowhere; a shorter one may.
    Failed,
    /// The way ends.
    Ended(E),
}

/// Who makes the steps of one way.
pub trait Walk {
    /// How the way ends.
    type End;
    /// What breaks it off.
    type Error;

    /// A step of about this length.
    ///
    /// # Errors
    /// What breaks the way off.
    fn step(&mut self, length: f64) -> Result<Stride<Self::End>, Self::Error>;

    /// What leads on where no step does, however short, with its length.
    ///
    /// # Errors
    /// What breaks the way off.
    fn leap(&mut self) -> Result<(f64, Stride<Self::End>), Self::Error> {
        Ok((0.0, Stride::Failed))
    }

    /// How the way ends where nothing leads on, or only steps that are hardly any.
    ///
    /// # Errors
    /// What breaks the way off.
    fn lost(&mut self) -> Result<Self::End, Self::Error>;
}

/// Goes one way to its end, from a first step of this length on.
///
/// # Errors
/// What breaks the way off.
pub fn walk<W: Walk>(walker: &mut W, first: f64) -> Result<W::End, W::Error> {
    let (mut pace, mut crawling) = (Pace::new(first), 0);
    while crawling < Pace::MOST_CRAWLING {
        let mut stride = walker.step(pace.length())?;
        if matches!(stride, Stride::Failed) {
            if pace.shorten() {
                continue;
            }
            let (length, over) = walker.leap()?;
            (pace, stride) = (Pace::new(length), over);
        }
        match stride {
            Stride::Made { wanted, longest } => {
                crawling = if pace.length() < Pace::CRAWL { crawling + 1 } else { 0 };
                pace.lengthen(wanted, longest);
            }
            Stride::Shorter(length) => pace = Pace::new(length),
            Stride::Failed => break,
            Stride::Ended(end) => return Ok(end),
        }
    }
    walker.lost()
}
