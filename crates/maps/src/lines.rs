//! Lines of text that comes in pieces.

/// Cuts bytes that come in pieces into lines.
#[derive(Debug, Default)]
pub struct Lines {
    begun: Vec<u8>,
}

impl Lines {
    /// Hands every line that ends in `bytes` to `each`, without its end.
    ///
    /// # Errors
    /// Those of `each`.
    pub fn take<E>(&mut self, bytes: &[u8], mut each: impl FnMut(&[u8]) -> Result<(), E>) -> Result<(), E> {
        for piece in bytes.split_inclusive(|&byte| byte == b'\n') {
            match piece.strip_suffix(b"\n") {
                None => self.begun.extend_from_slice(piece),
                Some(line) if self.begun.is_empty() => each(line)?,
                Some(end) => {
                    self.begun.extend_from_slice(end);
                    each(&self.begun)?;
                    self.begun.clear();
                }
            }
        }
        Ok(())
    }

    /// Whether all that came was whole lines.
    pub fn ended(&self) -> bool {
        self.begun.is_empty()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_come_whole_however_they_are_cut() {
        let text = b"one,1\n\ntwo,2\nthree,3\n";
        for size in 1..text.len() {
            let (mut lines, mut seen) = (Lines::default(), Vec::new());
            for piece in text.chunks(size) {
                let taken = lines.take(piece, |line| {
                    seen.push(String::from_utf8(line.to_vec()).unwrap());
                    Ok::<_, ()>(())
                });
                assert!(taken.is_ok());
            }
            assert!(lines.ended());
            assert_eq!(seen, ["one,1", "", "two,2", "three,3"], "{size}");
        }
    }
}
