//! Puts every mutant of a file behind a switch: `a + b` becomes `if on(7) { a - b } else { a + b }`. One mutant is on at a time, so
//! what is switched holds the original parts.

use crate::list::{Numbered, Place};
use proc_macro2::{LineColumn, Span};
use quote::quote;
use std::collections::HashMap;
use syn::spanned::Spanned;
use syn::visit_mut::{self, VisitMut};
use syn::{Arm, BinOp, Block, Expr, ExprMatch, Signature, parse_quote};

/// Rewrites a file. Mutants that it has used are taken out of the map; what is left stands in constant expressions, which no
/// switch can stand in.
pub struct Switch<'a, 'l> {
    pub places: &'a mut HashMap<(String, Place), Vec<Numbered<'l>>>,
}

fn place(span: Span) -> Place {
    let LineColumn { line, column } = span.start();
    Place { line, column: column + 1 }
}

/// Whether it is a `let` of a condition, or a chain with one: these cannot be parts of another expression.
fn has_let(expr: &Expr) -> bool {
    match expr {
        Expr::Let(_) => true,
        Expr::Binary(binary) => {
            matches!(binary.op, BinOp::And(_)) && (has_let(&binary.left) || has_let(&binary.right))
        }
        _ => false,
    }
}

impl<'l> Switch<'_, 'l> {
    fn take(&mut self, genre: &str, span: Span) -> Vec<Numbered<'l>> {
        self.places.remove(&(genre.to_owned(), place(span))).unwrap_or_default()
    }

    fn body(&mut self, signature: &Signature, block: &mut Block) {
        if signature.constness.is_some() {
            return;
        }
        let first = block.stmts.first().map(Spanned::span);
        visit_mut::visit_block_mut(self, block);
        for (number, mutant) in first.map_or(Vec::new(), |span| self.take("FnValue", span)).into_iter().rev()
        {
            let value: Expr = syn::parse_str(&mutant.replacement).expect("a value");
            block.stmts.insert(0, parse_quote! { if crate::mutant::on(#number) { return #value; } });
        }
    }
}

/// The expression, and before it each change behind its switch.
fn switched(changes: Vec<(u32, Expr)>, last: Expr) -> Expr {
    changes.into_iter().rev().fold(last, |rest, (number, changed)| {
        // Built of nodes: an operator behind a block would end a statement.
        let condition: Expr = parse_quote! { crate::mutant::on(#number) };
        let (one, other) = (
            block(changed),
            Box::new(Expr::Block(syn::ExprBlock { attrs: vec![], label: None, block: block(rest) })),
        );
        let choice = Expr::If(syn::ExprIf {
            attrs: vec![],
            if_token: Default::default(),
            cond: Box::new(condition),
            then_branch: one,
            else_branch: Some((Default::default(), other)),
        });
        Expr::Paren(syn::ExprParen { attrs: vec![], paren_token: Default::default(), expr: Box::new(choice) })
    })
}

fn block(expr: Expr) -> Block {
    Block { brace_token: Default::default(), stmts: vec![syn::Stmt::Expr(expr, None)] }
}

fn parens(expr: &Expr) -> Expr {
    Expr::Paren(syn::ExprParen {
        attrs: vec![],
        paren_token: Default::default(),
        expr: Box::new(expr.clone()),
    })
}

impl VisitMut for Switch<'_, '_> {
    fn visit_expr_mut(&mut self, expr: &mut Expr) {
        let original = expr.clone();
        visit_mut::visit_expr_mut(self, expr);
        let changes: Vec<(u32, Expr)> = match &original {
            Expr::Binary(binary) if !has_let(&original) => {
                let (left, right) = (&binary.left, &binary.right);
                let changed = |text: &str| -> Expr {
                    let op: BinOp = syn::parse_str(text).expect("an operator");
                    let mut changed = binary.clone();
                    changed.op = op;
                    // What is assigned to stands bare.
                    if !(text.ends_with('=') && !["==", "!=", "<=", ">="].contains(&text)) {
                        changed.left = Box::new(parens(left));
                    }
                    changed.right = Box::new(parens(right));
                    Expr::Binary(changed)
                };
                let taken = self.take("BinaryOperator", binary.op.span());
                taken.iter().map(|(number, mutant)| (*number, changed(mutant.replacement.trim()))).collect()
            }
            Expr::Unary(unary) => {
                let inner = &unary.expr;
                let taken = self.take("UnaryOperator", unary.op.span());
                taken.iter().map(|(number, _)| (*number, parens(inner))).collect()
            }
            Expr::Struct(whole) if whole.rest.is_some() => {
                let without = |at: usize| {
                    let mut fewer = whole.clone();
                    fewer.fields = whole
                        .fields
                        .iter()
                        .enumerate()
                        .filter(|(k, _)| *k != at)
                        .map(|(_, f)| f.clone())
                        .collect();
                    Expr::Struct(fewer)
                };
                let mut changes = Vec::new();
                for (at, field) in whole.fields.iter().enumerate() {
                    let taken = self.take("StructField", field.span());
                    changes.extend(taken.iter().map(|(number, _)| (*number, without(at))));
                }
                changes
            }
            _ => return,
        };
        if !changes.is_empty() {
            *expr = switched(changes, expr.clone());
        }
    }

    fn visit_expr_match_mut(&mut self, node: &mut ExprMatch) {
        let spans: Vec<(Span, Option<Span>)> = node
            .arms
            .iter()
            .map(|arm| (arm.span(), arm.guard.as_ref().map(|(_, guard)| guard.span())))
            .collect();
        visit_mut::visit_expr_match_mut(self, node);
        // Arms with a guard are not enough for the compiler.
        let has_rest =
            node.arms.iter().any(|arm| matches!(arm.pat, syn::Pat::Wild(_)) && arm.guard.is_none());
        for (arm, (whole, guard)) in node.arms.iter_mut().zip(spans) {
            let mut conditions: Vec<Expr> = Vec::new();
            let deleted = if has_rest { self.take("MatchArm", whole) } else { Vec::new() };
            conditions.extend(deleted.iter().map(|(number, _)| parse_quote! { !crate::mutant::on(#number) }));
            if let Some(span) = guard {
                let changes = self.take("MatchArmGuard", span);
                let changes: Vec<(u32, Expr)> = changes
                    .iter()
                    .map(|(number, mutant)| (*number, syn::parse_str(&mutant.replacement).expect("a value")))
                    .collect();
                if let Some((_, guard)) = &mut arm.guard
                    && !changes.is_empty()
                {
                    **guard = switched(changes, (**guard).clone());
                }
            }
            if let Some(condition) = conditions.pop() {
                set_guard(arm, condition);
            }
        }
    }

    fn visit_item_fn_mut(&mut self, node: &mut syn::ItemFn) {
        self.body(&node.sig, &mut node.block);
    }

    fn visit_impl_item_fn_mut(&mut self, node: &mut syn::ImplItemFn) {
        self.body(&node.sig, &mut node.block);
    }

    fn visit_trait_item_fn_mut(&mut self, node: &mut syn::TraitItemFn) {
        if let Some(block) = &mut node.default {
            self.body(&node.sig, block);
        }
    }

    // Constant expressions, and what is no expression.
    fn visit_item_const_mut(&mut self, _: &mut syn::ItemConst) {}
    fn visit_impl_item_const_mut(&mut self, _: &mut syn::ImplItemConst) {}
    fn visit_trait_item_const_mut(&mut self, _: &mut syn::TraitItemConst) {}
    fn visit_item_static_mut(&mut self, _: &mut syn::ItemStatic) {}
    fn visit_item_enum_mut(&mut self, _: &mut syn::ItemEnum) {}
    fn visit_expr_const_mut(&mut self, _: &mut syn::ExprConst) {}
    fn visit_type_mut(&mut self, _: &mut syn::Type) {}
    fn visit_path_arguments_mut(&mut self, _: &mut syn::PathArguments) {}
    fn visit_angle_bracketed_generic_arguments_mut(&mut self, _: &mut syn::AngleBracketedGenericArguments) {}
    fn visit_generics_mut(&mut self, _: &mut syn::Generics) {}
    fn visit_pat_mut(&mut self, _: &mut syn::Pat) {}
    fn visit_expr_repeat_mut(&mut self, node: &mut syn::ExprRepeat) {
        self.visit_expr_mut(&mut node.expr);
    }
}

fn set_guard(arm: &mut Arm, condition: Expr) {
    let token: syn::Token![if] = parse_quote! { if };
    arm.guard = Some((token, Box::new(condition)));
}

/// The switch itself, which stands at the end of the crate. It is set before `main` by the environment.
pub fn module() -> String {
    let tokens = quote! {
        extern crate std as mutant_std;
        /// Switches.
        #[allow(unsafe_code, missing_docs)]
        pub mod mutant {
            use super::mutant_std as std;
            use core::sync::atomic::{AtomicU32, Ordering};
            static ON: AtomicU32 = AtomicU32::new(0);
            #[used]
            #[unsafe(link_section = ".init_array")]
            static BEFORE_MAIN: extern "C" fn() = before_main;
            extern "C" fn before_main() {
                let number = std::env::var("TRISAP_MUTANT").ok().and_then(|text| text.parse().ok());
                ON.store(number.unwrap_or(0), Ordering::Relaxed);
            }
            #[inline(always)]
            pub fn on(number: u32) -> bool {
                ON.load(Ordering::Relaxed) == number
            }
        }
    };
    prettyplease::unparse(&syn::parse2(tokens).expect("a module"))
}
