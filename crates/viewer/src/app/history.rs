//! History of a value, for undo and redo.

/// Whether the user is in the middle of a gesture, such as the drag of a slider.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Gesture {
    /// No gesture goes on: the values are what the user wants.
    None,
    /// A gesture goes on: the values will change until it ends.
    Ongoing,
}

/// Values of the past and of the future of one that changes. What happens between pressing and releasing the mouse is one
/// step.
#[derive(Clone, Debug)]
pub struct History<T> {
    past: Vec<T>,
    present: T,
    future: Vec<T>,
}

/// Nobody goes back farther.
const MOST_STEPS: usize = 200;

impl<T: Clone + PartialEq> History<T> {
    /// Begins with a value.
    pub fn new(present: T) -> Self {
        Self { past: Vec::new(), present, future: Vec::new() }
    }

    /// Takes note of the value as it is now. What happens during a gesture becomes one step when the gesture has ended.
    pub fn note(&mut self, now: &T, gesture: Gesture) {
        if gesture == Gesture::Ongoing || *now == self.present {
            return;
        }
        self.past.push(std::mem::replace(&mut self.present, now.clone()));
        if self.past.len() > MOST_STEPS {
            self.past.remove(0);
        }
        self.future.clear();
    }

    /// The value before the last step.
    pub fn undo(&mut self) -> Option<T> {
        let before = self.past.pop()?;
        self.future.push(std::mem::replace(&mut self.present, before));
        Some(self.present.clone())
    }

    /// The value before the last [`undo`](Self::undo).
    pub fn redo(&mut self) -> Option<T> {
        let after = self.future.pop()?;
        self.past.push(std::mem::replace(&mut self.present, after));
        Some(self.present.clone())
    }

    /// Whether there is something to undo, and to redo.
    pub fn can(&self) -> [bool; 2] {
        [!self.past.is_empty(), !self.future.is_empty()]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn there_and_back_again() {
        let mut history = History::new(0);
        history.note(&1, Gesture::None);
        history.note(&1, Gesture::None);
        history.note(&2, Gesture::None);
        assert_eq!((history.undo(), history.undo(), history.undo()), (Some(1), Some(0), None));
        assert_eq!((history.redo(), history.can()), (Some(1), [true, true]));
        history.note(&5, Gesture::None);
        assert_eq!((history.redo(), history.undo()), (None, Some(1)), "a new step ends the future");
    }

    #[test]
    fn a_drag_is_one_step() {
        let mut history = History::new(0);
        for x in 1..9 {
            history.note(&x, Gesture::Ongoing);
        }
        history.note(&8, Gesture::None);
        assert_eq!((history.undo(), history.can()), (Some(0), [false, true]));
    }
}
