//! The basket: one line per kernel. The forms are in `forms`, their UFL counterparts in `peers/basket.py`.

use crate::forms::given::typed::*;

crate::register! { |c|
    poisson_tri_P1: Tangent of Cells, Triangle, degree 1, geometry 1, rule 0, [], Entities, poisson();
    elasticity_tri_P1: Tangent of Cells, Triangle, degree 1, geometry 1, rule 0, [], Entities, elasticity(c);
    poisson_tri_P2: Tangent of Cells, Triangle, degree 2, geometry 1, rule 2, [], Entities, poisson();
    elasticity_tri_P2: Tangent of Cells, Triangle, degree 2, geometry 1, rule 2, [], Entities, elasticity(c);
    neohooke_tangent_tri_P2_q2: Tangent of Cells, Triangle, degree 2, geometry 1, rule 2, [("u", 2)], Entities, neo_hookean(c);
    neohooke_residual_tri_P2_q2: Residual of Cells, Triangle, degree 2, geometry 1, rule 2, [("u", 2)], Entities, neo_hookean(c);
    neohooke_tangent_tri_P2_q4: Tangent of Cells, Triangle, degree 2, geometry 1, rule 4, [("u", 2)], Entities, neo_hookean(c);
    mass_tri_P2vec: Tangent of Cells, Triangle, degree 2, geometry 1, rule 4, [], Entities, mass();
    nitsche_residual_tri_P2: Residual of Facets, Triangle, degree 2, geometry 1, rule 4, [("u", 2), ("gap", 1)], Entities, contact(c);
    nitsche_tangent_tri_P2: Tangent of Facets, Triangle, degree 2, geometry 1, rule 4, [("u", 2), ("gap", 1)], Entities, contact(c);
    nitsche_nh_tangent_tri_P2: Tangent of Facets, Triangle, degree 2, geometry 1, rule 4, [("u", 2), ("gap", 1)], Entities, finite_contact(c);
    poisson_tet_P1: Tangent of Cells, Tetrahedron, degree 1, geometry 1, rule 0, [], Entities, poisson();
    elasticity_tet_P1: Tangent of Cells, Tetrahedron, degree 1, geometry 1, rule 0, [], Entities, elasticity(c);
    neohooke_tangent_tet_P1_q0: Tangent of Cells, Tetrahedron, degree 1, geometry 1, rule 0, [("u", 1)], Entities, neo_hookean(c);
    poisson_tet_P2: Tangent of Cells, Tetrahedron, degree 2, geometry 1, rule 2, [], Entities, poisson();
    elasticity_tet_P2: Tangent of Cells, Tetrahedron, degree 2, geometry 1, rule 2, [], Entities, elasticity(c);
    neohooke_tangent_tet_P2_q2: Tangent of Cells, Tetrahedron, degree 2, geometry 1, rule 2, [("u", 2)], Entities, neo_hookean(c);
    neohooke_residual_tet_P2_q2: Residual of Cells, Tetrahedron, degree 2, geometry 1, rule 2, [("u", 2)], Entities, neo_hookean(c);
    neohooke_tangent_tet_P2_q4: Tangent of Cells, Tetrahedron, degree 2, geometry 1, rule 4, [("u", 2)], Entities, neo_hookean(c);
    mass_tet_P2vec: Tangent of Cells, Tetrahedron, degree 2, geometry 1, rule 4, [], Entities, mass();
    nitsche_residual_tet_P2: Residual of Facets, Tetrahedron, degree 2, geometry 1, rule 4, [("u", 2), ("gap", 1)], Entities, contact(c);
    nitsche_tangent_tet_P2: Tangent of Facets, Tetrahedron, degree 2, geometry 1, rule 4, [("u", 2), ("gap", 1)], Entities, contact(c);
    nitsche_nh_tangent_tet_P2: Tangent of Facets, Tetrahedron, degree 2, geometry 1, rule 4, [("u", 2), ("gap", 1)], Entities, finite_contact(c);
    elasticity_quad_Q2_g2: Tangent of Cells, Quadrilateral, degree 2, geometry 2, rule 4, [], Entities, elasticity(c);
    elasticity_quad_Q2_g2_sumfact: Tangent of Cells, Quadrilateral, degree 2, geometry 2, rule 4, [], TensorProduct, elasticity(c);
    elasticity_quad_Q2_g1: Tangent of Cells, Quadrilateral, degree 2, geometry 1, rule 4, [], Entities, elasticity(c);
    elasticity_quad_Q2_g1_sumfact: Tangent of Cells, Quadrilateral, degree 2, geometry 1, rule 4, [], TensorProduct, elasticity(c);
    poisson_quad_Q2_g1: Tangent of Cells, Quadrilateral, degree 2, geometry 1, rule 4, [], Entities, poisson();
    elasticity_hex_Q1_g1: Tangent of Cells, Hexahedron, degree 1, geometry 1, rule 3, [], Entities, elasticity(c);
    elasticity_hex_Q1_g1_sumfact: Tangent of Cells, Hexahedron, degree 1, geometry 1, rule 3, [], TensorProduct, elasticity(c);
    poisson_hex_Q1_g1: Tangent of Cells, Hexahedron, degree 1, geometry 1, rule 3, [], Entities, poisson();
    elasticity_hex_Q2_g1: Tangent of Cells, Hexahedron, degree 2, geometry 1, rule 4, [], Entities, elasticity(c);
    elasticity_hex_Q2_g1_sumfact: Tangent of Cells, Hexahedron, degree 2, geometry 1, rule 4, [], TensorProduct, elasticity(c);
    poisson_hex_Q2_g1: Tangent of Cells, Hexahedron, degree 2, geometry 1, rule 4, [], Entities, poisson();
    elasticity_hex_Q2_g2: Tangent of Cells, Hexahedron, degree 2, geometry 2, rule 4, [], Entities, elasticity(c);
    elasticity_hex_Q2_g2_sumfact: Tangent of Cells, Hexahedron, degree 2, geometry 2, rule 4, [], TensorProduct, elasticity(c);
}
