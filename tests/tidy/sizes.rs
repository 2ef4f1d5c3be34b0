//! Files one can read in one go, functions one can see at once.

use crate::sources::{Source, all_sources, production_sources};
use syn::spanned::Spanned;
use syn::visit::{self, Visit};

const FILE_LINES_MAX: usize = 800;
const FUNCTION_LINES_MAX: usize = 70;
const PARAMETERS_MAX: usize = 5;
const COLUMNS_MAX: usize = 120;

#[test]
fn no_file_is_longer_than_its_readers_patience() {
    let long: Vec<String> = production_sources()
        .iter()
        .map(|source| (source.name.clone(), source.production_text().lines().count()))
        .filter(|(_, lines)| *lines > FILE_LINES_MAX)
        .map(|(name, lines)| format!("{name}: {lines} lines"))
        .collect();
    assert!(long.is_empty(), "longer than {FILE_LINES_MAX} lines: {long:#?}");
}

#[test]
fn no_line_is_wider_than_a_page() {
    let wide: Vec<String> = all_sources().iter().flat_map(wide_lines).collect();
    assert!(wide.is_empty(), "wider than {COLUMNS_MAX} columns: {wide:#?}");
}

fn wide_lines(source: &Source) -> Vec<String> {
    let numbered = source.text.lines().enumerate();
    let wide = numbered.filter(|(_, line)| line.chars().count() > COLUMNS_MAX);
    wide.map(|(index, _)| format!("{}:{}", source.name, index + 1)).collect()
}

#[test]
fn no_function_is_longer_or_takes_more_than_agreed() {
    let wrong: Vec<String> = all_sources().iter().flat_map(wrong_functions).collect();
    assert!(wrong.is_empty(), "{wrong:#?}");
}

fn wrong_functions(source: &Source) -> Vec<String> {
    let file = syn::parse_file(&source.text).unwrap_or_else(|error| panic!("{}: {error}", source.name));
    let mut functions = Functions { source, wrong: Vec::new() };
    functions.visit_file(&file);
    functions.wrong
}

/// What a caller has to give, the receiver aside.
fn parameters(signature: &syn::Signature) -> usize {
    signature.inputs.iter().filter(|input| matches!(input, syn::FnArg::Typed(_))).count()
}

struct Functions<'a> {
    source: &'a Source,
    wrong: Vec<String>,
}

impl Functions<'_> {
    fn look_at(&mut self, signature: &syn::Signature, body: &syn::Block) {
        let lines = body.span().end().line - signature.span().start().line + 1;
        let place = format!("{}:{} {}", self.source.name, signature.span().start().line, signature.ident);
        if lines > FUNCTION_LINES_MAX {
            self.wrong.push(format!("{place}: {lines} lines, at most {FUNCTION_LINES_MAX}"));
        }
        if parameters(signature) > PARAMETERS_MAX {
            self.wrong.push(format!("{place}: {} parameters, at most {PARAMETERS_MAX}", parameters(signature)));
        }
    }
}

impl<'ast> Visit<'ast> for Functions<'_> {
    fn visit_item_fn(&mut self, function: &'ast syn::ItemFn) {
        self.look_at(&function.sig, &function.block);
        visit::visit_item_fn(self, function);
    }

    fn visit_impl_item_fn(&mut self, function: &'ast syn::ImplItemFn) {
        self.look_at(&function.sig, &function.block);
        visit::visit_impl_item_fn(self, function);
    }
}
