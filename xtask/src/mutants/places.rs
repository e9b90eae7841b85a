//! The places of a source file where a fault can stand, each with the faults that can stand there.
//!
//! What is never run, or cannot be switched at run time, has none: tests, constants and what is `const`, patterns, types, attributes,
//! messages, and how a value is shown.

use std::ops::Range;

use proc_macro2::Span;
use syn::punctuated::Punctuated;
use syn::spanned::Spanned;
use syn::visit::{self, Visit};
use syn::{BinOp, Expr, ExprBinary, ExprIf, ExprMethodCall, Lit, Pat, Stmt, Token, UnOp};

/// One fault.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Fault {
    /// The bytes of the file that it replaces.
    pub(crate) range: Range<usize>,
    /// What it does to them.
    pub(crate) operator: &'static str,
    /// What stands there with it.
    pub(crate) faulty: String,
    pub(crate) form: Form,
}

/// How a fault is switched.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum Form {
    /// An expression in place of another.
    Value,
    /// The same, where it can be told whether the values differ: by this condition on [`VALUE`], the value without the fault.
    Told(String),
    /// A statement that is left out.
    LeftOut,
}

/// The name that the value without the fault has in [`Form::Told`].
pub(crate) const VALUE: &str = "value_without_the_fault";

/// Those of a file, in the order of its text.
pub(crate) fn faults(source: &str) -> syn::Result<Vec<Fault>> {
    let file = syn::parse_file(source)?;
    let mut places = Places { source, found: Vec::new() };
    places.visit_file(&file);
    places.found.sort_by_key(|fault| (fault.range.start, fault.range.end));
    Ok(places.found)
}

struct Places<'a> {
    source: &'a str,
    found: Vec<Fault>,
}

/// Methods that only read, so that asking twice changes nothing.
const READING: [&str; 13] =
    ["abs", "area", "cross", "dot", "exponent", "is_empty", "len", "length", "max", "min", "norm", "size", "value"];

/// Traits that only show a value.
const SHOWING: [&str; 3] = ["Debug", "Display", "Error"];

/// Constants of which a multiple is not another number.
const FIXED: [&str; 4] = ["ZERO", "NAN", "INFINITY", "NEG_INFINITY"];

impl Places<'_> {
    fn text(&self, span: Span) -> &str {
        &self.source[span.byte_range()]
    }

    fn push(&mut self, span: Span, operator: &'static str, faulty: String) {
        self.found.push(Fault { range: span.byte_range(), operator, faulty, form: Form::Value });
    }

    fn push_told(&mut self, span: Span, operator: &'static str, faulty: String, differs: String) {
        self.found.push(Fault { range: span.byte_range(), operator, faulty, form: Form::Told(differs) });
    }

    /// The text of `whole` with another in place of `part`.
    fn with(&self, whole: Span, part: Span, other: &str) -> String {
        let (whole, part) = (whole.byte_range(), part.byte_range());
        [&self.source[whole.start..part.start], other, &self.source[part.end..whole.end]].concat()
    }

    /// What an `if`, a `while` or a guard asks.
    fn condition(&mut self, asked: &Expr, can_be_always: bool) {
        match asked {
            Expr::Let(bound) => self.visit_expr(&bound.expr),
            Expr::Binary(ExprBinary { left, op: BinOp::And(_), right, .. }) if has_let(asked) => {
                self.condition(left, can_be_always);
                self.condition(right, can_be_always);
            }
            _ => {
                let span = asked.span();
                self.push(span, "negated", format!("!({})", self.text(span)));
                self.push_told(span, "never", "false".to_owned(), VALUE.to_owned());
                if can_be_always {
                    self.push_told(span, "always", "true".to_owned(), format!("!{VALUE}"));
                }
                self.visit_expr(asked);
            }
        }
    }

    fn binary(&mut self, whole: Span, ExprBinary { left, op, right, .. }: &ExprBinary) {
        let others: &[(&'static str, &str)] = match op {
            BinOp::Lt(_) => &[("< to <=", "<="), ("< to >", ">")],
            BinOp::Le(_) => &[("<= to <", "<"), ("<= to >=", ">=")],
            BinOp::Gt(_) => &[("> to >=", ">="), ("> to <", "<")],
            BinOp::Ge(_) => &[(">= to >", ">"), (">= to <=", "<=")],
            BinOp::Eq(_) => &[("== to !=", "!=")],
            BinOp::Ne(_) => &[("!= to ==", "==")],
            BinOp::And(_) => &[("&& to ||", "||")],
            BinOp::Or(_) => &[("|| to &&", "&&")],
            BinOp::Add(_) => &[("+ to -", "-")],
            BinOp::Sub(_) => &[("- to +", "+")],
            BinOp::Mul(_) => &[("* to /", "/")],
            BinOp::Div(_) => &[("/ to *", "*")],
            BinOp::Shl(_) => &[("<< to >>", ">>")],
            BinOp::Shr(_) => &[(">> to <<", "<<")],
            BinOp::BitAnd(_) => &[("& to |", "|")],
            BinOp::BitOr(_) => &[("| to &", "&")],
            BinOp::AddAssign(_) => &[("+= to -=", "-=")],
            BinOp::SubAssign(_) => &[("-= to +=", "+=")],
            BinOp::MulAssign(_) => &[("*= to /=", "/=")],
            BinOp::DivAssign(_) => &[("/= to *=", "*=")],
            _ => &[],
        };
        let is_told = matches!(
            op,
            BinOp::Lt(_)
                | BinOp::Le(_)
                | BinOp::Gt(_)
                | BinOp::Ge(_)
                | BinOp::Eq(_)
                | BinOp::Ne(_)
                | BinOp::And(_)
                | BinOp::Or(_)
        ) && reads(left)
            && reads(right);
        for (operator, other) in others {
            let faulty = self.with(whole, op.span(), other);
            if is_told {
                self.push_told(whole, operator, faulty.clone(), format!("{VALUE} != ({faulty})"));
            } else {
                self.push(whole, operator, faulty);
            }
        }
        if matches!(op, BinOp::Add(_) | BinOp::Sub(_) | BinOp::Mul(_) | BinOp::Div(_)) {
            let text = self.text(whole).to_owned();
            self.push(whole, "result negated", format!("-({text})"));
            self.push(whole, "result halved", format!("({text}) * 0.5"));
        }
    }

    fn method_call(&mut self, whole: Span, call: &ExprMethodCall) {
        let swapped = |operator, other| Some((operator, self.with(whole, call.method.span(), other)));
        let fault = match call.method.to_string().as_str() {
            "min" => swapped("min to max", "max"),
            "max" => swapped("max to min", "min"),
            "floor" => swapped("floor to ceil", "ceil"),
            "ceil" => swapped("ceil to floor", "floor"),
            "any" => swapped("any to all", "all"),
            "all" => swapped("all to any", "any"),
            "abs" if call.args.is_empty() => Some(("abs dropped", self.text(call.receiver.span()).to_owned())),
            "mul_add" if call.args.len() == 2 => {
                let added = call.args[1].span();
                Some(("+ to -", self.with(whole, added, &format!("-({})", self.text(added)))))
            }
            _ => None,
        };
        if let Some((operator, faulty)) = fault {
            self.push(whole, operator, faulty);
        }
    }

    fn literal(&mut self, span: Span, literal: &Lit) {
        let text = self.text(span).to_owned();
        match literal {
            Lit::Float(number) if number.base10_parse::<f64>().is_ok_and(|value| value == 0.0) => {
                self.push(span, "0 to 1", format!("({text} + 1.0)"));
                self.push(span, "0 to 1e-9", format!("({text} + 1e-9)"));
            }
            Lit::Float(_) => {
                self.push(span, "doubled", format!("(2.0 * {text})"));
                self.push(span, "halved", format!("(0.5 * {text})"));
            }
            Lit::Int(number) => {
                self.push(span, "one more", format!("({text} + 1)"));
                if number.base10_digits() != "0" {
                    self.push(span, "one less", format!("({text} - 1)"));
                }
            }
            _ => {}
        }
    }

    /// A constant where it is used, or an extreme that is handed on.
    fn path(&mut self, span: Span, path: &syn::Path) {
        let Some(name) = path.segments.last().map(|segment| segment.ident.to_string()) else { return };
        let text = self.text(span).to_owned();
        match name.as_str() {
            "min" | "max" | "larger" | "smaller" => {
                let (operator, other) = match name.as_str() {
                    "min" => ("min to max", "max"),
                    "max" => ("max to min", "min"),
                    "larger" => ("larger to smaller", "smaller"),
                    _ => ("smaller to larger", "larger"),
                };
                let last = path.segments.last().map_or(span, |segment| segment.ident.span());
                self.push(span, operator, self.with(span, last, other));
            }
            _ if !FIXED.contains(&name.as_str()) && is_constant(&name) => {
                self.push(span, "doubled", format!("(2.0 * {text})"));
                self.push(span, "halved", format!("(0.5 * {text})"));
                self.push(span, "one more", format!("({text} + 1)"));
                self.push(span, "one less", format!("({text} - 1)"));
            }
            _ => {}
        }
    }
}

fn is_constant(name: &str) -> bool {
    name.starts_with(|first: char| first.is_ascii_uppercase()) && !name.contains(|c: char| c.is_ascii_lowercase())
}

/// Whether there is a `let` among the conditions.
fn has_let(asked: &Expr) -> bool {
    match asked {
        Expr::Let(_) => true,
        Expr::Binary(ExprBinary { left, op: BinOp::And(_), right, .. }) => has_let(left) || has_let(right),
        _ => false,
    }
}

/// Whether it can be asked twice.
fn reads(asked: &Expr) -> bool {
    match asked {
        Expr::Lit(_) | Expr::Path(_) => true,
        Expr::Field(field) => reads(&field.base),
        Expr::Paren(inner) => reads(&inner.expr),
        Expr::Reference(inner) => inner.mutability.is_none() && reads(&inner.expr),
        Expr::Unary(inner) => reads(&inner.expr),
        Expr::Cast(inner) => reads(&inner.expr),
        Expr::Binary(both) => !is_assigning(&both.op) && reads(&both.left) && reads(&both.right),
        Expr::Index(index) => reads(&index.expr) && reads(&index.index),
        Expr::MethodCall(call) => {
            READING.contains(&call.method.to_string().as_str()) && reads(&call.receiver) && call.args.iter().all(reads)
        }
        _ => false,
    }
}

fn is_assigning(op: &BinOp) -> bool {
    matches!(op, BinOp::AddAssign(_) | BinOp::SubAssign(_) | BinOp::MulAssign(_) | BinOp::DivAssign(_))
}

fn is_conditional(attributes: &[syn::Attribute]) -> bool {
    attributes.iter().any(|attribute| attribute.path().is_ident("cfg") || attribute.path().is_ident("test"))
}

impl<'ast> Visit<'ast> for Places<'_> {
    fn visit_item_mod(&mut self, module: &'ast syn::ItemMod) {
        if !is_conditional(&module.attrs) {
            visit::visit_item_mod(self, module);
        }
    }

    fn visit_item_fn(&mut self, function: &'ast syn::ItemFn) {
        if !is_conditional(&function.attrs) && function.sig.constness.is_none() {
            visit::visit_item_fn(self, function);
        }
    }

    fn visit_impl_item_fn(&mut self, function: &'ast syn::ImplItemFn) {
        if !is_conditional(&function.attrs) && function.sig.constness.is_none() {
            visit::visit_impl_item_fn(self, function);
        }
    }

    fn visit_item_impl(&mut self, block: &'ast syn::ItemImpl) {
        let of_trait = block.trait_.as_ref().and_then(|(path, _)| path.segments.last());
        let shows = of_trait.is_some_and(|last| SHOWING.contains(&last.ident.to_string().as_str()));
        if !shows && !is_conditional(&block.attrs) {
            visit::visit_item_impl(self, block);
        }
    }

    fn visit_item_const(&mut self, _: &'ast syn::ItemConst) {}
    fn visit_item_static(&mut self, _: &'ast syn::ItemStatic) {}
    fn visit_impl_item_const(&mut self, _: &'ast syn::ImplItemConst) {}
    fn visit_trait_item_const(&mut self, _: &'ast syn::TraitItemConst) {}
    fn visit_item_enum(&mut self, _: &'ast syn::ItemEnum) {}
    fn visit_item_macro(&mut self, _: &'ast syn::ItemMacro) {}
    fn visit_expr_const(&mut self, _: &'ast syn::ExprConst) {}
    fn visit_attribute(&mut self, _: &'ast syn::Attribute) {}
    fn visit_type(&mut self, _: &'ast syn::Type) {}
    fn visit_generic_argument(&mut self, _: &'ast syn::GenericArgument) {}

    /// Nothing of a pattern but what its guard asks.
    fn visit_pat(&mut self, pattern: &'ast Pat) {
        if let Pat::Guard(guarded) = pattern {
            self.condition(&guarded.guard, true);
        }
    }

    fn visit_expr_repeat(&mut self, array: &'ast syn::ExprRepeat) {
        self.visit_expr(&array.expr);
    }

    fn visit_macro(&mut self, called: &'ast syn::Macro) {
        if called.path.is_ident("vec")
            && let Ok(values) = called.parse_body_with(Punctuated::<Expr, Token![,]>::parse_terminated)
        {
            // What is parsed here is gone afterwards; places are bytes of the source.
            let mut inner = Places { source: self.source, found: Vec::new() };
            values.iter().for_each(|value| inner.visit_expr(value));
            self.found.append(&mut inner.found);
        }
    }

    fn visit_stmt(&mut self, statement: &'ast Stmt) {
        if let Stmt::Expr(Expr::Return(_) | Expr::Continue(_) | Expr::Break(_), Some(_)) = statement
            && let Stmt::Expr(left, _) = statement
        {
            let range = left.span().byte_range();
            self.found.push(Fault { range, operator: "left out", faulty: String::new(), form: Form::LeftOut });
        }
        visit::visit_stmt(self, statement);
    }

    fn visit_expr(&mut self, asked: &'ast Expr) {
        let span = asked.span();
        match asked {
            Expr::If(ExprIf { cond, then_branch, else_branch, .. }) => {
                self.condition(cond, true);
                self.visit_block(then_branch);
                if let Some((_, other)) = else_branch {
                    self.visit_expr(other);
                }
                return;
            }
            Expr::While(repeated) => {
                self.condition(&repeated.cond, false);
                self.visit_block(&repeated.body);
                return;
            }
            Expr::Index(index) => {
                let place = index.index.span();
                if !matches!(&*index.index, Expr::Range(_)) {
                    let faulty = format!("(({}) + 1) % ({}).len()", self.text(place), self.text(index.expr.span()));
                    self.push(place, "next index", faulty);
                }
                // The number of a place, and the name of a table, are no quantities.
                if !matches!(&*index.index, Expr::Lit(_)) {
                    self.visit_expr(&index.index);
                }
                if !matches!(&*index.expr, Expr::Path(_)) {
                    self.visit_expr(&index.expr);
                }
                return;
            }
            Expr::Binary(both) => self.binary(span, both),
            Expr::Unary(inner) if matches!(inner.op, UnOp::Neg(_)) => {
                self.push(span, "- dropped", self.text(inner.expr.span()).to_owned());
            }
            Expr::Unary(inner) if matches!(inner.op, UnOp::Not(_)) => {
                self.push(span, "! dropped", self.text(inner.expr.span()).to_owned());
            }
            Expr::MethodCall(call) => self.method_call(span, call),
            Expr::Lit(literal) => self.literal(span, &literal.lit),
            Expr::Path(path) if path.qself.is_none() => self.path(span, &path.path),
            _ => {}
        }
        visit::visit_expr(self, asked);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The text of each place, what is done to it and what stands there then.
    fn listed(source: &str) -> Vec<(String, &'static str, String)> {
        faults(source).unwrap().into_iter().map(|fault| (source[fault.range].to_owned(), fault.operator, fault.faulty)).collect()
    }

    fn has(source: &str, place: &str, operator: &str, faulty: &str) {
        let places = listed(source);
        assert!(places.iter().any(|(p, o, f)| p == place && *o == operator && f == faulty), "{place} {operator}: {places:#?}");
    }

    #[test]
    fn every_kind_of_place_is_found() {
        has("fn f(x: f64) -> f64 { 1.5 * x }", "1.5", "doubled", "(2.0 * 1.5)");
        has("fn f(x: f64) -> f64 { 0.0 }", "0.0", "0 to 1", "(0.0 + 1.0)");
        has("fn f(n: usize) -> usize { n + 3 }", "3", "one less", "(3 - 1)");
        has("fn f(a: f64, b: f64) -> bool { a < b }", "a < b", "< to <=", "a <= b");
        has("fn f(a: f64, b: f64) -> f64 { a + b }", "a + b", "+ to -", "a - b");
        has("fn f(a: f64, b: f64) -> f64 { a / b }", "a / b", "result halved", "(a / b) * 0.5");
        has("fn f(mut a: f64) { a += 1.0; }", "a += 1.0", "+= to -=", "a -= 1.0");
        has("fn f(a: bool) -> i32 { if a { 1 } else { 2 } }", "a", "never", "false");
        has("fn f(a: bool, b: Option<i32>) { if a && let Some(_) = b {} }", "a", "negated", "!(a)");
        has("fn f(a: i32) { match a { x if x > 2 => {} _ => {} } }", "x > 2", "always", "true");
        has("fn f(a: bool, b: bool) -> bool { a && b }", "a && b", "&& to ||", "a || b");
        has("fn f(a: f64) -> f64 { a.min(g(a)) }", "a.min(g(a))", "min to max", "a.max(g(a))");
        has("fn f(a: &[f64]) -> f64 { a.iter().fold(A, f64::max) }", "f64::max", "max to min", "f64::min");
        has("fn f(a: f64) -> f64 { (a + b).abs() }", "(a + b).abs()", "abs dropped", "(a + b)");
        has("fn f(a: f64) -> f64 { -a }", "-a", "- dropped", "a");
        has("fn f(a: &[f64], i: usize) -> f64 { a[i] }", "i", "next index", "((i) + 1) % (a).len()");
        has("fn f(a: f64) -> f64 { ROUNDOFF * a }", "ROUNDOFF", "halved", "(0.5 * ROUNDOFF)");
        has("fn f(a: bool) { loop { if a { continue; } } }", "continue", "left out", "");
        has("fn f() { g(vec![2.5]) }", "2.5", "halved", "(0.5 * 2.5)");
    }

    #[test]
    fn what_is_not_run_has_none() {
        for source in [
            "const A: f64 = 2.0; static B: [f64; 2] = [1.0, 2.0];",
            "#[cfg(test)] mod tests { fn f() -> f64 { 2.0 } }",
            "#[test] fn f() { g(2.0); }",
            "impl std::fmt::Display for A { fn fmt(&self) { g(2.0) } }",
            "const fn f() -> f64 { 2.0 }",
            "fn f() { panic!(\"{}\", 2.0) }",
            "fn f(a: [f64; 3]) { match g { 3 | 4..=5 => {} _ => {} } }",
            "enum A { B = 3 }",
        ] {
            assert_eq!(listed(source), [], "{source}");
        }
    }

    #[test]
    fn no_fault_is_the_text_that_it_replaces() {
        let source = include_str!("places.rs");
        let places = listed(source);
        assert!(places.len() > 100);
        for (place, operator, faulty) in places {
            let is_expression = operator == "left out" || syn::parse_str::<Expr>(&faulty).is_ok();
            assert!(place != faulty && is_expression, "{place}, {operator}: {faulty}");
        }
    }

    #[test]
    fn only_what_can_be_asked_twice_is_told() {
        let told = |source| {
            let places = faults(source).unwrap();
            matches!(places.iter().find(|fault| fault.operator == "< to <=").unwrap().form, Form::Told(_))
        };
        assert!(told("fn f(a: f64) -> bool { a.abs() < 2.0 * b[3] }"));
        assert!(!told("fn f(a: f64) -> bool { i.next() < a }"));
    }
}
