//! What the user is told.

use super::App;
use planish_files::failure::Failure;
use std::time::{Duration, Instant};

/// How long good news are shown.
const NEWS_STAY: Duration = Duration::from_secs(10);

/// Something to tell the user.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Message {
    /// How bad it is.
    pub kind: MessageKind,
    /// One sentence.
    pub text: String,
    /// When it goes away by itself; errors stay until they are put away.
    until: Option<Instant>,
}

/// How bad it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MessageKind {
    /// All is well.
    Done,
    /// All is well, but.
    Warning,
    /// Something could not be done.
    Error,
}

impl App {
    /// What the user was told and has not put away.
    pub fn messages(&self) -> &[Message] {
        &self.messages
    }
    /// Puts a message away.
    pub fn dismiss(&mut self, index: usize) {
        if index < self.messages.len() {
            self.messages.remove(index);
        }
    }
    /// Tells the user something.
    pub fn say(&mut self, kind: MessageKind, text: impl Into<String>) {
        let text = text.into();
        // The same again says nothing new.
        self.messages.retain(|known| known.text != text);
        let until = (kind != MessageKind::Error).then(|| self.now + NEWS_STAY);
        self.messages.push(Message { kind, text, until });
    }
    /// Tells the user what could not be done; an interruption is no news.
    pub(crate) fn fail(&mut self, failure: &Failure) {
        match failure {
            Failure::Interrupted => {}
            Failure::Input(text) | Failure::Internal(text) => self.say(MessageKind::Error, text.clone()),
        }
    }

    /// Forgets the news that have been shown for long enough.
    pub(super) fn forget_old_news(&mut self) {
        let now = self.now;
        self.messages.retain(|message| message.until.is_none_or(|until| now < until));
    }

    /// When the next news are old.
    pub(super) fn news_end(&self) -> Option<Instant> {
        self.messages.iter().filter_map(|message| message.until).min()
    }
}
