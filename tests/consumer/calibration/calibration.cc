// calibration MOTION SIGMA PARAMETER[,PARAMETER...] MEASURED=VALUE:SIGMA
//
// A recording alone does not tell every parameter. Here one of them, or the mass of the cloth, was also measured by
// other means, and that measurement stands in the same problem as a residual of the user's own. SIGMA is the standard
// deviation of the recording's coordinates in m: both kinds of residuals must be in standard deviations to be weighed
// against each other. Prints what each fit can tell, without and with the measurement.
#include <ceres/problem.h>
#include <ceres/sized_cost_function.h>
#include <ceres/solver.h>

#include <cstdio>
#include <exception>
#include <sstream>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "costs/rollout_cost.h"
#include "datasets/motion/motion_file.h"
#include "identify/uncertainty/uncertainty.h"

namespace {

struct Measurement {
  std::string parameter;
  double value = 0.0, sigma = 0.0;  // in the parameter's own unit
};

//! [residual]
// (value - measured)/sigma of one parameter.
class MeasuredParameter : public ceres::SizedCostFunction<1, 1> {
 public:
  MeasuredParameter(clothid::ParameterBlock block, const Measurement& measurement)
      : block_(std::move(block)), measurement_(measurement) {}

  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override {
    const double coordinate = parameters[0][0];
    residuals[0] = (block_.ToValue(coordinate) - measurement_.value) / measurement_.sigma;
    if (jacobians != nullptr && jacobians[0] != nullptr) {
      jacobians[0][0] = block_.ValueDerivative(coordinate) / measurement_.sigma;
    }
    return true;
  }

 private:
  clothid::ParameterBlock block_;
  Measurement measurement_;
};
//! [residual]

// A recording's parameters as one Ceres problem, open to further residuals.
class Calibration {
 public:
  Calibration(const clothid::RecordedMotion& motion, const std::vector<std::string>& names) : q_(names.size()) {
    for (std::size_t i = 0; i < names.size(); ++i) {
      blocks_.push_back(clothid::MakeParameterBlock(names[i], motion.scene, {}));
      q_[i] = blocks_[i].ToCoordinate(blocks_[i].start);
      coordinates_.push_back(&q_[i]);
      problem_.AddParameterBlock(&q_[i], 1);
      problem_.SetParameterLowerBound(&q_[i], 0, blocks_[i].ToCoordinate(blocks_[i].lower_bound));
      problem_.SetParameterUpperBound(&q_[i], 0, blocks_[i].ToCoordinate(blocks_[i].upper_bound));
    }
    clothid::RolloutCostOptions options;
    options.jacobian = clothid::JacobianMethod::kSensitivity;
    auto* cost = new clothid::RolloutCost(motion, blocks_, options);
    num_measurements_ = cost->model().observation().num_residuals();
    problem_.AddResidualBlock(cost, nullptr, coordinates_);
  }

  //! [add]
  void Add(const Measurement& measurement) {
    for (std::size_t i = 0; i < blocks_.size(); ++i) {
      if (blocks_[i].name != measurement.parameter) continue;
      problem_.AddResidualBlock(new MeasuredParameter(blocks_[i], measurement), nullptr, coordinates_[i]);
      ++num_measurements_;
      return;
    }
    throw std::runtime_error("'" + measurement.parameter + "' was measured but is not among the parameters");
  }
  //! [add]

  void SolveAndPrint() {
    ceres::Solver::Options options;
    options.linear_solver_type = ceres::DENSE_QR;
    ceres::Solver::Summary summary;
    ceres::Solve(options, &problem_, &summary);
    if (!summary.IsSolutionUsable()) throw std::runtime_error(summary.message);
    const Eigen::Map<const Eigen::VectorXd> solution(q_.data(), static_cast<Eigen::Index>(q_.size()));
    Print(clothid::EstimateUncertainty(
        blocks_, solution, clothid::Linearize(coordinates_, num_measurements_, /*sigma_is_known=*/true, &problem_)));
  }

 private:
  void Print(const clothid::Uncertainty& uncertainty) const {
    for (std::size_t i = 0; i < blocks_.size(); ++i) {
      const clothid::ParameterUncertainty& parameter = uncertainty.parameters[i];
      std::printf("%s %.6g +- %.2g%s\n", blocks_[i].name.c_str(), blocks_[i].ToValue(q_[i]), parameter.std,
                  parameter.identifiable ? "" : " not identifiable");
    }
    for (const clothid::HiddenDirection& hidden : uncertainty.hidden_directions) {
      std::printf("hidden: %s\n", hidden.words.c_str());
    }
  }

  std::vector<clothid::ParameterBlock> blocks_;
  std::vector<double> q_;
  std::vector<double*> coordinates_;
  ceres::Problem problem_;
  int num_measurements_ = 0;
};

// "density=0.15:0.001", or "mass=0.0375:0.0002" in kg: the cloth on a balance tells its density.
Measurement ParseMeasurement(const std::string& text, const clothid::RecordedMotion& motion) {
  std::istringstream stream(text);
  Measurement measurement;
  char colon = 0;
  if (!std::getline(stream, measurement.parameter, '=') ||
      !(stream >> measurement.value >> colon >> measurement.sigma) || colon != ':' || !(measurement.sigma > 0.0)) {
    throw std::runtime_error("'" + text + "': expected NAME=VALUE:SIGMA");
  }
  if (measurement.parameter != "mass") return measurement;
  const double area = clothid::TriangleAreas(motion.scene.mesh).sum();
  return {"density", measurement.value / area, measurement.sigma / area};
}

std::vector<std::string> SplitAtCommas(const std::string& text) {
  std::istringstream stream(text);
  std::vector<std::string> words;
  for (std::string word; std::getline(stream, word, ',');) words.push_back(word);
  return words;
}

void Run(char** arguments) {
  clothid::RecordedMotion motion = clothid::ReadMotion(arguments[0]);
  motion.sigma = Eigen::VectorXd::Constant(motion.num_points(), std::stod(arguments[1]));
  const std::vector<std::string> names = SplitAtCommas(arguments[2]);
  const Measurement measurement = ParseMeasurement(arguments[3], motion);

  std::printf("the recording alone\n");
  Calibration alone(motion, names);
  alone.SolveAndPrint();
  std::printf("with %s\n", arguments[3]);
  Calibration both(motion, names);
  both.Add(measurement);
  both.SolveAndPrint();
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 5) {
    std::fprintf(stderr, "usage: calibration MOTION SIGMA PARAMETER[,PARAMETER...] MEASURED=VALUE:SIGMA\n");
    return 1;
  }
  try {
    Run(argv + 1);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "calibration: %s\n", error.what());
    return 2;
  }
  return 0;
}
