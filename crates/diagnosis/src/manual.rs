//! What a manual has to say of step changes [R150..R153].

use encoring_words::Model;
use encoring_words::model::MODELS;
use encoring_words::sheet::StepChange;

use crate::cause::JumpCause;
use crate::episode::Episode;

/// Whether it is, or may be, mechanical or electrical.
pub(crate) fn is_of_the_manual(episode: &Episode) -> bool {
    let causes = [episode.cause].into_iter().chain(episode.alternatives.iter().copied());
    causes.into_iter().any(JumpCause::is_of_the_manual)
}

/// The table of the one manual that has it.
pub(crate) fn step_changes() -> &'static [StepChange] {
    MODELS.into_iter().map(Model::step_changes).find(|steps| !steps.is_empty()).unwrap_or_default()
}
