//! Rigid motions as vectors of unknowns: the near-null space of elasticity, and what singular matrices are named by.

/// The translations, then the rotations about the axes through the middle of the nodes, as vectors of unknowns with D
/// components per node: 3 vectors in the plane, 6 in space, 1 on a line. Lengths are measured in the size of the body.
pub fn rigid_motions<const D: usize>(positions: &[[f64; D]]) -> Vec<Vec<f64>> {
    let (mut low, mut high) = ([f64::INFINITY; D], [f64::NEG_INFINITY; D]);
    for position in positions {
        for k in 0..D {
            low[k] = low[k].min(position[k]);
            high[k] = high[k].max(position[k]);
        }
    }
    let size = (0..D).map(|k| high[k] - low[k]).fold(0.0, f64::max).max(f64::MIN_POSITIVE);
    let mut motions = Vec::new();
    for component in 0..D {
        motions.push(
            (0..positions.len() * D).map(|unknown| f64::from(u8::from(unknown % D == component))).collect(),
        );
    }
    // In space the pairs are ordered so that the axes are x, y, z.
    let pairs: &[(usize, usize)] = match D {
        2 => &[(0, 1)],
        3 => &[(1, 2), (2, 0), (0, 1)],
        _ => &[],
    };
    for &(a, b) in pairs {
        let mut motion = vec![0.0; positions.len() * D];
        for (value, position) in motion.chunks_exact_mut(D).zip(positions) {
            let relative = |k: usize| (position[k] - 0.5 * (low[k] + high[k])) / size;
            value[a] = -relative(b);
            value[b] = relative(a);
        }
        motions.push(motion);
    }
    motions
}
