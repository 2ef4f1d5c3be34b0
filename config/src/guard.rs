//! Refuses deep nesting before a tree is built: a tree's own destructor would overflow the stack.
//!
//! The TOML parser bounds nested brackets, but not dotted keys: `a.a.a. ...` in one megabyte is half a million tables.

use toml_parser::decoder::Encoding;
use toml_parser::parser::{EventReceiver, RecursionGuard};
use toml_parser::{ErrorSink, ParseError, Source, Span};

/// Deepest tree that is read. The deepest real key has six steps.
const DEPTH_MAX: usize = 24;

/// Most signs that begin, part or end values: a resolved swarm of 100,000 robots has 2.6 million. Each may become a
/// node of the tree, which takes some 300 bytes.
const SIGNS_MAX: usize = 4_000_000;

/// Whether `text` is too much to be made into a tree: what is allowed.
pub(crate) fn too_much(text: &str) -> Option<String> {
    let is_sign = |byte: &&u8| matches!(byte, b'\n' | b'=' | b',' | b'[' | b'{');
    let signs = text.as_bytes().iter().filter(is_sign).count();
    (signs > SIGNS_MAX).then(|| format!("at most {SIGNS_MAX} line ends, commas, '=', '[' and '{{'"))
}

/// Where `text` is nested too deep, if it is: the offset of the first step too many.
pub(crate) fn too_deep_document(text: &str) -> Option<usize> {
    measure(text, toml_parser::parser::parse_document)
}

/// The same for a single value, as an override has it.
pub(crate) fn too_deep_value(text: &str) -> Option<usize> {
    measure(text, toml_parser::parser::parse_value)
}

/// Offset of the step too many, for the words of a problem.
pub(crate) fn depth_allowed() -> String {
    format!("at most {DEPTH_MAX} levels of tables and arrays")
}

type Parse = fn(&[toml_parser::lexer::Token], &mut dyn EventReceiver, &mut dyn ErrorSink);

fn measure(text: &str, parse: Parse) -> Option<usize> {
    let tokens = Source::new(text).lex().into_vec();
    let mut depth = Depth::default();
    let mut bounded = RecursionGuard::new(&mut depth, DEPTH_MAX as u32);
    parse(&tokens, &mut bounded, &mut Ignore);
    depth.too_deep_at
}

/// Syntax errors are said later, by the parser that builds the tree.
struct Ignore;

impl ErrorSink for Ignore {
    fn report_error(&mut self, _error: ParseError) {}
}

/// Counts dots of one key and brackets that are open. An upper bound of the true depth: keys of enclosing inline
/// tables are counted for as long as the brackets are open.
#[derive(Default)]
struct Depth {
    header: usize,
    in_header: bool,
    key: usize,
    open: Vec<usize>,
    too_deep_at: Option<usize>,
}

impl Depth {
    fn check(&mut self, at: Span) {
        let depth = self.header + self.key + self.open.iter().sum::<usize>() + self.open.len();
        if depth > DEPTH_MAX && self.too_deep_at.is_none() {
            self.too_deep_at = Some(at.start());
        }
    }

    fn open(&mut self, at: Span) -> bool {
        self.open.push(std::mem::take(&mut self.key));
        self.check(at);
        self.open.len() <= DEPTH_MAX
    }

    fn close(&mut self) {
        self.key = self.open.pop().unwrap_or_default();
    }

    fn start_header(&mut self) {
        self.open.clear();
        self.key = 0;
        self.header = 0;
        self.in_header = true;
    }
}

impl EventReceiver for Depth {
    fn std_table_open(&mut self, _span: Span, _error: &mut dyn ErrorSink) {
        self.start_header();
    }

    fn std_table_close(&mut self, _span: Span, _error: &mut dyn ErrorSink) {
        self.in_header = false;
    }

    fn array_table_open(&mut self, _span: Span, _error: &mut dyn ErrorSink) {
        self.start_header();
    }

    fn array_table_close(&mut self, _span: Span, _error: &mut dyn ErrorSink) {
        self.in_header = false;
    }

    fn inline_table_open(&mut self, span: Span, _error: &mut dyn ErrorSink) -> bool {
        self.open(span)
    }

    fn inline_table_close(&mut self, _span: Span, _error: &mut dyn ErrorSink) {
        self.close();
    }

    fn array_open(&mut self, span: Span, _error: &mut dyn ErrorSink) -> bool {
        self.open(span)
    }

    fn array_close(&mut self, _span: Span, _error: &mut dyn ErrorSink) {
        self.close();
    }

    fn simple_key(&mut self, span: Span, _kind: Option<Encoding>, _error: &mut dyn ErrorSink) {
        if self.in_header {
            self.header += 1;
        } else {
            self.key += 1;
        }
        self.check(span);
    }

    fn value_sep(&mut self, _span: Span, _error: &mut dyn ErrorSink) {
        self.key = 0;
    }

    fn newline(&mut self, _span: Span, _error: &mut dyn ErrorSink) {
        self.in_header = false;
        self.key = 0;
    }
}

#[cfg(test)]
mod tests {
    use super::{too_deep_document, too_deep_value};

    #[test]
    fn ordinary_nesting_passes() {
        assert_eq!(too_deep_document("[kinds.a.motion]\nx = { y = [1, { z.w = 2 }] }\n"), None);
        assert_eq!(too_deep_value("[1, 2, { a = 3 }]"), None);
    }

    #[test]
    fn half_a_million_dots_are_refused_and_not_built() {
        let dotted = format!("{}a = 1", "a.".repeat(500_000));
        assert_eq!(too_deep_document(&dotted), Some(48));
        let header = format!("[{}a]", "a.".repeat(500_000));
        assert_eq!(too_deep_document(&header), Some(49));
    }

    #[test]
    fn brackets_keys_and_headers_add_up() {
        let nested = format!("[a.b.c.d.e.f.g.h]\nx = {}", "{ i.j.k = ".repeat(8));
        assert!(too_deep_document(&nested).is_some());
        assert!(too_deep_value(&"[".repeat(100_000)).is_some());
        assert!(too_deep_value(&"{a.b.c=".repeat(100_000)).is_some());
    }
}
