//! How large a structure may be.

/// The most coordinates, modes and contacts; a chain with few of the latter two may have more masses. Matrices are full, and work grows with the
/// third power: of twice as many all that docs/limits.md tells takes eight times as long.
pub const MOST_COORDINATES: usize = 1000;

/// The most masses of a chain, some of whose modes are kept.
const MOST_MASSES: usize = 100_000;

/// The most numbers that a chain's modes hold: one a mode and mass, three a mode and contact. Those of [`MOST_COORDINATES`] masses with a contact
/// each are as many; a number takes 16 bytes.
const MOST_NUMBERS: usize = 4 * MOST_COORDINATES * MOST_COORDINATES;

/// Refuses a chain that has too many masses for as many modes and contacts.
pub(super) fn check_chain(sites: usize, modes: usize, contacts: usize) -> Result<(), String> {
    if sites > MOST_MASSES {
        return Err(format!("{sites} sites are too many: a chain has at most {MOST_MASSES} masses"));
    }
    let most = MOST_NUMBERS / (sites + 3 * contacts).max(1);
    if modes <= most {
        return Ok(());
    }
    Err(format!(
        "{sites} sites are too many for {modes} modes and {contacts} contacts: keep the slowest, modes = {most} in [structure], or give fewer \
         contacts"
    ))
}

/// Refuses what is too large, however it is given.
pub(super) fn check_size(what: &str, count: usize) -> Result<(), String> {
    if count <= MOST_COORDINATES {
        return Ok(());
    }
    Err(format!(
        "{count} {what} are too many: a structure has at most {MOST_COORDINATES} coordinates, {MOST_COORDINATES} modes and {MOST_COORDINATES} contacts"
    ))
}
