//! Trees that no builder here makes: wider ones, and lists. Whoever includes this file has `Aabb` and `RawTree` in scope.
#![allow(dead_code, reason = "each test needs a part of it")]

use super::{Aabb, RawTree};

/// Room for more children, and for every grandchild that fits into it.
pub fn widened(raw: &RawTree, width: usize) -> RawTree {
    let mut wide = RawTree {
        width,
        leaf_first: raw.leaf_first.clone(),
        leaf_count: raw.leaf_count.clone(),
        shape_index: raw.shape_index.clone(),
        ..RawTree::default()
    };
    let children = |node: i32| {
        let slots = node as usize * raw.width..(node as usize + 1) * raw.width;
        slots.filter(|slot| raw.child_index[*slot] != RawTree::EMPTY).collect::<Vec<usize>>()
    };
    let mut open = if raw.node_count() > 0 { vec![0] } else { Vec::new() };
    let mut at = 0;
    while at < open.len() {
        let mut slots = children(open[at]);
        while let Some(i) = slots.iter().position(|slot| {
            let child = raw.child_index[*slot];
            child >= 0 && slots.len() - 1 + children(child).len() <= width
        }) {
            let slot = slots.remove(i);
            slots.extend(children(raw.child_index[slot]));
        }
        for i in 0..width {
            let slot = slots.get(i).copied();
            let child = slot.map_or(RawTree::EMPTY, |slot| raw.child_index[slot]);
            wide.child_min.push(slot.map_or([0.0; 3], |slot| raw.child_min[slot]));
            wide.child_max.push(slot.map_or([0.0; 3], |slot| raw.child_max[slot]));
            wide.child_index.push(if child >= 0 { open.len() as i32 } else { child });
            if child >= 0 {
                open.push(child);
            }
        }
        at += 1;
    }
    wide
}

/// A list: every node has a leaf with one box and the rest. Depth is the number of boxes less one.
pub fn list(boxes: &[Aabb]) -> RawTree {
    let count = boxes.len();
    let mut raw = RawTree { width: 2, ..RawTree::default() };
    let mut rest: Vec<Aabb> = boxes.to_vec();
    for i in (0..count - 1).rev() {
        rest[i] = rest[i].union(rest[i + 1]);
    }
    for i in 0..count - 1 {
        let last = i + 2 == count;
        for (bounds, child) in [
            (boxes[i], RawTree::LEAVES - i as i32),
            (rest[i + 1], if last { RawTree::LEAVES - count as i32 + 1 } else { i as i32 + 1 }),
        ] {
            raw.child_min.push(bounds.min.into());
            raw.child_max.push(bounds.max.into());
            raw.child_index.push(child);
        }
    }
    raw.leaf_first = (0..count as i32).collect();
    raw.leaf_count = vec![1; count];
    raw.shape_index = (0..count as i32).collect();
    raw
}
