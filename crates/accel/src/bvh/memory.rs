//! Large arrays in large pages.

/// An empty vector with room for `count` items, for arrays that are filled once. On Linux its whole 2 MiB pages are
/// asked for as such: of the time of building over a million triangles, a third was the kernel's, giving out pages of
/// 4 KiB.
pub(crate) fn room_for<T>(count: usize) -> Vec<T> {
    let items: Vec<T> = Vec::with_capacity(count);
    #[cfg(target_os = "linux")]
    {
        const PAGE: usize = 1 << 21;
        let start = (items.as_ptr() as usize).next_multiple_of(PAGE);
        let end = (items.as_ptr() as usize + items.capacity() * size_of::<T>()) / PAGE * PAGE;
        if start < end {
            // SAFETY: the range lies in this allocation; the advice changes how memory is backed, not what it holds. It
            // may be refused, and then pages are small.
            unsafe { libc::madvise(start as *mut libc::c_void, end - start, libc::MADV_HUGEPAGE) };
        }
    }
    items
}

/// So many equal items.
pub(crate) fn filled<T: Clone>(item: T, count: usize) -> Vec<T> {
    let mut items = room_for(count);
    items.resize(count, item);
    items
}
