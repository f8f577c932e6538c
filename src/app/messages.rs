//! What the window has to say: results for a moment, errors until they are dismissed.

use std::time::{Duration, Instant};

/// How long a message that is no error stays.
const MOMENT: Duration = Duration::from_secs(6);

/// More than this many errors are counted instead of shown.
const MOST: usize = 5;

#[derive(Clone, Debug)]
pub struct Message {
    pub text: String,
    pub error: bool,
    /// The same text came this many times.
    pub count: usize,
    since: Instant,
}

/// The messages that are shown now, oldest first.
#[derive(Clone, Debug, Default)]
pub struct Messages {
    messages: Vec<Message>,
}

impl Messages {
    pub fn say(&mut self, text: impl Into<String>) {
        self.push(text.into(), false);
    }

    pub fn error(&mut self, text: impl Into<String>) {
        self.push(text.into(), true);
    }

    pub fn iter(&self) -> impl Iterator<Item = &Message> {
        self.messages.iter()
    }

    pub fn dismiss(&mut self, index: usize) {
        if index < self.messages.len() {
            self.messages.remove(index);
        }
    }

    /// Drops what has had its moment; when to look again.
    pub fn expire(&mut self, now: Instant) -> Option<Duration> {
        let age = |m: &Message| now.saturating_duration_since(m.since);
        self.messages.retain(|m| m.error || age(m) < MOMENT);
        self.messages.iter().filter(|m| !m.error).map(|m| MOMENT - age(m)).min()
    }

    fn push(&mut self, text: String, error: bool) {
        let now = Instant::now();
        if let Some(i) = self.messages.iter().position(|m| m.text == text && m.error == error) {
            let mut again = self.messages.remove(i);
            again.count += usize::from(error);
            again.since = now;
            self.messages.push(again);
            return;
        }
        if !error {
            // A newer result replaces the older one.
            self.messages.retain(|m| m.error);
        }
        self.messages.push(Message { text, error, count: 1, since: now });
        if self.messages.len() > MOST {
            self.messages.remove(0);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn texts(messages: &Messages) -> Vec<&str> {
        messages.iter().map(|m| m.text.as_str()).collect()
    }

    #[test]
    fn errors_stay_and_results_pass() {
        let mut messages = Messages::default();
        messages.error("no such file");
        messages.say("copied");
        messages.say("written");
        assert_eq!(texts(&messages), ["no such file", "written"]);
        assert!(messages.expire(Instant::now()).is_some_and(|d| d <= MOMENT));
        assert_eq!(messages.expire(Instant::now() + 2 * MOMENT), None);
        assert_eq!(texts(&messages), ["no such file"]);
        messages.dismiss(0);
        messages.dismiss(7);
        assert!(texts(&messages).is_empty());
    }

    #[test]
    fn the_same_error_is_counted_and_there_are_never_too_many() {
        let mut messages = Messages::default();
        for _ in 0..3 {
            messages.error("again");
        }
        assert_eq!(messages.iter().map(|m| m.count).collect::<Vec<_>>(), [3]);
        for i in 0..20 {
            messages.error(i.to_string());
        }
        assert_eq!(messages.iter().count(), MOST);
    }
}
