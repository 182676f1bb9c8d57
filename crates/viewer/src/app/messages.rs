//! Messages to the user.

use super::App;
use planish_files::failure::Failure;
use std::time::{Duration, Instant};

/// Time for which messages that are no errors are shown.
const NEWS_STAY: Duration = Duration::from_secs(10);

/// Message to the user.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Message {
    /// Severity of a message.
    pub kind: MessageKind,
    /// Text of the message, one sentence.
    pub text: String,
    /// Time at which the message disappears by itself; errors stay until they are dismissed.
    until: Option<Instant>,
}

/// Severity of a message.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MessageKind {
    /// Something was done.
    Done,
    /// Something was done, with a reservation.
    Warning,
    /// Something could not be done.
    Error,
}

impl App {
    /// Returns the messages that have not been dismissed.
    pub fn messages(&self) -> &[Message] {
        &self.messages
    }
    /// Dismisses a message.
    pub fn dismiss(&mut self, index: usize) {
        if index < self.messages.len() {
            self.messages.remove(index);
        }
    }
    /// Adds a message.
    pub fn say(&mut self, kind: MessageKind, text: impl Into<String>) {
        let text = text.into();
        // The same again says nothing new.
        self.messages.retain(|known| known.text != text);
        let until = (kind != MessageKind::Error).then(|| self.now + NEWS_STAY);
        self.messages.push(Message { kind, text, until });
    }
    /// Adds a message about a failure; an interruption is not reported.
    pub(crate) fn fail(&mut self, failure: &Failure) {
        match failure {
            Failure::Interrupted => {}
            Failure::Input(text) | Failure::Internal(text) => self.say(MessageKind::Error, text.clone()),
        }
    }

    /// Removes the messages that have been shown for long enough.
    pub(super) fn forget_old_news(&mut self) {
        let now = self.now;
        self.messages.retain(|message| message.until.is_none_or(|until| now < until));
    }

    /// Returns the time at which the next message disappears.
    pub(super) fn news_end(&self) -> Option<Instant> {
        self.messages.iter().filter_map(|message| message.until).min()
    }
}
