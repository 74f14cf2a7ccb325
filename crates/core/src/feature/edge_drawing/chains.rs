//! The branches of a walk, and the longest ways through them.

/// A piece of a walk between two turns.
#[derive(Clone, Debug, Default)]
struct Branch {
    pixels: Vec<(u32, u32)>,
    /// The branches at its end, towards falling and towards rising coordinates.
    children: [Option<usize>; 2],
}

/// The branches of the walk from one anchor: a tree whose root, branch 0, has no pixels.
#[derive(Debug, Default)]
pub(super) struct Branches(Vec<Branch>);

impl Branches {
    /// Forgets all branches.
    pub(super) fn restart(&mut self) {
        self.0.clear();
        self.0.push(Branch::default());
    }

    /// A new branch at the end of `parent`.
    pub(super) fn begin(&mut self, parent: usize, rises: bool) -> usize {
        let number = self.0.len();
        self.0[parent].children[usize::from(rises)] = Some(number);
        self.0.push(Branch::default());
        number
    }

    /// Adds a pixel to a branch.
    pub(super) fn extend(&mut self, branch: usize, at: (u32, u32)) {
        self.0[branch].pixels.push(at);
    }

    /// Takes the last pixel of a branch away.
    pub(super) fn shorten(&mut self, branch: usize) {
        self.0[branch].pixels.pop();
    }

    /// The chains of the walk: the longest way from end to end, and the longest ways through what is left of it, of at
    /// least `shortest` pixels.
    pub(super) fn chains(&self, shortest: usize) -> Vec<Vec<(u32, u32)>> {
        let longest = self.longest();
        let mut used = vec![false; self.0.len()];
        let [back, forth] = self.0[0].children;
        let mut main: Vec<_> = forth.map_or_else(Vec::new, |b| self.way(b, &longest, &mut used));
        main.reverse();
        let back = back.map_or_else(Vec::new, |b| self.way(b, &longest, &mut used));
        // Both begin with the anchor.
        main.extend(back.iter().skip(usize::from(!main.is_empty())));
        let mut chains = vec![main];
        for branch in 1..self.0.len() {
            if !used[branch] && longest[branch] >= shortest {
                chains.push(self.way(branch, &longest, &mut used));
            }
        }
        for chain in &mut chains {
            chain.dedup();
        }
        chains.retain(|chain| chain.len() > 1);
        chains
    }

    /// The pixels of the longest way from the beginning of each branch. Branches come after their parents.
    fn longest(&self) -> Vec<usize> {
        let mut longest = vec![0; self.0.len()];
        for (i, branch) in self.0.iter().enumerate().rev() {
            let onward = branch.children.iter().flatten().map(|&child| longest[child]).max();
            longest[i] = branch.pixels.len() + onward.unwrap_or(0);
        }
        longest
    }

    /// The pixels of the longest way from the beginning of `branch`, which are used then.
    fn way(&self, branch: usize, longest: &[usize], used: &mut [bool]) -> Vec<(u32, u32)> {
        let mut pixels = Vec::with_capacity(longest[branch]);
        let mut next = Some(branch);
        while let Some(branch) = next {
            used[branch] = true;
            pixels.extend_from_slice(&self.0[branch].pixels);
            let open = self.0[branch].children.iter().flatten().copied();
            next = open.filter(|&child| !used[child]).max_by_key(|&child| longest[child]);
        }
        pixels
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_longest_way_is_one_chain_and_long_rests_are_others() {
        let mut branches = Branches::default();
        branches.restart();
        let line = |branches: &mut Branches, branch: usize, x: u32, y: u32, length: u32| {
            (0..length).for_each(|i| branches.extend(branch, (x + i, y)));
        };
        let (forth, back) = (branches.begin(0, true), branches.begin(0, false));
        line(&mut branches, forth, 10, 0, 5);
        branches.extend(back, (10, 0));
        branches.extend(back, (9, 0));
        let (long, short) = (branches.begin(forth, true), branches.begin(forth, false));
        line(&mut branches, long, 15, 1, 20);
        line(&mut branches, short, 15, 9, 4);
        let chains = branches.chains(4);
        assert_eq!(chains.len(), 2);
        assert_eq!(chains[0].len(), 26, "both ends, and the anchor once");
        assert_eq!((chains[0][0], chains[0][25]), ((34, 1), (9, 0)));
        assert_eq!(chains[1].len(), 4);
        assert_eq!(branches.chains(5).len(), 1);
    }
}
