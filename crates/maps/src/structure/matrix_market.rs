//! Matrix Market files, the exchange format of sparse and dense matrices: real, general or symmetric, by coordinates or as an array.

use nalgebra::DMatrix;

/// Rows at most: structures are dense here.
const MOST_ROWS: usize = 2000;

/// The matrix of a text.
pub(super) fn read(text: &str) -> Result<DMatrix<f64>, String> {
    let mut lines = text.lines();
    let head = lines.next().unwrap_or_default().to_ascii_lowercase();
    let words: Vec<&str> = head.split_whitespace().collect();
    let [banner, object, format, field, symmetry] = words[..] else {
        return Err("it does not begin with %%MatrixMarket matrix FORMAT FIELD SYMMETRY".to_owned());
    };
    if banner != "%%matrixmarket" || object != "matrix" {
        return Err("it does not begin with %%MatrixMarket matrix".to_owned());
    }
    if !matches!(field, "real" | "integer" | "double") {
        return Err(format!("its entries are {field}: real ones are read"));
    }
    if !matches!(symmetry, "general" | "symmetric") {
        return Err(format!("it is {symmetry}: general and symmetric matrices are read"));
    }
    let mut numbers = lines.filter(|line| !line.starts_with('%')).flat_map(str::split_whitespace);
    let whole = |text: Option<&str>, what: &str| -> Result<usize, String> {
        let text = text.ok_or_else(|| format!("it ends before its {what}"))?;
        text.parse().map_err(|_| format!("its {what} is {text}, not a whole number"))
    };
    let rows = whole(numbers.next(), "number of rows")?;
    let columns = whole(numbers.next(), "number of columns")?;
    if rows.max(columns) > MOST_ROWS {
        return Err(format!("{rows} × {columns} is too large: at most {MOST_ROWS} rows are read; give a modal model"));
    }
    let mut matrix = DMatrix::zeros(rows, columns);
    let mirrored = symmetry == "symmetric";
    let mut put = |i: usize, j: usize, value: f64| {
        if i >= rows || j >= columns {
            return Err(format!("entry ({}, {}) is outside {rows} × {columns}", i + 1, j + 1));
        }
        matrix[(i, j)] = value;
        if mirrored && i != j {
            matrix[(j, i)] = value;
        }
        Ok(())
    };
    let real = |text: Option<&str>| -> Result<f64, String> {
        let text = text.ok_or("it ends before its last entry")?;
        text.parse().map_err(|_| format!("{text} is not a number"))
    };
    match format {
        "coordinate" => {
            let entries = whole(numbers.next(), "number of entries")?;
            for _ in 0..entries {
                let (i, j) = (whole(numbers.next(), "row")?, whole(numbers.next(), "column")?);
                // They count from 1.
                let (Some(i), Some(j)) = (i.checked_sub(1), j.checked_sub(1)) else {
                    return Err("rows and columns count from 1".to_owned());
                };
                put(i, j, real(numbers.next())?)?;
            }
        }
        "array" => {
            for j in 0..columns {
                for i in if mirrored { j } else { 0 }..rows {
                    put(i, j, real(numbers.next())?)?;
                }
            }
        }
        other => return Err(format!("its format is {other}: coordinate or array is read")),
    }
    Ok(matrix)
}

#[cfg(test)]
mod tests {
    use super::read;

    #[test]
    fn both_formats_and_symmetries_are_read() {
        let sparse = "%%MatrixMarket matrix coordinate real symmetric\n% a comment\n2 2 2\n1 1 2.5\n2 1 -1e0\n";
        assert_eq!(read(sparse).unwrap().as_slice(), [2.5, -1.0, -1.0, 0.0]);
        let dense = "%%MatrixMarket matrix array real general\n2 2\n1\n2\n3\n4\n";
        assert_eq!(read(dense).unwrap().as_slice(), [1.0, 2.0, 3.0, 4.0]);
        let half = "%%MatrixMarket matrix array real symmetric\n2 2\n1 2 4\n";
        assert_eq!(read(half).unwrap().as_slice(), [1.0, 2.0, 2.0, 4.0]);
        for (wrong, why) in [
            ("1 2", "%%MatrixMarket"),
            ("%%MatrixMarket matrix coordinate complex general\n1 1 0\n", "complex"),
            ("%%MatrixMarket matrix coordinate real general\n1 1 1\n2 1 3\n", "outside"),
            ("%%MatrixMarket matrix coordinate real general\n1 1 1\n0 1 3\n", "from 1"),
            ("%%MatrixMarket matrix array real general\n2 2\n1 2 3\n", "ends"),
            ("%%MatrixMarket matrix array real general\n90000 90000\n", "too large"),
        ] {
            assert!(read(wrong).unwrap_err().contains(why), "{wrong}");
        }
    }
}
