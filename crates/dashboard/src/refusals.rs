//! Why a request is refused, in sentences. The terminal and scripts have the English ones, the page those of its own
//! language.

use encoring_texts::{OWN, Said, SaidTemplate, texts};

texts! {
    "page";

    fn other_host() = "the page is not served under this Host; --web-host NAME adds a name";
    fn other_page() = "requests from other pages are refused";
    fn other_kind() = "the body must be application/json, a recording application/octet-stream";
    fn no_token() = "a token is needed: as a bearer, or entered in the page";
    fn wrong_token() = "this token is wrong";
    fn too_many() = "too many wrong tokens came from this address; try again in a minute";
    fn recording_too_long(bytes: usize) = "the recording is longer than {bytes} bytes; use encoring diagnose";
    fn recording_too_slow() = "the recording did not come in time";
    fn recording_broken_off() = "the recording is broken off";
    fn busy() = "another recording is being read; try again later";
    fn not_read() = "the recording could not be read";
    fn no_model(model: &str, models: String) = "model {model}: no such model; the models are {models}";
    fn other_model(position: u8, named: &str, said: &str) =
        "the recording says that encoder {position} is a {named}, not a {said}";
    fn no_position(position: usize, last: usize) = "position {position}; the last encoder is at {last}";
    fn body_too_long(bytes: usize) = "the body is broken off, or longer than {bytes} bytes";
    fn body_too_slow() = "the body did not come in time";
    fn no_text() = "the body is not UTF-8";
    fn no_login() = "the body is no object with the key token";
    fn stopped() = "the ring has stopped";
}

/// Every sentence that says why a request was refused.
pub fn refusals() -> impl Iterator<Item = &'static SaidTemplate> {
    let verbs = encoring_station::verbs::refusals();
    let unreadable = encoring_diagnosis::unreadable_sentences();
    TEXTS.iter().chain(OWN).chain(verbs).chain(unreadable)
}

/// That there is no model of this name.
pub(crate) fn unknown_model(model: &str) -> Said {
    no_model(model, encoring_words::model::MODELS.map(encoring_words::Model::name).join(", "))
}
