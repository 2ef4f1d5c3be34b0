//! STATUSTEXT (253): words in pieces of 50 bytes.

use super::raw::TextPiece;
use drover_contract::Severity;

/// Texts that are being put together at once, at most.
const PARTIAL_MAX: usize = 4;
/// Pieces of one text, at most.
const PIECES_MAX: usize = 10;

/// Puts pieces together. A text whose pieces went missing is given out as far as it came when its place is needed.
#[derive(Debug, Default)]
pub(crate) struct Texts {
    partial: Vec<Partial>,
}

#[derive(Debug)]
struct Partial {
    component: u8,
    id: u16,
    severity: u8,
    pieces: u8,
    bytes: Vec<u8>,
}

impl Texts {
    /// The text that `piece` completes, or that had to make room for it.
    pub(crate) fn handle(&mut self, component: u8, piece: TextPiece<'_>) -> Option<(Severity, String)> {
        if piece.id == 0 {
            return Some((severity(piece.severity), printable(piece.text)));
        }
        let known = self.partial.iter().position(|it| it.component == component && it.id == piece.id);
        let mut text = match known {
            Some(index) => self.partial.remove(index),
            None => Partial { component, id: piece.id, severity: piece.severity, pieces: 0, bytes: Vec::new() },
        };
        if piece.chunk != text.pieces {
            text.bytes.extend_from_slice(b"...");
        }
        text.bytes.extend_from_slice(piece.text);
        text.pieces = piece.chunk.saturating_add(1);
        let last = piece.text.len() < TextPiece::BYTES_MAX || text.bytes.len() >= PIECES_MAX * TextPiece::BYTES_MAX;
        if last {
            return Some(text.finish());
        }
        self.partial.push(text);
        (self.partial.len() > PARTIAL_MAX).then(|| self.partial.remove(0).finish())
    }
}

impl Partial {
    fn finish(self) -> (Severity, String) {
        (severity(self.severity), printable(&self.bytes))
    }
}

/// Whatever a wire says ends up on a terminal: only printable characters pass.
fn printable(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).chars().map(|letter| if letter.is_control() { ' ' } else { letter }).collect()
}

/// MAV_SEVERITY: 0 emergency .. 3 error, 4 warning, 5 notice and less.
const fn severity(wire: u8) -> Severity {
    match wire {
        0..=3 => Severity::Error,
        4 => Severity::Warning,
        _ => Severity::Info,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn piece(text: &[u8], id: u16, chunk: u8) -> TextPiece<'_> {
        TextPiece { severity: 4, text, id, chunk }
    }

    #[test]
    fn a_short_text_passes_at_once_and_without_control_characters() {
        let out = Texts::default().handle(1, piece(b"Arm: \x1b[31mno", 0, 0));
        assert_eq!(out, Some((Severity::Warning, "Arm:  [31mno".into())));
    }

    #[test]
    fn a_long_text_comes_in_pieces_and_a_lost_piece_shows() {
        let mut texts = Texts::default();
        let full = [b'a'; 50];
        assert_eq!(texts.handle(1, piece(&full, 7, 0)), None);
        let (_, whole) = texts.handle(1, piece(b"end", 7, 1)).expect("complete");
        assert_eq!(whole.len(), 53);
        assert_eq!(texts.handle(1, piece(&full, 8, 0)), None);
        let (_, holed) = texts.handle(1, piece(b"end", 8, 2)).expect("complete");
        assert!(holed.ends_with("a...end"));
    }

    #[test]
    fn texts_that_never_end_stay_bounded() {
        let mut texts = Texts::default();
        for id in 1..1000 {
            texts.handle(1, piece(&[b'x'; 50], id, 0));
            assert!(texts.partial.len() <= PARTIAL_MAX);
        }
        let mut endless = Texts::default();
        let ended = (0..=255).filter(|chunk| endless.handle(1, piece(&[b'x'; 50], 1, *chunk)).is_some()).count();
        assert!(ended >= 20, "cut every ten pieces");
    }
}
