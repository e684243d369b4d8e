#include "sim/path/handle_path.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "sim/path/handle_csv.h"
#include "tests/expect_error.h"
#include "tests/temporary_folder.h"

namespace clothid::handle_path_test {
namespace {

constexpr double kPi = 3.14159265358979323846;

Eigen::VectorXd UnevenTimes(int count) {
  std::mt19937 generator(3);
  std::uniform_real_distribution<double> interval(0.05, 0.15);
  Eigen::VectorXd times(count);
  double time = 2.0;
  for (double& t : times) t = (time += interval(generator));
  return times;
}

// Three rows: sine, cosine and a slower sine, of amplitude `amplitude`.
Eigen::MatrixXd Waves(const Eigen::VectorXd& times, double amplitude) {
  Eigen::MatrixXd values(3, times.size());
  const Eigen::ArrayXd t = times.array() - times[0];
  values.row(0) = amplitude * (2.0 * kPi * t / 4.0).sin();
  values.row(1) = amplitude * (2.0 * kPi * t / 4.0).cos();
  values.row(2) = amplitude * (2.0 * kPi * t / 7.0).sin();
  return values;
}

double Rms(const Eigen::MatrixXd& values) {
  return std::sqrt(values.squaredNorm() / static_cast<double>(values.size()));
}

TEST(HandlePath, ReproducesStraightPathsAtUnevenTimes) {
  const Eigen::VectorXd times = UnevenTimes(20);
  const Eigen::Vector3d start(1.0, 2.0, 3.0), velocity(-0.5, 0.25, 4.0);
  const HandlePath path(times, (velocity * times.transpose()).colwise() + start);
  for (double time = times[0]; time < times[19]; time += 0.013) {
    EXPECT_LT((path.At(time) - start - velocity * time).norm(), 1e-13);
  }
}

TEST(HandlePath, IsSmoothAcrossKnotsAndMeetsThem) {
  const Eigen::VectorXd times = UnevenTimes(30);
  const Eigen::MatrixXd positions = Waves(times, 1.0);
  const HandlePath path(times, positions);
  for (Eigen::Index i = 1; i + 1 < times.size(); ++i) {
    EXPECT_LT((path.At(times[i]) - positions.col(i)).norm(), 1e-15);
    const double h = 1e-6;
    const Eigen::Vector3d before = (path.At(times[i]) - path.At(times[i] - h)) / h;
    const Eigen::Vector3d after = (path.At(times[i] + h) - path.At(times[i])) / h;
    EXPECT_LT((after - before).norm(), 1e-3) << i;
  }
}

TEST(HandlePath, ConvergesWithThirdOrder) {
  double error[2];
  for (int level = 0; level < 2; ++level) {
    const int count = level == 0 ? 21 : 41;
    const Eigen::VectorXd times = Eigen::VectorXd::LinSpaced(count, 0.0, 4.0);
    const HandlePath path(times, Waves(times, 1.0));
    error[level] = 0.0;
    for (double time = 0.0; time < 4.0; time += 0.01) {
      error[level] = std::max(error[level], std::abs(path.At(time)[0] - std::sin(2.0 * kPi * time / 4.0)));
    }
  }
  EXPECT_GT(error[0] / error[1], 6.5);
}

TEST(HandlePath, RestsExactlyAndOutsideItsTimes) {
  const Eigen::VectorXd times = UnevenTimes(6);
  const Eigen::Vector3d place(0.1, 0.2, 0.3);
  const HandlePath resting(times, place.replicate(1, 6));
  for (double time = times[0] - 1.0; time < times[5] + 1.0; time += 0.0123) EXPECT_EQ(resting.At(time), place);
  const Eigen::MatrixXd positions = Waves(times, 1.0);
  const HandlePath path(times, positions);
  EXPECT_EQ(path.At(-100.0), positions.col(0));
  EXPECT_EQ(path.At(100.0), positions.col(5));
  const HandlePath fixed(times.head(1), place);
  EXPECT_EQ(fixed.At(7.0), place);
  EXPECT_EQ(fixed.num_handles(), 1);
}

TEST(HandlePath, RefusesWhatIsNoPath) {
  const auto expect = [](const Eigen::VectorXd& times, const Eigen::MatrixXd& positions) {
    ExpectError([&] { HandlePath(times, positions); }, ErrorKind::kBadData, {"handle path: "});
  };
  const Eigen::Vector3d times(0.0, 1.0, 2.0);
  Eigen::MatrixXd positions = Eigen::MatrixXd::Zero(3, 3);
  expect(Eigen::Vector3d(0.0, 1.0, 1.0), positions);
  expect(Eigen::Vector3d(0.0, std::nan(""), 1.0), positions);
  expect(times, Eigen::MatrixXd::Zero(3, 2));
  expect(times, Eigen::MatrixXd::Zero(4, 3));
  expect(Eigen::VectorXd(), Eigen::MatrixXd(3, 0));
  positions(1, 1) = 1e308;
  expect(1e-300 * times, positions);
  positions(1, 1) = HUGE_VAL;
  expect(times, positions);
}

TEST(SmoothPath, KeepsAConstantPath) {
  const Eigen::VectorXd times = UnevenTimes(50);
  const Eigen::MatrixXd values = Eigen::Vector3d(0.1, -20.0, 3.3).replicate(1, 50);
  EXPECT_LT((SmoothPath(times, values) - values).lpNorm<Eigen::Infinity>(), 1e-12);
}

TEST(SmoothPath, KeepsASmoothPathWithoutNoise) {
  const double amplitude = 0.2;
  const Eigen::VectorXd times = UnevenTimes(130);
  const Eigen::MatrixXd values = Waves(times, amplitude);
  EXPECT_LT((SmoothPath(times, values) - values).lpNorm<Eigen::Infinity>(), 1e-4 * amplitude);
}

TEST(SmoothPath, HalvesTheErrorOfANoisyPath) {
  const Eigen::VectorXd times = UnevenTimes(130);
  const Eigen::MatrixXd truth = Waves(times, 0.2);
  std::mt19937 generator(11);
  std::normal_distribution<double> noise(0.0, 0.004);
  const Eigen::MatrixXd values = truth.unaryExpr([&](double value) { return value + noise(generator); });
  const double before = Rms(values - truth), after = Rms(SmoothPath(times, values) - truth);
  EXPECT_LT(after, 0.5 * before) << before << " " << after;
}

TEST(SmoothPath, IsALeastCrossValidationSpline) {
  // What is taken off a path of pure noise is nearly all of it.
  std::mt19937 generator(5);
  std::normal_distribution<double> noise(0.0, 1.0);
  const Eigen::VectorXd times = UnevenTimes(400);
  const Eigen::MatrixXd values = Eigen::MatrixXd::NullaryExpr(6, 400, [&] { return noise(generator); });
  EXPECT_LT(Rms(SmoothPath(times, values)), 0.15);
}

TEST(SmoothPath, HandlesALongRecording) {
  std::mt19937 generator(5);
  std::normal_distribution<double> noise(0.0, 0.004);
  const Eigen::VectorXd times = UnevenTimes(100000);
  const Eigen::MatrixXd truth = Waves(times, 0.2).topRows(1);
  const Eigen::MatrixXd values = truth.unaryExpr([&](double value) { return value + noise(generator); });
  EXPECT_LT(Rms(SmoothPath(times, values) - truth), 0.5 * 0.004);
}

TEST(SmoothPath, LeavesShortPathsAlone) {
  const Eigen::VectorXd times = UnevenTimes(4);
  const Eigen::MatrixXd values = Eigen::MatrixXd::Random(3, 4);
  EXPECT_EQ(SmoothPath(times, values), values);
}

TEST(ReadHandleCsv, ReadsRowsOfTimes) {
  const TemporaryFolder folder;
  const std::string path =
      folder.Write("h.csv", "time, x0,y0,z0,x1,y1,z1\r\n0,1,2,3,4,5,6\r\n0.5,1,2,3,4,5,1e1\r\n\r\n");
  const HandlePath handles = ReadHandleCsv(path, 2);
  EXPECT_EQ(handles.num_handles(), 2);
  EXPECT_EQ(handles.times(), Eigen::Vector2d(0.0, 0.5));
  EXPECT_EQ(handles.positions()(5, 1), 10.0);
}

TEST(ReadHandleCsv, ReadsQuotedCells) {
  const TemporaryFolder folder;
  const std::string path =
      folder.Write("h.csv", "\"time\", \"x0\",\"y0\" ,\"z0\"\r\n\"0\",\" 1\",\"2 \",3\r\n\"0.5\",1,2,\"1e1\"\r\n");
  const std::string plain = folder.Write("p.csv", "time,x0,y0,z0\n0,1,2,3\n0.5,1,2,1e1\n");
  EXPECT_EQ(ReadHandleCsv(path, 1).times(), ReadHandleCsv(plain, 1).times());
  EXPECT_EQ(ReadHandleCsv(path, 1).positions(), ReadHandleCsv(plain, 1).positions());
}

TEST(ReadHandleCsv, NamesFileAndLine) {
  const TemporaryFolder folder;
  const auto expect = [&](const std::string& content, std::initializer_list<const char*> fragments) {
    const std::string path = folder.Write("h.csv", content);
    ExpectError([&] { ReadHandleCsv(path, 1); }, ErrorKind::kBadData, fragments);
  };
  expect("time,x0,y0\n", {"h.csv:1: ", "column 'z0'", "time,x0,y0,z0"});
  expect("time,x0,y0,z0,x1\n", {"h.csv:1: column 'x1': expected no more of these"});
  expect("time,x0,y0,z0\n0,1,2,3\n1,2,3\n", {"h.csv:3: expected 4 cells"});
  expect("time,x0,y0,z0\n0,1,2,3,4\n", {"h.csv:2: expected 4 cells"});
  expect("time,x0,y0,z0\n0,1,,3\n", {"h.csv:2: column 'y0': expected a finite number, found ''"});
  expect("time,x0,y0,z0\n0,1,nan,3\n", {"h.csv:2: column 'y0'", "'nan'"});
  expect("time,x0,y0,z0\n0,1,2 5,3\n", {"h.csv:2: column 'y0'", "'2 5'"});
  expect("time,x0,y0,z0\n0,\"1,2,3\n", {"h.csv:2: expected quoted cells to end with a quote"});
  expect("time,\"x\"0,y0,z0\n", {"h.csv:1: expected quoted cells to end with a quote"});
  expect("time,x0,y0,z0\n1,1,2,3\n0,1,2,3\n", {"h.csv:3: column 'time': expected a time after 1 s of line 2"});
  expect("time,x0,y0,z0\n", {"h.csv: expected the header 'time,x0,y0,z0' and at least one row"});
  ExpectError([&] { ReadHandleCsv(folder.File("none.csv"), 1); }, ErrorKind::kIo, {"none.csv"});
}

}  // namespace
}  // namespace clothid::handle_path_test
