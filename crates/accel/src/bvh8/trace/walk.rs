//! What the traversals share: queries, what was found, and the stack.

use eosphor_core::ray::Hit;

/// The three queries, as constants so that each traversal is compiled for each.
pub(super) type Query = u8;
/// The nearest hit.
pub(super) const CLOSEST: Query = 0;
/// Whether there is any.
pub(super) const ANY: Query = 1;
/// The nearest hit after another one.
pub(super) const NEXT: Query = 2;

/// The bits of a query that say which it is.
pub(super) const KIND: Query = 3;
/// Set in single rays' queries that count nodes and primitives.
pub(super) const COUNTING: Query = 4;

/// Places on a stack: at each level of the tree up to seven children wait, and a level has half the nodes of the one
/// below or a depth below that of the tree with two children a node, so 64 levels at most; and 8 more, since whole
/// vectors are written.
pub(super) const STACK: usize = 64 * 7 + 16;

/// In place of the place of a triangle.
pub(super) const NOT_PENDING: u32 = u32::MAX;

/// What a single ray has found.
#[derive(Clone, Copy, Debug)]
pub(super) struct Found {
    /// The best hit, or a miss at the largest `t` that counts. While it is pending, only its triangle is known.
    pub(super) best: Hit,
    /// No earlier than the best hit: what starts beyond it is left out.
    pub(super) end: f32,
    /// A hit before this is nearer than the best one.
    pub(super) before: f32,
    /// Where the best hit is certain but not computed: the place of its triangle, four times its block's number and its
    /// lane. Else [`NOT_PENDING`].
    pub(super) pending: u32,
    /// For [`NEXT`]: only hits after this one count.
    pub(super) after: Hit,
    /// For [`ANY`]: there is one.
    pub(super) any: bool,
    /// For [`COUNTING`]: boxes and primitives tested.
    pub(super) nodes: u32,
    pub(super) primitives: u32,
}

impl Found {
    #[inline(always)]
    pub(super) fn nothing(t_max: f32) -> Found {
        Found {
            best: Hit::miss(t_max),
            end: t_max,
            before: t_max,
            pending: NOT_PENDING,
            after: Hit::miss(t_max),
            any: false,
            nodes: 0,
            primitives: 0,
        }
    }

    /// Offers a hit that counts; `true` ends the search.
    #[inline(always)]
    pub(super) fn offer<const QUERY: Query>(&mut self, hit: Hit) -> bool {
        match QUERY & KIND {
            ANY => {
                self.any |= hit.t <= self.best.t;
                self.any
            }
            NEXT => {
                if self.after.before(&hit) & hit.before(&self.best) {
                    self.set(hit);
                }
                false
            }
            _ => {
                if hit.before(&self.best) {
                    self.set(hit);
                }
                false
            }
        }
    }

    /// The best hit is known.
    #[inline(always)]
    pub(super) fn set(&mut self, hit: Hit) {
        (self.best, self.end, self.before, self.pending) = (hit, hit.t, hit.t, NOT_PENDING);
    }
}
