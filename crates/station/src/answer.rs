//! What is answered to a line, as a line of JSON.

use encoring_texts::Said;
use serde::Serialize;
use serde_json::value::RawValue;

use crate::controlled::Controlled;
use crate::polled_view::PolledView;
use crate::verbs::{Command, Encoders, Given, Permission, Refused, VERBS, parse, shortened};
use crate::view::View;

/// The longest message of an answer, in characters; a message quotes what a peer sent.
const MESSAGE_CHARS_MAX: usize = 512;

/// What became of a line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LineFate {
    /// It was done.
    Done,
    /// It was not.
    Refused,
    /// Whoever said it may only look.
    Forbidden,
}

/// The answer to a line, without its end, and what became of it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ToldBack {
    /// One object of JSON.
    pub line: String,
    /// What became of it.
    pub fate: LineFate,
}

/// Reads one line, does what it asks and gives the answer, without its end. Waits for the ring for up to a cycle.
#[must_use]
pub fn answer(text: &str, controlled: &Controlled) -> String {
    let encoders = Encoders::Simulated(&controlled.units);
    let (id, result) = carried_out(text, encoders, Permission::Change, |command| command.obey(controlled));
    answered(id, &result, encoders, None)
}

/// The same for somebody who may not do everything.
#[must_use]
pub fn answer_within(text: &str, controlled: &Controlled, permission: Permission) -> ToldBack {
    told_back(text, Encoders::Simulated(&controlled.units), permission, |command| command.obey(controlled))
}

/// The same for a ring of any kind, which `obey`s.
pub(crate) fn told_back(
    text: &str,
    encoders: Encoders<'_>,
    permission: Permission,
    obey: impl FnOnce(Command) -> Result<Given, Refused>,
) -> ToldBack {
    let (id, result) = carried_out(text, encoders, permission, obey);
    let fate = match result {
        Ok(_) => LineFate::Done,
        Err(Refused::OnlyLooks) => LineFate::Forbidden,
        Err(_) => LineFate::Refused,
    };
    let said = result.as_ref().err().map(Refused::said);
    ToldBack { line: answered(id, &result, encoders, said.as_ref()), fate }
}

fn carried_out<'a>(
    text: &'a str,
    encoders: Encoders<'_>,
    permission: Permission,
    obey: impl FnOnce(Command) -> Result<Given, Refused>,
) -> (Option<&'a RawValue>, Result<Given, Refused>) {
    let request = parse(text, encoders);
    let result = request.command.and_then(|command| match (permission, command.changes()) {
        (Permission::Look, true) => Err(Refused::OnlyLooks),
        _ => obey(command),
    });
    (request.id, result)
}

/// The answer to what was not even read, with the reason, to a line of the control port.
#[must_use]
pub fn refusal(why: &str) -> String {
    in_json(false, None, Content::Refused { error: shortened(why, MESSAGE_CHARS_MAX) }, None)
}

/// The same to a page, which has the sentence in its own language.
#[must_use]
pub fn refusal_said(said: &Said) -> String {
    let error = shortened(said.text(), MESSAGE_CHARS_MAX);
    in_json(false, None, Content::Refused { error }, Some(said))
}

#[derive(Serialize)]
struct Answer<'a> {
    ok: bool,
    #[serde(skip_serializing_if = "Option::is_none")]
    id: Option<&'a RawValue>,
    #[serde(flatten)]
    content: Content<'a>,
    /// Why it was refused, for whoever says it in another language.
    #[serde(skip_serializing_if = "Option::is_none")]
    said: Option<&'a Said>,
}

#[derive(Serialize)]
#[serde(untagged)]
enum Content<'a> {
    Done {},
    Reply { reply: ReplyView },
    View { view: &'a View },
    PolledView { view: &'a PolledView },
    GatewayFaults { faults: &'a [String] },
    Help { verbs: Vec<Help> },
    Refused { error: String },
}

/// What an encoder replied to a service.
#[derive(Serialize)]
struct ReplyView {
    data: u32,
    error: bool,
    error_before: bool,
}

#[derive(Serialize)]
struct Help {
    verb: &'static str,
    does: String,
    examples: Vec<&'static RawValue>,
}

fn answered(
    id: Option<&RawValue>,
    result: &Result<Given, Refused>,
    encoders: Encoders<'_>,
    said: Option<&Said>,
) -> String {
    let content = match result {
        Ok(Given::Done) => Content::Done {},
        Ok(Given::Reply { reply, error_before }) => Content::Reply {
            reply: ReplyView { data: reply.data, error: reply.error, error_before: *error_before },
        },
        Ok(Given::View(view)) => Content::View { view },
        Ok(Given::PolledView(view)) => Content::PolledView { view },
        Ok(Given::GatewayFaults(faults)) => Content::GatewayFaults { faults },
        Ok(Given::Help) => Content::Help {
            verbs: VERBS
                .iter()
                .filter(|verb| encoders.take(verb))
                .map(|verb| Help {
                    verb: verb.name,
                    does: (verb.does)(),
                    examples: verb
                        .examples
                        .iter()
                        .filter_map(|text| serde_json::from_str(text).ok())
                        .collect(),
                })
                .collect(),
        },
        Err(refused) => Content::Refused { error: shortened(&refused.to_string(), MESSAGE_CHARS_MAX) },
    };
    in_json(result.is_ok(), id, content, said)
}

fn in_json(ok: bool, id: Option<&RawValue>, content: Content<'_>, said: Option<&Said>) -> String {
    let answer = Answer { ok, id, content, said };
    // Plain data with names for keys has no reason to fail.
    serde_json::to_string(&answer).unwrap_or_else(|_| r#"{"ok":false,"error":"no answer"}"#.to_owned())
}
