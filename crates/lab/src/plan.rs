//! In which order processes run: in blocks, each with every variant once, in a random order of its own.

use crate::experiment::Experiment;
use crate::statistics::CountedRandom;

/// What runs in a place of a block.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Slot {
    /// The variant of this number.
    Variant(usize),
    /// The base once more: what differs from its first run is noise.
    BaseAgain,
}

/// The order of a block: all variants that run here, and the base twice.
pub fn block_order(experiment: &Experiment, runs_here: &[bool], seed: u64, block: u32) -> Vec<Slot> {
    let base = experiment.variant(&experiment.base);
    let mut order: Vec<Slot> =
        (0..experiment.variants.len()).filter(|&number| runs_here[number]).map(Slot::Variant).collect();
    if base.is_some_and(|base| runs_here[base]) {
        order.push(Slot::BaseAgain);
    }
    // A key for each block, so that its order does not depend on what ran before.
    CountedRandom::new(seed ^ (u64::from(block) << 32)).shuffle(&mut order);
    order
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::builtin::builtin_experiments;

    #[test]
    fn a_block_holds_every_variant_once_and_the_base_twice() {
        for experiment in builtin_experiments() {
            let runs_here: Vec<bool> = experiment.variants.iter().map(|variant| !variant.needs_gpu).collect();
            let base = experiment.variant(&experiment.base).filter(|&base| runs_here[base]);
            let mut orders = std::collections::BTreeSet::new();
            for block in 0..12 {
                let order = block_order(&experiment, &runs_here, 7, block);
                assert_eq!(order, block_order(&experiment, &runs_here, 7, block));
                let mut sorted = order.clone();
                sorted.sort();
                let numbers = (0..runs_here.len()).filter(|&number| runs_here[number]);
                let expected: Vec<Slot> =
                    numbers.map(Slot::Variant).chain(base.map(|_| Slot::BaseAgain)).collect();
                assert_eq!(sorted, expected);
                orders.insert(order);
            }
            assert!(orders.len() > 1 || base.is_none(), "{}: the order is random", experiment.name);
        }
    }
}
