// clothid.predict, but for what the package makes of it.
#include <array>
#include <numeric>
#include <string>

#include "identify/prediction/bands.h"
#include "identify/prediction/coverage.h"
#include "identify/prediction/posterior.h"
#include "identify/prediction/prediction.h"
#include "sim/base/error.h"
#include "tools/python/bindings/arrays.h"
#include "tools/python/bindings/bindings.h"
#include "tools/python/bindings/long_call.h"

namespace clothid {
namespace {

// K matrices [R x T], quantiles or draws, as an array (K, shape).
template <typename Matrices>
py::array_t<double> FromMatrices(const Matrices& matrices, std::vector<py::ssize_t> shape) {
  shape.insert(shape.begin(), static_cast<py::ssize_t>(matrices.size()));
  py::array_t<double> array(shape);
  double* next = array.mutable_data();
  for (const Eigen::MatrixXd& matrix : matrices)
    next = std::copy(matrix.reshaped().begin(), matrix.reshaped().end(), next);
  return array;
}

// As (5, T), (5, T, 3) or (5, T, G, 3); of a single number (5,).
py::array_t<double> FromQuantiles(const std::array<Eigen::MatrixXd, 5>& quantiles, DerivedKind kind) {
  const Eigen::Index num_rows = quantiles[0].rows();
  std::vector<py::ssize_t> shape;
  if (kind != DerivedKind::kSlip) shape.push_back(quantiles[0].cols());
  if (kind == DerivedKind::kForce) shape.push_back(num_rows / 3);
  if (num_rows >= 3) shape.push_back(3);
  return FromMatrices(quantiles, shape);
}

// As (K, T, N, 3).
template <typename Matrices>
py::array_t<double> FromPositions(const Matrices& motions) {
  return FromMatrices(motions, {motions[0].cols(), motions[0].rows() / 3, 3});
}

py::dict FromShares(const SpreadShares& shares, const FitPosterior& posterior) {
  py::dict of;
  of["parameters"] = FromVector(shares.parameters);
  of["finer"] = FromVector(shares.finer);
  of["start"] = FromVector(shares.start);
  of["handles"] = FromVector(shares.handles);
  of["rest"] = FromVector(shares.rest);
  for (std::size_t i = 0; i < posterior.parameters.size(); ++i) {
    of[py::str(posterior.parameters[i].name)] = FromVector(shares.each.col(static_cast<Eigen::Index>(i)));
  }
  return of;
}

py::dict FromPrediction(const Prediction& prediction, const FitPosterior& posterior, bool with_draws) {
  py::dict of;
  of["times"] = FromVector(prediction.times);
  of["positions"] = FromPositions(prediction.quantiles);
  of["spread"] = FromVector(prediction.spread);
  of["moved"] = FromVector(prediction.moved);
  of["shares"] = FromShares(prediction.shares, posterior);
  py::dict derived;
  for (const DerivedBands& bands : prediction.derived) {
    derived[py::str(bands.request.name)] = FromQuantiles(bands.quantiles, bands.request.kind);
  }
  of["derived"] = derived;
  of["draws"] = with_draws ? py::object(FromPositions(prediction.cloths)) : py::none();
  of["num_draws"] = prediction.num_draws;
  of["num_failed"] = prediction.num_failed;
  of["worth_until"] = prediction.WorthUntil();
  of["warning"] = posterior.warning;
  return of;
}

}  // namespace

void BindPredict(py::module_* module) {
  module->def(
      "run_prediction",
      [](const py::object& scene_like, const std::string& result, const std::string& source, const std::string& of,
         const std::string& sources, int draws, bool keep_draws, double frame_rate, std::uint64_t seed, int threads,
         const py::object& progress) {
        const PyScene scene = ToScene(scene_like);
        FitPosterior posterior = ParsePosterior(result, source);
        FitToScene(*scene.scene, scene.source, &posterior);
        PredictionOptions options;
        SetSources(sources, "sources", &options);
        if (!of.empty()) options.derived = ParseDerived(of, "of", *scene.scene);
        options.num_draws = draws;
        options.keeps_draws = keep_draws;
        options.frame_rate = frame_rate;
        options.seed = seed;
        options.num_threads = threads;
        if (!progress.is_none()) {
          options.on_rollout = [&](int num_done) {
            const py::gil_scoped_acquire lock;
            progress(num_done, draws);
          };
        }
        Prediction prediction;
        RunInterruptibly([&](const std::atomic<bool>& cancel) {
          options.cancel = &cancel;
          prediction = Predict(*scene.scene, posterior, options);
        });
        return FromPrediction(prediction, posterior, keep_draws);
      },
      py::arg("scene"), py::arg("result"), py::arg("source"), py::arg("of"), py::arg("sources"), py::arg("draws"),
      py::arg("keep_draws"), py::arg("frame_rate"), py::arg("seed"), py::arg("threads"), py::arg("progress"));
  module->def(
      "leave_one_out",
      [](const py::array_t<double, py::array::c_style | py::array::forcecast>& draws) {
        ExpectUsage(draws.ndim() == 2 && draws.shape(0) >= kLeastDraws,
                    "draws: expected at least " + std::to_string(kLeastDraws));
        const Eigen::Map<const Eigen::MatrixXd> columns(draws.data(), draws.shape(1), draws.shape(0));
        std::vector<int> numbers(static_cast<std::size_t>(columns.cols()));
        std::iota(numbers.begin(), numbers.end(), 0);
        LeaveOneOut others(static_cast<int>(columns.cols()));
        for (const auto& row : columns.rowwise()) others.Add(ByOthers(row.transpose()), numbers, 1.0);
        return py::make_tuple(FromVector(others.Shares()), FromVector(others.Errors()));
      },
      py::arg("draws"));
}

}  // namespace clothid
