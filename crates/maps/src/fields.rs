//! The fields of a row of a table, read one after the other.

use std::fmt;
use std::str::FromStr;

use crate::text::clipped;

/// Characters shown of a field that is not as it must be.
const MOST_SHOWN: usize = 40;

/// The fields of a row with the names of their columns.
pub struct Fields<'a, N> {
    names: std::slice::Iter<'a, N>,
    values: csv::StringRecordIter<'a>,
}

impl<N> fmt::Debug for Fields<'_, N> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Fields").field("left", &self.names.len()).finish_non_exhaustive()
    }
}

impl<'a, N: AsRef<str>> Fields<'a, N> {
    /// Of a row that must have as many fields as there are names.
    ///
    /// # Errors
    /// How many it has.
    pub fn of(names: &'a [N], record: &'a csv::StringRecord) -> Result<Self, String> {
        ensure!(record.len() == names.len(), "it has {} fields and not {}", record.len(), names.len());
        Ok(Self { names: names.iter(), values: record.iter() })
    }

    /// The next one, as text.
    pub fn text(&mut self) -> &'a str {
        self.named().1
    }

    fn named(&mut self) -> (&'a str, &'a str) {
        (self.names.next().map_or("", AsRef::as_ref), self.values.next().unwrap_or_default())
    }

    /// One that has a value.
    ///
    /// # Errors
    /// The name of the column, and what stands there.
    pub fn value<T: FromStr>(&mut self) -> Result<T, String> {
        self.read(|text| text.parse().ok())
    }

    /// One that may be empty.
    ///
    /// # Errors
    /// As [`Fields::value`].
    pub fn number<T: FromStr>(&mut self) -> Result<Option<T>, String> {
        self.read(|text| if text.is_empty() { Some(None) } else { text.parse().map(Some).ok() })
    }

    /// One that has a finite number.
    ///
    /// # Errors
    /// As [`Fields::value`].
    pub fn finite(&mut self) -> Result<f64, String> {
        self.read(|text| text.parse().ok().filter(|value: &f64| value.is_finite()))
    }

    /// One that `read` knows.
    ///
    /// # Errors
    /// As [`Fields::value`].
    pub fn read<T>(&mut self, read: impl FnOnce(&'a str) -> Option<T>) -> Result<T, String> {
        let (name, text) = self.named();
        read(text).ok_or_else(|| format!("its {name} is `{}`", clipped(text, MOST_SHOWN)))
    }

    /// One that has finite numbers with spaces between, or none.
    ///
    /// # Errors
    /// As [`Fields::value`].
    pub fn numbers(&mut self) -> Result<Vec<f64>, String> {
        let finite = |text: &str| text.parse().ok().filter(|value: &f64| value.is_finite());
        self.read(|text| text.split(' ').filter(|one| !one.is_empty()).map(finite).collect())
    }

    /// Two of which both have a value or neither.
    ///
    /// # Errors
    /// As [`Fields::value`]; also of one without the other.
    pub fn pair(&mut self) -> Result<Option<(f64, f64)>, String> {
        let names: Vec<&str> = self.names.as_slice().iter().take(2).map(AsRef::as_ref).collect();
        match (self.number()?, self.number()?) {
            (Some(one), Some(other)) => Ok(Some((one, other))),
            (None, None) => Ok(None),
            _ => Err(format!("of its {} one has a value and the other none", names.join(" and "))),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fields_are_what_their_columns_say() {
        let record = csv::StringRecord::from(vec!["3", "", "0.1", "0.2", "x"]);
        let names = ["count", "margin", "value", "error", "class"];
        let mut fields = Fields::of(&names, &record).unwrap();
        assert_eq!((fields.value::<u32>(), fields.number::<f64>()), (Ok(3), Ok(None)));
        assert_eq!(fields.pair(), Ok(Some((0.1, 0.2))));
        assert_eq!(fields.value::<f64>().unwrap_err(), "its class is `x`");
        for lone in [["0.1", ""], ["", "0.2"]] {
            let record = csv::StringRecord::from(lone.to_vec());
            let told = Fields::of(&names[2..4], &record).unwrap().pair().unwrap_err();
            assert_eq!(told, "of its value and error one has a value and the other none");
        }
        let none = csv::StringRecord::from(vec!["", ""]);
        assert_eq!(Fields::of(&names[2..4], &none).unwrap().pair(), Ok(None));
        assert_eq!(Fields::of(&names[..4], &record).unwrap_err(), "it has 5 fields and not 4");
    }
}
