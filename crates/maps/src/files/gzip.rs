//! gzip on several threads: what is written is cut into pieces, each deflated by itself up to a whole byte, and one member holds them all,
//! so that every reader takes it. Where the pieces end depends on the bytes alone: the file is the same for any number of threads.

use std::collections::VecDeque;
use std::io::{self, Write};
use std::sync::Arc;
use std::thread::{Builder, JoinHandle};

use flate2::write::DeflateEncoder;
use flate2::{Compression, Crc};

/// Bytes in a piece: what it forgets of the 32 KiB before it costs less than a hundredth of its size, and a thread for it costs less
/// than a hundredth of its time.
const PIECE: usize = 1 << 19;

/// A member of deflated bytes, without a name, of no known time and system.
const HEADER: [u8; 10] = [0x1f, 0x8b, 8, 0, 0, 0, 0, 0, 0, 0xff];

/// An empty last block.
const LAST: [u8; 2] = [3, 0];

/// A deflated piece, and the checksum of what it was.
type Deflated = io::Result<(Vec<u8>, Crc)>;

/// Who is at work on a piece.
enum Piece {
    /// A thread of its own.
    Elsewhere(JoinHandle<Deflated>),
    /// Nobody: the system has no thread to spare.
    Here(Arc<Vec<u8>>),
}

/// A file under way; dropped before [`Gzip::finish`], it is cut short.
pub struct Gzip<W: Write> {
    inner: W,
    level: Compression,
    /// The most pieces at a time.
    threads: usize,
    /// Less than a piece.
    held: Vec<u8>,
    under_way: VecDeque<Piece>,
    checksum: Crc,
    begun: bool,
}

fn deflate(bytes: &[u8], level: Compression) -> Deflated {
    let (mut encoder, mut checksum) = (DeflateEncoder::new(Vec::new(), level), Crc::new());
    checksum.update(bytes);
    encoder.write_all(bytes)?;
    // Up to a whole byte, without an end.
    encoder.flush()?;
    Ok((std::mem::take(encoder.get_mut()), checksum))
}

impl Piece {
    fn begin(bytes: Vec<u8>, level: Compression) -> Self {
        let bytes = Arc::new(bytes);
        let theirs = Arc::clone(&bytes);
        Builder::new().spawn(move || deflate(&theirs, level)).map_or(Self::Here(bytes), Self::Elsewhere)
    }

    fn finish(self, level: Compression) -> Deflated {
        match self {
            Self::Elsewhere(thread) => thread.join().unwrap_or_else(|_| Err(io::Error::other("a thread has failed"))),
            Self::Here(bytes) => deflate(&bytes, level),
        }
    }
}

impl<W: Write> Gzip<W> {
    /// Deflates at most `threads` pieces at a time, beside whoever writes; `level` is 0 … 9, as gzip has it.
    #[must_use]
    pub fn new(inner: W, level: u32, threads: usize) -> Self {
        let (level, threads) = (Compression::new(level), threads.max(1));
        let (held, under_way, checksum) = Default::default();
        Self { inner, level, threads, held, under_way, checksum, begun: false }
    }

    /// Where the bytes go.
    #[must_use]
    pub fn get_ref(&self) -> &W {
        &self.inner
    }

    /// Writes what comes first, once enough others are under way.
    fn write_finished(&mut self, most: usize) -> io::Result<()> {
        while self.under_way.len() > most
            && let Some(piece) = self.under_way.pop_front()
        {
            let (bytes, checksum) = piece.finish(self.level)?;
            if !self.begun {
                self.begun = true;
                self.inner.write_all(&HEADER)?;
            }
            self.inner.write_all(&bytes)?;
            self.checksum.combine(&checksum);
        }
        Ok(())
    }

    fn begin_piece(&mut self) -> io::Result<()> {
        self.write_finished(self.threads - 1)?;
        self.under_way.push_back(Piece::begin(std::mem::take(&mut self.held), self.level));
        Ok(())
    }

    /// Writes all that is under way, and the end.
    ///
    /// # Errors
    /// Those of writing.
    pub fn finish(mut self) -> io::Result<W> {
        self.begin_piece()?;
        self.write_finished(0)?;
        self.inner.write_all(&LAST)?;
        self.inner.write_all(&self.checksum.sum().to_le_bytes())?;
        self.inner.write_all(&self.checksum.amount().to_le_bytes())?;
        Ok(self.inner)
    }
}

impl<W: Write> Write for Gzip<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let taken = bytes.len().min(PIECE - self.held.len());
        self.held.extend_from_slice(&bytes[..taken]);
        if self.held.len() == PIECE {
            self.begin_piece()?;
        }
        Ok(taken)
    }

    /// A piece is not cut short for it.
    fn flush(&mut self) -> io::Result<()> {
        self.inner.flush()
    }
}

#[cfg(test)]
mod tests {
    use std::io::{Read, Write};

    use super::{Gzip, PIECE};

    /// Rows of figures, as they are in tables.
    fn text(length: usize) -> Vec<u8> {
        let mut random = fastrand::Rng::with_seed(1);
        let row = |_| format!("{},{},none,,{:e}\n", random.f32(), random.u8(..), random.f64());
        let mut text = (0..length / 16 + 1).map(row).collect::<String>().into_bytes();
        text.truncate(length);
        text
    }

    fn packed(text: &[u8], threads: usize, at_a_time: usize) -> Vec<u8> {
        let mut gzip = Gzip::new(Vec::new(), 6, threads);
        text.chunks(at_a_time).for_each(|some| gzip.write_all(some).unwrap());
        gzip.finish().unwrap()
    }

    #[test]
    fn one_member_that_any_number_of_threads_writes_alike() {
        for length in [0, 1, PIECE - 1, PIECE, PIECE + 1, 5 * PIECE + 7] {
            let text = text(length);
            let alone = packed(&text, 1, 1 << 16);
            let mut unpacked = Vec::new();
            // This decoder knows of one member alone.
            let mut decoder = flate2::read::GzDecoder::new(&alone[..]);
            decoder.read_to_end(&mut unpacked).unwrap();
            assert!(unpacked == text, "{length}");
            assert!(decoder.into_inner().is_empty(), "{length}");
            for (threads, at_a_time) in [(0, 7777), (2, 1 << 20), (7, 4096)] {
                assert!(packed(&text, threads, at_a_time) == alone, "{length}, {threads} threads");
            }
        }
    }

    #[test]
    fn a_sink_that_fails_fails_the_writer() {
        struct Full(usize);
        impl Write for Full {
            fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
                self.0 = self.0.checked_sub(bytes.len()).ok_or_else(|| std::io::Error::other("full"))?;
                Ok(bytes.len())
            }
            fn flush(&mut self) -> std::io::Result<()> {
                Ok(())
            }
        }
        let text = text(8 * PIECE);
        let mut gzip = Gzip::new(Full(PIECE), 6, 2);
        let written = gzip.write_all(&text).and_then(|()| gzip.finish().map(|_| ()));
        assert_eq!(written.unwrap_err().to_string(), "full");
    }
}
