// What a fit of fields is asked to do.
#ifndef CLOTHID_IDENTIFY_FIELD_FIELD_FIT_OPTIONS_H_
#define CLOTHID_IDENTIFY_FIELD_FIELD_FIT_OPTIONS_H_

#include <Eigen/Core>
#include <functional>

#include "identify/base/options.h"

namespace clothid {

struct FieldIteration {
  int iteration = 0;
  double seconds = 0.0;
  double cost = 0.0, data_cost = 0.0;  // with and without the prior
  double weight = 0.0;                 // lambda
  Eigen::VectorXd coordinates;         // of all blocks
  int num_rollouts = 0;                // so far
  int num_products = 0;                // of conjugate gradients so far
};

struct FieldFitOptions {
  FitOptions fit;       // method, precision, loss, max_iterations, adjoint, cancel
  double weight = 0.0;  // lambda; 0: it is chosen
  bool estimate_deviations = true;
  std::function<void(const FieldIteration&)> on_iteration;  // may be empty
};

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_FIELD_FIELD_FIT_OPTIONS_H_
