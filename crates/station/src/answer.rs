//! What is answered to a line, as a line of JSON.

use serde::Serialize;
use serde_json::value::RawValue;

use crate::controlled::Controlled;
use crate::verbs::{Given, Refused, VERBS, parse, shortened};
use crate::view::View;

/// The longest message of an answer, in characters; a message quotes what a peer sent.
const MESSAGE_CHARS_MAX: usize = 512;

/// Reads one line, does what it asks and gives the answer, without its end. Waits for the ring for up to a cycle.
#[must_use]
pub fn answer(text: &str, controlled: &Controlled) -> String {
    let request = parse(text, &controlled.units);
    let result = request.command.and_then(|command| command.obey(controlled));
    answered(request.id, &result)
}

/// The answer to what was not even read, with the reason.
#[must_use]
pub fn refusal(why: &str) -> String {
    in_json(false, None, Content::Refused { error: shortened(why, MESSAGE_CHARS_MAX) })
}

#[derive(Serialize)]
struct Answer<'a> {
    ok: bool,
    #[serde(skip_serializing_if = "Option::is_none")]
    id: Option<&'a RawValue>,
    #[serde(flatten)]
    content: Content<'a>,
}

#[derive(Serialize)]
#[serde(untagged)]
enum Content<'a> {
    Done {},
    Reply { reply: ReplyView },
    View { view: &'a View },
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

fn answered(id: Option<&RawValue>, result: &Result<Given, Refused>) -> String {
    let content = match result {
        Ok(Given::Done) => Content::Done {},
        Ok(Given::Reply { reply, error_before }) => Content::Reply {
            reply: ReplyView { data: reply.data, error: reply.error, error_before: *error_before },
        },
        Ok(Given::View(view)) => Content::View { view },
        Ok(Given::GatewayFaults(faults)) => Content::GatewayFaults { faults },
        Ok(Given::Help) => Content::Help {
            verbs: VERBS
                .map(|verb| Help {
                    verb: verb.name,
                    does: (verb.does)(),
                    examples: verb
                        .examples
                        .iter()
                        .filter_map(|text| serde_json::from_str(text).ok())
                        .collect(),
                })
                .into(),
        },
        Err(refused) => Content::Refused { error: shortened(&refused.to_string(), MESSAGE_CHARS_MAX) },
    };
    in_json(result.is_ok(), id, content)
}

fn in_json(ok: bool, id: Option<&RawValue>, content: Content<'_>) -> String {
    let answer = Answer { ok, id, content };
    // Plain data with names for keys has no reason to fail.
    serde_json::to_string(&answer).unwrap_or_else(|_| r#"{"ok":false,"error":"no answer"}"#.to_owned())
}
