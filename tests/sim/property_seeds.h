// The seeds over which a property is tested: a few by default, FIRST:LAST of the environment's CLOTHID_PROPERTY_SEEDS
// instead where that is set, to look for counterexamples.
#ifndef CLOTHID_TESTS_SIM_PROPERTY_SEEDS_H_
#define CLOTHID_TESTS_SIM_PROPERTY_SEEDS_H_

#include <gtest/gtest.h>

#include <cstdint>
#include <cstdlib>
#include <numeric>
#include <sstream>
#include <string>
#include <vector>

namespace clothid {

inline std::vector<std::uint64_t> PropertySeeds(int default_count) {
  std::uint64_t first = 1, last = static_cast<std::uint64_t>(default_count);
  const char* range = std::getenv("CLOTHID_PROPERTY_SEEDS");
  if (range != nullptr) {
    char colon = ' ';
    std::istringstream text(range);
    const bool is_range = text >> first >> colon >> last && colon == ':' && first <= last && text.peek() == EOF;
    EXPECT_TRUE(is_range) << "CLOTHID_PROPERTY_SEEDS: expected FIRST:LAST, found '" << range << "'";
    if (!is_range) return {};
  }
  std::vector<std::uint64_t> seeds(last - first + 1);
  std::iota(seeds.begin(), seeds.end(), first);
  return seeds;
}

}  // namespace clothid

#endif  // CLOTHID_TESTS_SIM_PROPERTY_SEEDS_H_
