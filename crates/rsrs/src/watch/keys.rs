//! What keys ask for.

use ratatui::crossterm::event::{KeyCode, KeyEvent, KeyEventKind, KeyModifiers};

/// What a person asks for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Request {
    Quit,
    /// To stop all robots.
    Stop,
    /// To see what the keys do, or not any more.
    Help,
    /// To see other rows of the table, so many further down, by rows or by screens.
    Rows(isize),
    /// By screens.
    Screens(isize),
    /// To see the first rows, or the beginning of a recording.
    Begin,
    /// To see the last rows, or the end of a recording.
    End,
    /// To pause a recording, or to go on.
    Pause,
    /// To go back or forward in a recording.
    Skip(i8),
    Faster,
    Slower,
    /// To see everything anew, where another program has written over it.
    Redraw,
}

/// What a key asks for; `None` for one that asks for nothing.
pub fn request(key: KeyEvent) -> Option<Request> {
    if key.kind == KeyEventKind::Release {
        return None;
    }
    if key.modifiers.contains(KeyModifiers::CONTROL) {
        return match key.code {
            // In this mode a terminal sends no signal for them.
            KeyCode::Char('c' | 'd') => Some(Request::Quit),
            KeyCode::Char('l') => Some(Request::Redraw),
            _ => None,
        };
    }
    Some(match key.code {
        KeyCode::Char('q' | 'Q') | KeyCode::Esc => Request::Quit,
        KeyCode::Char('s' | 'S') => Request::Stop,
        KeyCode::Char('?' | 'h') => Request::Help,
        KeyCode::Up | KeyCode::Char('k') => Request::Rows(-1),
        KeyCode::Down | KeyCode::Char('j') => Request::Rows(1),
        KeyCode::PageUp => Request::Screens(-1),
        KeyCode::PageDown => Request::Screens(1),
        KeyCode::Home => Request::Begin,
        KeyCode::End => Request::End,
        KeyCode::Char(' ') => Request::Pause,
        KeyCode::Left => Request::Skip(-1),
        KeyCode::Right => Request::Skip(1),
        KeyCode::Char('+' | '=' | ']') => Request::Faster,
        KeyCode::Char('-' | '_' | '[') => Request::Slower,
        _ => return None,
    })
}

/// The first row after a request to see others, where there is room for `n_rows` of `n_robots`.
pub fn scrolled(first: usize, request: Request, (n_rows, n_robots): (usize, usize)) -> usize {
    let by = match request {
        Request::Rows(by) => by,
        Request::Screens(by) => by.saturating_mul(isize::try_from(n_rows).unwrap_or(isize::MAX)),
        Request::Begin => isize::MIN,
        Request::End => isize::MAX,
        _ => 0,
    };
    first.saturating_add_signed(by).min(n_robots.saturating_sub(n_rows))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ctrl_c_quits_and_letters_with_control_do_nothing_else() {
        let with_control = |letter| KeyEvent::new(KeyCode::Char(letter), KeyModifiers::CONTROL);

        assert_eq!(request(with_control('c')), Some(Request::Quit));
        assert_eq!(request(with_control('s')), None);
    }

    #[test]
    fn a_table_scrolls_to_its_ends_and_no_further() {
        let room = (18, 30);

        assert_eq!(scrolled(0, Request::Rows(1), room), 1);
        assert_eq!(scrolled(0, Request::Rows(-1), room), 0);
        assert_eq!(scrolled(1, Request::Screens(1), room), 12);
        assert_eq!(scrolled(12, Request::Begin, room), 0);
        assert_eq!(scrolled(0, Request::End, room), 12);
        assert_eq!(scrolled(5, Request::Rows(1), (30, 9)), 0);
    }
}
