//! What the page asks for besides tiles.

use serde_json::Value;
use vibrochain_lattice::Stop;

use crate::refusal::Refusal;

/// Answers about points and windows, computed by whoever serves the page.
pub trait Answers: Send + Sync {
    /// The file that the page is.
    fn page(&self) -> &'static str {
        ""
    }

    /// What the page begins with: `scene`, as [`View::value`](crate::View::value) has it, and whatever else it shows.
    fn start(&self) -> Value;

    /// Whether a question may take minutes. A new one of these waits for no other: the oldest is ended for it.
    fn is_long(&self, question: &str) -> bool;

    /// The answer to a question, by its name. It ends early, with any refusal, once `stop` is raised: nobody waits for it any more.
    ///
    /// # Errors
    /// [`Refusal`], 404 for a question that is not known.
    fn answer(&self, question: &str, asked: &Value, stop: &Stop) -> Result<Value, Refusal>;
}
