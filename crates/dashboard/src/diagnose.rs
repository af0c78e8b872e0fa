//! A recording that is dropped on the page: what `encoring diagnose` would print of it, and its picture.
//!
//! It is read as it comes, in a thread beside that of the ring, so that nothing of it is kept but what the diagnosis
//! needs. One is read at a time.

use std::io::{self, BufReader, Read};
use std::str::FromStr;

use axum::body::{Body, Bytes};
use axum::extract::rejection::QueryRejection;
use axum::extract::{Query, State};
use axum::http::StatusCode;
use axum::response::Response;
use encoring_diagnosis::{
    Detector, Diagnosed, DiagnosisReport, Options, Picture, RecordedSamples, SaidReport,
};
use encoring_figure::Chart;
use encoring_station::NamedEncoder;
use encoring_texts::{Said, own};
use encoring_trace::{Reader, TableLayout};
use encoring_words::Model;
use encoring_words::number::Bare;
use futures_util::StreamExt;
use serde::{Deserialize, Serialize};
use tokio::sync::mpsc::{Receiver, Sender, channel};
use tokio::task::spawn_blocking;
use tokio::time::{Duration, timeout};

use crate::in_json::{given, refused, wrong_query};
use crate::refusals;
use crate::shared::Shared;

/// The longest recording.
const RECORDING_BYTES_MAX: usize = 100_000_000;

/// How long all of it may take to come.
const COMES_WITHIN: Duration = Duration::from_secs(300);

/// Pieces that have come and are not read yet.
const PIECES_WAITING: usize = 4;

/// What is said of a recording.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct DiagnoseQuery {
    /// What the report calls it.
    #[serde(default)]
    name: String,
    /// The model on the type label; empty: the recording names it, or nobody knows it.
    #[serde(default)]
    model: String,
    /// Which column of a table is which, as `--columns` of `encoring diagnose` takes it; empty: its header says it.
    #[serde(default)]
    columns: String,
    /// Words without sign and base mark are decimal.
    #[serde(default)]
    decimal: bool,
}

/// What is found.
#[derive(Serialize)]
struct Found {
    rows: u64,
    /// `false` if there were too few rows.
    judged: bool,
    /// What was assumed of a table.
    assumed: Option<String>,
    /// No word has a letter, and all were read as hexadecimal.
    may_be_decimal: bool,
    /// The last line, if it has no line end and is left out.
    left_out: Option<u64>,
    report: DiagnosisReport,
    /// Its sentences as codes and values.
    said: SaidReport,
    /// In SVG.
    picture: String,
    /// The texts in the picture.
    labels: Vec<Label>,
}

/// A text in the picture, and what it says.
#[derive(Serialize)]
struct Label {
    text: String,
    said: Said,
}

impl From<Said> for Label {
    fn from(said: Said) -> Self {
        Self { text: said.to_string(), said }
    }
}

/// Why what comes is not taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{}", self.said())]
enum NotTaken {
    TooLong,
    TooSlow,
    BrokenOff,
}

impl NotTaken {
    fn said(self) -> Said {
        match self {
            Self::TooLong => refusals::recording_too_long(RECORDING_BYTES_MAX),
            Self::TooSlow => refusals::recording_too_slow(),
            Self::BrokenOff => refusals::recording_broken_off(),
        }
    }

    const fn status(self) -> StatusCode {
        match self {
            Self::TooLong => StatusCode::PAYLOAD_TOO_LARGE,
            Self::TooSlow => StatusCode::REQUEST_TIMEOUT,
            Self::BrokenOff => StatusCode::BAD_REQUEST,
        }
    }
}

/// Bytes on their way from the connection to whoever reads them in another thread.
struct Coming {
    pieces: Receiver<Result<Bytes, NotTaken>>,
    piece: Bytes,
}

impl Read for Coming {
    fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
        while self.piece.is_empty() {
            match self.pieces.blocking_recv() {
                Some(piece) => self.piece = piece.map_err(io::Error::other)?,
                None => return Ok(0),
            }
        }
        let taken = self.piece.split_to(into.len().min(self.piece.len()));
        into.iter_mut().zip(&taken).for_each(|(into, byte)| *into = *byte);
        Ok(taken.len())
    }
}

/// Passes the body on, piece by piece. What comes after the reader has had enough is read and dropped: an answer before
/// the end of a request is lost in some browsers.
async fn feed(body: Body, pieces: Sender<Result<Bytes, NotTaken>>, slow: Duration) -> Result<(), NotTaken> {
    let (mut stream, mut bytes) = (body.into_data_stream(), 0);
    loop {
        let piece = match timeout(slow, stream.next()).await {
            Ok(None) => return Ok(()),
            Ok(Some(Ok(piece))) => piece,
            Ok(Some(Err(_))) => return Err(NotTaken::BrokenOff),
            Err(_) => return Err(NotTaken::TooSlow),
        };
        bytes += piece.len();
        if bytes > RECORDING_BYTES_MAX {
            return Err(NotTaken::TooLong);
        }
        // A reader that has found an error is gone.
        let _ = pieces.send(Ok(piece)).await;
    }
}

/// The same for no longer than all of it may take; whoever reads learns why it ends early.
async fn fed(body: Body, pieces: Sender<Result<Bytes, NotTaken>>, slow: Duration) -> Result<(), NotTaken> {
    let fed = timeout(COMES_WITHIN, feed(body, pieces.clone(), slow)).await.unwrap_or(Err(NotTaken::TooSlow));
    if let Err(why) = fed {
        let _ = pieces.send(Err(why)).await;
    }
    fed
}

/// What somebody says of a recording.
struct About {
    name: String,
    /// On the type label.
    model: Option<Model>,
    /// `None`: the header of a table says it.
    layout: Option<TableLayout>,
}

impl About {
    fn of(query: DiagnoseQuery) -> Result<Self, Said> {
        let DiagnoseQuery { name, model, columns, decimal } = query;
        let model = match (model.is_empty(), Model::from_str(&model)) {
            (true, _) => None,
            (false, Ok(model)) => Some(model),
            (false, Err(_)) => return Err(refusals::unknown_model(&model)),
        };
        let columns = match columns.trim() {
            "" => None,
            said => Some(said.parse().map_err(|wrong: String| own(&wrong))?),
        };
        let bare = if decimal { Bare::Decimal } else { Bare::Hexadecimal };
        let layout =
            (columns.is_some() || decimal).then(|| TableLayout { columns, bare, ..TableLayout::default() });
        Ok(Self { name, model, layout })
    }

    /// Who looks at a recording that names these encoders.
    fn detector(&self, named: &[NamedEncoder]) -> Result<Detector, Said> {
        if let Some(said) = self.model
            && let Some(other) = named.iter().find(|one| one.model != said)
        {
            return Err(refusals::other_model(other.position, other.model.name(), said.name()));
        }
        let model = self.model.or(NamedEncoder::only_model(named));
        let all = Options { model, ..Options::default() };
        let about = |detector: Detector, one: &NamedEncoder| detector.about(one.position, one.options(&all));
        Ok(named.iter().fold(Detector::new(all.clone()), about))
    }
}

fn found(about: &About, coming: Coming) -> Result<Found, Said> {
    let name = &about.name;
    let mut recorded = RecordedSamples::open(name, BufReader::new(coming), about.layout.as_ref())?;
    let assumed = recorded.table().and_then(|table| table.assumed()).map(ToString::to_string);
    let named = NamedEncoder::all(name, &recorded)?;
    let detector = |_: &RecordedSamples<_>| about.detector(&named);
    let mut diagnosed = Diagnosed::read(&mut recorded, Some(Picture::default()), detector, || true)?;
    let picture = diagnosed.picture.take().unwrap_or_default();
    let episodes = &diagnosed.conclusion.episodes;
    let labels = picture.labels(name, episodes);
    let charts = picture.charts(name, 1, episodes);
    Ok(Found {
        rows: diagnosed.rows,
        judged: diagnosed.is_judged(),
        assumed,
        may_be_decimal: recorded.table().is_some_and(Reader::may_be_decimal),
        left_out: recorded.table().and_then(Reader::piece),
        picture: Chart::sheet(name, &charts),
        labels: labels.into_iter().map(Label::from).collect(),
        said: SaidReport::new(&diagnosed.conclusion),
        report: DiagnosisReport::new(&[diagnosed]),
    })
}

/// Why the position jumped in the recording that is the body.
pub(crate) async fn diagnose(
    State(shared): State<Shared>,
    query: Result<Query<DiagnoseQuery>, QueryRejection>,
    body: Body,
) -> Response {
    let about = match query.map(|Query(query)| About::of(query)) {
        Ok(Ok(about)) => about,
        Ok(Err(wrong)) => return refused(StatusCode::BAD_REQUEST, &wrong),
        Err(wrong) => return wrong_query(&wrong),
    };
    let Ok(alone) = shared.diagnosing.clone().try_acquire_owned() else {
        return refused(StatusCode::SERVICE_UNAVAILABLE, &refusals::busy());
    };
    let (pieces, coming) = channel(PIECES_WAITING);
    let coming = Coming { pieces: coming, piece: Bytes::new() };
    let reading = spawn_blocking(move || {
        let _alone = alone;
        found(&about, coming)
    });
    if let Err(why) = fed(body, pieces, shared.slow).await {
        return refused(why.status(), &why.said());
    }
    match reading.await {
        Ok(Ok(found)) => given(&found),
        Ok(Err(why)) => refused(StatusCode::BAD_REQUEST, &why),
        Err(_) => refused(StatusCode::INTERNAL_SERVER_ERROR, &refusals::not_read()),
    }
}
