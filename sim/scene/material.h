// The constants of a cloth. Which of them a scene has: sim/scene/parameter_table.h.
#ifndef CLOTHID_SIM_SCENE_MATERIAL_H_
#define CLOTHID_SIM_SCENE_MATERIAL_H_

namespace clothid {

struct Material {
  double density = 0.15;             // rho, kg/m^2
  double stretch_stiffness = 100.0;  // k, N/m
  double bending_stiffness = 0.0;    // k_b, N m; 0: the scene has no bending
  double drag = 0.0;                 // c_d, kg/(m^2 s), the same in every direction; 0: the scene has no such drag
  double damping = 0.0;              // eta, N s/m; 0: the scene has no internal damping. eta/k is a relaxation time
  // Of an orthotropic membrane, in place of k: C_11, C_22, C_66 and C_12, N/m (sim/shell/orthotropic_energy.h). One of
  // yarns has them at zero strain, and stiffens by b_1 and b_2 (sim/shell/yarn_energy.h).
  double warp_stiffness = 0.0, weft_stiffness = 0.0, shear_stiffness = 0.0, poisson_stiffness = 0.0;
  double warp_stiffening = 0.0, weft_stiffening = 0.0;
  // Of orthotropic bending, in place of k_b: D_11, D_22 and D_66, N m (sim/shell/bending_patch.h).
  double warp_bending = 0.0, weft_bending = 0.0, twist_bending = 0.0;

  // c_n and c_t of drag by direction: kg/(m^2 s), or kg/m^3 where the law of the air is quadratic
  // (sim/force/directional_drag.h). Both 0: the scene has none.
  double normal_drag = 0.0, tangential_drag = 0.0;
  double added_mass = 0.0;  // m_a, kg/m^2: air that moves with the cloth; inertia without weight
  double pressure = 0.0;    // p, Pa, of the air on the cloth's back (sim/force/pressure_term.h); 0: the scene has none

  double areal_inertia() const { return density + added_mass; }  // kg/m^2

  bool operator==(const Material& other) const;
};

}  // namespace clothid

#endif  // CLOTHID_SIM_SCENE_MATERIAL_H_
