//! Periodic conditions: the values on one region are those on another, carried over by a rigid motion.

use super::{Constraints, ConstraintsError, RigidMap};
use crate::coincident::{Coincident, distance};

impl<const D: usize> Constraints<D> {
    /// u at the image of each node of `from`, which must be a node of `to`, equals u at the node; vectors of D
    /// components are turned with it. On a part of a mesh each process has both regions whole (`part.with_surfaces(..)`).
    ///
    /// # Errors
    /// Unknown regions, on a part of a mesh regions that are not whole, a node without a partner (the first one, with the distance to the nearest), a map that leaves all
    /// nodes where they are, so that nothing would be said, a map that turns tensors or other values, or a contradiction
    /// to earlier conditions.
    pub fn periodic(&mut self, from: &str, to: &str, map: &RigidMap<D>) -> Result<(), ConstraintsError> {
        let place = format!("regions \"{from}\" and \"{to}\"");
        let (masters, slaves) = (self.nodes_to_relate(from, &place)?, self.nodes_to_relate(to, &place)?);
        let components = self.space.components();
        let is_vector = self.space.shape() == [D];
        if !is_vector && components > 1 && map.rotation != RigidMap::translation([0.0; D]).rotation {
            return Err(ConstraintsError::Components { place, space: components, value: D });
        }
        let position = |node: u32| self.space.positions()[node as usize];
        let images: Vec<[f64; D]> = masters.iter().map(|&node| map.apply(&position(node))).collect();
        let targets: Vec<[f64; D]> = slaves.iter().map(|&node| position(node)).collect();
        let partners = self.partners(from, to, &masters, &images, &targets)?;
        // As many on both sides: then the nodes of `to` have partners as well.
        let mut taken = vec![false; slaves.len()];
        partners.iter().for_each(|&slave| taken[slave] = true);
        if let Some(alone) = taken.iter().position(|taken| !taken) {
            return Err(self.without_partner(to, from, slaves[alone], distance(&images, &targets[alone])));
        }
        // Where all nodes stay, only vectors that turn are related. Some may stay: those on an axis of rotation do.
        let stays = masters.iter().zip(&partners).all(|(&master, &slave)| master == slaves[slave]);
        let turns = is_vector && map.rotation != RigidMap::translation([0.0; D]).rotation;
        if let Some(&node) = masters.first().filter(|_| stays && !turns) {
            let (from, to, node) = (from.to_owned(), to.to_owned(), node as usize);
            let position = self.space.positions()[node].to_vec();
            return Err(ConstraintsError::OntoItself { from, to, node, position });
        }
        let mut changed = self.clone();
        for (&master, &slave) in masters.iter().zip(&partners) {
            let (own, other) = (slaves[slave] as usize * components, master as usize * components);
            for component in 0..components {
                let mut terms = vec![(own + component, 1.0)];
                match is_vector {
                    true => {
                        let row = map.rotation[component].iter().enumerate().filter(|(_, r)| **r != 0.0);
                        terms.extend(row.map(|(k, r)| (other + k, -r)));
                    }
                    false => terms.push((other + component, -1.0)),
                }
                changed.add_equation(&place, &terms, 0.0)?;
            }
        }
        *self = changed;
        Ok(())
    }

    /// The target at each image.
    fn partners(
        &self,
        from: &str,
        to: &str,
        nodes: &[u32],
        images: &[[f64; D]],
        targets: &[[f64; D]],
    ) -> Result<Vec<usize>, ConstraintsError> {
        let coincident = Coincident::new(targets);
        let found = nodes.iter().zip(images).map(|(&node, image)| {
            coincident
                .find(image)
                .ok_or_else(|| self.without_partner(from, to, node, distance(targets, image)))
        });
        found.collect()
    }

    fn without_partner(&self, region: &str, other: &str, node: u32, distance: f64) -> ConstraintsError {
        let position = self.space.positions()[node as usize].to_vec();
        let (region, other, node) = (region.to_owned(), other.to_owned(), node as usize);
        ConstraintsError::NoPartner { region, other, node, position, distance }
    }
}
