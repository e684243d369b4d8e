// joint_fit FIRST SECOND: two recordings of one cloth on two surfaces, fitted together: one stiffness, two frictions.
#include <ceres/problem.h>
#include <ceres/solver.h>

#include <cstdio>
#include <stdexcept>
#include <vector>

#include "costs/rollout_cost.h"
#include "datasets/motion/motion_file.h"
#include "identify/uncertainty/uncertainty.h"

void Fit(const char* first, const char* second) {
  const clothid::RecordedMotion motions[] = {clothid::ReadMotion(first), clothid::ReadMotion(second)};
  // Starting values and bounds are those of the scenes. What Ceres changes are coordinates: log(k_stretch), mu, mu.
  const std::vector<clothid::ParameterBlock> blocks = {clothid::MakeParameterBlock("k_stretch", motions[0].scene, {}),
                                                       clothid::MakeParameterBlock("mu", motions[0].scene, {}),
                                                       clothid::MakeParameterBlock("mu", motions[1].scene, {})};
  ceres::Problem problem;
  Eigen::Vector3d q;
  for (int i = 0; i < 3; ++i) {
    q[i] = blocks[i].ToCoordinate(blocks[i].start);
    problem.AddParameterBlock(&q[i], 1);
    problem.SetParameterLowerBound(&q[i], 0, blocks[i].ToCoordinate(blocks[i].lower_bound));
    problem.SetParameterUpperBound(&q[i], 0, blocks[i].ToCoordinate(blocks[i].upper_bound));
  }
  // One residual block per recording: the shared stiffness, and the friction of its own surface.
  clothid::RolloutCostOptions options;
  options.jacobian = clothid::JacobianMethod::kSensitivity;  // few parameters, and the Jacobian that intervals need
  int num_measurements = 0;
  for (int r = 0; r < 2; ++r) {
    auto* cost = new clothid::RolloutCost(motions[r], {blocks[0], blocks[1 + r]}, options);  // owned by the problem
    num_measurements += cost->model().observation().num_residuals();
    problem.AddResidualBlock(cost, nullptr, &q[0], &q[1 + r]);
  }
  ceres::Solver::Options solver;
  solver.linear_solver_type = ceres::DENSE_QR;
  ceres::Solver::Summary summary;
  ceres::Solve(solver, &problem, &summary);
  if (!summary.IsSolutionUsable()) throw std::runtime_error(summary.message);

  const clothid::Linearization solution = clothid::Linearize({&q[0], &q[1], &q[2]}, num_measurements,
                                                             /*sigma_is_known=*/false, &problem);
  const clothid::Uncertainty uncertainty = clothid::EstimateUncertainty(blocks, q, solution);
  const char* labels[] = {"k_stretch", "first.mu", "second.mu"};
  for (int i = 0; i < 3; ++i)
    std::printf("%s %.6g +- %.2g\n", labels[i], blocks[i].ToValue(q[i]), uncertainty.parameters[i].std);
}

int main(int argc, char** argv) try {
  if (argc != 3) return std::fprintf(stderr, "usage: joint_fit FIRST.motion.bin SECOND.motion.bin\n"), 1;
  Fit(argv[1], argv[2]);
} catch (const std::exception& error) {
  return std::fprintf(stderr, "joint_fit: %s\n", error.what()), 2;
}
