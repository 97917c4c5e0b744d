//! The basket: one line per kernel. The forms stand in `forms`, their UFL counterparts in `peers/basket.py`.

use crate::forms::given::*;

crate::register! { |c, w|
    poisson_tri_P1: Tangent, Triangle, 1, 1, 0, [], Entities, poisson();
    elasticity_tri_P1: Tangent, Triangle, 1, 1, 0, [], Entities, elasticity(c);
    poisson_tri_P2: Tangent, Triangle, 2, 1, 2, [], Entities, poisson();
    elasticity_tri_P2: Tangent, Triangle, 2, 1, 2, [], Entities, elasticity(c);
    neohooke_tangent_tri_P2_q2: Tangent, Triangle, 2, 1, 2, [2], Entities, neo_hookean(c);
    neohooke_residual_tri_P2_q2: Residual, Triangle, 2, 1, 2, [2], Entities, neo_hookean(c);
    neohooke_tangent_tri_P2_q4: Tangent, Triangle, 2, 1, 4, [2], Entities, neo_hookean(c);
    mass_tri_P2vec: Tangent, Triangle, 2, 1, 4, [], Entities, mass();
    nitsche_residual_tri_P2: Residual, Triangle, 2, 1, 4, [2, 1], Entities, contact(c, w.scalar(1));
    nitsche_tangent_tri_P2: Tangent, Triangle, 2, 1, 4, [2, 1], Entities, contact(c, w.scalar(1));
    nitsche_nh_tangent_tri_P2: Tangent, Triangle, 2, 1, 4, [2, 1], Entities, finite_contact(c, w.scalar(1));
    poisson_tet_P1: Tangent, Tetrahedron, 1, 1, 0, [], Entities, poisson();
    elasticity_tet_P1: Tangent, Tetrahedron, 1, 1, 0, [], Entities, elasticity(c);
    neohooke_tangent_tet_P1_q0: Tangent, Tetrahedron, 1, 1, 0, [1], Entities, neo_hookean(c);
    poisson_tet_P2: Tangent, Tetrahedron, 2, 1, 2, [], Entities, poisson();
    elasticity_tet_P2: Tangent, Tetrahedron, 2, 1, 2, [], Entities, elasticity(c);
    neohooke_tangent_tet_P2_q2: Tangent, Tetrahedron, 2, 1, 2, [2], Entities, neo_hookean(c);
    neohooke_residual_tet_P2_q2: Residual, Tetrahedron, 2, 1, 2, [2], Entities, neo_hookean(c);
    neohooke_tangent_tet_P2_q4: Tangent, Tetrahedron, 2, 1, 4, [2], Entities, neo_hookean(c);
    mass_tet_P2vec: Tangent, Tetrahedron, 2, 1, 4, [], Entities, mass();
    nitsche_residual_tet_P2: Residual, Tetrahedron, 2, 1, 4, [2, 1], Entities, contact(c, w.scalar(1));
    nitsche_tangent_tet_P2: Tangent, Tetrahedron, 2, 1, 4, [2, 1], Entities, contact(c, w.scalar(1));
    nitsche_nh_tangent_tet_P2: Tangent, Tetrahedron, 2, 1, 4, [2, 1], Entities, finite_contact(c, w.scalar(1));
    elasticity_quad_Q2_g2: Tangent, Quadrilateral, 2, 2, 4, [], Entities, elasticity(c);
    elasticity_quad_Q2_g2_sumfact: Tangent, Quadrilateral, 2, 2, 4, [], TensorProduct, elasticity(c);
    elasticity_quad_Q2_g1: Tangent, Quadrilateral, 2, 1, 4, [], Entities, elasticity(c);
    elasticity_quad_Q2_g1_sumfact: Tangent, Quadrilateral, 2, 1, 4, [], TensorProduct, elasticity(c);
    poisson_quad_Q2_g1: Tangent, Quadrilateral, 2, 1, 4, [], Entities, poisson();
    elasticity_hex_Q1_g1: Tangent, Hexahedron, 1, 1, 3, [], Entities, elasticity(c);
    elasticity_hex_Q1_g1_sumfact: Tangent, Hexahedron, 1, 1, 3, [], TensorProduct, elasticity(c);
    poisson_hex_Q1_g1: Tangent, Hexahedron, 1, 1, 3, [], Entities, poisson();
    elasticity_hex_Q2_g1: Tangent, Hexahedron, 2, 1, 4, [], Entities, elasticity(c);
    elasticity_hex_Q2_g1_sumfact: Tangent, Hexahedron, 2, 1, 4, [], TensorProduct, elasticity(c);
    poisson_hex_Q2_g1: Tangent, Hexahedron, 2, 1, 4, [], Entities, poisson();
    elasticity_hex_Q2_g2: Tangent, Hexahedron, 2, 2, 4, [], Entities, elasticity(c);
    elasticity_hex_Q2_g2_sumfact: Tangent, Hexahedron, 2, 2, 4, [], TensorProduct, elasticity(c);
}
