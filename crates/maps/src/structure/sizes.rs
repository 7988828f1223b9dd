//! How large a structure may be.

/// The most coordinates, modes and contacts. Matrices are full, and work grows with the third power: of twice as many all that docs/limits.md
/// tells takes eight times as long.
pub const MOST_COORDINATES: usize = 1000;

/// Refuses what is too large, however it is given.
pub(super) fn check_size(what: &str, count: usize) -> Result<(), String> {
    if count <= MOST_COORDINATES {
        return Ok(());
    }
    Err(format!(
        "{count} {what} are too many: a structure has at most {MOST_COORDINATES} coordinates, {MOST_COORDINATES} modes and {MOST_COORDINATES} contacts"
    ))
}
