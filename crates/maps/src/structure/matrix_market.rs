//! Matrix Market files, the exchange format of sparse and dense matrices: real, general or symmetric, by coordinates or as an array.
//!
//! What the format does not allow is refused, as SciPy refuses it: a matrix that is read in part is another structure.

use nalgebra::DMatrix;

use super::sizes::check_size;

/// The lines that say something, with their numbers.
struct Lines<'a>(Box<dyn Iterator<Item = (usize, &'a str)> + 'a>);

impl<'a> Lines<'a> {
    /// After the comments, which come before all else.
    fn of(lines: impl Iterator<Item = (usize, &'a str)> + 'a) -> Self {
        let says = |(_, line): &(usize, &str)| !line.trim().is_empty();
        Self(Box::new(lines.filter(says).skip_while(|(_, line)| line.trim_start().starts_with('%'))))
    }

    /// The words of the next line, which are to be so many, and its number.
    fn words<const N: usize>(&mut self, what: &str) -> Result<(usize, [&'a str; N]), String> {
        let (number, line) = self.0.next().ok_or_else(|| format!("it ends before its {what}"))?;
        let words: Vec<&str> = line.split_whitespace().take(N + 1).collect();
        let words = words.try_into().map_err(|_| format!("line {number}: its {what} takes {N} numbers, one line"));
        words.map(|words| (number, words))
    }

    /// Refuses what comes after the last entry.
    fn end(mut self) -> Result<(), String> {
        self.0.next().map_or(Ok(()), |(number, _)| Err(format!("line {number}: it goes on after its last entry")))
    }
}

fn whole(line: usize, text: &str, what: &str) -> Result<usize, String> {
    text.parse().map_err(|_| format!("line {line}: its {what} is {text}, not a whole number"))
}

fn real(line: usize, text: &str) -> Result<f64, String> {
    text.parse().map_err(|_| format!("line {line}: {text} is not a number"))
}

/// The matrix of a text. Entries that are given twice are added.
pub(super) fn read(text: &str) -> Result<DMatrix<f64>, String> {
    let mut lines = text.lines().zip(1..).map(|(line, number)| (number, line));
    let head = lines.next().map_or(String::new(), |(_, line)| line.to_ascii_lowercase());
    let words: Vec<&str> = head.split_whitespace().collect();
    if !(words.first() == Some(&"%%matrixmarket") && words.get(1) == Some(&"matrix")) {
        return Err("it does not begin with %%MatrixMarket matrix".to_owned());
    }
    let [_, _, format, field, symmetry] = words[..] else {
        return Err("it does not begin with %%MatrixMarket matrix FORMAT FIELD SYMMETRY".to_owned());
    };
    if !matches!(field, "real" | "integer" | "double") {
        return Err(format!("its entries are {field}: real ones are read"));
    }
    if !matches!(symmetry, "general" | "symmetric") {
        return Err(format!("it is {symmetry}: general and symmetric matrices are read"));
    }
    let mirrored = symmetry == "symmetric";
    let mut lines = Lines::of(lines);
    match format {
        "coordinate" => {
            let (line, [rows, columns, entries]) = lines.words("number of rows, columns and entries")?;
            let mut matrix = zeros(line, [rows, columns], mirrored)?;
            for _ in 0..whole(line, entries, "number of entries")? {
                let (line, [row, column, value]) = lines.words("row, column and entry")?;
                let place = [(row, "row", matrix.nrows()), (column, "column", matrix.ncols())];
                let [i, j] = place.map(|(text, what, count)| {
                    // They count from 1.
                    let number = whole(line, text, what)?;
                    let inside = number.checked_sub(1).filter(|number| *number < count);
                    inside.ok_or_else(|| format!("line {line}: its {what} is {number}: give 1 to {count}"))
                });
                let (i, j, value) = (i?, j?, real(line, value)?);
                matrix[(i, j)] += value;
                if mirrored && i != j {
                    matrix[(j, i)] += value;
                }
            }
            lines.end().map(|()| matrix)
        }
        "array" => {
            let (line, [rows, columns]) = lines.words("number of rows and columns")?;
            let mut matrix = zeros(line, [rows, columns], mirrored)?;
            for j in 0..matrix.ncols() {
                for i in if mirrored { j } else { 0 }..matrix.nrows() {
                    let (line, [value]) = lines.words("entry")?;
                    matrix[(i, j)] = real(line, value)?;
                    if mirrored {
                        matrix[(j, i)] = matrix[(i, j)];
                    }
                }
            }
            lines.end().map(|()| matrix)
        }
        other => Err(format!("its format is {other}: coordinate or array is read")),
    }
}

/// A matrix of that size, if it is one that is read.
fn zeros(line: usize, sizes: [&str; 2], square: bool) -> Result<DMatrix<f64>, String> {
    let [rows, columns] =
        [(sizes[0], "number of rows"), (sizes[1], "number of columns")].map(|(text, what)| whole(line, text, what));
    let (rows, columns) = (rows?, columns?);
    if square && rows != columns {
        return Err(format!("it is symmetric and has {rows} rows and {columns} columns: give as many of both"));
    }
    check_size("coordinates", rows.max(columns))?;
    Ok(DMatrix::zeros(rows, columns))
}

#[cfg(test)]
mod tests {
    use super::read;

    #[test]
    fn both_formats_and_symmetries_are_read() {
        let sparse = "%%MatrixMarket matrix coordinate real symmetric\n% a comment\n\n2 2 2\n1 1 2.5\n\n2 1 -1e0\n\n";
        assert_eq!(read(sparse).unwrap().as_slice(), [2.5, -1.0, -1.0, 0.0]);
        let dense = "%%MatrixMarket matrix array real general\r\n2 2\r\n1\r\n2\r\n3\r\n4\r\n";
        assert_eq!(read(dense).unwrap().as_slice(), [1.0, 2.0, 3.0, 4.0]);
        let half = "%%MatrixMarket matrix array real symmetric\n2 2\n1\n2\n4\n";
        assert_eq!(read(half).unwrap().as_slice(), [1.0, 2.0, 2.0, 4.0]);
    }

    /// As scipy.io.mmread and MATLAB's mmread have them.
    #[test]
    fn entries_that_are_given_twice_are_added() {
        let twice = "%%MatrixMarket matrix coordinate real general\n2 2 3\n1 1 1.5\n1 1 2\n1 2 1\n";
        assert_eq!(read(twice).unwrap().as_slice(), [3.5, 0.0, 1.0, 0.0]);
        let both_halves = "%%MatrixMarket matrix coordinate real symmetric\n2 2 2\n2 1 1.5\n1 2 2\n";
        assert_eq!(read(both_halves).unwrap().as_slice(), [0.0, 3.5, 3.5, 0.0]);
    }

    /// What scipy.io.mmread refuses is refused, and so are a second number after an entry and a symmetric matrix that is not square.
    #[test]
    fn what_the_format_does_not_allow_is_refused() {
        let coordinate = |rest: &str| format!("%%MatrixMarket matrix coordinate real general\n{rest}");
        let array = |rest: &str| format!("%%MatrixMarket matrix array real general\n{rest}");
        let mirrored = |rest: &str| format!("%%MatrixMarket matrix coordinate real symmetric\n{rest}");
        for (wrong, why) in [
            ("1 2".to_owned(), "%%MatrixMarket"),
            (String::new(), "%%MatrixMarket"),
            ("%%MatrixMarket matrix coordinate complex general\n1 1 0\n".to_owned(), "complex"),
            ("%%MatrixMarket matrix coordinate real skew-symmetric\n1 1 0\n".to_owned(), "skew"),
            ("%%MatrixMarket matrix list real general\n1 1 0\n".to_owned(), "list"),
            (coordinate("1 1 1\n2 1 3\n"), "line 3: its row is 2: give 1 to 1"),
            (coordinate("1 1 1\n0 1 3\n"), "line 3: its row is 0: give 1 to 1"),
            (coordinate("1 1 1\n1 -1 3\n"), "its column is -1"),
            (coordinate("2 2 1\n1 1 1.5\n2 2 2\n"), "line 4: it goes on after its last entry"),
            (coordinate("2 2 1\n1 1 1.5\nhello\n"), "line 4: it goes on after its last entry"),
            (coordinate("2 2 1\n1 1 1.5\n% hello\n"), "line 4: it goes on after its last entry"),
            (coordinate("2 2 2\n1 1 1.5\n"), "ends"),
            (coordinate("2 2 2\n1 1 1.5\n% hello\n2 2 1\n"), "line 4"),
            (coordinate("2 2 2\n1 1 1.5 2 2 1\n"), "line 3"),
            (coordinate("2 2 1\n1 1\n1.5\n"), "line 3"),
            (coordinate("2 2 1\n1 1 1.5 7\n"), "line 3"),
            (coordinate("2 2 1 9\n1 1 1.5\n"), "line 2"),
            (coordinate("2 2\n1\n1 1 1.5\n"), "line 2"),
            (mirrored("2 3 1\n1 1 1.5\n"), "2 rows and 3 columns"),
            ("%%MatrixMarket matrix array real symmetric\n2 3\n1\n2\n3\n".to_owned(), "2 rows and 3 columns"),
            (array("2 2\n1\n2\n3\n"), "ends"),
            (array("2 2\n1\n2\n3\n4\n5\n"), "line 7"),
            // Column by column, as the format has it: which two lines of two numbers do not say.
            (array("2 2\n1 2\n3 4\n"), "line 3"),
            (array("90000 90000\n"), "90000"),
            (coordinate("90000 1 0\n"), "90000"),
        ] {
            let told = read(&wrong).unwrap_err();
            assert!(told.contains(why), "{wrong}: {told}");
        }
    }
}
