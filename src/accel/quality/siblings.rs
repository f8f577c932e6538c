//! What the boxes of a node's children say of the node: how much they share, and how much of it they leave empty.

use crate::geometry::Aabb;

/// `sum over pairs of area(box_i ∩ box_j) / area(union)`; 0 where the area of the box around all is.
pub fn overlap(siblings: &[Aabb]) -> f64 {
    let own = around(siblings).area();
    let mut shared = 0.0;
    for (i, a) in siblings.iter().enumerate() {
        for b in &siblings[i + 1..] {
            let common = a.intersection(*b);
            if !common.is_empty() {
                shared += f64::from(common.area());
            }
        }
    }
    if own > 0.0 { shared / f64::from(own) } else { 0.0 }
}

/// `1 - volume of the union of the boxes / volume of the box around them`, exact but for rounding; `None` where that
/// box has no volume.
pub fn empty_space(siblings: &[Aabb]) -> Option<f64> {
    let own = volume(&around(siblings));
    (own > 0.0).then(|| (1.0 - union_volume(siblings) / own).clamp(0.0, 1.0))
}

fn around(boxes: &[Aabb]) -> Aabb {
    boxes.iter().fold(Aabb::EMPTY, |all, b| all.union(*b))
}

fn volume(bounds: &Aabb) -> f64 {
    let extent = (bounds.max.as_dvec3() - bounds.min.as_dvec3()).max(glam::DVec3::ZERO);
    extent.element_product()
}

/// The volume of a union of boxes: each box's own, less what those behind it cover of it. Most siblings overlap few others,
/// so that this ends after a step or two.
fn union_volume(boxes: &[Aabb]) -> f64 {
    /// What a wide node may have.
    const MOST: usize = 16;
    let Some((first, rest)) = boxes.split_first() else { return 0.0 };
    if boxes.len() > MOST {
        // Beyond what nodes hold: no fixed room.
        let common: Vec<_> =
            rest.iter().map(|b| b.intersection(*first)).filter(|c| volume(c) > 0.0).collect();
        return volume(first) - union_volume(&common) + union_volume(rest);
    }
    let mut total = 0.0;
    for (i, first) in boxes.iter().enumerate() {
        let (mut common, mut count) = ([Aabb::EMPTY; MOST], 0);
        for other in &boxes[i + 1..] {
            let both = first.intersection(*other);
            if both == *first {
                // Wholly inside one that comes later.
                (common[0], count) = (both, 1);
                break;
            }
            if volume(&both) > 0.0 {
                common[count] = both;
                count += 1;
            }
        }
        total += volume(first) - union_volume(&common[..count]);
    }
    total
}

#[cfg(test)]
mod tests {
    use glam::Vec3;
    use rand::{RngExt, SeedableRng};
    use rand_pcg::Pcg32;

    use super::*;

    fn cube(at: [f32; 3], side: f32) -> Aabb {
        let min = Vec3::from_array(at);
        Aabb::new(min, min + Vec3::splat(side))
    }

    #[test]
    fn boxes_done_by_hand() {
        let apart = [cube([0.0; 3], 1.0), cube([3.0, 0.0, 0.0], 1.0)];
        assert_eq!((overlap(&apart), empty_space(&apart)), (0.0, Some(0.5)));
        let touching = [cube([0.0; 3], 1.0), cube([1.0, 0.0, 0.0], 1.0)];
        // They share a side of area 1, both sides of which count; the box around them has 10.
        assert_eq!((overlap(&touching), empty_space(&touching)), (0.2, Some(0.0)));
        let same = [cube([0.0; 3], 1.0); 5];
        assert_eq!((overlap(&same), empty_space(&same)), (10.0, Some(0.0)));
        let corners = [cube([0.0; 3], 2.0), cube([1.0; 3], 2.0)];
        assert_eq!(empty_space(&corners), Some(1.0 - 15.0 / 27.0));
        let flat = [Aabb::new(Vec3::ZERO, Vec3::new(1.0, 1.0, 0.0))];
        assert_eq!((overlap(&flat), empty_space(&flat)), (0.0, None));
        assert_eq!((overlap(&[]), empty_space(&[])), (0.0, None));
    }

    #[test]
    fn a_union_has_the_volume_of_its_cells() {
        let mut rng = Pcg32::seed_from_u64(7);
        for count in [2, 3, 8, 16, 20] {
            for _ in 0..20 {
                let boxes: Vec<Aabb> = (0..count)
                    .map(|_| {
                        let min: [i32; 3] = std::array::from_fn(|_| rng.random_range(0..8));
                        let size: [i32; 3] = std::array::from_fn(|_| rng.random_range(0..5));
                        let max: [i32; 3] = std::array::from_fn(|i| min[i] + size[i]);
                        let corner = |c: [i32; 3]| Vec3::from_array(c.map(|x| x as f32));
                        Aabb::new(corner(min), corner(max))
                    })
                    .collect();
                let mut cells = 0;
                for i in 0..13 * 13 * 13 {
                    let middle = Vec3::new((i % 13) as f32, (i / 13 % 13) as f32, (i / 169) as f32) + 0.5;
                    let inside = |b: &Aabb| b.min.cmplt(middle).all() && b.max.cmpgt(middle).all();
                    cells += u32::from(boxes.iter().any(inside));
                }
                assert_eq!(union_volume(&boxes), f64::from(cells), "{boxes:?}");
            }
        }
    }
}
