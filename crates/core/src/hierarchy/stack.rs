//! A stack of fixed size without initialisation.

use core::mem::MaybeUninit;

/// StackStorage for `N` items. Kept apart from [`Stack`] so that the stack's length can live in a register on the GPU.
pub(crate) type StackStorage<T, const N: usize> = [MaybeUninit<T>; N];

/// A stack over borrowed storage. Its users bound their depth; debug builds check.
pub struct Stack<'a, T: Copy, const N: usize> {
    storage: &'a mut StackStorage<T, N>,
    len: u32,
}

impl<'a, T: Copy, const N: usize> Stack<'a, T, N> {
    /// Uninitialised storage.
    #[inline(always)]
    pub const fn storage() -> StackStorage<T, N> {
        [const { MaybeUninit::uninit() }; N]
    }

    /// An empty stack.
    #[inline(always)]
    pub fn new(storage: &'a mut StackStorage<T, N>) -> Self {
        Stack { storage, len: 0 }
    }

    /// Whether nothing is on it.
    #[inline(always)]
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// Puts an item on top.
    ///
    /// # Safety
    /// Fewer than `N` items are on the stack. Debug builds check.
    #[inline(always)]
    pub unsafe fn push(&mut self, item: T) {
        debug_assert!((self.len as usize) < N, "the builder bounds the depth to the stack");
        // SAFETY: fewer than `N` items are on the stack (the contract of this function).
        unsafe { self.storage.get_unchecked_mut(self.len as usize).write(item) };
        self.len += 1;
    }

    /// Takes the top item.
    #[inline(always)]
    pub fn pop(&mut self) -> Option<T> {
        if self.len == 0 {
            return None;
        }
        self.len -= 1;
        // SAFETY: items below `len` were written by `push`.
        Some(unsafe { self.storage.get_unchecked(self.len as usize).assume_init() })
    }

    /// Takes the top item.
    ///
    /// # Safety
    /// There is one. Debug builds check.
    #[inline(always)]
    pub unsafe fn pop_unchecked(&mut self) -> T {
        debug_assert!(self.len > 0);
        self.len -= 1;
        // SAFETY: items below `len` were written by `push`.
        unsafe { self.storage.get_unchecked(self.len as usize).assume_init() }
    }

    /// The top item, to be changed in place.
    #[inline(always)]
    pub fn top_mut(&mut self) -> Option<&mut T> {
        if self.len == 0 {
            return None;
        }
        // SAFETY: items below `len` were written by `push`.
        Some(unsafe { self.storage.get_unchecked_mut(self.len as usize - 1).assume_init_mut() })
    }
}
