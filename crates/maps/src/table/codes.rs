//! A column of words as numbers: what memory holds of a map.

use std::collections::{HashMap, TryReserveError};

/// Of each cell the place of its word among those of the column, −1 where it has none.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Numbers {
    /// Of up to 128 words.
    Small(Vec<i8>),
    /// Of more.
    Large(Vec<i32>),
}

/// The words of a column, as it grows.
#[derive(Debug, Clone)]
pub struct Codes {
    numbers: Numbers,
    words: Vec<String>,
    places: HashMap<String, i32>,
}

impl Codes {
    /// For so many cells.
    ///
    /// # Errors
    /// There is no room for them.
    pub fn with_room(cells: usize) -> Result<Self, TryReserveError> {
        let mut numbers = Vec::new();
        numbers.try_reserve_exact(cells)?;
        Ok(Self { numbers: Numbers::Small(numbers), words: Vec::new(), places: HashMap::new() })
    }

    /// The next cell's word.
    pub fn push(&mut self, word: Option<&str>) {
        let code = word.map_or(-1, |word| match self.places.get(word) {
            Some(&place) => place,
            None => {
                // A map has fewer cells than there are numbers.
                let place = i32::try_from(self.words.len()).unwrap_or(i32::MAX);
                self.words.push(word.to_owned());
                self.places.insert(word.to_owned(), place);
                place
            }
        });
        if let Numbers::Small(numbers) = &mut self.numbers {
            match i8::try_from(code) {
                Ok(code) => return numbers.push(code),
                Err(_) => self.numbers = Numbers::Large(numbers.iter().map(|code| i32::from(*code)).collect()),
            }
        }
        if let Numbers::Large(numbers) = &mut self.numbers {
            numbers.push(code);
        }
    }

    /// The numbers, and the words by their places.
    pub fn into_parts(self) -> (Numbers, Vec<String>) {
        (self.numbers, self.words)
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test stops at the first surprise")]
mod tests {
    use super::*;

    /// As many words as a byte tells apart, and far more: each cell gets its own back.
    #[test]
    fn every_cell_keeps_its_word_however_many_there_are() {
        for count in [1, 127, 128, 129, 300, 40_000] {
            let told: Vec<Option<String>> =
                (0..2 * count + 5).map(|cell| (cell % 7 != 3).then(|| format!("{}+", (cell * 31) % count))).collect();
            let mut codes = Codes::with_room(told.len()).unwrap();
            told.iter().for_each(|word| codes.push(word.as_deref()));
            let (numbers, words) = codes.into_parts();
            assert_eq!(matches!(numbers, Numbers::Small(_)), words.len() <= 128, "{count}");
            let numbers: Vec<i32> = match numbers {
                Numbers::Small(numbers) => numbers.into_iter().map(i32::from).collect(),
                Numbers::Large(numbers) => numbers,
            };
            let kept = numbers.iter().map(|code| usize::try_from(*code).ok().map(|place| words[place].clone()));
            assert!(kept.eq(told), "{count}");
        }
    }
}
