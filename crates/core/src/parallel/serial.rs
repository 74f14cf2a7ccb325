//! The part of rayon's interface that this crate uses, on one thread.

use std::iter::{Copied, Enumerate, Map, Sum, Zip};
use std::slice::{Chunks, ChunksExactMut, ChunksMut, Iter, IterMut};

/// What rayon's prelude brings into scope.
pub(crate) mod prelude {
    pub(crate) use super::{
        IndexedParallelIterator, IntoParallelIterator, ParallelIterator, ParallelRefIterator,
        ParallelSlice,
    };
}

/// Threads that share work: this one.
pub(crate) fn current_num_threads() -> usize {
    1
}

/// Which of the threads this is; `None`, since it belongs to no pool.
pub(crate) fn current_thread_index() -> Option<usize> {
    None
}

/// Calls `a`, then `b`.
pub(crate) fn join<A, B>(a: impl FnOnce() -> A, b: impl FnOnce() -> B) -> (A, B) {
    let a = a();
    (a, b())
}

/// Calls `work` with a scope to spawn tasks in.
pub(crate) fn scope<R>(work: impl FnOnce(&Scope) -> R) -> R {
    work(&Scope)
}

/// Where tasks are spawned.
pub(crate) struct Scope;

impl Scope {
    /// Runs `task` at once.
    pub(crate) fn spawn(&self, task: impl FnOnce(&Self)) {
        task(self);
    }
}

/// An iterator with the names of a parallel one.
pub(crate) struct Serial<I>(I);

/// What turns into an iterator over items, one after another.
pub(crate) trait IntoParallelIterator: Sized {
    /// What it yields.
    type Item;
    /// The iterator that yields it.
    type Iter: Iterator<Item = Self::Item>;

    /// The plain iterator.
    fn serial(self) -> Self::Iter;

    /// The iterator with the names of a parallel one.
    fn into_par_iter(self) -> Serial<Self::Iter> {
        Serial(self.serial())
    }
}

impl<I: Iterator> IntoParallelIterator for Serial<I> {
    type Item = I::Item;
    type Iter = I;

    fn serial(self) -> I {
        self.0
    }
}

impl<T> IntoParallelIterator for std::ops::Range<T>
where
    Self: Iterator<Item = T>,
{
    type Item = T;
    type Iter = Self;

    fn serial(self) -> Self {
        self
    }
}

impl<'a, T> IntoParallelIterator for &'a [T] {
    type Item = &'a T;
    type Iter = Iter<'a, T>;

    fn serial(self) -> Self::Iter {
        self.iter()
    }
}

impl<'a, T> IntoParallelIterator for &'a Vec<T> {
    type Item = &'a T;
    type Iter = Iter<'a, T>;

    fn serial(self) -> Self::Iter {
        self.iter()
    }
}

/// What every iterator of this kind can do.
pub(crate) trait ParallelIterator: IntoParallelIterator {
    /// `change` of each item.
    fn map<R, F: FnMut(Self::Item) -> R>(self, change: F) -> Serial<Map<Self::Iter, F>> {
        Serial(self.serial().map(change))
    }

    /// `change` of each item, with a value that is kept from one to the next.
    fn map_init<T, R>(
        self,
        init: impl FnOnce() -> T,
        change: impl Fn(&mut T, Self::Item) -> R,
    ) -> Serial<impl Iterator<Item = R>> {
        let mut kept = init();
        Serial(self.serial().map(move |item| change(&mut kept, item)))
    }

    /// Calls `visit` with each item.
    fn for_each(self, visit: impl FnMut(Self::Item)) {
        self.serial().for_each(visit);
    }

    /// Calls `visit` with each item and a value that is kept from one to the next.
    fn for_each_init<T>(self, init: impl FnOnce() -> T, visit: impl Fn(&mut T, Self::Item)) {
        let mut kept = init();
        self.serial().for_each(|item| visit(&mut kept, item));
    }

    /// The items folded into one value, which is the only one of the new iterator.
    fn fold<T>(
        self,
        identity: impl FnOnce() -> T,
        fold: impl FnMut(T, Self::Item) -> T,
    ) -> Serial<std::iter::Once<T>> {
        Serial(std::iter::once(self.serial().fold(identity(), fold)))
    }

    /// All items made one by `reduce`, beginning with `identity`.
    fn reduce(
        self,
        identity: impl FnOnce() -> Self::Item,
        reduce: impl FnMut(Self::Item, Self::Item) -> Self::Item,
    ) -> Self::Item {
        self.serial().fold(identity(), reduce)
    }

    /// The sum of all items.
    fn sum<S: Sum<Self::Item>>(self) -> S {
        self.serial().sum()
    }

    /// All items in order.
    fn collect<C: FromIterator<Self::Item>>(self) -> C {
        self.serial().collect()
    }

    /// The items themselves, not references.
    fn copied<'a, T: Copy + 'a>(self) -> Serial<Copied<Self::Iter>>
    where
        Self::Iter: Iterator<Item = &'a T>,
    {
        Serial(self.serial().copied())
    }
}

impl<I: Iterator> ParallelIterator for Serial<I> {}

/// What can be done where each item has a number.
pub(crate) trait IndexedParallelIterator: ParallelIterator {
    /// Items with their numbers, from 0.
    fn enumerate(self) -> Serial<Enumerate<Self::Iter>> {
        Serial(self.serial().enumerate())
    }

    /// Pairs of the items of both.
    fn zip<Z: IntoParallelIterator>(self, other: Z) -> Serial<Zip<Self::Iter, Z::Iter>> {
        Serial(self.serial().zip(other.serial()))
    }

    /// Itself: nothing is split.
    fn with_min_len(self, _: usize) -> Self {
        self
    }

    /// The number of items.
    fn len(&self) -> usize;
}

impl<I: ExactSizeIterator> IndexedParallelIterator for Serial<I> {
    fn len(&self) -> usize {
        self.0.len()
    }
}

/// Iterators over what a slice holds.
pub(crate) trait ParallelRefIterator<T> {
    /// References to all items.
    fn par_iter(&self) -> Serial<Iter<'_, T>>;

    /// Mutable references to all items.
    fn par_iter_mut(&mut self) -> Serial<IterMut<'_, T>>;
}

impl<T> ParallelRefIterator<T> for [T] {
    fn par_iter(&self) -> Serial<Iter<'_, T>> {
        Serial(self.iter())
    }

    fn par_iter_mut(&mut self) -> Serial<IterMut<'_, T>> {
        Serial(self.iter_mut())
    }
}

/// Iterators over parts of a slice.
pub(crate) trait ParallelSlice<T> {
    /// Parts of `size` items; the last may be shorter.
    fn par_chunks(&self, size: usize) -> Serial<Chunks<'_, T>>;

    /// Mutable parts of `size` items; the last may be shorter.
    fn par_chunks_mut(&mut self, size: usize) -> Serial<ChunksMut<'_, T>>;

    /// Mutable parts of `size` items; what is left over is not visited.
    fn par_chunks_exact_mut(&mut self, size: usize) -> Serial<ChunksExactMut<'_, T>>;
}

impl<T> ParallelSlice<T> for [T] {
    fn par_chunks(&self, size: usize) -> Serial<Chunks<'_, T>> {
        Serial(self.chunks(size))
    }

    fn par_chunks_mut(&mut self, size: usize) -> Serial<ChunksMut<'_, T>> {
        Serial(self.chunks_mut(size))
    }

    fn par_chunks_exact_mut(&mut self, size: usize) -> Serial<ChunksExactMut<'_, T>> {
        Serial(self.chunks_exact_mut(size))
    }
}
