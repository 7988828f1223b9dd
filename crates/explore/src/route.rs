//! From a request to its answer.

use std::sync::Arc;
use std::time::Duration;

use http_body_util::{BodyExt, Full, LengthLimitError, Limited};
use hyper::body::{Body, Bytes};
use hyper::header::{CONNECTION, CONTENT_TYPE, HeaderName, HeaderValue, RETRY_AFTER};
use hyper::{Method, Request, Response, StatusCode};
use rayon::ThreadPool;
use serde::Deserialize;
use serde_json::{Value, json};
use tokio::time::timeout;
use vibrochain_lattice::{Parameter, Part, Row, Stop};

use crate::answers::Answers;
use crate::colours;
use crate::connection::Connection;
use crate::guard::Guard;
use crate::page::file;
use crate::refusal::Refusal;
use crate::scale;
use crate::tile;
use crate::view::{CELLS, View};
use crate::work::Work;

/// The most bytes of what is asked: a scene takes some hundred.
const MOST_ASKED: usize = 64 << 10;

/// How long a request may take to arrive.
const PATIENCE: Duration = Duration::from_secs(10);

/// Tiles that may wait, fewer than there are connections: what is too much is told so at once. The page asks for five at a time.
const TILES: usize = 128;

/// Answers that are computed at a time, and that may wait.
const RUNNING: usize = 2;
const ANSWERS: usize = 16;

/// The same for those that may take minutes. They have places of their own, so that none of them keeps a point waiting.
const LONG: usize = 2;
const LONG_ANSWERS: usize = 4;

/// Seconds after which to ask again where too many wait.
const LATER: &str = "1";

/// Nothing but this page's own files is loaded, by whatever it shows; nobody frames it; and it tells nobody its address.
const HEADERS: [(HeaderName, &str); 6] = [
    (
        hyper::header::CONTENT_SECURITY_POLICY,
        "default-src 'none'; script-src 'self'; style-src 'self'; connect-src 'self'; img-src 'self' blob:; \
         base-uri 'none'; form-action 'none'; frame-ancestors 'none'",
    ),
    (hyper::header::X_CONTENT_TYPE_OPTIONS, "nosniff"),
    (hyper::header::REFERRER_POLICY, "no-referrer"),
    (hyper::header::CACHE_CONTROL, "no-store"),
    (HeaderName::from_static("cross-origin-resource-policy"), "same-origin"),
    (HeaderName::from_static("cross-origin-opener-policy"), "same-origin"),
];

const JSON: &str = "application/json";
const NUMBERS: &str = "application/octet-stream";

/// Answers requests, from what the page and the program have.
pub(crate) struct Service {
    pub(crate) guard: Guard,
    pub(crate) answers: Arc<dyn Answers>,
    pub(crate) pool: Arc<ThreadPool>,
    pub(crate) tiles: Work,
    pub(crate) questions: Work,
    pub(crate) long: Work,
}

/// A tile, as it is asked for.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct TileAsked {
    scene: Value,
    z: u32,
    x: i64,
    y: i64,
}

/// The scale of a scene's numbers, likewise.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ScaleAsked {
    scene: Value,
    color: String,
}

/// A view, likewise.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ViewAsked {
    scene: Value,
}

impl Service {
    pub(crate) fn new(guard: Guard, answers: Arc<dyn Answers>, pool: ThreadPool) -> Self {
        let tiles = Work::new(pool.current_num_threads(), TILES);
        let (questions, long) = (Work::new(RUNNING, ANSWERS), Work::newest_first(LONG, LONG_ANSWERS));
        Self { guard, answers, pool: Arc::new(pool), tiles, questions, long }
    }

    /// Answers a request, whatever it is. `connection` is told when work on it begins and ends.
    pub(crate) async fn respond<B>(&self, request: Request<B>, connection: &Connection) -> Response<Full<Bytes>>
    where
        B: Body<Data = Bytes>,
        B::Error: Into<Box<dyn std::error::Error + Send + Sync>>,
    {
        let (code, kind, bytes) = match self.answer(request, connection).await {
            Ok((kind, bytes)) => (200, kind, bytes),
            Err(refusal) => (refusal.code, JSON, json!({ "error": refusal.message }).to_string().into()),
        };
        let mut response = Response::new(Full::new(bytes));
        *response.status_mut() = StatusCode::from_u16(code).unwrap_or(StatusCode::INTERNAL_SERVER_ERROR);
        let headers = response.headers_mut();
        headers.insert(CONTENT_TYPE, HeaderValue::from_static(kind));
        for (name, value) in HEADERS {
            headers.insert(name, HeaderValue::from_static(value));
        }
        if code == 503 {
            headers.insert(RETRY_AFTER, HeaderValue::from_static(LATER));
        }
        // Whoever may not ask, or too much, leaves the place to others; who asked for a wrong value asks again.
        if !matches!(code, 200 | 400 | 404 | 409 | 422 | 500) {
            headers.insert(CONNECTION, HeaderValue::from_static("close"));
        }
        response
    }

    async fn answer<B>(&self, request: Request<B>, connection: &Connection) -> Result<(&'static str, Bytes), Refusal>
    where
        B: Body<Data = Bytes>,
        B::Error: Into<Box<dyn std::error::Error + Send + Sync>>,
    {
        let (head, body) = request.into_parts();
        let name = self.guard.admit(&head.method, head.uri.path(), &head.headers)?.to_owned();
        let unknown = || Refusal::new(404, "there is no such thing here");
        if head.method == Method::GET {
            return match name.as_str() {
                "start" => {
                    let mut value = self.answers.start();
                    value["colours"] = colours::value();
                    value["parameters"] = Parameter::told().map(control).collect();
                    value["cells"] = CELLS.into();
                    Ok((JSON, value.to_string().into()))
                }
                name => {
                    let name = if name.is_empty() { self.answers.page() } else { name };
                    file(name).map(|file| (file.kind, Bytes::from_static(file.text.as_bytes()))).ok_or_else(unknown)
                }
            };
        }
        let asked = asked(body).await?;
        let _at_work = connection.at_work();
        match name.as_str() {
            "tile" => {
                let TileAsked { scene, z, x, y } = of(asked)?;
                let (pool, tile) = (Arc::clone(&self.pool), View::read(&scene)?.tile(z, x, y)?);
                let given_up = || Refusal::new(503, "nobody waits for this tile any more");
                let job = move |stop: &Stop| tile::compute(&tile, &pool, stop).ok_or_else(given_up);
                Ok((NUMBERS, self.tiles.run(job).await?.into()))
            }
            "scale" => {
                let ScaleAsked { scene, color } = of(asked)?;
                let (pool, view) = (Arc::clone(&self.pool), View::read(&scene)?);
                let quantity = scale::asked(view.scene(), &color)?;
                let given_up = || Refusal::new(503, "nobody waits for this scale any more");
                let job = move |stop: &Stop| scale::of(view.scene(), quantity, &pool, stop).ok_or_else(given_up);
                Ok((JSON, self.tiles.run(job).await?.to_string().into()))
            }
            "view" => {
                let ViewAsked { scene } = of(asked)?;
                let view = View::read(&scene)?;
                let (scene, conservative) = (view.value(), view.scene().is_conservative());
                let heading = [view.scene().heading(), view.scene().criterion()].join(", ");
                let value = json!({
                    "scene": scene,
                    "deepest": view.deepest(),
                    "conservative": conservative,
                    "heading": heading,
                });
                Ok((JSON, value.to_string().into()))
            }
            _ => {
                let answers = Arc::clone(&self.answers);
                let queue = if answers.is_long(&name) { &self.long } else { &self.questions };
                let value = queue.run(move |stop| answers.answer(&name, &asked, stop)).await?;
                Ok((JSON, value.to_string().into()))
            }
        }
    }
}

/// What the page needs to show a parameter and to ask for its value.
fn control(parameter: Parameter) -> Value {
    let Row { name, symbol, word, slider, part, .. } = parameter.row();
    json!({ "name": name, "letter": symbol, "label": format!("{word} {symbol}"), "slider": slider, "layers": *part == Part::Layers })
}

/// The body of a request, as JSON.
async fn asked<B>(body: B) -> Result<Value, Refusal>
where
    B: Body<Data = Bytes>,
    B::Error: Into<Box<dyn std::error::Error + Send + Sync>>,
{
    let large = || Refusal::new(413, format!("a request has at most {MOST_ASKED} bytes"));
    ensure!(body.size_hint().lower() <= MOST_ASKED as u64, large());
    let slow = |_| Refusal::new(408, "the request has not arrived in time");
    let whole = timeout(PATIENCE, Limited::new(body, MOST_ASKED).collect()).await.map_err(slow)?;
    let bytes = match whole {
        Ok(whole) => whole.to_bytes(),
        Err(error) if error.is::<LengthLimitError>() => return Err(large()),
        Err(_) => refuse!("the request ends before its end"),
    };
    serde_json::from_slice(&bytes).map_err(|error| Refusal::wrong(format!("the request is no JSON: {error}")))
}

fn of<T: serde::de::DeserializeOwned>(asked: Value) -> Result<T, Refusal> {
    serde_json::from_value(asked).map_err(|error| Refusal::wrong(error.to_string()))
}
