#include "tools/benchmark/accuracy/accuracy_point.h"

#include <algorithm>
#include <cmath>

namespace clothid {
namespace {

bool IsBetter(const AccuracyPoint& a, const AccuracyPoint& b) {
  return a.error <= b.error && a.seconds <= b.seconds && (a.error < b.error || a.seconds < b.seconds);
}

bool IsEqual(const AccuracyPoint& a, const AccuracyPoint& b) { return a.error == b.error && a.seconds == b.seconds; }

}  // namespace

bool AreComparable(const AccuracyPoint& a, const AccuracyPoint& b) {
  return a.scene == b.scene && a.setting == b.setting && a.quantity == b.quantity && a.reference == b.reference;
}

std::vector<bool> ParetoFront(const std::vector<AccuracyPoint>& points) {
  std::vector<bool> front;
  for (auto point = points.begin(); point != points.end(); ++point) {
    const bool is_beaten = std::any_of(points.begin(), points.end(), [&](const AccuracyPoint& other) {
      return AreComparable(other, *point) && IsBetter(other, *point);
    });
    const bool is_repeated = std::any_of(points.begin(), point, [&](const AccuracyPoint& other) {
      return AreComparable(other, *point) && IsEqual(other, *point);
    });
    front.push_back(!std::isnan(point->error) && !is_beaten && !is_repeated);
  }
  return front;
}

const AccuracyPoint* FindCheapest(const std::vector<AccuracyPoint>& points, double error) {
  const AccuracyPoint* cheapest = nullptr;
  for (const AccuracyPoint& point : points) {
    if (point.error <= error && (cheapest == nullptr || point.seconds < cheapest->seconds)) cheapest = &point;
  }
  return cheapest;
}

}  // namespace clothid
